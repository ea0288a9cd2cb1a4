"""What an identified model lets a person do, and `load`: a folder of results as the model that it holds."""

from __future__ import annotations

import json
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.core import Axis, Card, Diagnostic, InputError, Model, Progress, WithCard, content_of, library
from bristle.files import SUMMARY, read_arrays, read_axis, read_model, write_whole
from bristle.identification import Estimate, Fit
from bristle.prediction import fit_of
from bristle.report.results import REPORT

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from bristle.lab.widget import Widget
    from bristle.logs import Log
    from bristle.report.known_truth import KnownTruth
    from bristle.simulation import Prediction

COLUMNS = ("Parameter", "Value", "95 % interval", "Unit", "Standard error [%]", "Remark")


class DiagnosticWithMessage(Diagnostic):
    """A diagnostic with its sentence."""

    @property
    def message(self) -> str:
        """The sentence, with the numbers in units that read well."""
        from bristle.report.messages import message

        return message(self)

    def __str__(self) -> str:
        return self.message


class ModelInHand(WithCard):
    """An identified model: its parameters, how sure they are, what it predicts."""

    best: Any  # a Fit, and an Axis or None: fields of one that is loaded, properties of one that is identified
    axis: Any
    treatment: Mapping[str, float]

    @property
    def model(self) -> Model:
        """The friction model with its values."""
        return self.best.friction

    @property
    def plant(self) -> Model:
        """What the friction acts on, with its values."""
        return self.best.plant

    @property
    def parameters(self) -> dict[str, Estimate]:
        """Every parameter by name: ``value``, ``interval``, ``unit``, ``status``, ``std``."""
        return self.best.parameters

    @property
    def diagnostics(self) -> tuple[DiagnosticWithMessage, ...]:
        """What may mislead, and what the model rests on; each has its sentence in ``message``."""
        return tuple(DiagnosticWithMessage(**vars(diagnostic)) for diagnostic in self.best.diagnostics)

    @property
    def covariance_names(self) -> tuple[str, ...]:
        """Names of the parameters that were identified, in the order of the covariance; found before the fit last."""
        together = self.best.correlation_names
        stds = self._stds()
        return (*(name for name in together if name in stds), *(name for name in stds if name not in together))

    @property
    def covariance(self) -> np.ndarray:
        """Covariance of the parameters that were identified [products of their units], shape (parameter, parameter).

        An inertia that was found before the fit counts as independent of the others; `draws` have it as it is.
        """
        stds, together = self._stds(), self.best.correlation_names
        places = [index for index, name in enumerate(together) if name in stds]
        names, count = self.covariance_names, len(places)
        correlation = np.eye(len(names))
        correlation[:count, :count] = np.asarray(self.best.correlation, dtype=float)[np.ix_(places, places)]
        std = np.array([stds[name] for name in names])
        return correlation * np.outer(std, std)

    def _stds(self) -> dict[str, float]:
        """Return the standard errors of what was identified; products of parameters count as parameters."""
        return {
            estimate.name: estimate.std
            for estimate in self.best.estimates
            if estimate.status == "identified" and estimate.std is not None and np.isfinite(estimate.std)
        }

    @property
    def draws(self) -> dict[str, np.ndarray]:
        """Parameters that the log allows, as simulated logs tell, one entry a log; empty where there were none."""
        resampling = self.best.resampling
        return {} if resampling is None else {name: np.asarray(values) for name, values in resampling.bands.draws.items()}

    def predict(
        self, log: Log | str | PathLike[str] | Any, mode: str = "inverse", *, axis: Axis | str | PathLike[str] | None = None
    ) -> Prediction:
        """Predict a log, treated as the log of the identification was, with a 95 % band where there is one."""
        from bristle.files import TREATMENT
        from bristle.prediction import predict

        resampling = self.best.resampling
        options: dict[str, Any] = {name: self.treatment[name] for name in TREATMENT if name in self.treatment}
        options |= {"decimation": int(options["decimation"])} if "decimation" in options else {}
        bands = resampling.bands if resampling is not None else None
        return predict(self.plant, self.model, log, self.axis if axis is None else axis, mode, bands=bands, **options)

    def drive_table(self, entries: int = 20) -> list[tuple[float, float]]:
        """Return velocity and steady friction for the compensation of a drive, at most `entries` of them."""
        from bristle.prediction import drive_table

        return drive_table(self.best, entries)

    def known_truth(self, log: Any = None, *, draws: int = 10, progress: Progress | None = None) -> KnownTruth:
        """Return which parameters the log determines: simulated logs of this axis, whose truth is known, are identified again.

        The log of loaded results is looked for beside their folder, in it and in the current folder, where it is not named.
        """
        from bristle.identification import Determined
        from bristle.report.known_truth import KnownTruth

        best, (logs, axes, settings) = self.best, self._recorded(log)
        parameters = Determined.by_simulated_logs(logs, axes, best, self.treatment, settings, count=draws, progress=progress)
        return KnownTruth(best.name, {parameter.name: parameter for parameter in parameters}, draws)

    @abstractmethod
    def _recorded(self, log: Any) -> tuple[list[Log], list[Axis | None], Mapping[str, float]]:
        """Return the logs of the identification, their axes and the thresholds."""

    def plot(self) -> Figure:
        """Return measured and predicted effort over time, whole and where they differ most, as a figure of matplotlib."""
        from bristle.figures.fit import effort_over_time

        return effort_over_time(self.best)

    def widget(self) -> Widget:
        """Return the model to be touched in a notebook, each identified interval under its slider."""
        from bristle.lab import Widget
        from bristle.lab.living import uncertainty_of

        return Widget(self.model, uncertainty=uncertainty_of(self.best), fastest=float(self.treatment.get("velocity_max", 0.0)))

    def to_dataframe(self) -> Any:
        """Return the parameters as a data frame of pandas, one row a parameter."""
        pandas = library("pandas", "to_dataframe()")
        rows = {
            name: {
                "value": estimate.value,
                "unit": estimate.unit,
                "std": estimate.std,
                "robust_std": estimate.robust_std,
                "low": (estimate.interval or (None, None))[0],
                "high": (estimate.interval or (None, None))[1],
                "status": estimate.status,
                "description": estimate.description,
            }
            for name, estimate in self.parameters.items()
        }
        return pandas.DataFrame.from_dict(rows, orient="index").rename_axis("parameter")

    def _card(self) -> Card:
        from bristle.report.messages import warnings_of
        from bristle.report.model_tables import parameter_table

        table = parameter_table(self.best)
        columns = [index for index, head in enumerate(table.heads) if head in COLUMNS]
        rows = tuple(tuple(row[index] for index in columns) for row in table.rows)
        logs, remarks = self._words()
        title = f"{self.best.name}, identified{f' from {logs}' if logs else ''}: error {self.best.error_percent:.3g} %"
        heads = tuple(table.heads[index] for index in columns)
        return Card(title, heads, rows, (*remarks, *(f"warning: {warning}" for warning in warnings_of(self.best))))

    def _words(self) -> tuple[str, list[str]]:
        """Return from which logs, and what else there is to know."""
        return "", []


@dataclass(frozen=True, eq=False)
class Loaded(ModelInHand):
    """The best model of an identification, as it was saved.

    Parameters
    ----------
    best : Fit
        The model and what is known of it.
    treatment : mapping of str to float
        How the log was treated, as in `Identified`.
    axis : Axis or None
        What was known of the axis.
    summary : mapping
        What ``summary.json`` holds, of all models.
    page : str
        The report.
    folder : Path
        Where it was saved.
    """

    best: Fit
    treatment: Mapping[str, float]
    axis: Axis | None
    summary: Mapping[str, Any]
    page: str
    folder: Path = Path()

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

    def _recorded(self, log: Any) -> tuple[list[Log], list[Axis | None], Mapping[str, float]]:
        from bristle.report.known_truth import logs_of

        return *logs_of(self.folder, self.summary["provenance"], log), self.summary["settings"]

    def _words(self) -> tuple[str, list[str]]:
        behind = ", ".join(model["name"] for model in self.summary["models"][1:])
        return self.summary.get("provenance", {}).get("log") or "", [f"ranked behind it: {behind}"] * bool(behind)


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
        fit = fit_of(plant, friction, summary, traces, read_arrays(place, "draws"), info["bands"])
    except (KeyError, TypeError) as error:
        raise InputError(f"does not say what it should: {error!r}", path=str(place / SUMMARY)) from None
    axis, page = place / "axis.toml", place / REPORT
    return Loaded(
        fit,
        summary["treatment"],
        read_axis(axis) if axis.is_file() else None,
        summary,
        page.read_text(encoding="utf-8") if page.is_file() else "",
        place,
    )
