"""The reports of hysteresis operators: verdict by held-out error, tables of operators and parameters."""

from types import SimpleNamespace as Some

import numpy as np
import pytest

from bristle import hysteresis
from bristle.report import operators as report
from bristle.report.operators import comparison_of_operators, operator_ruling, operator_summary
from bristle.report.table import percent_text


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
    ruling = operator_ruling(error, held_out, fitted=fitted)
    assert (ruling.level, len(ruling.reasons)) == (level, reasons)
    told = "on these curves" if held_out is None else "on held-out curves"
    assert ruling.reasons[0] == f"the error is {percent_text(error if held_out is None else held_out)} of full scale {told}"


def fit(name, rank, error, rmse, held_out=None, notes=()):
    kept = None if held_out is None else Some(mean_percent=held_out, std_percent=0.5, of="the last curve")
    operator = hysteresis.preisach(s=1.25e7, f_p=150.0)
    prediction = Some(error_percent=error, rmse=rmse)
    metrics = {"error_percent": error}
    return Some(name=name, rank=rank, prediction=prediction, held_out=kept, notes=notes, operator=operator, offset=2.0, metrics=metrics)


RECORDED = Some(
    kind="translational",
    curves=(Some(u=np.zeros(3)), Some(u=np.zeros(4))),
    start="demagnetised",
    full_scale=0.5,
    notes=("read",),
    source=Some(name="<curves.csv>"),
)
FITS = (fit("preisach", 1, 1.5, 2e-3, 3.25, ("", "first", "second", "third")), fit("duhem", 2, 4.0, 5e-3), fit("c", 3, 1.0, 1e-3, 6.0))


def test_operators_are_compared_on_held_out_curves():
    table = comparison_of_operators(Some(recorded=RECORDED, fits=FITS))
    assert table.heads == ["Operator", "Rank", "Held-out error [% of full scale]", "Fitted [% of full scale]", "Fitted [mN]"]
    assert table.rows == [
        ["preisach", "1", "3.25 ± 0.50", "1.50", "2.00"],
        ["duhem", "2", "–", "4.00", "5.00"],
        ["c", "3", "6.00 ± 0.50", "1.00", "1.00"],
    ]


def test_first_page_of_an_operator_lists_the_other_operators():
    front = report._front(FITS[0].prediction, "axis: preisach", RECORDED, FITS)
    assert front.ruling.level == "with_care"
    assert front.facts.endswith("2 curves")
    assert front.title == "Held-out error 3.25\u00a0% of full scale"
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
    assert [(card.label, card.remark) for card in front.cards] == [("Error", "rms"), ("Full scale", "1 curve")]
    assert front.next.command.startswith("bristle identify CURVES")
    assert front.ruling.level == "usable"


def test_summary_of_an_operator_has_the_constant_output():
    congruency = Some(alike=0.1, anywhere=0.2)
    identification = Some(best=FITS[0], fits=FITS, recorded=RECORDED, congruency=congruency, unfinished="")
    summary = operator_summary(identification, provenance={"a": "b"})
    assert summary["parameters"]["offset"] == {"value": 2.0, "unit": "N", "description": "constant output added to the operator"}
    assert summary["parameters"]["f_p"]["value"] == 150.0
    assert summary["log"] == {"curves": 2, "samples": 7, "start": "demagnetised", "full_scale": 0.5, "notes": ("read",)}
    assert [model["rank"] for model in summary["models"]] == [1, 2, 3]
    assert summary["unfinished"] is None
    assert summary["verdict"]["level"] == "with_care"
    assert operator_summary(Some(**vars(identification) | {"unfinished": "stopped"}), provenance={})["unfinished"] == "stopped"


def test_page_of_an_operator_has_parameters_and_data(monkeypatch):
    seen = {}
    monkeypatch.setattr(report, "report_page", lambda kind, facts, front, sections, **options: seen.update(facts, sections=sections) or "")
    prediction = Some(**vars(FITS[0].prediction) | {"outputs": (1, 2)})
    levels = hysteresis.relays_of(hysteresis.preisach(s=1.0, f_p=1.0), 1.0, 4)
    for operator in (FITS[0].operator, levels):
        report.operator_prediction_report(prediction, operator, RECORDED, name="axis")
        compared, model, data = seen["sections"]
        rows = {row[0]: row[1] for row in model.blocks[0].rows}
        facts = data.blocks[0].content
        assert facts == [("Curves", "2"), ("Samples", "7"), ("Each begins", "demagnetised"), ("Full scale", "500 mN"), ("Note", "read")]
        assert (compared.heading, seen["outputs"], seen["log_name"]) == ("Remarks", (1, 2), "curves.csv")
    assert rows["levels"] == "5 numbers, in the model file"
    report.operator_prediction_report(prediction, FITS[0].operator, RECORDED, name="axis")
    assert {row[0]: row[1] for row in seen["sections"][1].blocks[0].rows}["f_p"] == "150 N"


@pytest.mark.parametrize(("count", "heading"), [(1, "Remarks"), (2, "Operators compared")])
def test_several_operators_are_compared(monkeypatch, count, heading):
    seen = {}
    monkeypatch.setattr(report, "report_page", lambda kind, facts, front, sections, **options: seen.update(facts, sections=sections) or "")
    prediction = Some(**vars(FITS[0].prediction) | {"outputs": (1, 2)})
    best = Some(**vars(FITS[0]) | {"prediction": prediction})
    report.operator_report(Some(best=best, fits=FITS[:count], recorded=RECORDED, notes=("a note",)), name="axis")
    compared, _, data = seen["sections"]
    assert ("Held out", "the last curve") in data.blocks[0].content
    assert (compared.heading, compared.blocks[0] is not None) == (heading, count == 2)
    assert compared.blocks[1].content == ("a note",)
    assert seen["outputs"] == (1, 2)
