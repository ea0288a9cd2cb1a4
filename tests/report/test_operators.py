"""The reports of hysteresis operators: verdict by held-out error, tables of operators and parameters."""

from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.report.pages import plain, seen_by

from bristle import hysteresis
from bristle.core import Diagnostic, Status
from bristle.report import operators as report, prediction as prediction_module
from bristle.report.table import percent_text
from bristle.simulation import MODES


@pytest.mark.parametrize(
    ("error", "held_out", "fitted", "level", "reasons"),
    [
        (4.9, None, False, "usable", 1),
        (5.1, None, False, "with_care", 1),
        (20.1, None, False, "no", 1),
        (20.0, None, False, "with_care", 1),
        (5.0, None, False, "usable", 1),
        (4.9, None, True, "with_care", 2),
        (1.0, 2.0, True, "usable", 1),
        (1.0, 2.1, True, "with_care", 2),
        (1.0, 25.0, True, "no", 2),
    ],
)
def test_verdict_of_an_operator_uses_the_held_out_error(error, held_out, fitted, level, reasons):
    ruling = report.operator_ruling(error, held_out, fitted=fitted)
    assert (ruling.level, len(ruling.reasons)) == (level, reasons)
    told = "on these curves" if held_out is None else "on held-out curves"
    assert (
        ruling.reasons[0]
        == f"the error is {percent_text(error if held_out is None else held_out)} of full scale {told}"
    )


def fit(name, rank, error, rmse, held_out=None, notes=()):
    kept = (
        None
        if held_out is None
        else Some(mean_percent=held_out, std_percent=0.5, of="the last curve")
    )
    operator = hysteresis.preisach(s=1.25e7, f_p=150.0)
    prediction = Some(error_percent=error, rmse=rmse)
    metrics = {"error_percent": error}
    return Some(
        name=name,
        rank=rank,
        prediction=prediction,
        held_out=kept,
        notes=notes,
        operator=operator,
        offset=2.0,
        metrics=metrics,
    )


RECORDED = Some(
    kind="translational",
    curves=(Some(u=np.zeros(3)), Some(u=np.zeros(4))),
    start="demagnetised",
    full_scale=0.5,
    notes=("read",),
    source=Some(name="<curves.csv>"),
)
FITS = (
    fit("preisach", 1, 1.5, 2e-3, 3.25, ("", "first", "second", "third")),
    fit("duhem", 2, 4.0, 5e-3),
    fit("c", 3, 1.0, 1e-3, 6.0),
)


def test_operators_are_compared_on_held_out_curves():
    table = report.comparison_of_operators(Some(recorded=RECORDED, fits=FITS))
    assert table.heads == [
        "Operator",
        "Rank",
        "Held-out error [% of full scale]",
        "Fitted [% of full scale]",
        "Fitted [mN]",
    ]
    assert table.rows == [
        ["preisach", "1", "3.25 ± 0.50", "1.50", "2.00"],
        ["duhem", "2", "–", "4.00", "5.00"],
        ["c", "3", "6.00 ± 0.50", "1.00", "1.00"],
    ]


def test_first_page_of_an_operator_lists_the_other_operators():
    front = report._front(FITS[0].prediction, "axis: preisach", RECORDED, FITS)
    assert (front.ruling.level, front.title) == (
        "with_care",
        "Held-out error 3.25\u00a0% of full scale",
    )
    assert front.facts.endswith("2 curves")
    cards = [(card.label, card.value.replace("\u00a0", " "), card.remark) for card in front.cards]
    assert cards == [
        ("Error", "2 mN", "rms"),
        ("Full scale", "500 mN", "2 curves"),
        ("Fitted curves", "1.50 %", ""),
        ("Next best", "4.00 %", "duhem"),
    ]
    assert front.next.command.startswith("bristle predict model.toml")


def test_first_page_of_a_prediction_has_no_other_operators():
    single = Some(**vars(RECORDED) | {"curves": RECORDED.curves[:1]})
    front = report._front(FITS[0].prediction, "axis", single, ())
    assert [(card.label, card.remark) for card in front.cards] == [
        ("Error", "rms"),
        ("Full scale", "1 curve"),
    ]
    assert (front.next.command[:23], front.ruling.level) == ("bristle identify CURVES", "usable")


def test_summary_of_an_operator_has_the_constant_output():
    congruency = Some(alike=0.1, anywhere=0.2)
    identification = Some(
        best=FITS[0], fits=FITS, recorded=RECORDED, congruency=congruency, unfinished=""
    )
    summary = report.operator_summary(identification, provenance={"a": "b"})
    assert summary["parameters"]["offset"] == {
        "value": 2.0,
        "unit": "N",
        "description": "constant output added to the operator",
    }
    assert summary["log"] == {
        "curves": 2,
        "samples": 7,
        "start": "demagnetised",
        "full_scale": 0.5,
        "notes": ("read",),
    }
    assert [model["rank"] for model in summary["models"]] == [1, 2, 3]
    numbers = (
        summary["parameters"]["f_p"]["value"],
        summary["unfinished"],
        summary["verdict"]["level"],
    )
    assert numbers == (150.0, None, "with_care")
    assert (
        report.operator_summary(
            Some(**vars(identification) | {"unfinished": "stopped"}), provenance={}
        )["unfinished"]
        == "stopped"
    )


def test_page_of_an_operator_has_parameters_and_data(monkeypatch):
    seen = seen_by(monkeypatch, report)
    prediction = Some(**vars(FITS[0].prediction) | {"outputs": (1, 2)})
    levels = hysteresis.relays_of(hysteresis.preisach(s=1.0, f_p=1.0), 1.0, 4)
    for operator, parameter, text in (
        (FITS[0].operator, "f_p", "150 N"),
        (levels, "levels", "5 numbers, in the model file"),
    ):
        report.operator_prediction_report(prediction, operator, RECORDED, name="axis")
        compared, model, data = seen["sections"]
        rows = {row[0]: row[1] for row in model.blocks[0].rows}
        facts = data.blocks[0].content
        assert facts == [
            ("Curves", "2"),
            ("Samples", "7"),
            ("Each begins", "demagnetised"),
            ("Full scale", "500 mN"),
            ("Note", "read"),
        ]
        assert (compared.heading, seen["outputs"], seen["log_name"]) == (
            "Remarks",
            (1, 2),
            "curves.csv",
        )
        assert rows[parameter] == text


@pytest.mark.parametrize(("count", "heading"), [(1, "Remarks"), (2, "Operators compared")])
def test_several_operators_are_compared(monkeypatch, count, heading):
    seen = seen_by(monkeypatch, report)
    prediction = Some(**vars(FITS[0].prediction) | {"outputs": (1, 2)})
    best = Some(**vars(FITS[0]) | {"prediction": prediction})
    report.operator_report(
        Some(best=best, fits=FITS[:count], recorded=RECORDED, notes=("a note",)), name="axis"
    )
    compared, _, data = seen["sections"]
    assert ("Held out", "the last curve") in data.blocks[0].content
    assert (compared.heading, compared.blocks[0] is not None, compared.blocks[1].content) == (
        heading,
        count == 2,
        ("a note",),
    )
    assert seen["outputs"] == (1, 2)


# --- The prediction_module of a prediction: error, verdict and next step


LOG = Some(kind="translational", source=Some(name="<a.csv>"), duration=4.0)
FRICTION = Some(name="lugre", kind="translational")
FORCES = {"force_error_percent": 3.456, "force_rmse": 0.25, "force_unit": "N"}
LENGTHS = {"position_error_percent": 2.5, "position_rmse": 4e-7, "position_unit": "m"}


def predicted(mode="inverse", **changes):
    known = {
        "mode": mode,
        "metrics": FORCES,
        "status": Status.OK,
        "diagnostics": (),
        "inside_percent": None,
        "position_inside_percent": None,
    }
    known |= {
        "effort": np.array([3.0, -4.0]),
        "position": np.array([0.0, 3e-6]),
        "position_predicted": None,
    }
    return Some(**known | changes)


@pytest.mark.parametrize(
    ("prediction", "rows"),
    [
        (
            predicted(inside_percent=94.4),
            {
                "Effort error": "3.46 %",
                "Measured effort inside the 95 % band": "94.4 %",
                "Effort error, root mean square": "250 mN",
            },
        ),
        (
            predicted("open-loop", metrics=LENGTHS, position_inside_percent=80.0),
            {
                "Position error": "2.50 %",
                "Measured position inside the 95 % band": "80.0 %",
                "Position error, root mean square": "0.400 µm",
            },
        ),
        (
            predicted("closed-loop", metrics=FORCES | LENGTHS | {"position_unit": "rad"}),
            {
                "Effort error": "3.46 %",
                "Effort error, root mean square": "250 mN",
                "Position error, root mean square": "0.400 µrad",
            },
        ),
        (predicted(metrics={}), {}),
    ],
)
def test_prediction_errors_have_units(prediction, rows):
    assert prediction_module.metrics_in_words(prediction) == list(rows.items())


@pytest.mark.parametrize(
    ("changes", "level", "reasons"),
    [
        ({}, "usable", ["the error is 3.46 % of the effort of this log"]),
        ({"metrics": LENGTHS}, "usable", ["the error is 2.50 % of the position of this log"]),
        (
            {"metrics": FORCES | LENGTHS},
            "usable",
            ["the error is 3.46 % of the effort of this log"],
        ),
        ({"metrics": {"force_error_percent": np.nan}}, "with_care", []),
        ({"metrics": {"force_error_percent": None}}, "with_care", []),
        (
            {"metrics": {"force_error_percent": 35.0}},
            "with_care",
            ["the error is 35.0 % of the effort of this log"],
        ),
        (
            {"metrics": {"force_error_percent": 90.0}},
            "no",
            ["the error is 90.0 % of the effort of this log"],
        ),
        ({"inside_percent": 80.0}, "usable", ["the error is 3.46 % of the effort of this log"]),
        (
            {"inside_percent": 79.0, "position_inside_percent": 95.0},
            "with_care",
            [
                "the error is 3.46 % of the effort of this log",
                "only 79.0 % of the measured effort is inside the 95 % band",
            ],
        ),
    ],
)
def test_verdict_follows_errors_and_bands(changes, level, reasons):
    ruling = prediction_module.prediction_ruling(predicted(**changes))
    assert (ruling.level, plain(ruling.reasons)) == (level, reasons)


def test_log_of_the_fit_and_missed_tolerance_ask_for_care():
    same_log, missed = (
        prediction_module.prediction_ruling(predicted(), own_log=True),
        prediction_module.prediction_ruling(predicted(status=Status.TOLERANCE_MISSED)),
    )
    reasons = [
        "the model was fitted to this log, so its error on other logs is unknown",
        Status.TOLERANCE_MISSED.sentence,
    ]
    assert [(ruling.level, ruling.reasons[1]) for ruling in (same_log, missed)] == [
        ("with_care", reason) for reason in reasons
    ]
    wild = prediction_module.prediction_ruling(
        predicted(
            status=Status.NOT_FINITE,
            diagnostics=(Diagnostic("short_stretch", "", "warning", {"samples": 3}),),
        )
    )
    assert wild == (
        "no",
        "It does not run",
        (Status.NOT_FINITE.sentence, "bristle left out a stretch too short for a prediction"),
    )


def test_warnings_ask_for_care_errors_forbid_notes_do_not_count():
    doubt = [
        Diagnostic("short_stretch", "", severity, {"samples": 3})
        for severity in ("note", "warning", "error")
    ]
    rulings = [
        prediction_module.prediction_ruling(predicted(diagnostics=(item, item))) for item in doubt
    ]
    assert [(ruling.level, len(ruling.reasons)) for ruling in rulings] == [
        ("usable", 1),
        ("with_care", 2),
        ("no", 2),
    ]


def front_of(prediction, **options):
    return prediction_module._front(
        prediction, FRICTION, LOG, "axis", **{"own_log": False} | options
    )


def further(prediction):
    return plain(prediction_module._further_lines(prediction, "translational"))


def test_first_page_has_the_error_and_the_share_inside_the_band():
    front = front_of(predicted(inside_percent=94.4))
    assert plain([front.facts])[0].endswith("log a.csv, 4 s · model lugre")
    assert plain([front.title, front.basis]) == [
        "Prediction error: 3.46 % of the effort",
        "(a.csv, inverse mode)",
    ]
    assert [(card.label, *plain([card.value, card.remark])) for card in front.cards] == [
        ("Effort error, rms", "250 mN", "of 3.54 N"),
        ("Effort inside the band", "94.4 %", "95 % band"),
    ]
    assert front.next.command == "bristle compare before.csv after.csv --axis axis.toml"


def test_errors_have_the_remaining_effort_of_the_controller():
    supplied = "with this feedforward the controller would supply 250 mN instead of 3.54 N, root mean square"
    lines = [
        further(predicted()),
        further(predicted("closed-loop")),
        further(predicted(effort=None)),
    ]
    inverse, closed = (f"{mode} mode: {MODES[mode]}" for mode in ("inverse", "closed-loop"))
    assert lines == [[inverse, supplied], [closed], [inverse]]


def test_errors_have_the_largest_position_error():
    item = predicted(
        "open-loop", metrics=LENGTHS, position_predicted=np.array([1e-6, 5e-6]), effort=None
    )
    assert further(item) == [
        f"open-loop mode: {MODES['open-loop']}",
        "largest position error: 2 µm",
    ]
    assert len(further(predicted("open-loop", metrics=LENGTHS))) == 1
    front = front_of(item)
    assert [(card.label, *plain([card.value])) for card in front.cards] == [
        ("Position error, rms", "0.400 µm"),
        ("95 % band", "–"),
    ]
    assert front_of(predicted(metrics={})).title == "No signal to compare"


def test_errors_have_the_advice_on_warnings():
    doubts = tuple(
        Diagnostic(code, "", "warning", {"samples": 3, "percent": 120.0, "signal": "effort"})
        for code in ("short_stretch", "worse_than_none")
    )
    assert (
        further(predicted(diagnostics=doubts))[-1]
        == "predict in another mode, or check model, units and signs"
    )
    assert (
        front_of(predicted(diagnostics=doubts)).next.command
        == "bristle identify FIRST THIS --axis axis.toml"
    )


def test_first_page_names_the_next_step():
    command = "bristle predict model.toml OTHER --axis axis.toml"
    assert front_of(predicted(), own_log=True).next == ("Predict a log of another motion", command)
    large = front_of(predicted(metrics=FORCES | {"force_error_percent": 90.0}))
    assert plain(large.ruling.reasons) == ["the error is 90.0 % of the effort of this log"]
    assert front_of(predicted()).ruling.reasons == ()


def test_summary_of_a_prediction_has_its_numbers():
    data = prediction_module.prediction_as_data(
        predicted(inside_percent=94.4, position_inside_percent=80.0, status=Status.NOT_FINITE)
    )
    expected = {
        "mode": "inverse",
        "inside_band_percent": 94.4,
        "position_inside_band_percent": 80.0,
        "completed": False,
    }
    assert data.items() >= (expected | {"status": Status.NOT_FINITE.sentence}).items()
    summary = prediction_module.prediction_summary(
        predicted(), friction=FRICTION, notes=("a",), provenance={"b": "c"}, own_log=True
    )
    assert (
        summary.items()
        >= {
            "model": "lugre",
            "kind": "translational",
            "log_notes": ("a",),
            "completed": True,
        }.items()
    )
    assert summary["verdict"]["level"] == "with_care"
