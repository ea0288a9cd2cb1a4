"""Hysteresis operators in numbers and tables: what was fitted to recorded curves, and what one says of others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from bristle.core.typography import number, with_unit
from bristle.core.variable import unit_of
from bristle.report.fronts.operators import operator_front, operator_ruling
from bristle.report.table import Quantity, Table

if TYPE_CHECKING:
    from bristle.core.contracts import Model
    from bristle.hysteresis.identification.result import OperatorFit, OperatorIdentification, OperatorPrediction
    from bristle.logs.curves import Curves

__all__ = ["comparison_of_operators", "operator_prediction_report", "operator_prediction_summary", "operator_report", "operator_summary"]


def operator_summary(identification: OperatorIdentification, *, provenance: Mapping[str, str]) -> dict[str, Any]:
    """Return the identification of an operator in numbers: the best one on top, all of them under ``models``."""
    best, kind = identification.best, identification.recorded.kind
    return {
        "model": best.name,
        "kind": kind,
        "parameters": _parameters(best.operator, best.offset),
        "verdict": operator_ruling(best.prediction.error_percent, best.held_out and best.held_out.mean_percent, fitted=True).as_data(),
        "metrics": best.metrics,
        "notes": best.notes,
        "congruency": {"alike": identification.congruency.alike, "anywhere": identification.congruency.anywhere},
        "models": [_model(fit) for fit in identification.fits],
        "log": _log(identification.recorded),
        "unfinished": identification.unfinished or None,
        "provenance": provenance,
    }


def operator_prediction_summary(
    prediction: OperatorPrediction, operator: Model, recorded: Curves, *, provenance: Mapping[str, str]
) -> dict[str, Any]:
    """Return in numbers what an operator says of recorded curves."""
    metrics = {"error_percent": prediction.error_percent, "rmse": prediction.rmse}
    return {
        "model": operator.name,
        "kind": operator.kind,
        "mode": "operator",
        "verdict": operator_ruling(prediction.error_percent, None, fitted=False).as_data(),
        "metrics": metrics | {"unit": unit_of("force", operator.kind), "full_scale": prediction.full_scale},
        "log": _log(recorded),
        "provenance": provenance,
    }


def operator_report(
    identification: OperatorIdentification, *, name: str, command: str, provenance: Mapping[str, str], banner: str | None = None
) -> str:
    """Return the report of the identification of an operator as one HTML page."""
    best = identification.best
    comparison = comparison_of_operators(identification) if len(identification.fits) > 1 else None
    return _page(
        best.prediction,
        best.operator,
        identification.recorded,
        title=f"{best.name} identified",
        name=name,
        fits=identification.fits,
        notes=identification.notes,
        comparison=comparison,
        command=command,
        provenance=provenance,
        banner=banner,
    )


def operator_prediction_report(
    prediction: OperatorPrediction,
    operator: Model,
    recorded: Curves,
    *,
    name: str,
    command: str,
    provenance: Mapping[str, str],
    banner: str | None = None,
) -> str:
    """Return the report of recorded curves, predicted by an operator, as one HTML page."""
    return _page(
        prediction,
        operator,
        recorded,
        title=f"prediction by {operator.name}",
        name=name,
        fits=(),
        notes=(),
        comparison=None,
        command=command,
        provenance=provenance,
        banner=banner,
    )


def _page(
    prediction: OperatorPrediction, operator: Model, recorded: Curves, *, name: str, title: str, fits: Sequence[OperatorFit], **content: Any
) -> str:
    from bristle.figures import recorded_curves
    from bristle.report.page import picture, render

    drawn = picture(
        "curves",
        lambda: recorded_curves(recorded.curves, prediction.outputs, recorded.kind),
        "Recorded and predicted output over the input",
        "Where the light line looks out from under the dark one, what was recorded is not predicted. Of many curves, some are shown.",
    )
    unit = unit_of("force", recorded.kind)
    facts = [
        ("Curves", str(len(recorded.curves))),
        ("Samples", str(sum(curve.u.size for curve in recorded.curves))),
        ("Each begins", recorded.start),
        ("Full scale", with_unit(recorded.full_scale, unit)),
        *(("Note", note) for note in recorded.notes),
    ]
    return render(
        "operator.html",
        axis_name=name,
        what=title,
        front=operator_front(prediction, name, title, recorded, drawn, fits),
        facts=facts,
        parameters=_parameter_table(operator),
        **content,
    )


def _parameter_table(operator: Model) -> Table:
    """Return the parameters of an operator; of a list, how many numbers it has."""
    rows = []
    for name, variable in operator.component.variables.items():
        value = operator.values[name]
        if isinstance(value, str):
            text = value
        elif hasattr(value, "__len__"):
            text = f"{len(value)} numbers, in the model file"
        else:
            text = with_unit(float(value), variable.unit(operator.kind))
        rows.append([name, text, variable.description])
    return Table(operator.name, ("Parameter", "Value", "Meaning"), rows)


def comparison_of_operators(identification: OperatorIdentification) -> Table:
    """Return the operators compared, best first."""
    rmse = Quantity.of(unit_of("force", identification.recorded.kind), [fit.prediction.rmse for fit in identification.fits])
    rows = [
        [
            fit.name,
            str(fit.rank),
            f"{number(fit.held_out.mean_percent, digits=3)} ± {number(fit.held_out.std_percent, digits=2)}" if fit.held_out else "–",
            number(fit.prediction.error_percent, digits=3),
            number(fit.prediction.rmse * rmse.scale.factor, digits=3),
        ]
        for fit in identification.fits
    ]
    heads = ("Operator", "Rank", "Error on what was not fitted [% of full scale]", "Fitted [% of full scale]")
    return Table("Operators compared", (*heads, rmse.head("Fitted")), rows)


def _model(fit: OperatorFit) -> dict[str, Any]:
    parameters = _parameters(fit.operator, fit.offset)
    return {"name": fit.name, "rank": fit.rank, "parameters": parameters, "metrics": fit.metrics, "notes": fit.notes}


def _parameters(operator: Model, offset: float) -> dict[str, Any]:
    """Return the parameters that are single numbers; tables stand in the model file."""
    values = {
        name: {"value": value, "unit": variable.unit(operator.kind), "description": variable.description}
        for name, variable in operator.component.variables.items()
        if not hasattr(value := operator.values[name], "__len__") or isinstance(value, str)
    }
    level = {"value": offset, "unit": unit_of("force", operator.kind), "description": "constant output beside it"}
    return values if "offset" in values else values | {"offset": level}


def _log(recorded: Curves) -> dict[str, Any]:
    return {
        "curves": len(recorded.curves),
        "samples": sum(curve.u.size for curve in recorded.curves),
        "start": recorded.start,
        "full_scale": recorded.full_scale,
        "notes": recorded.notes,
    }
