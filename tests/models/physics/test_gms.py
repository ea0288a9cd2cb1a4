"""Generalised Maxwell slip: Maxwell slip before sliding, the Stribeck curve with a lag in sliding."""

import numpy as np
import pytest

from bristle import friction
from bristle.engine import force_along

pytestmark = pytest.mark.usefixtures("in_plain_python")

ELEMENTS = {"k_i": [4e5, 2e5, 1e5, 4e4], "nu_i": [0.2, 0.3, 0.3, 0.2]}
MODEL = friction.gms(F_C=1.0, F_S=1.4, v_S=1e-3, C=50.0, sigma_2=0.4, **ELEMENTS)


def level(v):
    return 1.0 + 0.4 * np.exp(-((v / 1e-3) ** 2))


def test_without_stribeck_effect_it_is_maxwell_slip():
    x = np.cumsum(np.random.default_rng(2).standard_normal(600)) * 1e-6
    v = np.diff(x) / 1e-3
    flat = friction.gms(F_C=1.0, F_S=1.0, v_S=1e-3, C=50.0, **ELEMENTS)
    maxwell = friction.maxwell_slip(F_C=1.0, **ELEMENTS)
    np.testing.assert_allclose(
        force_along(flat, v, 1e-3), force_along(maxwell, v, 1e-3), atol=1e-12
    )


@pytest.mark.parametrize("v", [1e-4, 1e-3, -3e-3, 0.2])
def test_steady_sliding_is_the_stribeck_curve_in_both_directions(v):
    force = force_along(MODEL, np.full(1000, v), 1e-3)[-1]
    assert force == pytest.approx(np.sign(v) * level(v) + 0.4 * v, rel=1e-12)


def test_after_a_change_of_speed_the_force_relaxes_with_the_attraction():
    before, after, dt = 1e-4, 2e-3, 1e-4
    v = np.concatenate([np.full(2000, before), np.full(200, after)])
    force = force_along(MODEL, v, dt)[2000:] - 0.4 * after
    rate = 50.0 / level(after)
    t = dt * np.arange(201)
    decay = (level(before) - level(after)) / (rate * dt) * -np.diff(np.exp(-rate * t))
    np.testing.assert_allclose(force, level(after) + decay, atol=1e-10)


def test_the_mean_force_is_exact_through_stick_and_slip():
    v = np.concatenate([np.full(256, 2e-3), np.full(256, -3e-3)])
    fine = force_along(MODEL, v, 1e-4).reshape(8, 64).mean(axis=1)
    np.testing.assert_allclose(force_along(MODEL, v[::64], 64e-4), fine, atol=1e-12)
