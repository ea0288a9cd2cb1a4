"""Initial states: virgin, saturated, from a history, conditioned."""

import numpy as np
import pytest
from tests.models.hysteresis.paths import of

from bristle import hysteresis, response
from bristle.models.hysteresis.everett import KERNELS

every_kernel = pytest.mark.parametrize("kernel", KERNELS)


@every_kernel
def test_saturated_starts_on_the_branch_from_that_end(kernel):
    up = np.linspace(-5.0, 5.0, 41)
    risen = response(of(kernel), up, history=hysteresis.saturated(-5.0))
    fallen = response(of(kernel), -up, history=hysteresis.saturated(5.0))
    assert np.array_equal(risen, -fallen)
    assert abs(risen[-1] - response(of(kernel), [5.0])[0]) <= 1e-15
    assert fallen[20] < 0.0 < risen[20]


@every_kernel
def test_a_sweep_with_more_reversals_is_closer_to_the_virgin_state(kernel):
    x = np.linspace(0.05, 2.9, 30)
    virgin = response(of(kernel), x)
    misses = []
    for reversals in (25, 100, 200):
        after = response(of(kernel), x, history=hysteresis.conditioned(3.0, reversals))
        misses.append(np.max(np.abs(after - virgin)))
    assert misses[0] > 2.0 * misses[1] > 3.0 * misses[2]
    assert misses[1] < 0.02


@every_kernel
def test_a_sweep_erases_the_earlier_history(kernel):
    sweep = hysteresis.conditioned(3.0)
    x = np.linspace(0.0, 4.0, 20)
    fresh = response(of(kernel), x, history=sweep)
    used = response(of(kernel), x, history=[2.0, -1.5, 0.7, -2.9, *sweep])
    assert np.max(np.abs(fresh - used)) <= 1e-14
