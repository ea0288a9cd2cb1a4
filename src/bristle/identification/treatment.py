r"""From a log to regression rows: the standard treatment of inverse dynamics, and nothing else.

The position is filtered by a zero-phase Butterworth filter of fourth order and differentiated twice by central
differences; what lies within five periods of the cut-off from an edge is dropped. Whatever enters the regression (the
effort, the acceleration, each column of the friction model, its sign included) then passes one and the same
zero-phase low-pass filter and is decimated. Filtering all sides alike leaves the parameters unbiased; taking the sign
of a decimated velocity would not. Rows at rest are left out: there friction balances whatever effort there is.

References
----------
.. [1] A. Janot, P.-O. Vandanjon, M. Gautier, "A generic instrumental variable approach for industrial robot
   identification", IEEE Transactions on Control Systems Technology 22(1), 2014. doi:10.1109/TCST.2013.2246163
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from bristle.core.axis import Axis
from bristle.core.errors import InputError
from bristle.core.variable import Kind
from bristle.identification.words import with_unit

__all__ = ["Regression", "Stretch", "treat"]

CUTOFF_SHARE = 0.1  # of the sampling frequency
DECIMATION = 10
EDGE_PERIODS = 5  # of the cut-off frequency: the transient of the filter
REST_PERIODS = 5  # of the cut-off frequency, without an encoder step, make a rest
REST_IN_ROW = 0.01  # weight of samples at rest that a row may contain
ROWS_MIN = 50


@dataclass(frozen=True)
class Stretch:
    """A stretch of the log without gaps, at the rate of the log, filtered and without its edges.

    Each array has shape (sample,): time [s], position [m or rad], velocity, acceleration, effort [N or N*m].
    A velocity of +0.0 or -0.0 stands for rest after a motion forward or backward.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    effort: np.ndarray


@dataclass(frozen=True)
class Regression:
    """The stretches of a log, and how a signal along them becomes rows of a regression.

    Parameters
    ----------
    stretches : tuple of Stretch
        What is left of the log.
    kind : {"translational", "rotational"}
        The kind of axis.
    sample_time : float
        Of the log [s].
    resolution : float
        Step of the position encoder [m or rad].
    cutoff : float
        Of the filter of the position [Hz].
    decimation : int
        One row for so many samples.
    dropped : int
        Samples dropped at each edge of each stretch.
    """

    stretches: tuple[Stretch, ...]
    kind: Kind
    sample_time: float
    resolution: float
    cutoff: float
    decimation: int
    dropped: int

    def rows_of(self, parts: Sequence[np.ndarray]) -> np.ndarray:
        """Return a signal, given along each stretch, low-pass filtered and decimated, in motion only, shape (row,)."""
        return self._thinned(parts)[self._in_motion]

    def _thinned(self, parts: Sequence[np.ndarray]) -> np.ndarray:
        if self.decimation == 1:
            return np.concatenate(parts)
        from scipy.signal import resample_poly

        return np.concatenate(
            [resample_poly(part, 1, self.decimation, window=self._taps, padtype="edge") for part in parts]
        )

    @cached_property
    def _in_motion(self) -> np.ndarray:
        rests = [(stretch.velocity == 0.0).astype(float) for stretch in self.stretches]
        return np.abs(self._thinned(rests)) < REST_IN_ROW

    @cached_property
    def _taps(self) -> np.ndarray:
        from scipy.signal import firwin

        return firwin(2 * self.reach * self.decimation + 1, 1.0 / self.decimation, window="hamming")

    @property
    def reach(self) -> int:
        """By how many rows the decimating filter reaches to either side."""
        return 10 if self.decimation > 1 else 0

    @cached_property
    def time(self) -> np.ndarray:
        """Time of each row [s]."""
        return np.concatenate([stretch.time[:: self.decimation] for stretch in self.stretches])[self._in_motion]

    @cached_property
    def velocity(self) -> np.ndarray:
        """Velocity of each row [m/s or rad/s]."""
        return self.rows_of([stretch.velocity for stretch in self.stretches])

    @cached_property
    def acceleration(self) -> np.ndarray:
        """Acceleration of each row [m/s^2 or rad/s^2]."""
        return self.rows_of([stretch.acceleration for stretch in self.stretches])

    @cached_property
    def effort(self) -> np.ndarray:
        """Effort of each row [N or N*m]."""
        return self.rows_of([stretch.effort for stretch in self.stretches])

    @cached_property
    def all_velocities(self) -> np.ndarray:
        """Velocity of every sample [m/s or rad/s], before decimation."""
        return np.concatenate([stretch.velocity for stretch in self.stretches])

    @property
    def rest_share(self) -> float:
        """Share of the samples at rest."""
        return float(np.mean(self.all_velocities == 0.0))

    @cached_property
    def reversals(self) -> tuple[tuple[int, int], ...]:
        """Where the direction changes: number of the stretch, and of the first sample after it."""
        found = []
        for number, stretch in enumerate(self.stretches):
            forward = ~np.signbit(stretch.velocity)
            found += [(number, int(k) + 1) for k in np.flatnonzero(forward[1:] != forward[:-1])]
        return tuple(found)


def treat(log: Any, axis: Axis | None, cutoff: float | None = None, decimation: int | None = None) -> Regression:
    """Return the regression rows of a log.

    Parameters
    ----------
    log : Log
        Position and effort over time, in SI.
    axis : Axis or None
        Its cut-off, decimation and encoder resolution hold where no argument overrides them.
    cutoff : float, optional
        Cut-off of the zero-phase filter [Hz]; a tenth of the sampling frequency where nothing is given.
    decimation : int, optional
        Of how many samples one row is kept; 10 where nothing is given.

    Raises
    ------
    InputError
        If the cut-off or the decimation cannot be used, the log is too short for them, or nothing moves.
    """
    dt = float(log.sample_time)
    cutoff = _cutoff(cutoff if cutoff is not None else axis and axis.cutoff, dt)
    decimation = _decimation(decimation if decimation is not None else axis and axis.decimation)
    position = np.asarray(log.position.values, dtype=float)
    given = axis.resolution if axis is not None else None
    resolution = _smallest_step(position) if given is None else given
    dropped = max(round(EDGE_PERIODS / (cutoff * dt)), 1)
    shortest = 2 * dropped + ROWS_MIN * decimation
    kept = [part for part in log.segments if len(range(*part.indices(position.size))) >= shortest]
    if not kept:
        raise InputError(
            "is too short for this filter and decimation", path="log", value=f"{position.size} samples",
            allowed=f"at least {shortest} samples without a gap",
            mend="Record a longer motion, raise the cut-off or lower the decimation",
        )  # fmt: skip
    stretches = tuple(_stretch(log, part, dt, cutoff, dropped, resolution) for part in kept)
    moving = tuple(stretch for stretch in stretches if np.any(stretch.velocity != 0.0))
    regression = Regression(moving, log.kind, dt, resolution, cutoff, decimation, dropped)
    if not moving or regression.time.size < ROWS_MIN:
        raise InputError(
            "the axis hardly moves", path="log.position",
            value=f"a range of {with_unit(float(np.ptp(position)), 'length', log.kind)}",
            mend="Record a motion in both directions, over the speeds at which the axis works",
        )  # fmt: skip
    return regression


def _cutoff(given: float | None, dt: float) -> float:
    if given is None:
        return CUTOFF_SHARE / dt
    if not (np.isfinite(given) and 0.0 < given < 0.5 / dt):
        raise InputError("out of range", path="cutoff", value=given, allowed=f"between 0 and {0.5 / dt:g} Hz, half "
                         "the sampling frequency")  # fmt: skip
    return float(given)


def _decimation(given: int | None) -> int:
    if given is None:
        return DECIMATION
    if isinstance(given, bool) or given != int(given) or not 1 <= given <= 10_000:
        raise InputError("must be a whole number", path="decimation", value=given, allowed="1 to 10000")
    return int(given)


def _smallest_step(position: np.ndarray) -> float:
    steps = np.abs(np.diff(position))
    steps = steps[steps > 0.0]
    return float(steps.min()) if steps.size else 0.0


def _stretch(log: Any, part: slice, dt: float, cutoff: float, dropped: int, resolution: float) -> Stretch:
    from scipy.signal import butter, sosfiltfilt

    raw = np.asarray(log.position.values[part], dtype=float)
    # The offset of a long stroke would cost digits in the second difference.
    origin = raw[0]
    smooth = sosfiltfilt(butter(4, cutoff, fs=1.0 / dt, output="sos"), raw - origin)
    velocity = np.gradient(smooth, dt)
    acceleration = np.gradient(velocity, dt)
    window = max(round(REST_PERIODS / (cutoff * dt)), 1)
    velocity = _with_sides(velocity, _rests(raw, window, 1.5 * resolution))
    kept = slice(dropped, raw.size - dropped)
    return Stretch(
        time=np.asarray(log.time.values[part], dtype=float)[kept],
        position=smooth[kept] + origin,
        velocity=velocity[kept],
        acceleration=acceleration[kept],
        effort=np.asarray(log.effort.values[part], dtype=float)[kept],
    )


def _rests(position: np.ndarray, window: int, step: float) -> np.ndarray:
    """Return where the position stays within one step both before and after, shape (sample,) of bool.

    Both sides, because around a turning point the position before and after are alike though the body moves.
    """
    padded = np.pad(position, window, mode="edge")
    here = padded[window:-window]
    before, after = padded[: -2 * window], padded[2 * window :]
    return (np.abs(after - here) <= step) & (np.abs(here - before) <= step)


def _with_sides(velocity: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """Return the velocity with a zero at rest, which carries the sign of the last motion."""
    moving = np.flatnonzero(~rest)
    if moving.size == 0:
        return np.zeros_like(velocity)
    last = moving[np.maximum(np.searchsorted(moving, np.arange(velocity.size), side="right") - 1, 0)]
    return np.where(rest, np.copysign(0.0, velocity[last]), velocity)
