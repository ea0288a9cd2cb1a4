"""`Record`: a motion of an axis as competitors see it, without its effort if they predict the effort."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from bristle.core import Axis, Kind, Model
from bristle.logs import Log, low_passed

MEASURED = "BRISTLE_DATA"  # names the folder with measured logs
EDGE = 5.0  # periods of the cut-off at each end, where the filter has a transient


@dataclass(frozen=True, eq=False)
class Record:
    """Motion of an axis, in SI units; the arrays of an arm have shape (sample, joint).

    Parameters
    ----------
    time, position : ndarray, shape (sample,)
        Samples of the log [s, m or rad].
    velocity, acceleration : ndarray, shape (sample,)
        Estimates from the position, filtered without a phase shift.
    effort : ndarray or None, shape (sample,)
        Measured effort [N or N*m] of a record for training; None in a record to predict.
    axis : Axis
        Known facts: resolution of the encoder, cut-off, mass if known, terms such as gravity.
    robot : str
        Geometry of an arm (TOML); empty for a single axis.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    effort: np.ndarray | None
    axis: Axis
    robot: str = ""

    @classmethod
    def of(
        cls,
        time: np.ndarray,
        position: np.ndarray,
        effort: np.ndarray | None,
        axis: Axis,
        robot: str = "",
    ) -> Record:
        """Return the record of a motion, with its derivatives."""
        dt = (time[-1] - time[0]) / (time.size - 1)
        velocity = np.gradient(smoothed(position, dt, axis), dt, axis=0)
        return cls(time, position, velocity, np.gradient(velocity, dt, axis=0), effort, axis, robot)

    @property
    def sample_time(self) -> float:
        """Time between samples [s]."""
        return float((self.time[-1] - self.time[0]) / (self.time.size - 1))

    @property
    def kind(self) -> Kind:
        """``translational`` or ``rotational``."""
        return self.axis.kind

    @property
    def motion(self) -> Record:
        """The record without its effort."""
        return replace(self, effort=None)

    @property
    def joints(self) -> list[Record]:
        """The record of each joint of an arm."""
        columns = (self.position, self.velocity, self.acceleration, self.effort)
        parts = (
            [None if column is None else column[:, joint] for column in columns]
            for joint in range(self.position.shape[1])
        )
        return [Record(self.time, *part, self.axis) for part in parts]  # type: ignore[arg-type]

    @property
    def edge(self) -> int:
        """Samples at each end that the scores leave out."""
        return min(
            round(EDGE / (_cutoff(self.axis, self.sample_time) * self.sample_time)),
            self.time.size // 4,
        )


@dataclass(frozen=True, eq=False)
class Data:
    """Data of one case of a task: what a competitor receives, and what only the bench knows."""

    train: list[Record]
    test: list[Record] = field(default_factory=list)
    """With the effort, which competitors never receive."""
    reference: Record | None = None
    """Desired motion: of the loop to predict, or of the axis to compensate."""
    followed: np.ndarray | None = None
    """Measured following error of that loop [m or rad]."""
    loop_mass: float = 0.0
    truth: Mapping[str, float] = field(default_factory=dict)
    left: Callable[[Model | None, np.ndarray | None], float] | None = None
    """Share of the following error that another law and a feedforward effort leave; None is the law of the loop, and no effort."""


def smoothed(signal: np.ndarray, dt: float, axis: Axis) -> np.ndarray:
    """Return a signal, shape (sample, ...), after the zero-phase filter of the axis."""
    return np.ascontiguousarray(low_passed(signal.T, _cutoff(axis, dt), dt).T)


def _cutoff(axis: Axis, dt: float) -> float:
    return axis.cutoff or 0.1 / dt


def log_of(record: Record) -> Log:
    """Return a record as a log, for `bristle.identify` and `bristle.predict`."""
    columns = {"time": record.time, "position": record.position}
    return Log.from_columns(
        columns | ({} if record.effort is None else {"effort": record.effort}), axis=record.axis
    )
