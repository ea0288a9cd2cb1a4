"""What a simulation returns: numbers by hand, cards, and where a reversal is worst."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bristle.core.diagnostic import Diagnostic
from bristle.core.experiment import Experiment
from bristle.core.status import Status
from bristle.simulation.result import Prediction, SimulationResult, VariantResult, mean_result
from bristle.simulation.statistics import (
    NO_STATISTICS,
    Statistics,
    relative_error_percent,
    statistics_of,
    swing_at_worst_reversal,
    worst_reversal,
)

SIGNALS = (
    "time",
    "reference",
    "measured",
    "position",
    "velocity",
    "command",
    "effort",
    "feedforward",
    "friction",
)


def variant(name="base", **changes):
    signals = {signal: np.arange(4.0) for signal in SIGNALS}
    numbers = {
        "following_error": Statistics(1e-3, 0.0, 0.0, 2e-3, 0.0, 0.0),
        "true_error": Statistics(0.0, 0.0, 0.0, 3e-3, 0.0, 0.0),
        "by_direction": {"forward": Statistics(*range(6))},
        "effort_rms": 4.0,
        "effort_peak": 5.0,
        "motion": Statistics(6e-3, 0.0, 0.0, 0.0, 7e-3, 8e-3),
    }
    return VariantResult(name, **(signals | numbers | changes))


def test_a_signal_in_six_numbers():
    assert statistics_of([3.0, -1.0, 1.0, 1.0]) == Statistics(
        4.0, 1.0, pytest.approx(math.sqrt(2.0)), pytest.approx(math.sqrt(3.0)), -1.0, 3.0
    )
    assert np.isnan(list(vars(statistics_of([])).values())).all()
    assert np.isnan(list(vars(NO_STATISTICS).values())).all()


def test_a_signal_that_diverged_has_the_numbers_that_are_left():
    result = statistics_of([1e200, -1e200])
    assert (result.rms, result.max, result.min) == (math.inf, 1e200, -1e200)


@pytest.mark.parametrize(
    ("predicted", "percent"),
    [([3.0, 4.0], 0.0), ([0.0, 0.0], 100.0), ([3.0, 3.0], 20.0), ([6.0, 8.0], 100.0)],
)
def test_an_error_is_percent_of_the_signal(predicted, percent):
    assert relative_error_percent(np.array([3.0, 4.0]), np.array(predicted)) == pytest.approx(
        percent
    )


def test_a_signal_of_zeros_has_no_percent_error():
    assert math.isnan(relative_error_percent(np.zeros(2), np.ones(2)))


def test_the_numbers_of_a_variant_have_their_names():
    numbers = variant().as_dict()
    assert list(numbers) == [
        "following_error",
        "true_error",
        "by_direction",
        "effort",
        "motion",
        "status",
        "runs",
    ]
    assert numbers["following_error"]["rms"] == 2e-3
    assert numbers["true_error"]["rms"] == 3e-3
    assert numbers["by_direction"]["forward"] == dict(
        zip(("peak_to_peak", "mean", "std", "rms", "min", "max"), range(6), strict=True)
    )
    assert numbers["effort"] == {"rms": 4.0, "peak": 5.0}
    assert numbers["motion"]["max"] == 8e-3
    assert (numbers["status"], numbers["runs"]) == (Status.OK.sentence, 1)
    assert variant(trials=(2.0, 1.0)).as_dict()["trials"] == [2.0, 1.0]


def test_a_spread_follows_its_number():
    numbers = variant(spread={"effort": {"rms": 0.5}}, runs=3).as_dict()
    assert list(numbers["effort"].items()) == [("rms", 4.0), ("rms_spread", 0.5), ("peak", 5.0)]


def test_a_variant_has_a_card_in_its_units():
    assert variant()._title() == "base: simulated, 4 samples, translational"
    assert variant()._remarks() == [
        "Following error, peak to peak: 1 mm",
        "its rms: 2 mm",
        "True error, rms: 3 mm",
        "Effort, rms: 4 N",
        "Peak: 5 N",
        f"Status: {Status.OK.sentence}",
    ]
    assert variant(kind="rotational")._row()[3] == "4 N·m"


def test_the_card_of_an_open_loop_has_its_motion_and_no_error():
    nothing = np.full(4, np.nan)
    opened = variant(reference=nothing)
    assert opened.is_open
    assert not variant().is_open
    assert not variant(reference=np.array([np.nan, 1.0])).is_open
    assert not variant(reference=np.zeros(0)).is_open
    assert opened._remarks()[:3] == [
        "Position, peak to peak: 6 mm",
        "lowest: 7 mm",
        "highest: 8 mm",
    ]


def test_numbers_of_several_runs_are_means_with_the_spread_of_a_sample_and_the_signals_of_the_first():
    nine = Statistics(*[9.0] * 6)
    runs = [
        variant(effort_rms=4.0, trials=(1.0, 3.0)),
        variant(
            effort_rms=6.0,
            trials=(3.0, 5.0),
            effort=np.full(4, 9.0),
            motion=nine,
            true_error=nine,
            status=Status.SOLVE_INACCURATE,
        ),
    ]
    result = mean_result(runs)
    assert (result.effort_rms, result.effort_peak, result.trials) == (5.0, 5.0, (2.0, 4.0))
    assert (result.motion.peak_to_peak, result.true_error.rms) == pytest.approx(
        (0.5 * 9.006, 0.5 * 9.003)
    )
    assert (result.status, result.runs) == (Status.SOLVE_INACCURATE, 2)
    assert result.spread["effort"] == {"rms": pytest.approx(math.sqrt(2.0)), "peak": 0.0}
    assert result.spread["by_direction"]["forward"]["max"] == 0.0
    assert result.by_direction["forward"] == runs[0].by_direction["forward"]
    assert result.effort.tolist() == [0.0, 1.0, 2.0, 3.0]


def test_a_mean_of_one_run_is_the_run_and_a_diverged_run_represents_all():
    single, lost = (
        mean_result([variant()]),
        mean_result([variant(), variant(status=Status.NOT_FINITE, effort_rms=7.0)]),
    )
    assert (single.spread, single.runs) == ({}, 1)
    assert (lost.effort_rms, lost.runs, lost.spread) == (7.0, 2, {})


def result_of(*variants, refused=()):
    return SimulationResult(
        Experiment("bench", "translational", ()),
        {item.name: item for item in variants},
        dict(refused),
    )


def test_an_experiment_has_a_card():
    card = result_of(variant(), variant("other"), refused={"third": "has no gains"})._card()
    assert result_of(variant())._card().title == "bench: 1 variant simulated"
    assert (card.title, card.heads[1]) == (
        "bench: 2 variants simulated",
        "Following error, peak to peak",
    )
    assert [row[0] for row in card.rows] == ["base", "other"]
    assert card.remarks == ("third was not simulated: has no gains",)


OPENED = variant(reference=np.full(4, np.nan))


@pytest.mark.parametrize(
    ("variants", "head"),
    [
        ((OPENED,), "Position, peak to peak"),
        ((OPENED, variant("other")), "Following error, peak to peak"),
        ((), "Following error, peak to peak"),
    ],
)
def test_only_open_loops_are_told_by_their_position(variants, head):
    assert result_of(*variants)._card().heads[1] == head


def test_an_experiment_is_plain_data_and_a_table():
    result = result_of(variant(), variant("other"), refused={"third": "why"})
    data, frame = result.to_dict(), result.to_dataframe()
    assert {name: data[name] for name in ("name", "kind", "refused")} == {
        "name": "bench",
        "kind": "translational",
        "refused": {"third": "why"},
    }
    assert list(data["variants"]) == ["base", "other"]
    assert (frame.columns[0], frame.attrs["units"]["position"]) == ("variant", "m")
    assert frame["variant"].tolist() == ["base"] * 4 + ["other"] * 4
    assert result_of().to_dataframe().empty


def prediction(**changes):
    values = {
        "effort": np.array([1.0, 2.0, 3.0, 4.0]),
        "effort_predicted": np.array([1.0, 2.5, 3.0, 6.0]),
        "half_width": np.full(4, 0.5),
    }
    values |= {
        "position": np.zeros(4),
        "position_predicted": np.array([0.0, 0.0, 0.0, 1.0]),
        "position_half_width": np.full(4, 0.1),
    }
    metrics = {"force_error_percent": 12.3456, "position_error_percent": None, "position_unit": "m"}
    return Prediction("inverse", np.arange(4.0), metrics=metrics, **(values | changes))


@pytest.mark.parametrize(
    ("changes", "effort", "position"),
    [
        ({}, 75.0, 75.0),
        ({"half_width": None}, None, 75.0),
        ({"effort_predicted": None}, None, 75.0),
        ({"effort": None}, None, 75.0),
        ({"position_half_width": None}, 75.0, None),
    ],
)
def test_the_share_of_samples_inside_a_band(changes, effort, position):
    result = prediction(**changes)
    assert (result.inside_percent, result.position_inside_percent) == (effort, position)


@pytest.mark.parametrize(
    ("metrics", "kind"),
    [
        ({"position_unit": "m"}, "translational"),
        ({"position_unit": "rad"}, "rotational"),
        ({}, "translational"),
    ],
)
def test_the_unit_of_the_position_sets_the_kind_of_a_prediction(metrics, kind):
    assert replace(prediction(), metrics=metrics).kind == kind


def test_a_prediction_has_a_card():
    result = prediction(
        diagnostics=(
            Diagnostic("filtered", "", "note", {"cutoff": 100.0}),
            Diagnostic("at_bound", "F_C", "warning"),
        )
    )
    assert result._title() == "Prediction (inverse) of 4 samples, translational"
    remarks = result._remarks()
    assert remarks[:3] == [
        "error of the effort: 12.3 %",
        "inside the band of the effort: 75 %",
        "inside the band of the position: 75 %",
    ]
    assert remarks[-2:] == ["note: filtered", "warning: at_bound F_C"]


TURNING = np.abs(np.arange(1000.0) % 500.0 - 250.0)  # turns at 250, 500 and 750
ERROR = np.zeros(1000)
ERROR[[255, 495, 505, 760]] = 1.0, -1.0, 1.0, 1.5
SHORT, LATE = np.abs(np.arange(100.0) - 50.0), np.abs(np.arange(100.0) - 98.0)


@pytest.mark.parametrize(
    ("reference", "error", "around", "swing"),
    [
        # A twentieth of the samples, a third of them before the reversal; forty samples, or all of a short record.
        (TURNING, ERROR, slice(484, 534), 2.0),
        (SHORT, np.zeros(100), slice(37, 77), 0.0),
        (SHORT[40:60], np.zeros(20), slice(0, 20), 0.0),
        (LATE, np.zeros(100), slice(60, 100), 0.0),
        (np.arange(100.0), np.zeros(100), None, None),  # never turns
    ],
)
def test_the_worst_reversal_has_the_widest_swing_of_the_error(reference, error, around, swing):
    assert worst_reversal(reference, error) == around
    assert swing_at_worst_reversal(reference, error) == swing
