"""Results as plain data: the output of ``--json``, and the raw numbers that this output omits.

No other module of the golden tests depends on the structure of results, or on names that ``bristle`` does not export.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from bristle.files.summary import plain
from bristle.identification.hysteresis import predict_operator
from bristle.identification.preprocessing import treat
from bristle.prediction import drive_table, unexplained_force
from bristle.report.messages import assumptions_of, note_of
from bristle.report.operators import operator_prediction_summary, operator_summary
from bristle.report.prediction import prediction_summary
from bristle.report.summary import identification_summary

__all__ = [
    "of_break_aways",
    "of_identification",
    "of_operator_prediction",
    "of_operators",
    "of_prediction",
    "predict_operator",
    "signal",
    "unexplained",
]

MARKS = 7  # of a signal that are kept one by one, beside its length, mean and root mean square


def of_identification(result: Any) -> dict[str, Any]:
    """Return all that an identification says."""
    summary = identification_summary(
        result, table=drive_table(result.best, 20), simulation=None, prediction=None, provenance={}
    )
    traces = {name: signal(values) for name, values in vars(result.best.traces).items()}
    return plain(
        {
            "json": summary,
            "notes": result.notes,
            "fits": [_fit(fit) for fit in result.fits],
            "traces": traces,
        }
    )


def _fit(fit: Any) -> dict[str, Any]:
    """Return what the JSON leaves out of a fit."""
    return {
        "name": fit.name,
        "rank": fit.rank,
        "plant": {"name": fit.plant.name, **fit.plant.values},
        "friction": dict(fit.friction.values),
        "order": [estimate.name for estimate in fit.estimates],
        "error_percent": fit.error_percent,
        "held_out": None if fit.held_out is None else vars(fit.held_out),
        "measurements": None if fit.information is None else fit.information.measurements,
        "combinations": {estimate.name: _estimate(estimate) for estimate in fit.combinations},
        "correlation": {
            "names": fit.correlation_names,
            "below_the_diagonal": [row[:place] for place, row in enumerate(fit.correlation)][1:],
        },
        "assumptions": assumptions_of(fit),
        "lag": fit.lag,
        "further": fit.further,
        "unfinished": fit.unfinished,
        "resampling": None if fit.resampling is None else _resampling(fit.resampling),
        "predicted": signal(fit.traces.predicted),
        "mechanical": signal(fit.traces.mechanical),
    }


def _estimate(item: Any) -> dict[str, Any]:
    numbers = {name: getattr(item, name) for name in ("value", "std", "robust_std", "interval")}
    return numbers | {
        "name": item.name,
        "unit": item.unit,
        "status": item.status,
        "note": note_of(item),
        "description": item.description,
    }


def _resampling(result: Any) -> dict[str, Any]:
    draws = {name: np.asarray(item) for name, item in result.bands.draws.items()}
    return {
        "draws": {
            name: item if item.ndim == 1 else [signal(each) for each in item]
            for name, item in draws.items()
        },
        "bands": {name: value for name, value in vars(result.bands).items() if name != "draws"},
        "scatter": result.scatter,
        "curve": result.curve,
    }


def of_prediction(prediction: Any, friction: Any) -> dict[str, Any]:
    """Return all that a prediction says."""
    summary = prediction_summary(prediction, friction=friction, notes=(), provenance={})
    names = (
        "time",
        "effort",
        "effort_predicted",
        "position",
        "position_predicted",
        "half_width",
        "position_half_width",
    )
    return plain(
        {"json": summary, "signals": {name: signal(getattr(prediction, name)) for name in names}}
    )


def of_operators(result: Any) -> dict[str, Any]:
    """Return all that an identification of operators says."""
    fits = [
        {
            "name": fit.name,
            "rank": fit.rank,
            "offset": fit.offset,
            "values": _short(fit.operator.values),
            "held_out": None if fit.held_out is None else vars(fit.held_out),
            "notes": fit.notes,
            "outputs": signal(np.concatenate(fit.prediction.outputs)),
        }
        for fit in result.fits
    ]
    return plain(
        {"json": operator_summary(result, provenance={}), "notes": result.notes, "fits": fits}
    )


def of_operator_prediction(prediction: Any, operator: Any, recorded: Any) -> dict[str, Any]:
    """Return all that an operator says of curves."""
    summary = operator_prediction_summary(prediction, operator, recorded, provenance={})
    return plain({"json": summary, "outputs": signal(np.concatenate(prediction.outputs))})


def of_break_aways(log: Any, axis: Any, cutoff: float, plant: Any, friction: Any) -> list[Any]:
    """Return the break-aways of a log by rate, of a model that is known."""
    return plain(
        [
            break_away._asdict()
            for break_away in treat(log, axis, cutoff).break_aways(plant, friction.values["offset"])
        ]
    )


def unexplained(plant: Any, friction: Any, log: Any, axis: Any) -> dict[str, Any] | None:
    """Return the force that a model does not explain."""
    return signal(unexplained_force(plant, friction, log, axis))


def _short(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values, of long lists what tells them apart."""
    return {name: signal(item) if np.size(item) > 100 else item for name, item in values.items()}


def signal(values: Any) -> dict[str, Any] | None:
    """Return what tells a signal from another one: its size, mean, root mean square and a few of its samples."""
    if values is None:
        return None
    flat = np.ravel(np.asarray(values, float))
    places = np.linspace(0, flat.size - 1, MARKS).astype(int)
    return {
        "size": flat.size,
        "mean": float(np.mean(flat)),
        "rms": float(np.sqrt(np.mean(flat**2))),
        "samples": flat[places].tolist(),
    }
