"""The law over a reversal: where its force changes sign, over which distance, and what that is worth on a circle."""

import numpy as np
import pytest
from benchmarks.independent import DT, GAINS, follow, sliders

from bristle import controllers
from bristle.core.contracts import Reference

pytestmark = pytest.mark.usefixtures("compiled_axis")

STRIBECK = {"F_C": 40.0, "F_S": 50.0, "v_S": 4e-4}


def fed(law, t, x, v, a):
    """Return the compensation along a motion that the axis follows without error [N]."""
    state, forces = law.component.start(x[0], v[0], a[0], DT, law.parameters), []
    for sample in zip(t, x, v, a, strict=True):
        _, place, speed, acceleration = map(float, sample)
        effort, state = law.component.step(
            state, Reference(place, speed, acceleration, 0.0), place, DT, law.parameters
        )
        effort -= law.values["J"] * acceleration
        forces.append(effort)
    return np.array(forces)


def turning(acceleration=-0.1, duration=0.4):
    """Return a motion that reverses at half of its duration."""
    t = DT * np.arange(round(duration / DT)) + 0.5 * DT
    v = acceleration * (t - 0.5 * duration)
    return t, 0.5 * acceleration * (t - 0.5 * duration) ** 2, v, np.full(t.size, acceleration)


def still_law(**own):
    # Without gains on the error, the effort is inertia and compensation only.
    return controllers.predictive_reversal(J=600.0, lambda_=0.0, K_1=0.0, **STRIBECK, **own)


@pytest.mark.parametrize("lead", [0.0, 5e-3, 20e-3])
def test_the_force_changes_its_sign_by_the_lead_before_the_velocity(lead):
    t, *motion = turning()
    force = fed(still_law(lead=lead), t, *motion)
    assert t[np.flatnonzero(np.diff(np.sign(force)))[0]] == pytest.approx(0.2 - lead, abs=2 * DT)
    assert np.count_nonzero(np.diff(np.sign(force))) == 1


def test_the_force_is_that_of_stribeck_at_the_expected_speed():
    t, *motion = turning()
    force, speed = fed(still_law(lead=5e-3), t, *motion), np.abs(motion[1] + 5e-3 * motion[2])
    assert np.max(np.abs(force)) == pytest.approx(50.0, abs=1.0)
    assert np.abs(force[speed > 3e-3]) == pytest.approx(40.0, abs=1e-6)


def test_the_force_reverses_over_the_distance():
    t, x, v, a = turning()
    force = fed(still_law(x_0=2e-6), t, x, v, a)
    half = np.interp(2e-6 * np.log(2.0), -x[t > 0.2], force[t > 0.2])
    assert half == pytest.approx(0.0, abs=3.0)  # half of the reversal, after a distance of x_0 ln 2
    assert force[-1] == pytest.approx(-40.0, rel=1e-3)
    # A motion that stops and continues in the same direction has no reversal.
    stop = np.where(t < 0.2, v, -v)
    assert (
        np.min(fed(still_law(x_0=2e-6), t, DT * np.cumsum(stop), stop, np.where(t < 0.2, a, -a)))
        > 39.0
    )


def test_the_distance_reduces_the_error_of_a_reversal_and_a_lead_alone_increases_it():
    axis = sliders(7)
    level, offset = (
        float(np.sum(axis.limit)),
        axis.numbers[4] + axis.numbers[5] * float(np.sum(axis.limit)),
    )
    t, x, v, a = turning(duration=1.0)
    desired = np.array([x, v, a, np.full(t.size, offset)])
    own = {"F_C": level, "F_S": 1.18 * level, "v_S": 4e-4, "F_v": axis.numbers[3]}

    def glitch(**further):
        return follow(
            controllers.predictive_reversal(**GAINS, **own, **further), axis, desired, 7
        ).peak(0.4, 0.8)

    at_once = glitch()
    assert glitch(x_0=2e-6, lead=2e-3) < 0.5 * at_once
    assert glitch(lead=5e-3) > at_once


def test_the_force_of_a_start_from_rest_rises_from_zero():
    t = DT * np.arange(200)
    force = fed(still_law(x_0=2e-6), t, 0.05 * t**2, 0.1 * t, np.full(t.size, 0.1))
    assert force[0] == 0.0
    assert np.all(force >= 0.0)
    assert force[-1] == pytest.approx(40.0, rel=1e-3)


@pytest.mark.parametrize(("velocity", "side"), [(0.5, 1), (-0.5, -1), (0.0, 0)])
def test_a_law_that_takes_over_knows_the_side_of_the_motion(velocity, side):
    assert still_law().component.start(0.2, velocity, 0.0, DT, still_law().parameters)[2:] == (
        0.2,
        side,
        side,
    )
