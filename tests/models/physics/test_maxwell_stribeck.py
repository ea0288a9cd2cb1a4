"""Maxwell-slip elements with Stribeck limits and scatter."""

import numpy as np
import pytest

from bristle import friction, response
from bristle.engine import force_along, settled

pytestmark = pytest.mark.usefixtures("in_plain_python")

SIZES = {"F_C": 20.0, "F_S": 28.0, "v_S": 2e-3, "k_i": [6e6, 3e6, 1e6], "nu_i": [0.3, 0.4, 0.3]}
QUIET = friction.maxwell_stribeck(**SIZES)


def test_with_one_limit_it_is_the_maxwell_slip_model():
    same = {"k_i": SIZES["k_i"], "nu_i": SIZES["nu_i"], "sigma_2": 200.0}
    x = np.cumsum(np.random.default_rng(3).standard_normal(500)) * 1e-6
    ours = response(friction.maxwell_stribeck(F_C=25.0, F_S=25.0, v_S=1.0, **same), x, 1e-3)
    reference = response(friction.maxwell_slip(F_C=25.0, **same), x, 1e-3)
    assert ours == pytest.approx(reference, abs=1e-9)


@pytest.mark.parametrize("v", [1e-6, 1e-3, 5e-3, -5e-3])
def test_in_sliding_it_follows_the_stribeck_curve(v):
    state, memory = settled(QUIET, v)
    curve = friction.stribeck(F_C=20.0, F_S=28.0, v_S=2e-3, F_v=0.0)
    assert force_along(QUIET, [v], 1e-4, state=state, memory=memory) == pytest.approx(
        force_along(curve, [v], 1e-4)
    )


def test_micro_damping_belongs_to_the_elements_that_stick():
    damped = friction.maxwell_stribeck(**SIZES, sigma_1=1e3)
    slow, still = 1e-3, 1e-12
    stuck = (
        force_along(damped, [slow], still / slow)[0] - force_along(QUIET, [slow], still / slow)[0]
    )
    assert stuck == pytest.approx(1e3 * slow)
    state, memory = settled(damped, slow)
    sliding = force_along(damped, [slow], 1e-3, state=state, memory=memory)[0]
    assert sliding == pytest.approx(force_along(QUIET, [slow], 1e-3, state=state, memory=memory)[0])


def peaks(model, amplitude=50e-6, cycles=150):
    count = 40
    x = -amplitude * np.cos(2.0 * np.pi * np.arange(cycles * count + 1) / count)
    force = response(model, x, 0.05)[1:].reshape(-1, count)
    return force.max(axis=1)


def test_the_limit_scatters_from_reversal_to_reversal_as_specified():
    quiet, rough = peaks(QUIET), peaks(friction.maxwell_stribeck(**SIZES, scatter=0.05, seed=4))
    assert np.ptp(quiet[1:]) < 1e-9
    assert np.std(rough) / quiet[-1] == pytest.approx(0.05, rel=0.15)
    assert np.mean(rough) == pytest.approx(quiet[-1], rel=0.01)
    assert abs(np.corrcoef(rough[1:], rough[:-1])[0, 1]) < 0.2


def test_a_seed_gives_one_friction_and_another_seed_another():
    first, again, other = (
        peaks(friction.maxwell_stribeck(**SIZES, scatter=0.05, seed=s), cycles=20)
        for s in (4, 4, 5)
    )
    assert np.array_equal(first, again)
    assert not np.any(first[1:] == other[1:])


def test_a_reversal_slower_than_the_threshold_is_ignored():
    model = friction.maxwell_stribeck(**SIZES, scatter=0.2, seed=1, v_r=1.0)
    result, quiet = peaks(model, cycles=20), peaks(QUIET, cycles=20)
    # One limit is drawn, and no other: all peaks are scaled alike.
    assert result / quiet == pytest.approx(result[0] / quiet[0])
    assert result[0] != pytest.approx(quiet[0], rel=0.01)
