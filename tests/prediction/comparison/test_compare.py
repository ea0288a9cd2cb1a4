"""What a comparison finds of logs whose changes are known, and what it refuses."""

from dataclasses import replace

import numpy as np
import pytest
from tests.prediction.comparison.machine import STEP, log, sine, wandering

import bristle as br
from bristle.core.errors import InputError, InputWarning
from bristle.report.messages import message

ERRORS = (
    "following_error.rms",
    "following_error.peak",
    "reversals.forward_to_backward",
    "reversals.backward_to_forward",
)


def codes(result):
    return {diagnostic.code for diagnostic in result.diagnostics}


def holds(change, value):
    low, high = change.interval
    return low <= value <= high


def test_a_smaller_error_and_less_friction_are_found_with_their_size():
    comparison = br.compare(log(1, sine(12)), log(2, sine(10), gain=0.7, friction=7.0))
    for name in ERRORS:
        change = comparison.changes[name]
        assert change.verdict == "lower"
        assert change.interval_percent[0] - 3.0 < -30.0 < change.interval_percent[1] + 3.0
    assert holds(comparison.changes["friction.level"], -1.0)
    assert comparison.changes["effort.rms"].verdict == "lower"
    assert comparison.helped is True
    assert codes(comparison) == {"one_recording"}
    assert {
        comparison.changes[name].unit for name in ("following_error.rms", "friction.level")
    } == {"m", "N"}
    assert (
        comparison.shared.cycles_before,
        comparison.shared.cycles_after,
        comparison.shared.motions,
    ) == (11, 9, 1)
    assert len(comparison.friction_curve) == 4
    assert all(holds(change, -1.0) for _, change in comparison.friction_curve)


def test_a_motion_that_never_repeats_is_compared_cycle_by_cycle_with_its_counterpart():
    comparison = br.compare(log(1, wandering(30.0)), log(2, wandering(20.0), gain=0.8))
    assert comparison.shared.paired
    assert comparison.shared.motions == comparison.shared.cycles_after >= 8
    assert comparison.shared.before_percent < 75.0
    change = comparison.changes["following_error.rms"]
    assert change.interval_percent[0] < -20.0 < change.interval_percent[1]
    assert change.interval_percent[1] - change.interval_percent[0] < 10.0


def test_a_motion_in_one_direction_is_compared_in_pieces():
    t = STEP * np.arange(4000)
    slide = (
        0.1 * t + 0.002 * np.sin(2.0 * t),
        0.1 + 0.004 * np.cos(2.0 * t),
        -0.008 * np.sin(2.0 * t),
    )
    elsewhere = slide[0] + 1.3, *slide[1:]
    comparison = br.compare(log(1, slide), log(2, elsewhere, gain=0.5))
    assert not comparison.shared.complete
    assert {"pieces_for_cycles", "friction_not_told"} <= codes(comparison)
    assert not [name for name in comparison.changes if name.startswith(("reversals", "friction"))]
    assert comparison.changes["following_error.rms"].verdict == "lower"


def test_without_a_reference_effort_and_friction_are_compared_with_a_remark():
    comparison = br.compare(log(1, sine(9), reference=None), log(2, sine(9), friction=7.0))
    assert set(comparison.changes) == {"effort.rms", "effort.peak", "friction.level"}
    assert comparison.helped is None
    lacking = next(
        diagnostic for diagnostic in comparison.diagnostics if diagnostic.code == "no_reference"
    )
    assert lacking.numbers["sides"] == ("before",)
    assert "does not compare the following error" in message(lacking)
    assert "Without a reference" in comparison.sentences[0]


def test_without_an_effort_the_following_error_is_compared():
    comparison = br.compare(log(1, sine(9), effort=None), log(2, sine(9), effort=None, gain=0.5))
    assert set(comparison.changes) == set(ERRORS)
    assert "no_effort" in codes(comparison)
    assert comparison.helped


def test_several_logs_of_a_side_are_combined():
    comparison = br.compare(
        [log(1, sine(5)), log(2, sine(6))], [log(3, sine(5)), log(4, sine(5))], window="40 ms"
    )
    assert (comparison.shared.cycles_before, comparison.shared.cycles_after) == (9, 8)
    assert "one_recording" not in codes(comparison)
    assert comparison.window == pytest.approx(0.04)


def test_logs_that_follow_each_other_in_time_cancel_a_drift():
    own, motion, logs = log(1, sine(5)), sine(5), {False: ([], []), True: ([], [])}
    for place, side in enumerate((0, 1, 1, 0, 1, 0, 0, 1)):
        recorded = log(10 + place, motion, gain=(1.0, 0.7)[side] * (1.0 + 0.1 * place))
        for follows, sides in logs.items():
            sides[side].append(replace(recorded, time=own.time.values + 100.0 * place * follows))
    widths = {
        follows: np.ptp(br.compare(*sides).changes[ERRORS[0]].interval)
        for follows, sides in logs.items()
    }
    assert widths[True] < 0.5 * widths[False]


def test_of_several_logs_of_a_side_a_short_one_is_named_and_the_others_are_compared():
    short = {name: np.linspace(0.0, 1.0, 60) for name in ("time", "position", "effort")}
    with pytest.warns(InputWarning, match="leaves out a log: .*60 instead of"):
        assert len(br.compare([short, log(1, sine(9))], log(2, sine(9))).logs_before) == 1


@pytest.mark.parametrize(
    ("words", "refused"),
    [
        ("names no log", lambda item: br.compare([], item)),
        (
            "NaN",
            lambda item: br.compare(
                item,
                {
                    "time": STEP * np.arange(400),
                    "position": np.full(400, np.nan),
                    "effort": np.ones(400),
                },
            ),
        ),
        ("no such file", lambda item: br.compare("gone.csv", item)),
        (
            "all contain a reference, or all contain an effort",
            lambda item: br.compare(log(1, sine(9), effort=None), log(2, sine(9), reference=None)),
        ),
        ("must be positive", lambda item: br.compare(item, log(2, sine(9)), window=0.0)),
        ("1 mm", lambda item: br.compare(item, log(2, sine(9)), window="1 mm")),
        (
            "2 axis files for 3 logs",
            lambda item: br.compare(
                item, [log(2, sine(9)), log(3, sine(9))], axis=[br.Axis(), br.Axis()]
            ),
        ),
        ("different kinds", lambda item: br.compare(log(2, sine(9), kind="rotational"), item)),
        (
            "is also the log from before the change.*and another log from after the change",
            lambda item: br.compare(item, item),
        ),
        (
            "same reference: the same positions at the same speed",
            lambda item: br.compare(item, log(2, sine(9, amplitude=0.04))),
        ),
        (
            "no cycle of the references is the same",
            lambda item: br.compare(item, log(2, sine(9, period=1.2))),
        ),
        (
            "no cycle of the positions .compared because a log has no reference. is the same",
            lambda item: br.compare(item, log(2, sine(9, amplitude=0.04), reference=None)),
        ),
    ],
)
def test_incomparable_logs_are_refused(words, refused):
    with pytest.raises(InputError, match=words):
        refused(log(1, sine(9)))
