"""The methods of an identified model, and `load`: the model of a folder of results."""

from __future__ import annotations

import json
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.core import (
    Axis,
    Card,
    Diagnostic,
    InputError,
    Model,
    Progress,
    WithCard,
    content_of,
    guarded,
    library,
    whole,
)
from bristle.files import SUMMARY, read_arrays, read_axis, read_model, write_whole
from bristle.identification import Estimate, Fit
from bristle.prediction import Claim, Compensation, compensation_of, fit_of
from bristle.report.notebook import as_html, bundle
from bristle.report.results import REPORT

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from bristle.logs import Log
    from bristle.report.known_truth import KnownTruth
    from bristle.simulation import Prediction

COLUMNS = ("Parameter", "Value", "95 % interval", "Unit", "Standard error [%]", "Remark")


class DiagnosticWithMessage(Diagnostic):
    """A diagnostic with its sentence."""

    @property
    def message(self) -> str:
        """The sentence, with its numbers in readable units."""
        from bristle.report.messages import message

        return message(self)

    def __str__(self) -> str:
        return self.message


class ModelInHand(WithCard):
    """An identified model: parameters, uncertainty and predictions."""

    best: Any  # a Fit, and an Axis or None: fields of `Loaded`, properties of `Identified`
    axis: Any
    treatment: Mapping[str, float]

    @property
    def model(self) -> Model:
        """The friction model with its values."""
        return self.best.friction

    @property
    def plant(self) -> Model:
        """The plant with its values."""
        return self.best.plant

    @property
    def parameters(self) -> dict[str, Estimate]:
        """Every parameter by name: ``value``, ``interval``, ``unit``, ``status``, ``std``."""
        return self.best.parameters

    @property
    def diagnostics(self) -> tuple[DiagnosticWithMessage, ...]:
        """Warnings and assumptions of the model, each with its sentence in ``message``."""
        return tuple(
            DiagnosticWithMessage(**vars(diagnostic)) for diagnostic in self.best.diagnostics
        )

    @property
    def covariance_names(self) -> tuple[str, ...]:
        """Names of the identified parameters in the order of the covariance; parameters estimated before the fit are last."""
        together = self.best.correlation_names
        stds = self._stds()
        return (
            *(name for name in together if name in stds),
            *(name for name in stds if name not in together),
        )

    @property
    def covariance(self) -> np.ndarray:
        """Covariance of the identified parameters [products of their units], shape (parameter, parameter).

        An inertia estimated before the fit counts as independent of the other parameters; `draws` include the true correlation.
        """
        stds, together = self._stds(), self.best.correlation_names
        places = [index for index, name in enumerate(together) if name in stds]
        names, count = self.covariance_names, len(places)
        correlation = np.eye(len(names))
        correlation[:count, :count] = np.asarray(self.best.correlation, dtype=float)[
            np.ix_(places, places)
        ]
        std = np.array([stds[name] for name in names])
        return correlation * np.outer(std, std)

    def _stds(self) -> dict[str, float]:
        """Return the standard errors of the identified parameters; products of parameters count as parameters."""
        return {
            estimate.name: estimate.std
            for estimate in self.best.estimates
            if estimate.status == "identified"
            and estimate.std is not None
            and np.isfinite(estimate.std)
        }

    @property
    def draws(self) -> dict[str, np.ndarray]:
        """Parameters of the replicates, one entry for each simulated log; empty without replicates."""
        resampling = self.best.resampling
        return (
            {}
            if resampling is None
            else {name: np.asarray(values) for name, values in resampling.bands.draws.items()}
        )

    def predict(
        self,
        log: Log | str | PathLike[str] | Any,
        mode: str = "inverse",
        *,
        axis: Axis | str | PathLike[str] | None = None,
    ) -> Prediction:
        """Predict a log with the treatment of the identification, and with its 95 % band if the model has bands."""
        from bristle.files import TREATMENT
        from bristle.prediction import predict

        resampling = self.best.resampling
        options: dict[str, Any] = {
            name: self.treatment[name] for name in TREATMENT if name in self.treatment
        }
        options |= {"decimation": int(options["decimation"])} if "decimation" in options else {}
        bands = resampling.bands if resampling is not None else None
        return predict(
            self.plant,
            self.model,
            log,
            self.axis if axis is None else axis,
            mode,
            bands=bands,
            **options,
        )

    def drive_table(self, entries: int = 20) -> list[tuple[float, float]]:
        """Return velocity and steady friction for the compensation of a drive, with at most `entries` rows."""
        from bristle.prediction import drive_table

        return drive_table(self.best, entries)

    @guarded(draws=whole(1, 1000))
    def known_truth(
        self, log: Any = None, *, draws: int = 10, progress: Progress | None = None
    ) -> KnownTruth:
        """Return which parameters the log determines: simulate logs of this axis and identify them again.

        For loaded results without a named log, bristle searches the parent folder, the folder and the current folder.
        """
        from bristle.identification import Determined
        from bristle.report.known_truth import KnownTruth

        best, (logs, axes, settings) = self.best, self._recorded(log)
        parameters = Determined.by_simulated_logs(
            logs, axes, best, self.treatment, settings, count=draws, progress=progress
        )
        return KnownTruth(best.name, {parameter.name: parameter for parameter in parameters}, draws)

    @abstractmethod
    def _recorded(self, log: Any) -> tuple[list[Log], list[Axis | None], Mapping[str, float]]:
        """Return the logs of the identification, their axes and the thresholds."""

    def plot(self) -> Figure:
        """Return measured and predicted effort as a matplotlib figure: over the whole log, and around the largest difference."""
        from bristle.report.figures.fit import effort_over_time

        return effort_over_time(self.best)

    def widget(self) -> Any:
        """Return an interactive model for a notebook, a `Widget` of the lab, with the identified interval under each slider."""
        from bristle.report.apps import part
        from bristle.report.living import uncertainty_of

        return part("widget")(
            self.model,
            uncertainty=uncertainty_of(self.best),
            fastest=float(self.treatment.get("velocity_max", 0.0)),
        )

    def to_dataframe(self) -> Any:
        """Return the parameters as a data frame of pandas, one row for each parameter."""
        from bristle.report.messages import picked

        pandas = library("pandas", "to_dataframe()")
        rows = {
            name: picked(estimate, "value", "unit", "std", "robust_std")
            | dict(zip(("low", "high"), estimate.interval or (None, None), strict=True))
            | picked(estimate, "status", "description")
            for name, estimate in self.parameters.items()
        }
        return pandas.DataFrame.from_dict(rows, orient="index").rename_axis("parameter")

    _repr_html_, _repr_mimebundle_ = as_html, bundle  # pyright: ignore[reportAssignmentType]

    def _card(self) -> Card:
        from bristle.report.messages import warnings_of
        from bristle.report.model_tables import parameter_table

        table = parameter_table(self.best)
        columns = [index for index, head in enumerate(table.heads) if head in COLUMNS]
        rows = tuple(tuple(row[index] for index in columns) for row in table.rows)
        logs, remarks = self._words()
        return Card(
            f"{self.best.name}, identified{f' from {logs}' if logs else ''}: error {self.best.error_percent:.3g} %",
            tuple(table.heads[index] for index in columns),
            rows,
            (*remarks, *(f"warning: {warning}" for warning in warnings_of(self.best))),
        )

    def _words(self) -> tuple[str, list[str]]:
        """Return the names of the logs, and remarks."""
        return "", []


@dataclass(frozen=True, eq=False)
class Loaded(ModelInHand):
    """The best model of a saved identification.

    Parameters
    ----------
    best : Fit
        The model with its uncertainty.
    treatment : mapping of str to float
        The treatment of the log, as in `Identification`.
    axis : Axis or None
        The axis of the identification.
    summary : mapping
        The contents of ``summary.json``, for all models.
    page : str
        The report, an HTML page.
    folder : Path
        The folder of the saved results.
    """

    best: Fit
    treatment: Mapping[str, float]
    axis: Axis | None
    summary: Mapping[str, Any]
    page: str
    folder: Path = Path()

    def to_dict(self) -> dict[str, Any]:
        """Return the numbers of ``summary.json`` as plain data."""
        return dict(self.summary)

    def report(self, path: str | PathLike[str]) -> Path:
        """Write the saved report; return the file.

        Parameters
        ----------
        path : path-like
            The file; an existing file is replaced.
        """
        return write_whole(path, self.page)

    @property
    def compensation(self) -> Compensation:
        """The share of the friction to feed forward, and the moves that it helps, as saved."""
        usual = compensation_of(self.best.friction, self.axis, self.treatment)
        saved = self.summary.get("feedforward")
        if saved is None:  # of an earlier version
            return usual
        claims = tuple(Claim(*map(claim.get, Claim._fields)) for claim in saved["claims"])
        return usual._replace(rule=usual.rule._replace(gain=saved["first_gain"]), claims=claims)

    def _recorded(self, log: Any) -> tuple[list[Log], list[Axis | None], Mapping[str, float]]:
        from bristle.report.known_truth import logs_of

        return *logs_of(self.folder, self.summary["provenance"], log), self.summary["settings"]

    def _words(self) -> tuple[str, list[str]]:
        behind = ", ".join(model["name"] for model in self.summary["models"][1:])
        return self.summary.get("provenance", {}).get("log") or "", [
            f"next in rank: {behind}"
        ] * bool(behind)


@guarded()
def load(folder: str | PathLike[str], *, allow_code: bool = False) -> Loaded:
    """Load the results of ``save`` or ``bristle identify --out`` from a folder.

    Parameters
    ----------
    folder : path-like
        The folder.
    allow_code : bool
        Whether user code in the folder may run without earlier permission.

    Returns
    -------
    Loaded
        The model with its saved numbers.

    Raises
    ------
    InputError
        If a file is missing or invalid.
    """
    place = Path(folder)
    if not (place / SUMMARY).is_file():
        raise InputError(
            "there is no such file",
            path=str(place / SUMMARY),
            mend="Name a folder written by `save` or `bristle identify --out`",
        )
    try:
        summary = json.loads(content_of(place / SUMMARY).data)
    except ValueError as error:
        raise InputError(f"is not JSON: {error}", path=str(place / SUMMARY)) from None
    plant, friction, info = read_model(place / "model.toml", allow_code=allow_code)
    traces = read_arrays(place, "traces")
    if plant is None or not traces or "parameters" not in summary:
        raise InputError(
            "contains no identification", path=str(place), mend="Name a folder written by `save`"
        )
    try:
        fit = fit_of(plant, friction, summary, traces, read_arrays(place, "draws"), info["bands"])
    except (KeyError, TypeError) as error:
        raise InputError(
            f"has missing or invalid entries: {error!r}", path=str(place / SUMMARY)
        ) from None
    axis, page = place / "axis.toml", place / REPORT
    return Loaded(
        fit,
        summary["treatment"],
        read_axis(axis) if axis.is_file() else None,
        summary,
        page.read_text(encoding="utf-8") if page.is_file() else "",
        place,
    )
