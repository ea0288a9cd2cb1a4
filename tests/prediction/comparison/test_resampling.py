"""Which cycles are compared, how many count as one, and how wide an interval is: small cases worked out by hand."""

import math

import numpy as np
import pytest
from scipy import stats
from tests.prediction.comparison.machine import correlated

from bristle.prediction.comparison import resampling
from bristle.prediction.comparison.resampling import changed, plan_of


def mean(sums):
    """The mean of what sums and numbers say."""
    return sums[..., 0] / sums[..., 1]


def counted(*values):
    """Each value with the number 1."""
    return np.stack([np.array(values, dtype=float), np.ones(len(values))], axis=1)


@pytest.mark.parametrize(
    ("before", "after", "is_paired"),
    [
        ([0, 0, 1], [0, 0, 1], False),  # 4 of 6 cycles come again
        ([0, 0, 1, 2], [0, 0, 1, 2], False),  # 4 of 8
        ([0, 0, 1, 2, 3], [0, 0, 1, 2, 3], True),  # 4 of 10
        (3 * [*range(6)], 3 * [*range(6)], True),  # six motions, three times each
        (4 * [*range(6)], 4 * [*range(6)], False),
        (3 * [*range(5)], 3 * [*range(5)], False),
        ([0, 0, 0], [0], True),  # a motion that comes once on one side
        ([0, 0, 5, 5], [0, 0, 6, 6], False),  # motions of one side alone do not count
    ],
)
def test_cycles_are_drawn_as_pairs_if_most_motions_are_rare(before, after, is_paired):
    assert plan_of(before, after).paired is is_paired


def test_motions_that_occur_once_are_left_out_if_others_repeat():
    plan = plan_of([0, 1, 0, 0], [1, 0, 0])
    assert (plan.before.tolist(), plan.after.tolist()) == ([0, 2, 3], [1, 2])
    assert (plan.kinds_before.tolist(), plan.kinds_after.tolist()) == ([0, 0, 0], [0, 0])


def test_no_cycle_is_compared_without_a_motion_in_common():
    plan = plan_of([0, 0], [1, 1])
    assert plan.before.size == plan.after.size == 0
    assert (
        changed(
            mean,
            counted(1, 2),
            counted(3, 4),
            plan_of([0, 0], [0, 0])._replace(kinds_after=np.array([1, 1])),
        )
        is None
    )


@pytest.mark.parametrize(
    ("before", "after", "kinds", "expected"),
    [
        # Sides without scatter.
        ([2, 2, 2], [3, 3, 3], ([0, 0, 0], [0, 0, 0]), (2.0, 3.0, (1.0, 1.0))),
        # However much paired motions differ, the second side is half of the first one, or shifted through zero.
        ([1, 5, 2, 9, 3], [0.5, 2.5, 1, 4.5, 1.5], (range(5), range(5)), (4.0, 2.0, (-2.0, -2.0))),
        ([1, -5, 2, -9, 3], [3, -3, 4, -7, 5], (range(5), range(5)), (-1.6, 0.4, (2.0, 2.0))),
        # Motion 0 has the value 1 and 3, motion 1 the value 2 and 4, both the same weight on both sides.
        (
            [1, 1, 1, 1, 2, 2],
            [3, 3, 4, 4, 4, 4],
            ([0, 0, 0, 0, 1, 1], [0, 0, 1, 1, 1, 1]),
            (1.5, 3.5, (2.0, 2.0)),
        ),
        # A single pair.
        ([4], [6], ([0], [0]), (4.0, 6.0, None)),
    ],
)
def test_a_change_that_does_not_scatter_is_exact(before, after, kinds, expected):
    result = changed(mean, counted(*before), counted(*after), plan_of(*kinds))
    assert (result.before, result.after) == pytest.approx(expected[:2])
    assert result.interval == (expected[2] and pytest.approx(expected[2]))
    assert result.as_one == 1.0


def test_paired_cycles_of_a_motion_are_combined():
    # Motion 7 is 3.5 and 6, motion 2 is 1 and 2, motion 3 is 1 and 8.
    result = changed(mean, counted(4, 1, 3, 1), counted(6, 2, 8), plan_of([7, 2, 7, 3], [7, 2, 3]))
    assert (result.before, result.after) == (pytest.approx(5.5 / 3.0), pytest.approx(16.0 / 3.0))


def test_cycles_without_any_sum_do_not_count():
    kinds = [0, 0, 0, 0]
    sums = counted(1, 2, 3, 0)
    sums[3] = 0.0
    expected = changed(mean, counted(1, 2, 3), counted(2, 3, 4, 5), plan_of([0, 0, 0], kinds))
    assert changed(mean, sums, counted(2, 3, 4, 5), plan_of(kinds, kinds)) == expected
    assert (expected.before, expected.after) == (2.0, 3.5)


# In an order in which neighbours differ.
PAIRED = np.array([1.2, 1.9, 0.7, 1.5, 0.4, 2.3, 1.1, 1.6])
T_7 = 2.364624  # Student's t of 7 degrees of freedom, at 0.975


def test_the_interval_of_paired_motions_is_that_of_students_t():
    error = T_7 * np.std(PAIRED, ddof=1) / math.sqrt(8.0)
    shifted = changed(
        mean, counted(*(PAIRED - PAIRED)), counted(*PAIRED), plan_of(range(8), range(8))
    )
    assert shifted.interval == (
        pytest.approx(PAIRED.mean() - error, rel=0.06),
        pytest.approx(PAIRED.mean() + error, rel=0.06),
    )
    # Small shares of a value are the same in a ratio.
    near = 1.0 + 0.01 * PAIRED
    ratio = changed(mean, counted(*8 * [1.0]), counted(*near), plan_of(range(8), range(8)))
    assert np.mean(ratio.interval) == pytest.approx(0.01 * PAIRED.mean(), rel=0.01)
    assert 0.5 * np.ptp(ratio.interval) == pytest.approx(0.01 * error, rel=0.06)


def test_an_infinite_ratio_stays_a_number():
    sizes = counted(1e-200, 1.0, 1e-200, 1e-200, 1e-200)
    result = changed(mean, sizes, sizes[::-1], plan_of(range(5), range(5)))
    assert all(map(math.isfinite, result.interval))
    assert result.interval[1] == pytest.approx(result.before * math.exp(100.0), rel=0.1)


def test_cycles_that_scatter_less_have_a_narrower_interval():
    signs, plan = np.array([1, -1, -1, 1, 1, 1, -1, -1]), plan_of(8 * [0], 8 * [0])
    wide, narrow = (
        changed(mean, counted(*(5.0 + scatter * signs)), counted(*8 * [6.0]), plan)
        for scatter in (1.0, 0.5)
    )
    widths = [np.ptp(result.interval) for result in (wide, narrow)]
    assert widths[0] == pytest.approx(2.0 * widths[1], rel=1e-6)
    assert np.mean(wide.interval) == pytest.approx(1.0)


def test_the_side_with_scatter_determines_the_degrees_of_freedom():
    # Of the two, only eight cycles scatter: Student's t with 7 degrees of freedom and the variance of their mean.
    values = np.array([1, -1, -1, 1, -1, 1, 1, -1]) + 5.0
    result = changed(mean, counted(*values), counted(*30 * [6.0]), plan_of(8 * [0], 30 * [0]))
    assert 0.5 * np.ptp(result.interval) == pytest.approx(
        2.3646 * math.sqrt(8.0 / 7.0 / 8.0), rel=0.06
    )


LOGS = np.array([5.0, 5.4, 4.9, 5.1]), np.array([3.0, 3.1, 3.3, 3.5])


def recordings(before, after, places=((0, 3, 5, 6), (1, 2, 4, 7)), *, in_turn=False):
    """The change of the mean of logs of two cycles each, which scatter by one per cent of the first log."""
    sides = [
        counted(*(np.repeat(side, 2) + np.tile([0.01, -0.01], len(side))))
        for side in (before, after)
    ]
    kinds = [np.zeros(len(side), dtype=int) for side in sides]
    return changed(
        mean,
        *sides,
        plan_of(*kinds, *(np.repeat(own, 2) for own in places))._replace(in_turn=in_turn),
    )


def test_the_logs_of_a_side_are_the_replicates_of_its_interval():
    result = recordings(*LOGS)
    expected = stats.ttest_ind(LOGS[1], LOGS[0], equal_var=False).confidence_interval()
    assert result.interval == pytest.approx(tuple(expected), rel=1e-3)
    assert result.as_one == 1.0


def test_a_drift_of_alternate_recordings_cancels_on_each_side():
    drift = 5.0 + 0.3 * np.array([0, 3, 5, 6]), 3.0 - 0.2 * np.array([1, 2, 4, 7])
    result = recordings(*drift, in_turn=True)
    assert result.interval == pytest.approx((-3.75, -3.75), abs=1e-6)
    assert np.ptp(recordings(*drift).interval) > 1.0


@pytest.mark.parametrize(
    "places",
    [((0, 1, 2, 3), (4, 5, 6, 7)), ((0, 2, 4, 6), (1, 3, 5, 7))],
    ids=["one side after the other", "by turns"],
)
def test_a_drift_that_does_not_cancel_stays_in_the_interval(places):
    drift = [5.0 + 0.3 * np.array(own) for own in places]
    assert recordings(*drift, places, in_turn=True) == recordings(*drift, places)


def test_two_logs_of_a_side_keep_their_drift():
    low, high = recordings([5.0, 5.9], [3.3, 3.6], ((0, 3), (1, 2)), in_turn=True).interval
    # More than by Student's t of 3 degrees of freedom.
    assert high - low > 2.0 * 3.18 * math.sqrt(0.45**2 + 0.15**2)


def test_a_single_log_of_a_side_has_the_scatter_of_its_cycles():
    one, four = ((0,), (1, 2, 3, 4)), LOGS[1]
    assert recordings([5.0], four, one, in_turn=True) == recordings([5.0], four, one)
    alone = recordings([5.0], [3.2], ((0,), (1,)))
    assert np.ptp(alone.interval) < np.ptp(recordings([5.0], four, one).interval)


@pytest.mark.parametrize(
    ("found", "given", "expected"),
    [
        # Correlated neighbours count as fewer cycles.
        (resampling._as_one, ([1.0, -1.0, 1.0, -1.0],), 1.0),  # neighbours that differ
        # A correlation of a quarter, raised by a quarter.
        (resampling._as_one, ([1.0, 1.0, -1.0, -1.0],), 2.0),
        (resampling._as_one, ([1.0, 1.0, 1.0, -1.0, -1.0, -1.0],), 1.0 + 2.0 * (0.5 + 1.0 / 6.0)),
        (resampling._as_one, ([0.0, 0.0, 0.0, 0.0],), 1.0),
        (resampling._as_one, ([1.0, -1.0],), 1.0),
        (
            resampling._as_one,
            ([1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0, 0.0],),
            1.0 + 2.0 * (5.0 / 8.0 + 2.0 / 8.0 + 2.0 / 9.0),
        ),
        (resampling._as_one, ([1.0, 2.0, 2.0, 1.0],), 2.0),  # half of all at most
        # A variance is raised for few correlated cycles: of 1 and 3 it is 1. Its freedom does not fall below 1.
        (
            resampling._spread,
            ([1.0, 3.0, np.nan, np.inf], 12, 2, 1.5),
            (1.5 * 12.0 / 10.0, 12.0 / 1.5 - 2.0),
        ),
        (resampling._spread, ([1.0, 3.0], 2, 1, 1.0), (2.0, 1.0)),
        (resampling._spread, ([1.0, 3.0], 4, 1, 2.0), (8.0 / 3.0, 1.0)),
        # An interval lies evenly about the change.
        (resampling._interval, (2.0, 4.0, 1e9), (2.0 - 2.0 * 1.959964, 2.0 + 2.0 * 1.959964)),
        (resampling._interval, (0.0, 1.0, 1.0), (-12.7062, 12.7062)),
    ],
)
def test_numbers_of_an_interval_are_those_by_hand(found, given, expected):
    assert found(
        *(np.array(item) if isinstance(item, list) else item for item in given)
    ) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.8])
def test_the_number_per_independent_cycle_follows_a_known_correlation(correlation):
    values = correlated(np.random.default_rng(4), 40_000, correlation)
    expected = (1.0 + correlation) / (1.0 - correlation)
    assert resampling._as_one(values - values.mean()) == pytest.approx(expected, rel=0.06)


def test_the_influence_of_a_cycle_is_its_distance_from_its_motion():
    values, kinds = np.array([1.0, 3.0, 10.0, 14.0]), np.array([0, 0, 2, 2])
    influence = resampling._influence(lambda sums: sums[..., 0], values[:, None], np.ones(4), kinds)
    assert influence == pytest.approx([-1.0, 1.0, -2.0, 2.0])


def test_an_indispensable_cycle_has_no_influence():
    with np.errstate(invalid="ignore"):
        influence = resampling._influence(
            mean, np.array([[2.0, 1.0]]), np.ones(1), np.zeros(1, dtype=int)
        )
    assert influence.tolist() == [0.0]


def test_draws_keep_the_number_of_cycles_and_are_enough_for_two_digits_of_a_variance():
    drawn = resampling._draws(7, np.random.default_rng(1))
    assert drawn.sum(axis=1).tolist() == [7.0] * len(drawn)
    assert np.mean(drawn, axis=0) == pytest.approx(np.ones(7), abs=0.15)
    assert 1.0 / math.sqrt(2.0 * len(drawn)) < 0.03


@pytest.mark.parametrize(
    ("change", "variance"), [(math.nan, 1.0), (1.0, math.nan), (math.inf, 1.0)]
)
def test_a_missing_number_has_no_interval(change, variance):
    assert resampling._interval(change, variance, 3.0) is None
    assert math.isnan(resampling._spread(np.array([1.0, np.nan]), 4, 1, 1.0)[0])
