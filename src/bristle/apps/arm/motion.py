"""The common motion of the joints of an arm, and the parts of the joint efforts that friction may explain."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from bristle.core import Axis, InputError, cached_property
from bristle.logs import Log, low_passed, period_of
from bristle.models.plants import SPRINGS

BANDWIDTH = 20.0  # of the rigid-body motion [Hz]: filter of logs with a higher rate
ROWS_PER_PERIOD = 2.5  # of the bandwidth
REPEATED = 0.01  # of the variance of a position: difference between periods
WIDTHS = np.geomspace(2e-5, 0.1, 8)  # yield distances of elements, over the stroke
SPEEDS = np.geomspace(0.01, 0.3, 4)  # decay of friction over speed, over the largest speed


@dataclass(frozen=True)
class Motion:
    """Angles and efforts of all joints at the common times of their logs, each of shape (sample, joint)."""

    time: np.ndarray  # [s]
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    effort: np.ndarray
    step: int  # samples for each row of the identification
    log: str = ""  # its mark
    terms: tuple[np.ndarray, ...] = ()
    """Columns of the spring and of the known forces of each joint, each of shape (sample, column)."""

    @cached_property
    def rows(self) -> slice:
        """The samples that are rows."""
        return slice(0, len(self.time), self.step)

    @cached_property
    def period(self) -> float | None:
        """The time after which all joints repeat their motion at least three times in all [s]; None without such a time."""
        step = np.median(np.diff(self.time[self.rows]))
        moved = [joint for joint in self.position[self.rows].T if np.ptp(joint) > 0.0]
        periods = [period_of(joint, step) for joint in moved]
        if not periods or None in periods:
            return None
        longest = max(period for period in periods if period is not None)
        lag = round(longest / step)
        apart = [np.mean((joint[lag:] - joint[:-lag]) ** 2) / np.var(joint) for joint in moved]
        return longest if max(apart) < REPEATED else None

    def friction_columns(self, joint: int) -> np.ndarray:
        """Return columns that span the friction and the terms of a joint: pre-sliding, fall over speed, damping, terms, constant."""
        q, v = self.position[self.rows, joint], self.velocity[self.rows, joint]
        elements = stops(q, WIDTHS * np.ptp(q))
        fall = np.exp(-np.abs(v)[:, None] / (SPEEDS * np.max(np.abs(v))))
        terms = [self.terms[joint][self.rows]] if self.terms else []
        return np.hstack(
            [elements, elements[:, :1] * fall, v[:, None], *terms, np.ones((len(q), 1))]
        )


def stops(position: np.ndarray, widths: np.ndarray) -> np.ndarray:
    """Return the relative forces of elastic elements that slip at these distances, shape (sample, element), from 0."""
    forces, force = np.zeros((len(position), len(widths))), np.zeros(len(widths))
    steps = np.diff(position)[:, None] / widths
    for row, step in enumerate(steps, start=1):
        force = np.clip(force + step, -1.0, 1.0)
        forces[row] = force
    return forces


def motion_of(logs: Sequence[Log], axes: Mapping[str, Axis]) -> Motion:
    """Return the common motion of the logs of all joints, with derivatives along each stretch without a gap."""
    from scipy.interpolate import make_interp_spline

    first, dt, begin = logs[0], float(logs[0].sample_time), next(iter(axes))
    for name, log in zip(axes, logs, strict=True):
        if log.effort is None:
            raise InputError(
                "has no effort", path=f"joint {name}", mend="Name its column under [columns]"
            )
        if not np.array_equal(log.time.values, first.time.values):
            raise InputError(
                f"has other times than {begin}",
                path=f"joint {name}",
                mend="Record all joints in one log",
            )
    step = max(int(1.0 / (dt * BANDWIDTH * ROWS_PER_PERIOD)), 1)
    recorded = np.array(
        [
            [log.position.values for log in logs],
            [log.effort.values for log in logs if log.effort is not None],
        ]
    )
    terms = [_terms(log, axis) for log, axis in zip(logs, axes.values(), strict=True)]
    signals = {
        name: np.empty(recorded.shape[1:])
        for name in ("position", "velocity", "acceleration", "effort")
    }
    for part in first.segments or (slice(0, len(first)),):
        times = first.time.values[part]
        position, effort = (
            low_passed(recorded[..., part], BANDWIDTH, dt) if step > 1 else recorded[..., part]
        )
        spline = make_interp_spline(times, position, k=5, axis=1)
        for signal, values in zip(
            signals.values(), (position, spline(times, 1), spline(times, 2), effort), strict=True
        ):
            signal[:, part] = values
        for forces in terms if step > 1 else ():
            forces[:, part] = low_passed(forces[:, part], BANDWIDTH, dt)
    columns = {name: signal.T for name, signal in signals.items()}
    mark, forces = first.origin.mark, tuple(forces.T for forces in terms)
    return Motion(first.time.values, **columns, step=step, log=mark, terms=forces)


def _terms(log: Log, axis: Axis) -> np.ndarray:
    """Return the forces of spring and known columns of a joint, apart from their factors, shape (column, sample)."""
    springs = cable(log.position.values)[: SPRINGS.get(axis.spring or "", 0)]
    return np.vstack([springs, *(column.values for column in log.regressors)])


def cable(position: np.ndarray) -> np.ndarray:
    """Return the powers of a position that span the force of a cable, each at most 1, shape (power, sample)."""
    place = (position - np.mean(position)) / (np.ptp(position) or 1.0)
    return np.array([place**power for power in range(1, SPRINGS["cubic"] + 1)])
