"""What a comparison rests on: windows, shares of motion, doubts, and logs that are refused."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from tests.prediction.comparison.machine import STEP, log, sine

import bristle as br
from bristle.core.errors import InputError
from bristle.prediction.comparison.compare import (
    _changes,
    _diagnostics,
    _refuse_unlike,
    _window_samples,
)
from bristle.prediction.comparison.cycles import Cycle, Recording, Side
from bristle.prediction.comparison.measures import Measure
from bristle.prediction.comparison.resampling import plan_of
from bristle.prediction.comparison.result import Change, Shared


def stretch(turns=(), step=0.01):
    """A stretch of a log that turns at these samples."""
    return Recording(step, np.zeros(200), None, None, None, np.array(turns, dtype=int))


def sides(*stretches):
    """Two sides of a cycle of 90 samples in each of some stretches."""
    side = Side([Cycle(each, slice(0, 90)) for each in stretches])
    return side, side


@pytest.mark.parametrize(("window", "samples"), [(0.05, 5), (0.054, 5), (0.056, 6), (1e-6, 1)])
def test_a_window_has_its_number_of_samples_but_at_least_one(window, samples):
    assert _window_samples(sides(stretch()), window) == samples


@pytest.mark.parametrize(
    ("turns", "samples"),
    [
        ((0, 100, 200, 300), 10),  # a tenth of the time between two reversals
        ((0, 100, 400, 500), 10),  # of the median
        ((0, 20, 40), 4),  # four at least
        ((50,), 9),  # a tenth of a cycle, where a stretch turns once
        ((), None),
    ],
)
def test_a_window_is_a_tenth_of_the_time_between_reversals(turns, samples):
    assert _window_samples(sides(stretch(turns)), None) == samples


def test_reversals_of_a_stretch_count_once_for_any_number_of_cycles():
    often, seldom = stretch((0, 50, 100)), stretch((0, 200, 400, 600))
    side = Side(
        [
            Cycle(often, slice(0, 90)),
            Cycle(often, slice(0, 90)),
            Cycle(often, slice(0, 90)),
            Cycle(seldom, slice(0, 90)),
        ]
    )
    assert _window_samples((side, side), None) == 20


# --- doubts ----------------------------------------------------------------------------------------------------------


def change(name="following_error.rms", before=1.0, interval=(-0.3, -0.1)):
    return Change(name, "length", before, 0.8 * before, interval)


SOUND = Shared(100.0, 100.0, 10, 10, 1, complete=True, paired=False, as_one=1.0)


def recorded(**changed):
    """A log as far as doubts look at it."""
    channels = {"reference": 1, "effort": 1, "sample_time": 1e-3, "kind": "translational"}
    return SimpleNamespace(**(channels | changed)), None


def doubts(shared=SOUND, changes=None, before=None, after=None, reason=None):
    """Code, severity and numbers of each doubt of a comparison of four logs a side."""
    changes = {"friction.level": change("friction.level")} if changes is None else changes
    before, after = before or [recorded()] * 4, after or [recorded()] * 4
    outcome = _diagnostics(before, after, shared, changes, reason)
    return {item.code: (item.severity, dict(item.numbers)) for item in outcome}


def shared_by(**changed):
    return replace(SOUND, **changed)


RMS, LEVEL = "following_error.rms", "friction.level"


@pytest.mark.parametrize(
    ("asked", "expected"),
    [
        ({}, {}),
        ({"shared": shared_by(before_percent=99.0, cycles_before=6, as_one=2.0)}, {}),
        (
            {"shared": shared_by(before_percent=98.9)},
            {"motions_differ": ("warning", {"before_percent": 98.9, "after_percent": 100.0})},
        ),
        (
            {"shared": shared_by(after_percent=98.9)},
            {"motions_differ": ("warning", {"before_percent": 100.0, "after_percent": 98.9})},
        ),
        ({"shared": shared_by(cycles_before=5)}, {"few_cycles": ("warning", {"cycles": 5})}),
        ({"shared": shared_by(cycles_after=4)}, {"few_cycles": ("warning", {"cycles": 4})}),
        ({"shared": shared_by(as_one=2.1)}, {"cycles_alike": ("note", {"cycles": 2.1})}),
        # Too few cycles give no interval.
        ({"changes": {LEVEL: change(LEVEL, interval=None)}}, {"few_cycles": ("warning", {})}),
        # Friction is not told without a reason, and not where it is no wonder.
        (
            {"changes": {RMS: change()}, "reason": InputError("is too short")},
            {"friction_not_told": ("warning", {"why": "is too short"})},
        ),
        ({"changes": {RMS: change()}}, {"friction_not_told": ("warning", {"why": ""})}),
        (
            {"changes": {RMS: change()}, "before": [recorded(effort=None)] * 4},
            {"no_effort": ("warning", {"sides": ("before",)})},
        ),
        (
            {"after": [*[recorded()] * 3, recorded(sample_time=1.002e-3)]},
            {"sample_times_differ": ("note", {"longest": 1.002e-3})},
        ),
        ({"after": [*[recorded()] * 3, recorded(sample_time=1.0005e-3)]}, {}),
        ({"after": [recorded()]}, {"one_recording": ("note", {})}),
        ({"before": [recorded()]}, {"one_recording": ("note", {})}),
        ({"after": [recorded()] * 3}, {"few_recordings": ("note", {"logs": 3})}),
        ({"before": [recorded()] * 3}, {"few_recordings": ("note", {"logs": 3})}),
        ({"shared": shared_by(paired=True), "after": [recorded()] * 3}, {}),
    ],
)
def test_a_doubt_of_a_comparison_has_its_numbers(asked, expected):
    assert doubts(**asked) == expected


@pytest.mark.parametrize("cycles", [4, 10])
def test_pieces_are_reported_in_place_of_too_few_cycles(cycles):
    assert set(doubts(shared_by(cycles_before=cycles, complete=False))) == {"pieces_for_cycles"}


@pytest.mark.parametrize(("half", "identical"), [(0.9e-6, True), (1.1e-6, False)])
def test_an_interval_of_hardly_any_width_is_that_of_identical_cycles(half, identical):
    narrow = change(LEVEL, before=-1.0, interval=(0.2 - half, 0.2 + half))
    assert ("cycles_identical" in doubts(changes={LEVEL: narrow})) is identical


@pytest.mark.parametrize(
    ("before", "after", "sides"),
    [(None, 1, ("before",)), (1, None, ("after",)), (None, None, ("before", "after"))],
)
@pytest.mark.parametrize(
    ("channel", "code"), [("reference", "no_reference"), ("effort", "no_effort")]
)
def test_a_missing_channel_is_reported_with_its_side(channel, code, before, after, sides):
    pairs = [[*[recorded()] * 3, recorded(**{channel: value})] for value in (before, after)]
    assert doubts(before=pairs[0], after=pairs[1]) == {code: ("warning", {"sides": sides})}


# --- quantities ------------------------------------------------------------------------------------------------------


def test_a_quantity_unknown_on_a_side_is_left_out():
    side = Side([Cycle(stretch(), slice(0, 9), 0)] * 3)
    measures = [
        Measure(
            "told",
            "length",
            lambda side: np.array([[2.0, 1.0]] * 3),
            lambda sums: sums[..., 0] / sums[..., 1],
        ),
        Measure("nowhere", "length", lambda side: np.zeros((3, 2)), lambda sums: sums[..., 0]),
        Measure(
            "no number", "force", lambda side: np.ones((3, 2)), lambda sums: np.nan * sums[..., 0]
        ),
    ]
    changes, as_one = _changes(measures, (side, side), plan_of([0] * 3, [0] * 3), "rotational")
    assert list(changes) == ["told"]
    assert (changes["told"].before, changes["told"].after, changes["told"].unit) == (
        2.0,
        2.0,
        "rad",
    )
    assert as_one == [1.0]


def test_shares_of_motion_are_of_samples():
    # Three of the cycles of the first log are of the motion of the second one, and half as long as the others.
    fast, slow = sine(6, period=0.5), sine(4)
    both = [np.concatenate(pair) for pair in zip(fast, slow, strict=True)]
    comparison = br.compare(log(1, both), log(2, sine(6, period=0.5)))
    assert comparison.shared.after_percent == 100.0
    assert comparison.shared.before_percent == pytest.approx(
        100.0 * 5 * 0.5 / (5 * 0.5 + 3.25), abs=5.0
    )
    assert comparison.course.time[1] == pytest.approx(STEP)
    assert comparison.shared.as_one == 1.0
    # The fast part takes four times the force.
    assert comparison.changes["effort.rms"].verdict == "no_change"


def test_friction_over_speed_is_separate_from_changes():
    comparison = br.compare(log(1, sine(6)), log(2, sine(6)))
    assert not any(name.startswith("friction.at_speeds") for name in comparison.changes)
    speeds = [speed for speed, _ in comparison.friction_curve]
    assert speeds == sorted(speeds)
    assert [change.name for _, change in comparison.friction_curve] == [
        f"friction.at_speeds.{k}" for k in range(len(speeds))
    ]
    assert [len(side) for side in (comparison.logs_before, comparison.logs_after)] == [1, 1]
    assert comparison.window == pytest.approx(0.05, abs=STEP)
    assert len(comparison.turns) == 2


def test_logs_that_differ_in_a_sample_or_in_a_channel_are_not_the_same():
    item = log(1, sine(6))
    position = item.position.values.copy()
    position[7] += 1e-9
    _refuse_unlike([(item, None)], [(log(1, sine(6), position=position), None)])
    _refuse_unlike([(item, None)], [(log(1, sine(6), effort=None), None)])
    _refuse_unlike([(item, None)], [(log(1, sine(7)), None)])
    with pytest.raises(InputError, match="is also the log from before the change"):
        _refuse_unlike([(log(2, sine(6)), None), (item, None)], [(log(1, sine(6)), None)])
