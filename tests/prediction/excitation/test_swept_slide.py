"""Slides with a sine of rising frequency: within the limits of the axis, without reversals, and the resonance is found."""

import math

import numpy as np
import pytest
from benchmarks.two_mass import drive_of, of_the_motor, recorded

from bristle.core import Axis
from bristle.core.errors import InputError
from bristle.identification.elasticity import elastic_coupling
from bristle.logs.log import Log
from bristle.prediction.excitation import excite
from bristle.prediction.excitation.swept_slide import _sine, cruises_of, swept_slide

SHAPE = {
    "amplitude": 0.05,
    "velocity": 0.02,
    "acceleration": 2.0,
    "shaking": 0.01,
    "f_0": 3.0,
    "f_1": 60.0,
    "leg_count": 3,
}


def sampled(count=400_001, **changes):
    slide = swept_slide(**SHAPE | changes)
    time = np.linspace(0.0, slide.component.duration(slide.parameters), count)
    return time, *slide.component.sample(time, slide.parameters)


@pytest.mark.parametrize("jerk", [math.inf, 100.0])
def test_velocity_and_acceleration_are_derivatives_of_the_position(jerk):
    time, position, velocity, acceleration = sampled(jerk=jerk)
    # Without a jerk limit, the acceleration steps at the corners.
    step = np.abs(np.diff(acceleration, prepend=0.0)) > 0.5
    smooth = ~(step | np.roll(step, 1) | np.roll(step, -1))
    smooth[[0, -1]] = False
    assert np.max(np.abs(np.gradient(position, time) - velocity)[smooth]) < 1e-6
    assert np.max(np.abs(np.gradient(velocity, time) - acceleration)[smooth]) < 5e-3


def test_the_acceleration_contains_the_change_of_the_amplitude():
    """A sweep of more than an octave in a period: the second derivative of the amplitude is as large as that of the sine."""
    p = swept_slide(**SHAPE | {"acceleration": 0.3, "f_0": 1.0}, jerk=20.0).parameters
    time = np.linspace(0.0, 1.0, 200_001)
    _, velocity, acceleration = _sine(time, 1.0, p)
    # Between the fades, whose ends are corners of the acceleration.
    inside = (time > 0.11) & (time < 0.89)
    error = np.abs(np.gradient(velocity, time) - acceleration)[inside]
    assert np.max(error) < 1e-6 * np.max(np.abs(acceleration))


def test_the_sine_keeps_the_limits_and_the_direction_of_the_slide():
    time, _, velocity, acceleration = sampled(jerk=100.0)
    assert np.max(np.abs(acceleration)) <= 2.0
    assert np.max(np.abs(np.diff(acceleration))) / time[1] <= 100.0 * 1.001
    for begin, length in cruises_of(_legs()):
        leg = velocity[(time > begin) & (time < begin + length)]
        assert np.min(np.abs(leg)) >= 0.0099
        assert np.ptp(np.sign(leg)) == 0.0


def _legs():
    from bristle.prediction.excitation.swept_slide import _legs as legs

    return legs(swept_slide(**SHAPE, jerk=100.0).parameters)


def test_a_slow_sine_has_its_velocity_and_a_fast_sine_the_acceleration_of_the_axis():
    time, _, velocity, acceleration = sampled(f_1=400.0)
    begin, length = cruises_of(_legs())[0]
    early, late = (
        (time > begin + a * length) & (time < begin + b * length)
        for a, b in ((0.1, 0.2), (0.8, 0.9))
    )
    assert np.max(np.abs(velocity[early])) == pytest.approx(0.03, rel=0.05)
    assert np.max(np.abs(acceleration[late])) == pytest.approx(2.0, rel=0.05)


LIMITS = {
    "sample_time": 1e-3,
    "velocity_limit": 0.2,
    "acceleration_limit": 5.0,
    "stroke": (-0.2, 0.2),
}


def test_a_motion_for_a_resonance_comes_only_on_request_and_within_the_limits():
    assert {piece.purpose for piece in excite(Axis(**LIMITS), rehearsed=False).motion.pieces} == {
        "stribeck"
    }
    motion = excite(Axis(**LIMITS), purposes="resonance", duration="40 s", rehearsed=False).motion
    assert {piece.purpose for piece in motion.pieces} == {"resonance"}
    assert motion.duration == pytest.approx(40.0, rel=0.02)
    assert np.max(np.abs(motion.position)) <= 0.2
    assert np.max(np.abs(motion.velocity)) <= 0.2
    assert np.max(np.abs(motion.acceleration)) <= 5.0
    assert motion.position[-1] == pytest.approx(motion.position[0])


@pytest.mark.parametrize(
    ("missing", "words"), [("velocity_limit", "velocity limit"), ("stroke", "travel limit")]
)
def test_a_motion_for_a_resonance_needs_the_limits_of_a_long_slide(missing, words):
    limits = {name: value for name, value in LIMITS.items() if name != missing}
    with pytest.raises(
        InputError, match=f"cannot contain resonance, because the {words} of the axis is unknown"
    ):
        excite(Axis(**limits), purposes="resonance", rehearsed=False)


@pytest.mark.slow
@pytest.mark.fast_cases(2)
@pytest.mark.parametrize(
    ("seed", "elastic"),
    [(504, True), (504, False), (501, True), (502, True), (503, True), (501, False)],
)
def test_the_log_of_the_motion_shows_the_coupling_of_an_elastic_drive_only(seed, elastic):
    drive = drive_of(seed, elastic=elastic)
    axis = Axis(**LIMITS | {"sample_time": drive.sample_time, "resolution": drive.step})
    motion = excite(axis, purposes="resonance", rehearsed=False).motion
    log = recorded(
        drive, motion.position, np.zeros(motion.position.size), np.random.default_rng(seed)
    )
    coupling = elastic_coupling([Log.from_columns(of_the_motor(log), axis=axis)], [axis])
    if elastic:
        assert coupling.antiresonance == pytest.approx(drive.antiresonance, rel=0.03)
    else:
        assert coupling is None
