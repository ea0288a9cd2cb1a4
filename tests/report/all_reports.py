"""A small result of each kind of report, and its page with figures, rendered once per session."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from tests.prediction.excitation.axes import STAGE

from bristle import hysteresis
from bristle.apps.arm.report import arm_prediction
from bristle.apps.design.report import design_report, design_summary
from bristle.apps.study.fleet.report import fleet_report, fleet_summary
from bristle.apps.study.report import study_report, study_summary
from bristle.apps.study.store import Runs
from bristle.core import Diagnostic, Origin
from bristle.identification.hysteresis.result import OperatorPrediction
from bristle.logs.curves import Curve, Curves
from bristle.prediction import drive_table
from bristle.prediction.excitation import excite
from bristle.report.comparison import comparison_report, comparison_summary
from bristle.report.excitation import excitation_report, excitation_summary
from bristle.report.figures.contract import example_facts
from bristle.report.identification import identification_report
from bristle.report.log import log_report, log_ruling
from bristle.report.operators import operator_prediction_report, operator_prediction_summary
from bristle.report.page import plates
from bristle.report.prediction import prediction_report, prediction_summary
from bristle.report.simulation import simulation_report, simulation_summary
from bristle.report.summary import identification_summary

COMMON = {"command": "bristle do it", "provenance": {"bristle": "0"}}
LOGS = ("before.csv", "after.csv")


@cache
def results():
    """Small results by name, from logs that have names."""
    facts = dict(example_facts("translational"))
    log = _named(facts["log"], LOGS[0])
    facts["identification"] = replace(facts["identification"], log=log)
    facts["prediction"] = replace(facts["prediction"], log=LOGS[0])
    sides = (
        (_named(facts["comparison"].logs_before[0], LOGS[0]),),
        (_named(facts["comparison"].logs_after[0], LOGS[1]),),
    )
    facts["comparison"] = replace(facts["comparison"], logs_before=sides[0], logs_after=sides[1])
    motion = excite(STAGE, rehearsed=False)
    friction, fitted = (
        np.sign(motion.motion.velocity),
        SimpleNamespace(best=facts["identification"].best, sweep=None),
    )
    rehearsal = SimpleNamespace(
        identification=fitted, truth={}, peak_effort=1.0, lag=0.0, loop=False, friction=friction
    )
    u = np.linspace(-1e-6, 1e-6, 50)
    return facts | {
        "log": log,
        "excitation": replace(motion, rehearsal=rehearsal),
        "recorded": Curves((Curve(u, 1e6 * u),), source=Path(LOGS[0])),
    }


def _named(log, name):
    return replace(log, source=Path(name), origin=Origin(name, "0" * 64))


def identification(*, by_position=False, doubts=()):
    """An identification with its summary, or with given doubts."""
    facts = results()
    result, best = facts["identification"], facts["identification"].best
    best = replace(best, diagnostics=(*best.diagnostics, *doubts))
    best = replace(best, position_rmse=1e-6, position_error_percent=1.0) if by_position else best
    result = replace(result, fits=(best, *result.fits[1:]))
    values = {
        "prediction": facts["prediction"],
        "simulation": facts["simulation"],
        "table": drive_table(best, 10),
    }
    summary = identification_summary(result, provenance={}, **values)
    return identification_report(result, axis_name="axis", **values, **COMMON), summary


def prediction():
    facts, best = results(), results()["identification"].best
    page = prediction_report(
        facts["prediction"],
        plant=best.plant,
        friction=best.friction,
        log=facts["log"],
        axis_name="axis",
        **COMMON,
    )
    return page, prediction_summary(
        facts["prediction"], friction=best.friction, notes=(), provenance={}
    )


def simulation():
    facts = results()
    return simulation_report(facts["simulation"], **COMMON), simulation_summary(
        facts["simulation"], files={}, provenance={}
    )


def log():
    result = results()["log"]
    return log_report(result, (), name="axis", **COMMON), {
        "verdict": log_ruling(result, ()).as_data(),
        "diagnostics": [],
    }


def design():
    result = results()["design"]
    return design_report(result, **COMMON), design_summary(result, provenance={})


def comparison():
    result = results()["comparison"]
    return comparison_report(result, name="axis", **COMMON), comparison_summary(
        result, name="axis", provenance={}
    )


def excitation():
    result = results()["excitation"]
    summary = excitation_summary(result, files={}, identify="bristle identify LOG", provenance={})
    return excitation_report(result, identify="bristle identify LOG", **COMMON), summary


def study():
    runs = results()["study"]
    summary = study_summary(runs, **COMMON)
    return study_report(runs, summary, command="bristle"), summary


def fleet():
    """Three logs of a fleet, with one failure."""
    texts = {
        "folder": ["a", "b", "b"],
        "log": [*LOGS, "third.csv"],
        "status": ["ok", "ok", "failed"],
        "reason": ["", "", "no effort"],
    }
    numbers = {
        "run": np.arange(3),
        "held_out_error": np.array([0.01, 0.02, np.nan]),
        "friction.F_C": np.array([5.0, 6.0, np.nan]),
    }
    ends = {
        "friction.F_C.lower": np.array([4.0, 5.0, np.nan]),
        "friction.F_C.upper": np.array([6.0, 7.0, np.nan]),
    }
    texts |= {
        "friction.F_C.status": ["identified", "identified", ""],
        "diagnostics": ["", "clipped", ""],
    }
    about = {"friction.F_C": {"unit": "N", "description": "friction", "role": "parameter"}}
    described = {
        "name": "axes",
        "kind": "translational",
        "model": "coulomb",
        "runs": 3,
        "metrics": ["friction.F_C"],
        "columns": about,
    }
    runs = Runs(
        described, numbers | ends | {name: np.array(values) for name, values in texts.items()}
    )
    summary = fleet_summary(runs, provenance={})
    return fleet_report(runs, summary, command="bristle"), summary


def arm():
    """Two joints, each with the prediction of the example."""
    facts, best = results(), results()["identification"].best
    one = prediction_summary(
        facts["prediction"], friction=best.friction, notes=(), provenance={"bristle": "0"}
    )
    names = ("A1", "A2")
    summary, _, page = arm_prediction(
        dict.fromkeys(names, one),
        dict.fromkeys(names, facts["prediction"]),
        "arm",
        LOGS[0],
        "bristle",
    )
    return page, summary


def operator():
    recorded = results()["recorded"]
    predicted, model = (
        OperatorPrediction(tuple(curve.f for curve in recorded.curves), 0.1, 1.0),
        hysteresis.preisach(s=1.25e7, f_p=150.0),
    )
    summary = operator_prediction_summary(predicted, model, recorded, provenance={})
    return operator_prediction_report(predicted, model, recorded, name="axis", **COMMON), summary


KINDS = {
    "identification": identification,
    "prediction": prediction,
    "simulation": simulation,
    "log": log,
    "design": design,
    "comparison": comparison,
    "excitation": excitation,
    "study": study,
    "fleet": fleet,
    "operator": operator,
    "arm": arm,
}
DOUBTED = {"doubts": (Diagnostic("sign_reversed", severity="error", numbers={"percent": 90.0}),)}
"""Options of an unusable identification."""


def rendered(kind, **options):
    """Return page, summary and figures of a kind of report, rendered again."""
    with plates() as drawn:
        page, summary = KINDS[kind](**options)
    return page, summary, drawn


@cache
def report_of(kind):
    """Return page, summary and figures of a kind of report, rendered once."""
    return rendered(kind)
