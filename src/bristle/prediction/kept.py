"""A fit from its files: numbers of a summary, traces, draws."""

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from bristle.core import Diagnostic, Model
from bristle.files.model import NUMBERS
from bristle.identification.estimate import Estimate
from bristle.identification.result import Bands, Fit, Resampling, Scatter, Traces

SIMULATED = ("position_error_percent", "position_rmse", "loop_error_percent", "loop_rmse")


def fit_of(
    plant: Model,
    friction: Model,
    summary: Mapping[str, Any],
    traces: Mapping[str, np.ndarray],
    draws: Mapping[str, np.ndarray],
    bands: Mapping[str, Any] | None,
) -> Fit:
    """Return the fit with the numbers of a summary, arrays and a model file."""
    numbers = [
        {
            name: tuple(value) if isinstance(value, list) else value
            for name, value in entry["numbers"].items()
        }
        for entry in summary["diagnostics"]
    ]
    diagnostics = tuple(
        Diagnostic(entry["code"], entry["parameter"], entry["severity"], own, friction.kind)
        for entry, own in zip(summary["diagnostics"], numbers, strict=True)
    )
    metrics = summary["metrics"]
    correlation = summary["correlation"]
    errors = {name: metrics[name] for name in SIMULATED}
    errors |= {
        name: math.nan if metrics[name] is None else metrics[name]
        for name in ("condition_number", "force_error_percent")
    }
    return Fit(
        plant=plant,
        friction=friction,
        estimates=_estimates(summary["parameters"], diagnostics),
        correlation=np.array(correlation["values"], dtype=float),
        correlation_names=tuple(correlation["names"]),
        traces=Traces(**traces),
        diagnostics=diagnostics,
        combinations=_estimates(summary["combinations"], diagnostics),
        lag=summary["treatment"].get("lag"),
        resampling=_resampling(summary["resampling"], draws, bands),
        **errors,
    )


def _estimates(
    parameters: Mapping[str, Any], diagnostics: tuple[Diagnostic, ...]
) -> tuple[Estimate, ...]:
    """Return the parameters; the reason for an unidentified parameter is among the diagnostics."""
    names = {field.name for field in fields(Estimate)}
    reasons = {reason.parameter: reason for reason in reversed(diagnostics) if reason.parameter}
    return tuple(
        Estimate(
            name=name,
            **{
                key: value
                for key, value in entry.items()
                if key in names and key not in ("interval", "value")
            },
            value=math.inf if entry["value"] is None else entry["value"],  # JSON has no infinity
            interval=tuple(entry["interval"]) if entry["interval"] else None,
            reason=None if entry["status"] == "identified" else reasons.get(name),
        )
        for name, entry in parameters.items()
    )


def _resampling(
    numbers: Mapping[str, Any] | None,
    draws: Mapping[str, np.ndarray],
    bands: Mapping[str, Any] | None,
) -> Resampling | None:
    """Return the uncertainty of the model, with all draws if their file exists, else with those of the model file."""
    if numbers is None or not (draws or bands):
        return None
    errors = {name: numbers[name] for name in NUMBERS if name != "scatter"}
    curve = numbers["virgin_curve"]
    return Resampling(
        bands=Bands(draws or (bands or {})["draws"], scatter=numbers["scatter"]["value"], **errors),
        scatter=Scatter(**numbers["scatter"]),
        half_cycles=numbers["half_cycles"],
        resolution=numbers["resolution"],
        curve=tuple(zip(*(curve[name] for name in ("x", "force", "low", "high")), strict=True)),
        curve_from=numbers["virgin_curve_from"],
    )
