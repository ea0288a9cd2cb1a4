"""The Preisach operator as a friction model."""

import numpy as np
import pytest

from bristle import friction, hysteresis, response
from bristle.models.hysteresis.everett import KERNELS

WALK = np.cumsum(np.random.default_rng(8).standard_normal(300)) * 5e-7


@pytest.mark.parametrize("kernel", KERNELS)
def test_the_force_is_the_mean_of_the_operator_over_a_step(kernel):
    sizes = {"s": 1e7, "f_p": 28.0, "kernel": kernel}
    path, parts = WALK - WALK[0], 400
    fine = np.interp(np.arange(parts * (path.size - 1) + 1) / parts, np.arange(path.size), path)
    operator = response(hysteresis.preisach(**sizes), fine)
    means = 0.5 * (operator[1:] + operator[:-1])
    force = response(friction.preisach_contact(**sizes), path, 1e-3)
    assert force[1:] == pytest.approx(means.reshape(-1, parts).mean(axis=1), abs=3e-3 * 28.0)
    # A short step is a trapezium.
    short = 1e-3 * path
    operator = response(hysteresis.preisach(**sizes), short)
    force = response(friction.preisach_contact(**sizes), short, 1e-3)
    assert force[1:] == pytest.approx(0.5 * (operator[1:] + operator[:-1]), abs=1e-12)


def test_below_break_away_it_equals_the_composite_with_a_gate():
    sizes = {"s": 1e7, "f_p": 60.0}
    composite = friction.preisach_lugre(**sizes, F_C=40.0, F_S=40.0, v_S=1.0, rho=0.9)
    small = 0.5 * WALK
    ours, reference = (
        response(item, small, 1e-3) for item in (friction.preisach_contact(**sizes), composite)
    )
    assert np.max(np.abs(reference)) < 0.9 * 40.0
    assert ours == pytest.approx(reference, abs=1e-9)
