"""The likelihood ratio over onsets, and how often a healthy axis exceeds its threshold."""

import numpy as np
import pytest
from benchmarks.watch_thresholds import largest

from bristle.core.errors import InputError
from bristle.fleet.change import COURSES, WINDOW, LevelChange, course_of_change, largest_ratios
from bristle.fleet.false_alarms import RATES, false_alarms_from, threshold_for
from bristle.fleet.innovations import Innovations


def brute(innovations, time, scores, at):
    """The largest ratio at an observation, with every change filtered by itself."""
    ratios = []
    for course in COURSES:
        for onset in range(max(at - WINDOW + 1, 0), at + 1):
            shift = innovations.residuals(course_of_change(LevelChange(onset, course), time))[: at + 1]
            energy = np.sum(shift[scores[: at + 1] != 0.0] ** 2)
            if energy > 1e-9:
                ratios.append(abs(scores[: at + 1] @ shift) / np.sqrt(energy))
    return max(ratios)


def test_the_ratio_is_that_of_every_onset_looked_at_by_itself():
    rng = np.random.default_rng(1)
    count = 40
    time = np.cumsum(rng.uniform(0.5, 2.0, count))
    innovations = Innovations(np.column_stack([np.ones(count), rng.standard_normal(count)]), np.ones(count))
    scores = innovations.scores(rng.standard_normal(count) + 0.2 * np.maximum(np.arange(count) - 20, 0))
    ratios = largest_ratios(innovations, time, scores)
    for at in (8, 25, 39):
        assert ratios[at] == pytest.approx(brute(innovations, time, scores, at), rel=1e-6)


def test_onsets_beyond_the_window_are_left_behind():
    count = WINDOW + 40
    scores = np.full(count, 1e-9)
    scores[5:30] = 1.5  # a change long ago
    ratios = largest_ratios(Innovations(np.ones((count, 1)), np.ones(count)), np.arange(float(count)), scores)
    assert ratios[30] > 5.0
    assert ratios[-1] < 1e-6


def test_several_series_of_one_design_are_as_each_by_itself():
    rng = np.random.default_rng(4)
    innovations, time = Innovations(np.ones((30, 1)), np.ones(30)), np.arange(30.0)
    scores = rng.standard_normal((30, 3))
    together = largest_ratios(innovations, time, scores)
    for place in range(3):
        assert together[:, place] == pytest.approx(largest_ratios(innovations, time, scores[:, place]))


def test_the_table_of_thresholds_is_what_is_simulated():
    # The share of the runs that exceeds the threshold of a rate, within four standard errors.
    tops = largest(200, seed=5, observations=200)[:, -1]
    for rate in (1e-3, 3e-3, 1e-2):
        expected = 1.0 - np.exp(-200.0 * rate)
        error = 4.0 * np.sqrt(expected * (1.0 - expected) / tops.size)
        assert np.mean(tops > threshold_for(rate)) == pytest.approx(expected, abs=error)


def test_thresholds_fall_as_the_rate_rises_and_end_where_nothing_was_simulated():
    grid = np.geomspace(RATES[0], RATES[-1], 20)
    assert np.all(np.diff([threshold_for(rate) for rate in grid]) < 0.0)
    for rate in (0.5 * RATES[0], 2.0 * RATES[-1]):
        with pytest.raises(InputError, match="not simulated"):
            threshold_for(rate)


@pytest.mark.parametrize(
    ("text", "days", "quantities", "rate"),
    [
        ("1 in 1000 days", 1.0, 1, 1e-3),
        ("1 per 1000 days", 0.5, 1, 5e-4),
        ("2/1000 days", 1.0, 4, 5e-4),
        ("1 in 500 logs", 7.0, 2, 1e-3),
        ("1 in 500 logs", None, 1, 2e-3),
    ],
)
def test_a_rate_is_shared_by_quantities_and_follows_the_time_between_observations(text, days, quantities, rate):
    assert false_alarms_from(text).per_observation(days, quantities) == pytest.approx(rate)


@pytest.mark.parametrize("text", ["", "often", "1 in 0 days", "0 in 5 days", "1 in 1000 weeks", "-1 in 3 days"])
def test_what_is_no_rate_is_refused(text):
    with pytest.raises(InputError, match="is no rate"):
        false_alarms_from(text)
