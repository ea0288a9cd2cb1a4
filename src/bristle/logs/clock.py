"""The time base of a log: gaps split it, small jitter is resampled away, the rest is refused."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from bristle.core.errors import InputError

__all__ = ["GAP", "JITTER_LIMIT", "Clock", "clock_of"]

JITTER_LIMIT = 0.1  # of the sample time, for 19 of 20 stamps
JITTER_LARGEST = 0.25  # of the sample time, for every stamp
UNIFORM = 0.01  # of the sample time: rounding of the stamps, left alone
GAP = 1.5  # sample times
GAP_SHARE = 0.05  # more intervals than this being gaps, the log has no sample time
SHORTEST_SEGMENT = 10  # samples
SHORTEST, LONGEST = 1e-12, 1e9  # sample time [s]: beyond them its square or its inverse is no number to reckon with
WINDOW = 101  # samples over which a clock may drift and be no jitter


@dataclass(frozen=True)
class Clock:
    """The uniform grid of time of a log, segment by segment.

    Parameters
    ----------
    sample_time : float
        Time between samples [s].
    pieces : tuple of (slice, ndarray)
        For each segment the recorded samples it draws on, and its uniform grid [s].
    stamps : ndarray
        Time of the recorded samples [s].
    uniform : bool
        Whether the recorded samples lie on the grid already.
    notes : tuple of str
        What was resampled or left out.
    """

    sample_time: float
    pieces: tuple[tuple[slice, np.ndarray], ...]
    stamps: np.ndarray
    uniform: bool
    notes: tuple[str, ...] = ()

    @property
    def time(self) -> np.ndarray:
        """The grid, all segments in one [s]."""
        return np.concatenate([grid for _, grid in self.pieces])

    @property
    def segments(self) -> tuple[slice, ...]:
        """The segments as slices of the grid."""
        ends = np.cumsum([0, *(grid.size for _, grid in self.pieces)])
        return tuple(slice(int(a), int(b)) for a, b in pairwise(ends))

    def sampled(self, values: np.ndarray, lag: float = 0.0, *, smooth: bool = True) -> np.ndarray:
        """Return recorded values on the grid, as they were recorded `lag` later [s].

        Parameters
        ----------
        values : ndarray, shape (recorded_count,)
            A recorded channel.
        lag : float
            By how much it lags [s].
        smooth : bool
            Between samples, a cubic spline, else straight lines, as befits a signal that jumps.
        """
        parts = []
        for raw, grid in self.pieces:
            shift = (grid[0] + lag - self.stamps[raw][0]) / self.sample_time
            if self.uniform and abs(shift - round(shift)) < UNIFORM:
                parts.append(values[raw][round(shift) : round(shift) + grid.size])
            elif smooth:
                from scipy.interpolate import CubicSpline

                parts.append(CubicSpline(self.stamps[raw], values[raw])(grid + lag))
            else:
                parts.append(np.interp(grid + lag, self.stamps[raw], values[raw]))
        return np.concatenate(parts)


def clock_of(stamps: np.ndarray, place: str, *, delay: float = 0.0, sample_time: float | None = None) -> Clock:
    """Return the uniform grid of time that recorded time stamps lie on or near.

    Parameters
    ----------
    stamps : ndarray, shape (recorded_count,)
        Recorded time [s].
    place : str
        Where they come from, for the message.
    delay : float
        By how much the effort lags: where no sample of it is left, the grid ends early [s].
    sample_time : float, optional
        What the axis file says it is [s].

    Raises
    ------
    InputError
        If time steps back, stands still, has steps that no axis is sampled at, or jitters: 19 of 20 stamps by more
        than a tenth of the sample time, or any by more than a quarter.
    """
    steps = np.diff(stamps)
    _refuse_backward(stamps, steps, place)
    usual = float(np.median(steps))
    if not SHORTEST <= usual <= LONGEST:
        raise InputError(f"steps by {usual:.6g} s", path=place, allowed=f"{SHORTEST:g} s to {LONGEST:g} s",
                         mend="Mend the unit of the time column")  # fmt: skip
    gaps = steps > GAP * usual
    period = float(steps[~gaps].mean())
    if sample_time is not None and abs(period / sample_time - 1) > UNIFORM:
        raise InputError(
            f"steps by {period:.6g} s and the axis file says otherwise",
            path=place,
            allowed=f"{sample_time:g} s",
            mend="Mend the unit of the time column, or sample_time in [timing]",
        )
    if gaps.mean() > GAP_SHARE:
        raise InputError(
            f"is not even: {gaps.mean():.0%} of its steps exceed {GAP} of their median {usual:.6g} s",
            path=place,
            mend="Record at a fixed rate",
        )
    bounds = [0, *(np.flatnonzero(gaps) + 1).tolist(), stamps.size]
    raws = [slice(a, b) for a, b in pairwise(bounds)]
    usable = [raw for raw in raws if raw.stop - raw.start >= SHORTEST_SEGMENT]
    notes = _gap_notes(stamps, raws, usable)
    uniform, jitter = _jitter(stamps, usable, period, place)
    if not uniform:
        notes.append(
            f"time stamps jitter by {jitter} of the sample time: resampled onto a uniform grid of {period:.6g} s"
        )
    pieces = [(raw, _grid(stamps[raw], period, delay)) for raw in usable]
    pieces = [(raw, grid) for raw, grid in pieces if grid.size >= SHORTEST_SEGMENT]
    if not pieces:
        raise InputError(
            f"has no stretch of {SHORTEST_SEGMENT} even samples" + (f" within a delay of {delay:g} s" if delay else ""),
            path=place,
            mend="Mend the delay in [timing] of the axis file, or record without gaps",
        )
    return Clock(period, tuple(pieces), stamps, uniform, tuple(notes))


def _refuse_backward(stamps: np.ndarray, steps: np.ndarray, place: str) -> None:
    bad = np.flatnonzero(steps <= 0)
    if not bad.size:
        return
    at = int(bad[0])
    backward = steps[at] < 0
    raise InputError(
        f"{'runs backward' if backward else 'is repeated'} at sample {at + 1} "
        f"({stamps[at]:.9g} s, then {stamps[at + 1]:.9g} s; {bad.size} such steps)",
        path=place,
        mend="Cut the log where a second recording begins, or sort it"
        if backward
        else "If the stamps are merely rounded, leave the time column out and write sample_time in [timing]",
    )


def _gap_notes(stamps: np.ndarray, raws: list[slice], usable: list[slice]) -> list[str]:
    if len(raws) == 1:
        return []
    ends = ", ".join(f"{stamps[raw.start - 1]:.6g} s" for raw in raws[1:6])
    notes = [f"{len(raws) - 1} gaps (the first after {ends}): split into {len(usable)} segments"]
    lost = sum(raw.stop - raw.start for raw in raws) - sum(raw.stop - raw.start for raw in usable)
    if lost:
        notes.append(f"{lost} samples in segments shorter than {SHORTEST_SEGMENT} samples were left out")
    return notes


def _jitter(stamps: np.ndarray, raws: list[slice], period: float, place: str) -> tuple[bool, str]:
    """Return whether the stamps lie on a grid, and in words by which part of the sample time they deviate."""
    errors = [stamps[raw] - period * np.arange(raw.stop - raw.start) for raw in raws]
    errors = [(error - error.mean()) / period for error in errors]
    if max((float(np.ptp(error)) for error in errors), default=0.0) <= 2 * UNIFORM:
        return True, ""
    from scipy.ndimage import uniform_filter1d

    local = np.concatenate([np.abs(error - uniform_filter1d(error, min(WINDOW, error.size))) for error in errors])
    usual, largest = float(np.quantile(local, 0.95)), float(np.max(local))
    jitter = f"{100 * usual:.2g} % (19 of 20 stamps) and {100 * largest:.2g} % (all)"
    if usual > JITTER_LIMIT or largest > JITTER_LARGEST:
        raise InputError(
            f"jitters by {jitter} of the sample time {period:.6g} s",
            path=place,
            allowed=f"up to {100 * JITTER_LIMIT:g} % and {100 * JITTER_LARGEST:g} %",
            mend="If the samples are even and the stamps are not, leave the time column out and write "
            "sample_time in [timing]; else record at a fixed rate",
        )
    return False, jitter


def _grid(stamps: np.ndarray, period: float, delay: float) -> np.ndarray:
    """Return the uniform grid within the stamps on which the effort, too, was recorded."""
    first = stamps[0] + period * np.ceil(max(-delay, 0.0) / period - UNIFORM)
    count = int(np.floor((stamps[-1] - max(delay, 0.0) - first) / period + UNIFORM)) + 1
    return first + period * np.arange(max(count, 0))
