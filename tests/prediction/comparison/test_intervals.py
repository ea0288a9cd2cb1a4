"""The interval of a change holds what it says: on logs with memory, cycles that are alike, motions that come once."""

import numpy as np
import pytest
from tests.prediction.comparison.machine import correlated, log, sine, wandering

import bristle as br
from bristle.prediction.comparison import resampling
from bristle.prediction.comparison.measures import level_measures
from bristle.prediction.comparison.resampling import changed, plan_of

RMS = level_measures("error", "following_error", "length")[0].value
SAMPLES = 100  # of a cycle
LEVELS = (1.0, 0.8)


def errors(rng, cycles, level, likeness):
    """The following error of some cycles, shape (cycle, sample): its size scatters from cycle to cycle."""
    size = level * (1.0 + 0.2 * correlated(rng, cycles, likeness))
    wave = np.sin(np.linspace(0.0, 2.0 * np.pi, SAMPLES, endpoint=False))
    return size[:, None] * wave + 0.3 * correlated(rng, cycles * SAMPLES, 0.95).reshape(
        cycles, SAMPLES
    )


TRUE = [np.sqrt(0.5 * level * level * 1.04 + 0.09) for level in LEVELS]


def coverage(cycles, *, likeness=0.0, paired=False, repeats=200):
    """The share of intervals that hold the true change of the root mean square."""
    fixed = 0
    for seed in range(repeats):
        rng = np.random.default_rng(seed)
        sums = []
        for level in LEVELS:
            error = errors(rng, cycles, level, likeness)
            sums.append(
                np.stack(
                    [np.sum(error * error, axis=1), np.full(len(error), float(error.shape[1]))],
                    axis=1,
                )
            )
        kinds = np.arange(len(sums[0])) if paired else np.zeros(len(sums[0]), dtype=int)
        low, high = changed(RMS, *sums, plan_of(kinds, kinds)).interval
        fixed += low <= TRUE[1] - TRUE[0] <= high
    return fixed / repeats


@pytest.mark.fast_cases(2)
@pytest.mark.parametrize("cycles", [3, 8, 20])
def test_intervals_of_cycles_cover_95_percent(cycles):
    assert 0.90 <= coverage(cycles) <= 0.985


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("cycles", [6, 30])
def test_intervals_of_motions_that_occur_once_cover_95_percent(cycles):
    assert 0.90 <= coverage(cycles, paired=True) <= 0.985


@pytest.mark.slow
def test_intervals_of_correlated_cycles_are_wider(monkeypatch):
    assert coverage(60, likeness=0.6) >= 0.88
    monkeypatch.setattr(resampling, "_as_one", lambda influence: 1.0)
    assert coverage(60, likeness=0.6) < 0.82


ALTERNATE = (0, 1, 1, 0, 1, 0, 0, 1)


def coverage_of_recordings(order, *, drift=0.0, scatter=0.0, in_turn=True, repeats=200):
    """The share of intervals that hold the true change, and their median width, of recordings with four cycles each."""
    order, place, held, widths = np.array(order), np.arange(len(order)), [], []
    # After the change, the quantity falls less and rises with time.
    courses = [
        level + slope * drift * (np.exp(-place / 12.0) - np.mean(np.exp(-place / 12.0)))
        for level, slope in ((1.0, 1.0), (0.8, -0.6))
    ]
    for seed in range(repeats):
        rng, sums = np.random.default_rng(4000 + seed), []
        for side, course in enumerate(courses):
            level = course[order == side] + scatter * rng.standard_normal(np.sum(order == side))
            cycles = np.repeat(level, 4) + 0.01 * (1.0 - 0.7 * side) * rng.standard_normal(
                4 * level.size
            )
            sums.append(np.stack([cycles * cycles, np.ones(cycles.size)], axis=1))
        places = [np.repeat(place[order == side], 4) for side in (0, 1)]
        plan = plan_of(*(np.zeros(own.size, dtype=int) for own in places), *places)._replace(
            in_turn=in_turn
        )
        low, high = changed(RMS, *sums, plan).interval
        held.append(low <= -0.2 <= high)
        widths.append(high - low)
    return np.mean(held), np.median(widths)


@pytest.mark.parametrize("in_turn", [True, False])
@pytest.mark.parametrize("scatter", [0.0, 0.03])
@pytest.mark.parametrize("order", [ALTERNATE, (0, 1, 1, 0)])
def test_intervals_of_several_recordings_cover_95_percent(order, scatter, in_turn):
    assert 0.92 <= coverage_of_recordings(order, scatter=scatter, in_turn=in_turn)[0] <= 0.99


def test_a_drift_cancels_in_recordings_whose_order_is_known():
    share, width = coverage_of_recordings(ALTERNATE, drift=0.05, repeats=80)
    assert 0.92 <= share <= 0.99
    assert width < 1.2 * coverage_of_recordings(ALTERNATE, repeats=20)[1]
    assert coverage_of_recordings(ALTERNATE, drift=0.05, in_turn=False, repeats=20)[1] > 1.5 * width


@pytest.mark.slow
@pytest.mark.parametrize("motion", [sine(9), wandering(14.0)], ids=["repeats", "never repeats"])
def test_intervals_cover_zero_in_95_percent_of_unchanged_axes(motion):
    result = [br.compare(log(2 * seed, motion), log(2 * seed + 1, motion)) for seed in range(50)]
    changes = [change for item in result for change in item.changes.values()]
    assert len(changes) == 7 * len(result)
    assert 0.90 <= np.mean([change.verdict == "no_change" for change in changes]) <= 0.985


@pytest.mark.slow
def test_intervals_cover_a_real_change_in_95_percent():
    fixed = []
    for seed in range(50):
        comparison = br.compare(log(2 * seed, sine(9)), log(2 * seed + 1, sine(9), friction=7.6))
        low, high = comparison.changes["friction.level"].interval
        fixed.append(low <= -0.4 <= high)
    assert 0.88 <= np.mean(fixed) <= 1.0
