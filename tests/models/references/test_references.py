"""Desired motions: within their limits, where they should end, and velocity the derivative of position."""

import math
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from bristle.core import InputError
from bristle.models.references import chirp, circle, recorded, s_curve, sine, triangle, varied_sine
from bristle.models.references.fade import fade
from bristle.models.references.legs import legs_through

positive = st.floats(1e-3, 1e3)

MOTIONS = {
    "s_curve": s_curve(distance=-0.1, velocity=0.2, acceleration=2.0, jerk=50.0),
    "s_curve without limit of the jerk": s_curve(distance=0.1, velocity=0.2, acceleration=2.0),
    "triangle": triangle(
        amplitude=7e-6, velocity=1e-5, acceleration=1e-3, cycle_count=3, ratio=0.7
    ),
    "chirp": chirp(amplitude=1e-6, f_0=5.0, f_1=60.0, duration=2.0, ramp=0.3),
    "chirp of one frequency": chirp(amplitude=1e-6, f_0=5.0, f_1=5.0, duration=2.0, ramp=0.3),
    "sine": sine(amplitude=1e-3, frequency=2.0, ramp=0.5),
    "sine at full speed": sine(amplitude=1e-3, frequency=2.0, offset=5e-4),
    "varied sine": varied_sine(
        amplitudes=[0.0, 2e-3, 1e-3, 3e-3], frequency=3.0, duration=1.5, offset=1e-3
    ),
    "circle, x": circle(radius=0.05, feed=0.1, offset=0.2),
    "circle, y": circle(radius=0.05, feed=0.1, axis="y", offset=0.2),
}


def sampled(model, t):
    return model.component.sample(t, model.parameters)


def duration(model):
    return model.component.duration(model.parameters)


@pytest.mark.parametrize("name", MOTIONS)
def test_velocity_and_acceleration_are_derivatives(name):
    model = MOTIONS[name]
    end = duration(model) if hasattr(model.component, "duration") else 2.0
    t = np.linspace(-0.1 * end, 1.1 * end if hasattr(model.component, "duration") else end, 40_001)
    x, v, a = sampled(model, t)
    step = np.diff(t)
    assert np.max(np.abs(x[1:] - x[0] - np.cumsum(0.5 * (v[1:] + v[:-1]) * step))) <= 1e-4 * np.ptp(
        x
    )
    # Where the acceleration jumps, a trapezoid is off by half a step of it.
    assert np.max(np.abs(v[1:] - v[0] - np.cumsum(0.5 * (a[1:] + a[:-1]) * step))) <= 0.02 * np.max(
        np.abs(v)
    )


@given(
    distance=positive, velocity=positive, acceleration=positive, jerk=positive | st.just(math.inf)
)
@settings(max_examples=60, deadline=None)
def test_a_move_ends_at_its_distance_within_its_limits(distance, velocity, acceleration, jerk):
    model = s_curve(distance=distance, velocity=velocity, acceleration=acceleration, jerk=jerk)
    end = duration(model)
    x, v, a = sampled(model, np.linspace(0.0, 1.01 * end, 3000))
    assert x[0] == 0.0
    assert x[-1] == distance
    assert np.all(np.diff(x) >= -1e-12 * distance)
    assert np.max(np.abs(v)) <= velocity * (1.0 + 1e-9)
    assert np.max(np.abs(a)) <= acceleration * (1.0 + 1e-9)
    assert (
        np.max(np.abs(np.diff(a))) <= jerk * end * 1.01 / 2999 * (1.0 + 1e-6) + 1e-9 * acceleration
    )


@pytest.mark.parametrize(
    ("limits", "shortest"),
    [
        ({"velocity": 1e9, "acceleration": 2.0}, 2.0 * math.sqrt(0.1 / 2.0)),
        ({"velocity": 0.2, "acceleration": 2.0}, 0.1 / 0.2 + 0.2 / 2.0),
        ({"velocity": 1e9, "acceleration": 1e9, "jerk": 50.0}, (32.0 * 0.1 / 50.0) ** (1.0 / 3.0)),
        ({"velocity": 0.2, "acceleration": 2.0, "jerk": 50.0}, 0.1 / 0.2 + 0.2 / 2.0 + 2.0 / 50.0),
    ],
)
def test_a_move_takes_the_shortest_possible_time(limits, shortest):
    assert duration(s_curve(distance=0.1, **limits)) == pytest.approx(shortest, rel=1e-9)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("ratio", [1.0, 0.8, 1.25])
def test_triangles_turn_at_their_turning_points(ratio, side):
    model = triangle(
        amplitude=2.0 * side, velocity=1.0, acceleration=10.0, cycle_count=3, ratio=ratio
    )
    x, v, _ = sampled(model, np.linspace(0.0, duration(model), 200_001))
    turns = np.flatnonzero(np.sign(v[1:-1]) * np.sign(v[2:]) < 0) + 1
    assert x[turns] == pytest.approx([2.0 * side * (-ratio) ** k for k in range(6)], abs=1e-6)
    assert x[-1] == pytest.approx(0.0, abs=1e-12)


def test_a_chirp_passes_every_frequency_at_its_time():
    model = chirp(amplitude=1.0, f_0=2.0, f_1=32.0, duration=8.0)
    t = np.linspace(0.0, 8.0, 80_001)
    x, _, _ = sampled(model, t)
    crossings = t[1:][np.sign(x[1:]) != np.sign(x[:-1])]
    halves = np.diff(crossings)
    # Four octaves in eight seconds: two seconds for each.
    for octave in range(4):
        inside = halves[(crossings[1:] > 2.0 * octave) & (crossings[1:] < 2.0 * octave + 2.0)]
        assert 0.5 / inside[1] == pytest.approx(2.0 * 2.0**octave, rel=0.25)
        assert 0.5 / inside[-2] == pytest.approx(4.0 * 2.0**octave, rel=0.25)


def test_a_sine_grows_to_its_amplitude_about_its_centre():
    x, _, _ = sampled(
        sine(amplitude=2.0, frequency=1.0, offset=3.0, ramp=0.5), np.array([0.0, 0.125, 0.75, 1.25])
    )
    # A quintic has risen to 0.103515625 after a quarter.
    assert x == pytest.approx([3.0, 3.0 + 2.0 * np.sqrt(0.5) * 0.103515625, 1.0, 5.0])
    assert sampled(sine(amplitude=2.0, frequency=1.0), np.array([0.25]))[0] == pytest.approx([2.0])


def test_a_fade_is_half_in_the_middle_and_symmetric():
    w, rate, bend = fade(np.array([0.0, 0.5, 1.0, 1.5, 2.0, 2.5]), 2.0)
    assert w == pytest.approx([0.0, 0.103515625, 0.5, 0.896484375, 1.0, 1.0])
    # In the middle it rises by 15/8 over its length.
    assert rate[[0, 2, 4, 5]] == pytest.approx([0.0, 15.0 / 16.0, 0.0, 0.0])
    assert bend[[0, 2, 4, 5]] == pytest.approx([0.0, 0.0, 0.0, 0.0])
    assert bend[1] == -bend[3] == pytest.approx(60.0 * 0.25 * 0.75 * 0.5 / 4.0)
    assert [part.tolist() for part in fade(np.array([0.0, 1.0]), 0.0)] == [
        [1.0, 1.0],
        [0.0, 0.0],
        [0.0, 0.0],
    ]


def test_a_varied_sine_passes_its_amplitudes_and_keeps_the_last():
    model = varied_sine(amplitudes=[1.0, 2.0, 4.0], frequency=10.0, duration=2.0, offset=3.0)
    # Peaks at 0.025 s after each tenth of a second.
    x, _, _ = sampled(model, np.array([0.025, 1.025, 2.025, 9.025]))
    assert x == pytest.approx([4.0, 5.0, 7.0, 7.0], abs=0.05)
    _, v, a = sampled(model, np.array([9.0, 9.025]))
    assert v[0] == pytest.approx(4.0 * 20.0 * np.pi)
    assert a[1] == pytest.approx(-4.0 * (20.0 * np.pi) ** 2)


def test_both_axes_of_a_circle_run_at_its_feed_around_its_centre():
    t = np.linspace(0.0, 3.0, 50)
    (x, v_x, a_x), (y, v_y, a_y) = (
        sampled(circle(radius=0.05, feed=0.1, axis=axis, offset=0.2), t) for axis in ("x", "y")
    )
    assert np.hypot(x - 0.2, y - 0.2) == pytest.approx(0.05)
    assert np.hypot(v_x, v_y) == pytest.approx(0.1)
    assert np.hypot(a_x, a_y) == pytest.approx(0.1**2 / 0.05)
    assert (x[0], y[0], v_y[0]) == pytest.approx((0.25, 0.2, 0.1))
    assert circle(radius=0.05, feed=0.1).values["axis"] == "x"


def test_a_recorded_motion_has_central_differences_and_rests_after_its_end():
    x, v, a = sampled(
        recorded(position=[0.0, 1.0, 4.0, 9.0, 16.0], sample_time=1.0),
        np.array([0.0, 1.0, 1.5, 2.0, 4.0, 4.5]),
    )
    assert x == pytest.approx([0.0, 1.0, 2.5, 4.0, 16.0, 16.0])
    assert v == pytest.approx([1.0, 2.0, 3.0, 4.0, 7.0, 0.0])
    assert a == pytest.approx([1.0, 1.5, 1.75, 2.0, 1.0, 0.0])


def test_a_chirp_is_at_rest_at_both_ends_and_outside():
    model = MOTIONS["chirp"]
    x, v, a = sampled(model, np.array([-1.0, 0.0, 2.0, 3.0]))
    assert [part.tolist() for part in (v, a)] == [[0.0] * 4] * 2
    assert x == pytest.approx(0.0, abs=1e-18)
    assert duration(model) == 2.0
    plain = chirp(amplitude=1.0, f_0=2.0, f_1=2.0, duration=1.0)
    assert sampled(plain, np.array([0.125, 0.25, 0.375]))[0] == pytest.approx([1.0, 0.0, -1.0])
    assert sampled(plain, np.array([0.0, 0.5]))[1].tolist() == pytest.approx([0.0, 4.0 * np.pi])


def test_a_leg_has_seven_phases_of_constant_jerk():
    # 2 m at 1 m/s, 2 m/s^2 and 10 m/s^3: 0.2 s to 2 m/s^2, 0.3 s there, 0.2 s back; the rest at 1 m/s.
    legs = legs_through([2.0], 1.0, 2.0, 10.0)
    assert np.diff(np.append(legs.time, legs.end))[:7] == pytest.approx(
        [0.2, 0.3, 0.2, 1.3, 0.2, 0.3, 0.2]
    )
    assert legs.jerk == pytest.approx([10.0, 0.0, -10.0, 0.0, -10.0, 0.0, 10.0, 0.0])
    assert legs.acceleration == pytest.approx([0.0, 2.0, 2.0, 0.0, 0.0, -2.0, -2.0, 0.0], abs=1e-12)
    assert legs.velocity == pytest.approx([0.0, 0.2, 0.8, 1.0, 1.0, 0.8, 0.2, 0.0], abs=1e-12)
    assert legs.position[3:5] == pytest.approx([0.35, 1.65])
    assert legs.end == pytest.approx(2.7)


# Speeding up to v takes half of the way: v/2 (v/a + a/j), or without the largest acceleration v sqrt(v/j).
@pytest.mark.parametrize(
    ("distance", "peak"), [(0.5, math.sqrt(1.04) - 0.2), (0.01, (2.5e-4) ** (1.0 / 3.0))]
)
def test_a_leg_without_a_cruise_keeps_its_jerk_and_lowers_the_rest(distance, peak):
    t = np.linspace(0.0, legs_through([distance], 1e3, 2.0, 10.0).end, 4001)
    x, v, a = legs_through([distance], 1e3, 2.0, 10.0).sample(t)
    assert np.max(v) == pytest.approx(peak, rel=1e-5)
    assert np.max(np.abs(np.diff(a) / np.diff(t))) == pytest.approx(10.0, rel=1e-3)
    assert x[-1] == pytest.approx(distance)


def test_legs_follow_each_other_and_a_leg_of_no_length_takes_no_time():
    legs = legs_through([1.0, 1.0, -1.0], 1.0, 1e6)
    assert legs.end == pytest.approx(3.0, abs=1e-5)
    x, v, _ = legs.sample(np.array([-1.0, 0.5, 1.5, 2.5, 9.0]))
    assert x == pytest.approx([0.0, 0.5, 0.5, -0.5, -1.0], abs=1e-5)
    assert v == pytest.approx([0.0, 1.0, -1.0, -1.0, 0.0], abs=1e-5)


CHIRP = partial(chirp, amplitude=1.0, f_0=1.0, f_1=2.0, duration=1.0)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        *((lambda ramp=ramp: CHIRP(ramp=ramp), "Shorten the ramp") for ramp in (0.6, 0.51)),
        (lambda: recorded(position=[0.0, 1.0], sample_time=1.0), "at least 3 positions"),
    ],
)
def test_a_ramp_takes_half_of_a_chirp_at_most_and_a_record_three_positions_at_least(call, words):
    assert CHIRP(ramp=0.5).values["ramp"] == 0.5
    with pytest.raises(InputError, match=words):
        call()
