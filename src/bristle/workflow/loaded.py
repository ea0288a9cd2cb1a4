"""`load`: a folder of results as the model that it holds, with the numbers that it was saved with."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core.axis import Axis
from bristle.core.content import content_of
from bristle.core.contracts import Model
from bristle.core.diagnostic import Diagnostic
from bristle.core.errors import InputError
from bristle.files.arrays import read_arrays
from bristle.files.axis import read_axis
from bristle.files.model import NUMBERS, read_model
from bristle.files.results import SUMMARY
from bristle.files.single import write_whole
from bristle.identification.result import Estimate, Fit, Resampling, Scatter, Traces
from bristle.identification.simulated_bands import Bands
from bristle.report.results import REPORT
from bristle.workflow.model_in_hand import ModelInHand

__all__ = ["Loaded", "load"]

SIMULATED = ("position_error_percent", "position_rmse", "loop_error_percent", "loop_rmse")


@dataclass(frozen=True, eq=False)
class Loaded(ModelInHand):
    """The best model of an identification, as it was saved.

    Parameters
    ----------
    fit : Fit
        The model and what is known of it.
    treatment : mapping of str to float
        How the log was treated, as in `Identified`.
    known_axis : Axis or None
        What was known of the axis.
    summary : mapping
        What ``summary.json`` holds, of all models.
    page : str
        The report.
    """

    fit: Fit
    treatment: Mapping[str, float]
    known_axis: Axis | None
    summary: Mapping[str, Any]
    page: str

    @property
    def best(self) -> Fit:
        """The model and what is known of it."""
        return self.fit

    @property
    def axis(self) -> Axis | None:
        """What was known of the axis."""
        return self.known_axis

    @property
    def _treatment(self) -> Mapping[str, float]:
        return self.treatment

    def to_dict(self) -> dict[str, Any]:
        """Return the numbers as plain data, as ``summary.json`` holds them."""
        return dict(self.summary)

    def report(self, path: str | PathLike[str]) -> Path:
        """Write the report as it was saved; return the file.

        Parameters
        ----------
        path : path-like
            The file; one that is there is replaced.
        """
        return write_whole(path, self.page)

    def _source(self) -> str:
        name = self.summary.get("provenance", {}).get("log")
        return f" from {name}" if name else ""

    def _beside(self) -> tuple[str, ...]:
        behind = ", ".join(model["name"] for model in self.summary["models"][1:])
        return (f"ranked behind it: {behind}",) if behind else ()


def load(folder: str | PathLike[str], *, allow_code: bool = False) -> Loaded:
    """Return what ``save``, or ``bristle identify --out``, wrote into a folder.

    Parameters
    ----------
    folder : path-like
        The folder.
    allow_code : bool
        Whether a model of a person's own, in a file beside the model file, may run without having been allowed before.

    Returns
    -------
    Loaded
        The model with the numbers that it was saved with.

    Raises
    ------
    InputError
        If a file is missing, or does not say what it should.
    """
    place = Path(folder)
    try:
        summary = json.loads(content_of(place / SUMMARY).data)
    except ValueError as error:
        raise InputError(f"is no JSON: {error}", path=str(place / SUMMARY)) from None
    plant, friction, info = read_model(place / "model.toml", allow_code=allow_code)
    traces = read_arrays(place, "traces")
    if plant is None or not traces or "parameters" not in summary:
        raise InputError("holds no identification", path=str(place), mend="Name a folder that `save` wrote")
    try:
        fit = _fit(plant, friction, summary, Traces(**traces), read_arrays(place, "draws"), info["bands"])
    except (KeyError, TypeError) as error:
        raise InputError(f"does not say what it should: {error!r}", path=str(place / SUMMARY)) from None
    axis, page = place / "axis.toml", place / REPORT
    return Loaded(
        fit,
        summary["treatment"],
        read_axis(axis) if axis.is_file() else None,
        summary,
        page.read_text(encoding="utf-8") if page.is_file() else "",
    )


def _fit(
    plant: Model,
    friction: Model,
    summary: Mapping[str, Any],
    traces: Traces,
    draws: Mapping[str, np.ndarray],
    bands: Mapping[str, Any] | None,
) -> Fit:
    diagnostics = tuple(
        Diagnostic(entry["code"], entry["parameter"], entry["severity"], _numbers(entry["numbers"]), friction.kind)
        for entry in summary["diagnostics"]
    )
    metrics, correlation = summary["metrics"], summary["correlation"]
    simulated = {name: metrics[name] for name in SIMULATED}
    return Fit(
        plant=plant,
        friction=friction,
        estimates=_estimates(summary["parameters"], diagnostics),
        correlation=np.array(correlation["values"], dtype=float),
        correlation_names=tuple(correlation["names"]),
        condition_number=_number(metrics["condition_number"]),
        traces=traces,
        force_error_percent=_number(metrics["force_error_percent"]),
        diagnostics=diagnostics,
        combinations=_estimates(summary["combinations"], diagnostics),
        lag=summary["treatment"].get("lag"),
        resampling=_resampling(summary["resampling"], draws, bands),
        **simulated,
    )


def _estimates(parameters: Mapping[str, Any], diagnostics: tuple[Diagnostic, ...]) -> tuple[Estimate, ...]:
    """Return the parameters; why one is not identified is among the diagnostics."""
    names = {field.name for field in fields(Estimate)}
    reasons = {reason.parameter: reason for reason in reversed(diagnostics) if reason.parameter}
    return tuple(
        Estimate(
            name=name,
            **{key: value for key, value in entry.items() if key in names and key != "interval"},
            interval=tuple(entry["interval"]) if entry["interval"] else None,
            reason=None if entry["status"] == "identified" else reasons.get(name),
        )
        for name, entry in parameters.items()
    )


def _resampling(numbers: Mapping[str, Any] | None, draws: Mapping[str, np.ndarray], bands: Mapping[str, Any] | None) -> Resampling | None:
    """Return how sure the model is, with every draw where their file is there, else with those of the model file."""
    if numbers is None or not (draws or bands):
        return None
    errors = {name: numbers[name] for name in NUMBERS if name != "scatter"}
    curve = numbers["virgin_curve"]
    return Resampling(
        bands=Bands(draws or (bands or {})["draws"], scatter=numbers["scatter"]["value"], **errors),
        scatter=Scatter(**numbers["scatter"]),
        half_cycles=numbers["half_cycles"],
        resolution=numbers["resolution"],
        white=numbers["white"],
        jackknife=numbers["jackknife_std"],
        curve=tuple(zip(*(curve[name] for name in ("x", "force", "low", "high")), strict=True)),
        curve_from=numbers["virgin_curve_from"],
    )


def _numbers(numbers: Mapping[str, Any]) -> dict[str, Any]:
    return {name: tuple(value) if isinstance(value, list) else value for name, value in numbers.items()}


def _number(value: float | None) -> float:
    return float("nan") if value is None else value
