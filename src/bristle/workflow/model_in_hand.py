"""What an identified model lets a person do, whether it was just identified or loaded from a folder."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.core.diagnostic import Diagnostic
from bristle.core.tabular import Card, WithCard, library

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from bristle.core.axis import Axis
    from bristle.core.contracts import Model
    from bristle.identification.result import Estimate, Fit
    from bristle.lab.widget import Widget
    from bristle.logs.log import Log
    from bristle.simulation.result import Prediction

__all__ = ["DiagnosticWithMessage", "ModelInHand"]

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

    @property
    @abstractmethod
    def best(self) -> Fit:
        """The model and what is known of it."""

    @property
    @abstractmethod
    def axis(self) -> Axis | None:
        """What was known of the axis."""

    @property
    @abstractmethod
    def _treatment(self) -> Mapping[str, float]:
        """How the log of the identification was treated."""

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """Return the numbers as plain data, as ``summary.json`` holds them."""

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
        from bristle.files.model import TREATMENT
        from bristle.prediction.predict import predict

        resampling, treatment = self.best.resampling, self._treatment
        options: dict[str, Any] = {name: treatment[name] for name in TREATMENT if name in treatment}
        options |= {"decimation": int(options["decimation"])} if "decimation" in options else {}
        bands = resampling.bands if resampling is not None else None
        own = self.axis if axis is None else axis
        return predict(self.plant, self.model, log, own, mode, bands=bands, **options)

    def drive_table(self, entries: int = 20) -> list[tuple[float, float]]:
        """Return velocity and steady friction for the compensation of a drive, at most `entries` of them."""
        from bristle.prediction.drive_table import drive_table

        return drive_table(self.best, entries)

    def plot(self) -> Figure:
        """Return measured and predicted effort over time, and what is left over, as a figure of matplotlib."""
        from bristle import figures

        return figures.fitted(self.best)

    def widget(self) -> Widget:
        """Return the model to be touched in a notebook, each identified interval under its slider."""
        from bristle.lab import Widget
        from bristle.lab.living import uncertainty_of

        fastest = float(self._treatment.get("velocity_max", 0.0))
        return Widget(self.model, uncertainty=uncertainty_of(self.best), fastest=fastest)

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
        title = f"{self.best.name}, identified{self._source()}: error {self.best.error_percent:.3g} %"
        return Card(
            title,
            tuple(table.heads[index] for index in columns),
            rows,
            (*self._beside(), *(f"warning: {warning}" for warning in warnings_of(self.best))),
        )

    def _source(self) -> str:
        """Return from which log, in words."""
        return ""

    def _beside(self) -> tuple[str, ...]:
        """Return what else there is to know, in words."""
        return ()
