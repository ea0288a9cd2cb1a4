"""Desired motions: within their limits, where they should end, and velocity the derivative of position."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bristle import references
from bristle.core import InputError
from bristle.references import chirp, s_curve, sine, triangle

positive = st.floats(1e-3, 1e3)

MOTIONS = {
    "s_curve": s_curve(distance=-0.1, velocity=0.2, acceleration=2.0, jerk=50.0),
    "s_curve without limit of the jerk": s_curve(distance=0.1, velocity=0.2, acceleration=2.0),
    "triangle": triangle(amplitude=7e-6, velocity=1e-5, acceleration=1e-3, cycle_count=3, ratio=0.7),
    "chirp": chirp(amplitude=1e-6, f_0=5.0, f_1=60.0, duration=2.0, ramp=0.3),
    "chirp of one frequency": chirp(amplitude=1e-6, f_0=5.0, f_1=5.0, duration=2.0, ramp=0.3),
    "sine": sine(amplitude=1e-3, frequency=2.0, ramp=0.5),
}


def sampled(model, t):
    return model.component.sample(t, model.parameters)


def duration(model):
    return model.component.duration(model.parameters)


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("name", MOTIONS)
def test_velocity_and_acceleration_are_derivatives(name):
    model = MOTIONS[name]
    end = duration(model) if hasattr(model.component, "duration") else 2.0
    t = np.linspace(-0.1 * end, 1.1 * end if hasattr(model.component, "duration") else end, 60_001)
    x, v, a = sampled(model, t)
    step = np.diff(t)
    assert np.diff(x) == pytest.approx(0.5 * (v[1:] + v[:-1]) * step, abs=1e-6 * np.ptp(x))
    # Where the acceleration jumps, a trapezoid is off by half a step of it.
    assert v[1:] - v[0] == pytest.approx(np.cumsum(0.5 * (a[1:] + a[:-1]) * step), abs=0.02 * np.max(np.abs(v)))


@given(distance=positive, velocity=positive, acceleration=positive, jerk=positive | st.just(math.inf))
@settings(max_examples=60, deadline=None)
def test_a_move_ends_where_it_should_and_keeps_its_limits(distance, velocity, acceleration, jerk):
    model = s_curve(distance=distance, velocity=velocity, acceleration=acceleration, jerk=jerk)
    end = duration(model)
    x, v, a = sampled(model, np.linspace(0.0, 1.01 * end, 3000))
    assert x[0] == 0.0
    assert x[-1] == distance
    assert np.all(np.diff(x) >= -1e-12 * distance)
    assert np.max(np.abs(v)) <= velocity * (1.0 + 1e-9)
    assert np.max(np.abs(a)) <= acceleration * (1.0 + 1e-9)
    assert np.max(np.abs(np.diff(a))) <= jerk * end * 1.01 / 2999 * (1.0 + 1e-6) + 1e-9 * acceleration


@pytest.mark.parametrize(
    ("limits", "shortest"),
    [
        ({"velocity": 1e9, "acceleration": 2.0}, 2.0 * math.sqrt(0.1 / 2.0)),
        ({"velocity": 0.2, "acceleration": 2.0}, 0.1 / 0.2 + 0.2 / 2.0),
        ({"velocity": 1e9, "acceleration": 1e9, "jerk": 50.0}, (32.0 * 0.1 / 50.0) ** (1.0 / 3.0)),
        ({"velocity": 0.2, "acceleration": 2.0, "jerk": 50.0}, 0.1 / 0.2 + 0.2 / 2.0 + 2.0 / 50.0),
    ],
)
def test_a_move_takes_the_shortest_time_there_is(limits, shortest):
    assert duration(s_curve(distance=0.1, **limits)) == pytest.approx(shortest, rel=1e-9)


@pytest.mark.parametrize("ratio", [1.0, 0.8, 1.25])
def test_triangles_turn_where_they_should(ratio):
    model = triangle(amplitude=2.0, velocity=1.0, acceleration=10.0, cycle_count=3, ratio=ratio)
    t = np.linspace(0.0, duration(model), 200_001)
    x, v, _ = sampled(model, t)
    turns = np.flatnonzero(np.sign(v[1:-1]) * np.sign(v[2:]) < 0) + 1
    assert x[turns] == pytest.approx([2.0 * (-ratio) ** k for k in range(6)], abs=1e-6)
    assert x[-1] == pytest.approx(0.0, abs=1e-12)


def test_a_triangle_may_begin_backward():
    forward, backward = (triangle(amplitude=a, velocity=1.0, acceleration=10.0) for a in (2.0, -2.0))
    t = np.linspace(0.0, duration(forward), 1001)
    assert sampled(backward, t)[0] == pytest.approx(-sampled(forward, t)[0])


def test_a_chirp_passes_every_frequency_in_the_time_that_its_sweep_gives_it():
    model = chirp(amplitude=1.0, f_0=2.0, f_1=32.0, duration=8.0)
    t = np.linspace(0.0, 8.0, 800_001)
    x, _, _ = sampled(model, t)
    crossings = t[1:][np.sign(x[1:]) != np.sign(x[:-1])]
    halves = np.diff(crossings)
    # Four octaves in eight seconds: two seconds for each.
    for octave in range(4):
        inside = halves[(crossings[1:] > 2.0 * octave) & (crossings[1:] < 2.0 * octave + 2.0)]
        assert 0.5 / inside[1] == pytest.approx(2.0 * 2.0**octave, rel=0.25)
        assert 0.5 / inside[-2] == pytest.approx(4.0 * 2.0**octave, rel=0.25)


def test_a_ramp_longer_than_the_chirp_is_refused():
    with pytest.raises(InputError, match="Shorten the ramp"):
        chirp(amplitude=1.0, f_0=1.0, f_1=2.0, duration=1.0, ramp=0.6)


def test_all_references_are_known_by_name():
    assert set(references.REFERENCES) == {"recorded", "sine", "varied_sine", "s_curve", "triangle", "chirp", "circle"}
