"""Results of a simulation."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from bristle.core import Diagnostic, Experiment, Model, Status, with_unit
from bristle.core.tabular import Card, Tabular, WithCard, library, plain
from bristle.core.variable import KINDS, Kind, unit_of
from bristle.simulation.statistics import NO_STATISTICS, Statistics, mean_statistics

HEADS = (
    "Variant",
    "Following error, peak to peak",
    "its rms",
    "True error, rms",
    "Effort, rms",
    "Peak",
    "Status",
)
MODES = {
    "inverse": "the effort, from the measured motion",
    "closed-loop": "effort and motion, from the reference and the controller of the axis",
    "open-loop": "the motion, from the measured effort",
}
"""Predicted signals in each mode, and their inputs."""

OPEN_HEADS = (
    "Variant",
    "Position, peak to peak",
    "lowest",
    "highest",
    "Effort, rms",
    "Peak",
    "Status",
)


@dataclass(frozen=True)
class VariantResult(Tabular):
    """One simulated variant of an experiment; arrays of shape (sample,), in SI units of the axis.

    Parameters
    ----------
    name : str
        Name of the variant.
    following_error : Statistics
        Reference minus encoder reading, after the settling time.
    true_error : Statistics
        Reference minus true position, for a `ball_screw` that of the table, after the settling time.
    by_direction : mapping
        Statistics of the following error while the reference moves forward, and while it moves backward.
    effort_rms, effort_peak : float
        Rms of the applied effort, and its largest absolute value (`effort_peak`) [N or N*m].
    time : ndarray
        Times of the samples [s]. Signals include the settling time.
    reference, measured, position, velocity : ndarray
        `reference`: commanded position; `measured`: position from the sensor; `position`, `velocity`: true motion
        [m or rad, m/s or rad/s].
    command, effort, feedforward : ndarray
        `command`: output of the controller; `effort`: effort of the drive until the next sample; `feedforward`:
        feedforward input of the controller [N or N*m].
    friction : ndarray
        Friction force [N or N*m].
    status : Status
        Status at the end of the run.
    runs : int
        Number of runs with different noise; statistics are means over the runs, signals are those of the first run.
    spread : mapping
        Standard deviation over the runs of each number of `as_dict`, in the structure of `as_dict`; empty for a single
        run.
    trials : tuple of float
        Following error peak to peak of each trial, if the motion is learned [m or rad].
    kind : {"translational", "rotational"}
        Kind of axis.
    motion : Statistics
        Position after the settling time. In an open loop, which has no reference, the errors and `by_direction` are
        NaN.
    at_load : bool
        Whether reports compare the true error, because a variant of the experiment leads by the wind-up of a screw.
    load_reference : ndarray or None
        Desired position of the load, if `reference` leads it by the wind-up of a screw [m or rad].
    controller : Model or None
        The control law with its learned parameters, for the next run; None in an open loop.
    """

    name: str
    following_error: Statistics
    true_error: Statistics
    by_direction: Mapping[str, Statistics]
    effort_rms: float
    effort_peak: float
    time: np.ndarray
    reference: np.ndarray
    measured: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    command: np.ndarray
    effort: np.ndarray
    feedforward: np.ndarray
    friction: np.ndarray
    status: Status = Status.OK
    runs: int = 1
    spread: Mapping[str, Any] = field(default_factory=dict)
    trials: tuple[float, ...] = ()
    kind: Kind = "translational"
    motion: Statistics = NO_STATISTICS
    at_load: bool = False
    load_reference: np.ndarray | None = None
    controller: Model | None = None

    @property
    def compared(self) -> str:
        """Name of the error that reports compare."""
        if self.at_load:
            return "true_error"
        return "following_error"

    @property
    def compared_error(self) -> Statistics:
        """Statistics of this error."""
        if self.at_load:
            return self.true_error
        return self.following_error

    @property
    def error_word(self) -> str:
        """The error that reports compare, in words."""
        if self.at_load:
            return "Error of the load"
        return "Following error"

    @property
    def error(self) -> np.ndarray:
        """The error that reports compare, at each sample [m or rad]."""
        if not self.at_load:
            return self.reference - self.measured
        if self.load_reference is None:
            return self.reference - self.position
        return self.load_reference - self.position

    def as_dict(self) -> dict[str, Any]:
        """Return the numbers without the arrays; for several runs each mean has a ``..._spread``."""
        record = _with_spread(self._numbers(), self.spread) | {
            "status": self.status.sentence,
            "runs": self.runs,
        }
        if self.trials:
            record["trials"] = list(self.trials)
        return record

    def _facts(self) -> dict[str, Any]:
        return {"name": self.name, "kind": self.kind} | plain(self.as_dict())

    def _title(self) -> str:
        return f"{self.name}: simulated, {len(self.time)} samples, {self.kind}"

    @property
    def is_open(self) -> bool:
        """Whether the variant is an open loop, without a reference."""
        return self.reference.size > 0 and bool(np.all(np.isnan(self.reference)))

    def _remarks(self) -> list[str]:
        heads = OPEN_HEADS if self.is_open else HEADS
        return [
            f"{head}: {text}" for head, text in zip(heads[1:], self._row(), strict=True) if text
        ]

    def _row(self) -> tuple[str, ...]:
        """Return its numbers as a row of the card of an experiment."""
        length = unit_of("length", self.kind)
        force = unit_of("force", self.kind)
        errors = (self.following_error.peak_to_peak, self.following_error.rms, self.true_error.rms)
        if self.is_open:
            errors = (self.motion.peak_to_peak, self.motion.min, self.motion.max)
        efforts = (self.effort_rms, self.effort_peak)
        cells = [
            *(with_unit(error, length) for error in errors),
            *(with_unit(effort, force) for effort in efforts),
        ]
        return *cells, self.status.sentence

    def _numbers(self) -> dict[str, Any]:
        return {
            "following_error": asdict(self.following_error),
            "true_error": asdict(self.true_error),
            "by_direction": {
                name: asdict(statistics) for name, statistics in self.by_direction.items()
            },
            "effort": {"rms": self.effort_rms, "peak": self.effort_peak},
            "motion": asdict(self.motion),
        }


def _with_spread(numbers: Mapping[str, Any], spread: Mapping[str, Any]) -> dict[str, Any]:
    merged: dict[str, Any] = {}
    for name, value in numbers.items():
        if isinstance(value, Mapping):
            merged[name] = _with_spread(value, spread.get(name, {}))
        else:
            merged[name] = value
            if name in spread:
                merged[f"{name}_spread"] = spread[name]
    return merged


def _spread(numbers: Sequence[Any]) -> Any:
    """Return the standard deviation of each number over the runs, in the structure of one run."""
    if isinstance(numbers[0], Mapping):
        return {name: _spread([part[name] for part in numbers]) for name in numbers[0]}
    return float(np.std(numbers, ddof=1))


def mean_result(runs: Sequence[VariantResult]) -> VariantResult:
    """Return runs of a variant as one, with mean numbers and the signals of the first run; a diverged run as it is."""
    diverged = next((run for run in runs if run.status is Status.NOT_FINITE), None)
    if diverged is not None:
        return replace(diverged, runs=len(runs))
    if len(runs) == 1:
        return replace(runs[0], runs=1)
    return replace(
        runs[0],
        following_error=mean_statistics([run.following_error for run in runs]),
        true_error=mean_statistics([run.true_error for run in runs]),
        by_direction={
            name: mean_statistics([run.by_direction[name] for run in runs])
            for name in runs[0].by_direction
        },
        motion=mean_statistics([run.motion for run in runs]),
        effort_rms=float(np.mean([run.effort_rms for run in runs])),
        effort_peak=float(np.mean([run.effort_peak for run in runs])),
        status=next((run.status for run in runs if run.status is not Status.OK), Status.OK),
        runs=len(runs),
        trials=tuple(np.mean([run.trials for run in runs], axis=0).tolist()),
        spread=_spread([run._numbers() for run in runs]),
    )


@dataclass(frozen=True)
class SimulationResult(WithCard):
    """A simulated experiment: its variants by name, in order.

    Parameters
    ----------
    experiment : Experiment
        The simulated experiment.
    variants : mapping of str to VariantResult
        Result of each variant.
    refused : mapping of str to str
        Variants that bristle did not simulate: name and reason, in words.
    unstable : tuple of str
        Variants whose linear loop is unstable, although the simulation did not diverge: no report calls one the best.
    """

    experiment: Experiment
    variants: Mapping[str, VariantResult]
    refused: Mapping[str, str] = field(default_factory=dict)
    unstable: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return all results as plain data: each variant with its numbers, its ``signals`` and their ``units``."""
        return {
            "name": self.experiment.name,
            "kind": self.experiment.kind,
            "refused": dict(self.refused),
            "variants": {name: variant.to_dict() for name, variant in self.variants.items()},
        }

    def to_dataframe(self) -> Any:
        """Return the signals of all variants as a data frame of pandas, one row a sample, in SI.

        Returns
        -------
        pandas.DataFrame
            With a column ``variant`` before the signals of `VariantResult`.

        Raises
        ------
        MissingExtraError
            If pandas is not installed.
        """
        pandas = library("pandas", "to_dataframe()")
        frames = {name: variant.to_dataframe() for name, variant in self.variants.items()}
        units = next((frame.attrs["units"] for frame in frames.values()), {})
        for name, frame in frames.items():
            frame.attrs = {}  # pandas would compare them number by number
            frame.insert(0, "variant", name)
        stacked = (
            pandas.concat(list(frames.values()), ignore_index=True)
            if frames
            else pandas.DataFrame()
        )
        stacked.attrs["units"] = units
        return stacked

    def to_xarray(self) -> Any:
        """Return the signals of all variants as a data set of xarray over ``variant`` and ``time``, in SI.

        Returns
        -------
        xarray.Dataset
            NaN for missing samples, if a variant was cut short or has other sample times.

        Raises
        ------
        MissingExtraError
            If xarray is not installed.
        """
        xarray = library("xarray", "to_xarray()")
        sets = [variant.to_xarray() for variant in self.variants.values()]
        if not sets:
            return xarray.Dataset()
        names = xarray.DataArray(list(self.variants), dims="variant", name="variant")
        together = xarray.concat(sets, dim=names, join="outer", combine_attrs="drop_conflicts")
        return together.assign_attrs(name=self.experiment.name, kind=self.experiment.kind)

    def _card(self) -> Card:
        rows = tuple((name, *variant._row()) for name, variant in self.variants.items())
        noun = "variants"
        if len(rows) == 1:
            noun = "variant"
        title = f"{self.experiment.name}: {len(rows)} {noun} simulated"
        heads = (
            OPEN_HEADS
            if rows and all(variant.is_open for variant in self.variants.values())
            else HEADS
        )
        return Card(
            title,
            heads,
            rows,
            tuple(f"{name} was not simulated: {reason}" for name, reason in self.refused.items()),
        )


@dataclass(frozen=True)
class Prediction(Tabular):
    """A model run on a log; arrays of shape (sample,), in SI units of the axis.

    Parameters
    ----------
    mode : {"inverse", "closed-loop", "open-loop"}
        ``inverse``: effort from the measured motion. ``closed-loop``: effort and motion from the reference,
        with the controller of the axis. ``open-loop``: motion from the measured effort.
    time : ndarray
        Time of the samples [s].
    effort : ndarray
        Effort of the log, filtered if the mode needs it [N or N*m].
    effort_predicted : ndarray or None
        Predicted effort [N or N*m]; None if the mode does not predict it.
    position : ndarray
        Position of the log, filtered if the mode needs it [m or rad].
    position_predicted : ndarray or None
        Predicted position [m or rad]; None if the mode does not predict it.
    metrics : mapping
        ``force_error_percent``, ``position_error_percent``, ``position_rmse``, ``position_unit``; a value is None if the mode
        does not predict the signal.
    status : Status
        Status at the end of the simulation.
    diagnostics : tuple of Diagnostic
        Warnings, and notes on the data and assumptions of the prediction.
    half_width : ndarray or None
        Half-width of the 95 % band around the effort [N or N*m]; None if the model has no intervals, or the mode does not
        predict the effort.
    position_half_width : ndarray or None
        Half-width of the 95 % band around the position [m or rad]; None if the model has no intervals, or the mode does
        not predict the position.
    log : str
        Name of the log.
    """

    mode: str
    time: np.ndarray
    effort: np.ndarray | None
    effort_predicted: np.ndarray | None
    position: np.ndarray
    position_predicted: np.ndarray | None
    metrics: Mapping[str, float | str | None]
    status: Status = Status.OK
    diagnostics: tuple[Diagnostic, ...] = ()
    half_width: np.ndarray | None = None
    position_half_width: np.ndarray | None = None
    log: str = ""

    @property
    def kind(self) -> Kind:
        """Kind of axis, from the unit of the position."""
        if self.metrics.get("position_unit") == unit_of("length", KINDS[1]):
            return KINDS[1]
        return KINDS[0]

    @property
    def inside_percent(self) -> float | None:
        """Share of the samples of the effort inside the 95 % band [%]; None without a band."""
        return _inside_percent(self.effort, self.effort_predicted, self.half_width)

    @property
    def position_inside_percent(self) -> float | None:
        """Share of the samples of the position inside the 95 % band [%]; None without a band."""
        return _inside_percent(self.position, self.position_predicted, self.position_half_width)

    def _facts(self) -> dict[str, Any]:
        return super()._facts() | {
            "inside_percent": self.inside_percent,
            "position_inside_percent": self.position_inside_percent,
        }

    def _title(self) -> str:
        return f"Prediction ({self.mode}) of {len(self.time)} samples, {self.kind}"

    def _remarks(self) -> list[str]:
        errors = {
            "effort": self.metrics.get("force_error_percent"),
            "position": self.metrics.get("position_error_percent"),
        }
        inside = {"effort": self.inside_percent, "position": self.position_inside_percent}
        return [
            *(
                f"error of the {name}: {error:.3g} %"
                for name, error in errors.items()
                if isinstance(error, float)
            ),
            *(
                f"inside the band of the {name}: {share:.3g} %"
                for name, share in inside.items()
                if share is not None
            ),
            *super()._remarks(),
            *(
                f"{item.severity}: {item.code} {item.parameter}".rstrip()
                for item in self.diagnostics
            ),
        ]


def _inside_percent(
    signal: np.ndarray | None, predicted: np.ndarray | None, half_width: np.ndarray | None
) -> float | None:
    if signal is None or predicted is None or half_width is None:
        return None
    return 100.0 * float(np.mean(np.abs(signal - predicted) <= half_width))
