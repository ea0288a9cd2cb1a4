"""Where a motion turns: noise and rests make no half-cycle, and every sample belongs to one."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from bristle.logs import turns
from bristle.logs.turns import (
    graininess,
    half_cycle_numbers,
    legs_of,
    noise_of,
    numbered,
    period_of,
    rests,
    rests_of,
    reversals,
    turning_points,
    whole_cycle,
    with_sides,
)

MOTIONS = st.lists(st.integers(-20, 20), min_size=2, max_size=60).map(
    lambda steps: np.cumsum(steps).astype(float)
)


RESTING = np.array([1.0, 0.0, -0.0, -1.0, -1.0, 0.0, 0.0, -1.0])
NOISY = np.array([0.0, 5.0, 4.9, 5.1, 0.0, 0.1, 0.0, 5.0])
STAY = np.concatenate([np.arange(10.0), np.full(12, 10.0), np.arange(11.0, 21.0)])


@pytest.mark.parametrize(
    ("call", "places"),
    [
        # A rest belongs to the motion before it unless its zero has a sign.
        (lambda: reversals(RESTING), [3]),
        (lambda: reversals(RESTING, sided=True), [2, 5, 7]),
        # Noise makes no turn, and a stroke does.
        (lambda: turning_points(NOISY, 1.0), [3, 4]),
        (lambda: turning_points(NOISY, 1.0, reversals(np.diff(NOISY)).tolist()), [3, 4]),
        (lambda: turning_points(NOISY), reversals(np.diff(NOISY)).tolist()),
        (lambda: turning_points(NOISY, 0.05), reversals(np.diff(NOISY)).tolist()),
        # Of a motion to and fro the farthest sample is the turning point.
        (lambda: turning_points(np.array([0.0, 3.0, 2.5, 4.0, 3.9, 0.0]), 1.0), [3]),
        (lambda: turning_points(np.array([0.0, -3.0, -2.5, -4.0, 0.0]), 1.0), [3]),
        (lambda: turning_points(np.array([0.0, 1.0, 0.0]), 1.0), []),  # no farther than the least
        # A rest lasts over whole windows, unlike a turning point.
        # A step to either side is within one.
        (lambda: np.flatnonzero(rests(STAY, 3, 1.0)), list(range(9, 23))),
        (lambda: np.flatnonzero(rests(np.arange(30.0), 3, 1.0)), []),
        (lambda: np.flatnonzero(rests(np.abs(np.arange(-15.0, 16.0)), 3, 1.0)), []),
        (lambda: np.flatnonzero(rests(np.zeros(8), 3, 1.0)), list(range(8))),
        (lambda: rests_of(np.arange(5.0), 0.4, 0.01), []),
        (lambda: rests_of(np.arange(60.0), 0.4, 0.01), []),
        # An axis that never moves has no side.
        (
            lambda: np.signbit(with_sides(np.array([-1.0, 2.0]), np.array([True, True]))),
            [False, False],
        ),
        (lambda: with_sides(np.array([-1.0, 2.0]), np.array([False, False])), [-1.0, 2.0]),
    ],
)
def test_turns_and_rests_are_where_the_motion_has_them(call, places):
    assert np.array_equal(call(), places)


@given(MOTIONS)
def test_steps_turn_where_the_position_is_extreme(position):
    turns = reversals(np.diff(position))
    before = [
        np.diff(position)[:k][np.flatnonzero(np.diff(position)[:k])[-1]] for k in turns.tolist()
    ]
    assert all(
        back * np.diff(position)[k] < 0.0 for back, k in zip(before, turns.tolist(), strict=True)
    )


@given(MOTIONS, st.sampled_from([2.0, 7.0, 15.0]))
def test_turns_lie_as_far_apart_as_is_asked_for(position, least):
    turns = turning_points(position, least)
    heights = position[[0, *turns]]
    assert np.all(np.abs(np.diff(heights)) > least)
    ways = np.diff(heights)
    assert np.all(ways[1:] * ways[:-1] < 0.0)


@given(
    st.lists(
        st.lists(st.integers(1, 19), max_size=5, unique=True).map(sorted), min_size=1, max_size=4
    )
)
def test_half_cycles_are_counted_through_all_segments(turns):
    numbers = np.concatenate(half_cycle_numbers(turns, [20] * len(turns)))
    assert numbers.size == 20 * len(turns)
    assert set(np.diff(numbers)) <= {0, 1}
    assert numbers[-1] + 1 == sum(len(turn) + 1 for turn in turns)
    assert numbered(turns[0], 20) == pytest.approx(numbers[:20])
    assert all(numbers[k] == numbers[k - 1] + 1 for k in turns[0])


def test_a_cycle_is_over_where_the_motion_passes_its_beginning_in_the_same_direction():
    phase = 2.0 * np.pi * np.arange(2500) / 1000.0 + 0.5
    position, velocity = -np.cos(phase), np.sin(phase)
    downward = int(np.argmax((position < position[0]) & (velocity < 0.0)))
    assert whole_cycle(position, velocity) == 1000 > downward > 500
    assert whole_cycle(position[:900], velocity[:900]) is None


TIME = 0.01 * np.arange(3000)
SINE = 7.0 + np.sin(2.0 * np.pi * TIME / 2.5)
TWO = np.sin(2.0 * np.pi * TIME / 1.5) + 0.8 * np.sin(2.0 * np.pi * TIME / 3.0)
NOISE = np.random.default_rng(1).standard_normal(3000)


@pytest.mark.parametrize(
    ("motion", "dt", "likeness", "period"),
    [
        (SINE - 7.0, 0.01, 0.9, pytest.approx(2.5, rel=0.01)),
        (SINE, 0.01, 0.9, pytest.approx(2.5, rel=0.01)),
        (SINE, 0.02, 0.9, pytest.approx(5.0, rel=0.01)),
        (SINE[:400], 0.01, 0.9, None),  # 1.6 periods
        (TIME**2, 0.01, 0.9, None),
        (np.ones(500), 0.01, 0.9, None),
        (TWO, 0.01, 0.9, pytest.approx(3.0, rel=0.01)),  # its halves are similar
        (NOISE, 0.01, 0.5, None),
        (NOISE + TWO, 0.01, 0.9, None),  # less alike than is asked for
        (NOISE + TWO, 0.01, 0.3, pytest.approx(3.0, rel=0.02)),
    ],
)
def test_a_period_is_whole_and_that_of_the_motion_wherever_its_middle_lies(
    motion, dt, likeness, period
):
    assert period_of(motion, dt, likeness, 2.0) == period


def test_second_differences_separate_noise_from_motion():
    noise = 0.01 * np.random.default_rng(2).standard_normal(20_000)
    motion = np.sin(np.linspace(0.0, 6.0, noise.size)) + noise
    assert [noise_of(signal) for signal in (motion, np.arange(9.0), np.ones(2))] == pytest.approx(
        [0.01, 0.0, 0.0], rel=0.03
    )
    # Four times the noise, or two steps and a half of the encoder.
    signals = (
        (motion, 1e-9),
        (np.arange(9.0), 0.2),
        (2.0 * np.arange(9.0), None),
        (np.ones(9), None),
    )
    assert [graininess(*signal) for signal in signals] == pytest.approx(
        [0.04, 0.5, 5.0, 0.0], rel=0.03
    )


def test_a_rest_lasts_longer_than_an_eighth_of_a_second_within_a_grain():
    dt = 0.01
    ramp = np.arange(1.0, 41.0)
    position = np.concatenate(
        [np.zeros(30), ramp, np.full(8, 41.0), 41.0 + ramp, np.full(30, 82.0)]
    )
    first, last = rests_of(position, 0.4, dt)
    assert (first.start, last.stop) == (0, position.size)
    assert first.stop == pytest.approx(30, abs=1)
    assert last.start == pytest.approx(position.size - 30, abs=1)


def test_legs_go_from_rest_to_turning_point_at_the_speed_of_their_cruise():
    dt, grain = 0.01, 0.02
    speed = np.concatenate(
        [
            np.zeros(30),
            np.linspace(0.0, 2.0, 20),
            np.full(160, 2.0),
            np.full(100, -2.0),
            np.zeros(30),
        ]
    )
    position = np.cumsum(dt * speed)
    outward, back = legs_of(position, rests_of(position, grain, dt), grain, dt)
    assert (outward.from_rest, back.from_rest) == (True, False)
    assert (outward.speed, back.speed) == (
        pytest.approx(2.0, rel=0.01),
        pytest.approx(2.0, rel=0.01),
    )
    assert outward.last == back.first == 209
    assert [outward.distance, back.distance] == pytest.approx(
        [position[209], -2.0], abs=2.0 * grain
    )
    assert back.duration == pytest.approx(1.0, abs=0.06)
    assert 0.85 < outward.cruise_share < 1.0
    # Where the speed is reached.
    assert position[outward.cruise.start] == pytest.approx(0.2, abs=0.2)


def test_a_tiny_leg_between_long_legs_merges_with_them():
    dt, grain = 0.01, 1e-4
    speed = np.concatenate(
        [np.full(200, 1.0), np.full(4, -0.5), np.full(4, 0.5), np.full(200, -1.0)]
    )
    position = np.cumsum(dt * speed)
    outward, back = legs_of(position, [], grain, dt)
    assert [outward.distance, back.distance] == pytest.approx([2.0, -2.0], abs=0.05)
    assert not outward.from_rest


def waves(samples, count=5000):
    return np.sin(2.0 * np.pi * np.arange(count) / samples)


@pytest.mark.parametrize(
    ("motion", "period"),
    [
        (waves(137.0) + 0.3 * waves(137.0 / 3.0), pytest.approx(68.5)),
        (np.arange(5000.0) ** 2, None),
        (waves(637.0), pytest.approx(318.5)),  # which the first thousand do not show
        (waves(7.0), pytest.approx(3.5)),  # of which every fifth sample looks five times as slow
        (np.concatenate([waves(7.0, 1500), NOISE, NOISE[:500]]), None),
    ],
)
def test_the_period_of_a_long_motion_is_found_to_the_sample(monkeypatch, motion, period):
    monkeypatch.setattr(turns, "LONG", 1000)
    assert period_of(motion, 0.5, 0.9, 2.0) == period
