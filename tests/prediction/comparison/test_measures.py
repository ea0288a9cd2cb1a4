"""What is measured of cycles: levels, peaks behind reversals, means over cycles, and friction by ranges of speed."""

import numpy as np
import pytest

from bristle.prediction.comparison import measures
from bristle.prediction.comparison.cycles import Cycle, Recording, Side
from bristle.prediction.comparison.measures import (
    SlidingRows,
    course_of,
    level_measures,
    turn_courses,
    turn_measures,
)

STEP = 0.5  # s


def recording(motion, error=None, *, effort=None, sliding=None, turns=()):
    """A stretch of a log with two samples in a second."""
    parts = (
        None if part is None else np.array(part, dtype=float) for part in (error, effort, sliding)
    )
    return Recording(STEP, np.array(motion, dtype=float), *parts, np.array(turns, dtype=int))


def side(stretch, *cycles):
    """The cycles of a stretch, each from a sample to another, with the number of its motion."""
    return Side([Cycle(stretch, slice(begin, end), kind) for begin, end, kind in cycles])


# A motion that turns back at the samples 3 and 9 and forward at 0, 6 and 12.
ZIGZAG = [0, 1, 2, 3, 2, 1, 0, 1, 2, 3, 2, 1, 0]


def values_of(measure, *sides):
    """What a quantity is, of each side."""
    return [float(measure.value(measure.sums(chosen).sum(axis=0))) for chosen in sides]


def test_levels_are_the_root_mean_square_of_all_samples_and_the_mean_of_peaks():
    chosen = side(recording(range(6), [3.0, -4.0, 0.0, 1.0, -2.0, 9.0]), (0, 2, 0), (2, 5, 0))
    rms, peak = level_measures("error", "following_error", "length")
    assert (rms.name, peak.name) == ("following_error.rms", "following_error.peak")
    assert {rms.quantity, peak.quantity} == {"length"}
    assert values_of(rms, chosen) == pytest.approx([np.sqrt(30.0 / 5.0)])
    assert values_of(peak, chosen) == [3.0]  # of 4 and 2
    assert rms.sums(chosen).tolist() == [[25.0, 2.0], [5.0, 3.0]]


def test_peaks_after_reversals_are_those_of_each_direction():
    error = np.zeros(13)
    error[[3, 6, 8, 9, 11]] = 7.0, -1.0, 3.0, -2.0, 5.0
    stretch = recording(ZIGZAG, error, turns=[0, 3, 6, 9, 12])
    backward, forward = turn_measures(2)
    assert (backward.name, forward.name) == (
        "reversals.forward_to_backward",
        "reversals.backward_to_forward",
    )
    assert backward.quantity == forward.quantity == "length"
    chosen = side(stretch, (0, 6, 0), (6, 12, 0))
    # Behind 3 it is 7, behind 9 it is 5, which lies at the end of the window; behind 0 nothing, behind 6 it is 3.
    assert backward.sums(chosen).tolist() == [[7.0, 1.0], [5.0, 1.0]]
    assert forward.sums(chosen).tolist() == [[0.0, 1.0], [3.0, 1.0]]
    assert values_of(backward, chosen) == [6.0]
    # A log may begin with a reversal.
    assert turn_measures(1)[1].sums(chosen).tolist() == [[0.0, 1.0], [1.0, 1.0]]


def test_a_reversal_counts_in_the_cycle_that_begins_with_it():
    error = np.zeros(13)
    error[6] = 4.0
    stretch = recording(ZIGZAG, error, turns=[3, 6, 9])
    forward = turn_measures(1)[1]
    assert forward.sums(side(stretch, (0, 6, 0))).tolist() == [[0.0, 0.0]]
    assert forward.sums(side(stretch, (6, 9, 0))).tolist() == [[4.0, 1.0]]


def test_a_window_that_ends_after_the_log_is_ignored():
    stretch = recording(ZIGZAG, np.ones(13), turns=[9])
    chosen = side(stretch, (6, 13, 0))
    assert turn_measures(3)[0].sums(chosen).tolist() == [[1.0, 1.0]]  # sample 12 is the last one
    assert turn_measures(4)[0].sums(chosen).tolist() == [[0.0, 0.0]]


@pytest.mark.parametrize(
    ("sides", "follows", "expected"),
    [
        (
            (
                side(
                    recording([0, 1, 0, 2, 3, 0, 1, 0], [1, 2, 3, 4, 5, 6, 7, 8]),
                    (0, 3, 0),
                    (3, 5, 1),
                    (5, 8, 0),
                ),
                side(recording([0, 1, 0, 2, 3], [10, 20, 30, 40, 50]), (0, 3, 0), (3, 5, 1)),
            ),
            True,
            {
                "time": [0.0, 0.5, 1.0, 1.5, 2.0],
                "motion": [0.0, 1.0, 0.0, 2.0, 3.0],
                "before": [3.5, 4.5, 5.5, 4.0, 5.0],
                "after": [10.0, 20.0, 30.0, 40.0, 50.0],
            },
        ),
        # As long as the shortest cycle.
        (
            (
                side(recording([0, 1, 2, 3], [1, 1, 1, 1]), (0, 4, 0)),
                side(recording([0, 1, 2], [2, 2, 2]), (0, 3, 0)),
            ),
            True,
            {"motion": [0.0, 1.0, 2.0]},
        ),
        # Of the effort, without a reference.
        (
            (
                side(recording([0, 1], effort=[1, 2]), (0, 2, 0)),
                side(recording([0, 1], effort=[3, 4]), (0, 2, 0)),
            ),
            False,
            {"before": [1.0, 2.0], "after": [3.0, 4.0]},
        ),
    ],
)
def test_courses_are_means_over_cycles_motion_after_motion(sides, follows, expected):
    course = course_of(*sides, follows=follows)
    assert {name: getattr(course, name).tolist() for name in expected} == expected


def test_courses_around_reversals_cover_one_window_before_and_three_after():
    error = np.arange(13.0)
    stretch = recording(ZIGZAG, error, turns=[3, 6, 9])
    both = (
        side(stretch, (0, 6, 0), (6, 12, 0)),
        side(recording(ZIGZAG, 2.0 * error, turns=[3, 6, 9]), (0, 6, 0), (6, 12, 0)),
    )
    backward, forward = turn_courses(*both, 1)
    assert backward.name == "forward_to_backward"
    assert backward.time.tolist() == [-0.5, 0.0, 0.5, 1.0, 1.5]
    # The mean around 3 and 9, whose last sample is 12
    assert backward.before.tolist() == [5.0, 6.0, 7.0, 8.0, 9.0]
    assert backward.after.tolist() == [10.0, 12.0, 14.0, 16.0, 18.0]
    assert (forward.name, forward.before.tolist()) == (
        "backward_to_forward",
        [5.0, 6.0, 7.0, 8.0, 9.0],
    )


@pytest.mark.parametrize(
    ("turns", "others", "window", "names"),
    [
        ([3, 6], [3], 1, ["forward_to_backward"]),
        ([3, 6], [3, 6], 2, ["forward_to_backward", "backward_to_forward"]),
        ([0], [0], 1, []),  # no sample stands before it
        ([10], [10], 1, []),  # three windows behind it there is none
    ],
)
def test_a_direction_that_only_a_side_has_gives_no_course(turns, others, window, names):
    both = [
        side(recording(ZIGZAG, np.arange(13.0), turns=places), (0, 12, 0))
        for places in (turns, others)
    ]
    assert [turn.name for turn in turn_courses(*both, window)] == names


# --- friction ------------------------------------------------------------------------------------------------------

LEVEL, SLOPE, MASS, WEIGHT = 5.0, 2.0, 3.0, 7.0


SPEEDS = np.linspace(0.0, 1.0, 101)


def sliding(speeds=SPEEDS, *, level=LEVEL, both=True):
    """Velocity, acceleration and effort of a stroke forth and back."""
    v = np.concatenate([speeds, -speeds if both else speeds])
    a = np.cos(37.0 * np.arange(v.size))
    return np.array([v, a, MASS * a + WEIGHT + np.sign(v) * (level + SLOPE * np.abs(v))])


def strokes(*parts, kinds=None):
    """A side with a cycle of each of some strokes."""
    kinds = [0] * len(parts) if kinds is None else kinds
    stretches = [recording(np.zeros(part.shape[1]), sliding=part) for part in parts]
    return Side(
        [
            Cycle(stretch, slice(0, stretch.motion.size), kind)
            for stretch, kind in zip(stretches, kinds, strict=True)
        ]
    )


def test_ranges_of_speed_are_even_from_a_tenth_of_the_usual_top_to_the_largest():
    rows = SlidingRows(strokes(sliding(), sliding()), strokes(sliding(), sliding()))
    top = np.quantile(SPEEDS, 0.95)
    assert rows.edges == pytest.approx(np.linspace(0.1 * top, 1.0, 5), rel=1e-6)
    assert rows.ranges.tolist() == [0, 1, 2, 3]
    middles = 0.5 * (rows.edges[1:] + rows.edges[:-1])
    assert rows.speeds == pytest.approx(middles, abs=0.006)
    # Of the speeds 0.10 to 1.00 each counts in four cycles and two directions.
    assert rows.weights.sum() == 4 * 2 * 91


@pytest.mark.parametrize("scale", [1e-3, 1.0, 50.0])
def test_ranges_of_speed_and_friction_in_them_are_those_of_an_axis_of_any_speed(scale):
    rows = SlidingRows(
        *(strokes(sliding(scale * SPEEDS), sliding(scale * SPEEDS)) for _ in range(2))
    )
    usual = SlidingRows(*(strokes(sliding(), sliding()) for _ in range(2)))
    assert rows.edges / scale == pytest.approx(usual.edges)
    assert rows.ranges.tolist() == [0, 1, 2, 3]
    assert np.array(rows.speeds) / scale == pytest.approx(usual.speeds)


@pytest.mark.parametrize("faster", [0, 1])
def test_ranges_of_speed_reach_to_the_largest_of_either_side(faster):
    sides = [strokes(sliding(), sliding()), strokes(sliding(), sliding())]
    sides[faster] = strokes(sliding(2.0 * SPEEDS), sliding(2.0 * SPEEDS))
    edges = SlidingRows(*sides).edges
    assert edges[-1] == pytest.approx(2.0)
    assert edges[0] == pytest.approx(
        0.1 * np.quantile(np.concatenate([SPEEDS, 2.0 * SPEEDS]), 0.95), rel=0.01
    )


def test_friction_is_half_the_difference_between_directions_at_each_speed():
    before, after = strokes(sliding(), sliding()), strokes(sliding(level=4.0), sliding(level=4.0))
    rows = SlidingRows(before, after)
    level, *ranges = rows.measures()
    assert level.name == "friction.level"
    assert [item.name for item in ranges] == [f"friction.at_speeds.{k}" for k in range(4)]
    assert {item.quantity for item in (level, *ranges)} == {"force"}
    for item, speed in zip(ranges, rows.speeds, strict=True):
        assert values_of(item, before, after) == pytest.approx(
            [LEVEL + SLOPE * speed, 4.0 + SLOPE * speed], abs=0.01
        )
    low, high = values_of(level, before, after)
    shares = rows.weights / rows.weights.sum()
    assert low == pytest.approx(LEVEL + SLOPE * float(shares @ rows.speeds), abs=0.01)
    assert low - high == pytest.approx(1.0, abs=1e-6)


def test_a_range_without_a_direction_gives_no_friction():
    slow, fast = np.linspace(0.0, 0.5, 101), np.linspace(0.5, 1.0, 101)
    part = np.concatenate([sliding(slow), sliding(fast, both=False)], axis=1)
    rows = SlidingRows(strokes(part, part), strokes(part, part))
    assert rows.ranges.size == 2
    assert max(rows.speeds) < 0.56


def test_cycles_in_one_direction_give_no_friction():
    both, forward = strokes(sliding(), sliding()), strokes(sliding(both=False), sliding(both=False))
    measures = SlidingRows(both, both).measures()
    assert np.isnan([values_of(item, forward) for item in measures]).all()
    assert not np.isnan([values_of(item, both) for item in measures]).any()


def test_a_motion_without_rows_does_not_affect_friction():
    full, empty = sliding(), np.full_like(sliding(), np.nan)
    before, after = (strokes(full, empty, full, empty, kinds=[0, 1, 0, 1]) for _ in range(2))
    rows = SlidingRows(before, after)
    assert rows.kinds.tolist() == [0]
    sums = rows.measures()[0].sums(before)
    assert [bool(chosen.any()) for chosen in sums] == [True, False, True, False]


def test_cycles_without_rows_give_no_friction():
    bare = strokes(np.empty((3, 0)), np.empty((3, 0)))
    rows = SlidingRows(bare, bare)
    assert (rows.measures(), rows.speeds) == ([], [])


def test_rows_that_are_not_numbers_are_left_out():
    part = sliding()
    part[2, 5] = part[1, 9] = np.nan
    (cycle,) = strokes(part).cycles
    assert measures._rows(cycle).shape == (3, part.shape[1] - 2)
    (bare,) = side(recording([0, 1, 2]), (0, 3, 0)).cycles
    assert measures._rows(bare).shape == (3, 0)


def test_rows_are_those_of_the_cycle():
    part = sliding()
    chosen = side(recording(np.zeros(part.shape[1]), sliding=part), (10, 14, 0))
    assert measures._rows(chosen.cycles[0])[0].tolist() == part[0, 10:14].tolist()


@pytest.mark.parametrize(
    ("rows", "blocks", "serves"), [(10, 2, True), (9, 2, False), (19, 2, True), (40, 1, False)]
)
def test_a_range_needs_twenty_rows_from_two_blocks_in_each_direction(rows, blocks, serves):
    count = np.zeros((3, 2, 1), dtype=int)
    count[:blocks] = rows
    full = np.full((3, 2, 1), 40)
    kinds = [np.zeros(3, dtype=int)] * 2
    assert measures._serving([full, count], kinds).tolist() == ([0] if serves else [])
    assert measures._serving([count, full], kinds).tolist() == ([0] if serves else [])
    half = full.copy()
    half[:, 1] = 0
    assert measures._serving([half, full], kinds).tolist() == []


def test_blocks_of_paired_motions_are_the_motions():
    kinds = [np.array([0, 1, 2, 3])] * 2
    count, full = np.zeros((4, 2, 1), dtype=int), np.full((4, 2, 1), 40)
    count[:2] = 10
    assert measures._serving([count, full], kinds).tolist() == [0]
    count[0], count[1] = 20, 0
    assert measures._serving([count, full], kinds).tolist() == []
