"""Where a motion turns: noise and rests make no half-cycle, and every sample belongs to one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bristle.logs.turns import half_cycle_numbers, numbered, reversals, turning_points, whole_cycle

MOTIONS = st.lists(st.integers(-20, 20), min_size=2, max_size=60).map(lambda steps: np.cumsum(steps).astype(float))


def test_a_rest_belongs_to_the_motion_before_it_unless_its_zero_has_a_sign():
    velocity = np.array([1.0, 0.0, -0.0, -1.0, -1.0, 0.0, 0.0, -1.0])
    assert reversals(velocity).tolist() == [3]
    assert reversals(velocity, sided=True).tolist() == [2, 5, 7]


@given(MOTIONS)
def test_steps_turn_where_the_position_is_extreme(position):
    turns = reversals(np.diff(position))
    before = [np.diff(position)[:k][np.flatnonzero(np.diff(position)[:k])[-1]] for k in turns.tolist()]
    assert all(back * np.diff(position)[k] < 0.0 for back, k in zip(before, turns.tolist(), strict=True))


@given(MOTIONS, st.sampled_from([2.0, 7.0, 15.0]))
def test_turns_lie_as_far_apart_as_is_asked_for(position, least):
    turns = turning_points(position, least)
    heights = position[[0, *turns]]
    assert np.all(np.abs(np.diff(heights)) > least)
    ways = np.diff(heights)
    assert np.all(ways[1:] * ways[:-1] < 0.0)


def test_noise_makes_no_turn_and_a_stroke_does():
    position = np.array([0.0, 5.0, 4.9, 5.1, 0.0, 0.1, 0.0, 5.0])
    candidates = reversals(np.diff(position)).tolist()
    assert turning_points(position, 1.0) == turning_points(position, 1.0, candidates) == [3, 4]
    assert turning_points(position) == turning_points(position, 0.05) == candidates


@given(st.lists(st.lists(st.integers(1, 19), max_size=5, unique=True).map(sorted), min_size=1, max_size=4))
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
