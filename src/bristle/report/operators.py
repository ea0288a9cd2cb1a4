"""Hysteresis operators in numbers and tables: what was fitted to recorded curves, and what one says of others."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from bristle.core.typography import number
from bristle.core.variable import unit_of
from bristle.report.table import Quantity, Table

if TYPE_CHECKING:
    from bristle.core.contracts import Model
    from bristle.identification.operators.result import OperatorFit, OperatorIdentification, OperatorPrediction
    from bristle.logs.curves import Curves

__all__ = ["comparison_of_operators", "operator_prediction_summary", "operator_summary"]


def operator_summary(found: OperatorIdentification, *, provenance: Mapping[str, str]) -> dict[str, Any]:
    """Return the identification of an operator in numbers: the best one on top, all of them under ``models``."""
    best, kind = found.best, found.recorded.kind
    return {
        "model": best.name,
        "kind": kind,
        "parameters": _parameters(best.operator, best.offset),
        "metrics": best.metrics,
        "notes": best.notes,
        "congruency": {"alike": found.congruency.alike, "anywhere": found.congruency.anywhere},
        "models": [_model(fit) for fit in found.fits],
        "log": _log(found.recorded),
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
        "metrics": metrics | {"unit": unit_of("force", operator.kind), "full_scale": prediction.full_scale},
        "log": _log(recorded),
        "provenance": provenance,
    }


def comparison_of_operators(found: OperatorIdentification) -> Table:
    """Return the operators compared, best first."""
    rmse = Quantity.of(unit_of("force", found.recorded.kind), [fit.prediction.rmse for fit in found.fits])
    rows = [
        [
            fit.name,
            str(fit.rank),
            f"{number(fit.held_out.mean_percent, digits=3)} ± {number(fit.held_out.std_percent, digits=2)}"
            if fit.held_out
            else "–",
            number(fit.prediction.error_percent, digits=3),
            rmse.cell(fit.prediction.rmse),
        ]
        for fit in found.fits
    ]
    heads = ("Operator", "Rank", "Error on what was not fitted [% of full scale]", "Fitted [% of full scale]")
    return Table("Operators compared", (*heads, rmse.head("Fitted")), rows)


def _model(fit: OperatorFit) -> dict[str, Any]:
    parameters = _parameters(fit.operator, fit.offset)
    return {"name": fit.name, "rank": fit.rank, "parameters": parameters, "metrics": fit.metrics, "notes": fit.notes}


def _parameters(operator: Model, offset: float) -> dict[str, Any]:
    """Return the parameters that are single numbers; tables stand in the model file."""
    found = {
        name: {"value": value, "unit": variable.unit(operator.kind), "description": variable.description}
        for name, variable in operator.component.variables.items()
        if not hasattr(value := operator.values[name], "__len__") or isinstance(value, str)
    }
    level = {"value": offset, "unit": unit_of("force", operator.kind), "description": "constant output beside it"}
    return found if "offset" in found else found | {"offset": level}


def _log(recorded: Curves) -> dict[str, Any]:
    return {
        "curves": len(recorded.curves),
        "samples": sum(one.u.size for one in recorded.curves),
        "start": recorded.start,
        "full_scale": recorded.full_scale,
        "notes": recorded.notes,
    }
