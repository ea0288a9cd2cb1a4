"""Time base of a log: split at gaps, sort rows, resample uneven stamps."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from bristle.core import InputError, number
from bristle.logs.turns import runs

LEAVE_OUT = "Leave the column of time out of the axis file and write sample_time in [timing]"


EVERY = slice(None)  # row, in the order of the log


@dataclass(frozen=True)
class Order:
    """Rows in the order of time."""

    rows: np.ndarray | slice
    stamps: np.ndarray
    notes: tuple[str, ...] = ()


def order_of(stamps: np.ndarray, place: str) -> Order:
    """Return the rows of a log in the order of time; the rows after a restart of the clock are a second recording."""
    steps = np.diff(stamps)
    if not steps.any():
        raise InputError(
            f"does not advance: all its values are {stamps[0]:.9g} s", path=place, mend=LEAVE_OUT
        )
    if not np.any(steps < 0):
        return Order(EVERY, stamps)
    if np.all(steps <= 0):
        return Order(
            np.arange(stamps.size)[::-1],
            stamps[::-1],
            ("the newest row came first: bristle reversed the rows",),
        )
    backward = np.flatnonzero(steps < 0)
    # A clock that stepped back recovers within 32 rows, unless it restarted.
    restarts = [int(i) for i in backward if stamps[i + 1 : i + 1 + 32].max() < stamps[i]]
    local = backward.size - len(restarts)
    # Largest share of backward steps in a log that can be sorted.
    if len(restarts) > 50 or local > 0.25 * steps.size:
        before, behind = stamps[backward[0] : backward[0] + 2]
        raise InputError(
            f"is not in order: {backward.size} of its {steps.size} steps go backward, the first at sample "
            f"{backward[0] + 1} (from {before:.9g} s to {behind:.9g} s)",
            path=place,
            mend=f"Export the rows sorted by time. If they are in order, {LEAVE_OUT[0].lower()}{LEAVE_OUT[1:]}",
        )
    notes = []
    if restarts:  # continue the stamps of a restarted clock after a pause
        # Pause of 10.0 sample times before a restarted clock.
        stamps, pause = (
            stamps.copy(),
            10.0 * median_step(stamps[: restarts[0] + 1]) if restarts[0] > 1 else 0.0,
        )
        for last in restarts:
            stamps[last + 1 :] += stamps[last] + pause - stamps[last + 1]
        ends = ", ".join(str(i + 1) for i in restarts[:5])
        notes.append(
            f"the clock restarts at row {ends}: bristle reads the log as {len(restarts) + 1} consecutive recordings"
        )
    if not local:
        return Order(EVERY, stamps, tuple(notes))
    rows = np.argsort(stamps, kind="stable")
    notes.append(
        f"{local} {'row was' if local == 1 else 'rows were'} out of order: bristle sorted the rows by time"
    )
    return Order(rows, stamps[rows], tuple(notes))


def median_step(stamps: np.ndarray) -> float:
    """Return the usual time between samples [s], which neither jitter nor rounded stamps change."""
    over = max(1, min(16, (stamps.size - 1) // 4))  # rows between the two stamps of a step
    return float(np.median(stamps[over:] - stamps[:-over])) / over


def without_repeats(order: Order, repeats: np.ndarray | None, fewest: int, place: str) -> Order:
    """Correct stamps that repeat the previous stamp, and leave out rows that repeat the whole previous row."""
    # A row with different readings is a sample. All rows of a burst have the time of arrival as their stamp: their true
    # times lie between the stamps before and after the burst.
    stamps, notes = order.stamps.copy(), list(order.notes)
    repeated = np.append(False, np.diff(stamps) <= 0)
    if not repeated.any():
        return order
    different = stamps.size - int(repeated.sum())
    if different < fewest:
        raise InputError(
            f"has only {different} different time stamps in {stamps.size} rows",
            path=place,
            mend=LEAVE_OUT,
        )
    rows = np.arange(stamps.size)[order.rows]
    twice = repeated & (np.ones(stamps.size, dtype=bool) if repeats is None else repeats[rows])
    if count := int(twice.sum()):
        notes.append(
            f"{count} {'row repeats' if count == 1 else 'rows repeat'} the previous row: bristle uses each row once"
        )
        stamps, rows, repeated = stamps[~twice], rows[~twice], repeated[~twice]
    if late := int(repeated.sum()):
        sentence = "1 time stamp repeats" if late == 1 else f"{late} time stamps repeat"
        notes.append(
            f"{sentence} the previous time stamp: bristle interpolates between the neighbouring time stamps"
        )
    spread, usual = stamps.copy(), median_step(stamps) if late else 0.0
    for run in runs(repeated):
        # Spread the stamps of a burst evenly on the side with free time.
        first, last = run.start - 1, run.stop - 1  # rows with the same stamp
        size = last - first + 1
        before = spread[first - 1] if first else stamps[first] - size * usual
        after = stamps[last + 1] if last + 1 < stamps.size else stamps[last] + usual
        free = stamps[first] - before, after - stamps[first]
        if free[0] >= free[1]:  # stamped on arrival of the burst
            spread[first : last + 1] = before + free[0] * np.arange(1, size + 1) / size
        else:
            spread[first : last + 1] = stamps[first] + free[1] * np.arange(size) / size
    return Order(rows, spread, tuple(notes))


BRIDGED = 3  # consecutive lost rows that are interpolated: a longer pause splits the log
HALF = 0.5  # of the sample time: delay of all later stamps that shows a lost row
UNIFORM = 0.01  # of the sample time: rounding of the stamps, which is not corrected


def samples_between(stamps: np.ndarray, usual: float) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Return the steps that are pauses, the count of samples in each other step, and notes on interpolated rows."""
    # A lost row delays all later stamps; a late row delays only its own stamp. The medians of the stamps before and after a
    # step, relative to even stamps, distinguish the two.
    from scipy.ndimage import median_filter

    counts = np.ones(stamps.size - 1)
    # Rows before a step, and behind it: 16 late rows are no majority of them.
    reach = min(33, stamps.size)
    for _ in range(8):  # lost rows close to each other are found one by one
        off = (stamps - usual * np.concatenate([[0.0], np.cumsum(counts)])) / usual
        # Medians of the values up to each row, and from each row on.
        before, behind = (
            median_filter(side, size=reach, origin=(reach - 1) // 2, mode="nearest")
            for side in (off, off[::-1])
        )
        before, behind = before[:-1], behind[::-1][1:]
        rise = behind - before
        late = np.flatnonzero(rise > HALF)
        if not late.size:
            break
        jumps = np.diff(off)
        for near in np.split(late, np.flatnonzero(np.diff(late) > 1) + 1):
            missing = np.round(jumps[near])
            if (
                missing.min() >= 0.0
                and abs(missing.sum() - (behind[near[-1]] - before[near[0]])) < HALF
            ):
                counts[near] += missing  # the single steps agree with the stamps around all of them
                continue
            at = near[np.argmax(jumps[near])]
            counts[at] += max(round(float(min(rise[near].max(), jumps[at]))), 1)
    # If more than 0.1 of the rows are missing, do not interpolate.
    gaps = counts > (BRIDGED + 1.0 if np.sum(counts > 1.0) <= 0.1 * counts.size else 1.0)
    fraction = np.abs(np.diff(stamps) / usual - counts)
    # If 0.99 of the steps are even, a pause of a fractional number of samples belongs to the clock and splits the log.
    if np.quantile(fraction, 0.99) < UNIFORM:
        gaps |= (counts > 1.0) & (fraction > UNIFORM)
    counts[gaps] = 1.0
    lost = int(np.sum(counts - 1.0))
    rows = "1 row is" if lost == 1 else f"{lost} rows are"
    return (
        gaps,
        counts,
        [f"{rows} missing, at most {BRIDGED} consecutively: bristle interpolates"] if lost else [],
    )


GAP = 1.5  # sample times: half of the step of a lost row is left for jitter
SHORTEST_SEGMENT = 10  # samples
SHORTEST, LONGEST = 1e-12, 1e9  # sample time [s]: beyond, its square or its inverse overflows
DEVIATES = 0.05  # of the sample time: deviations that show whether stamps or samples are uneven


@dataclass(frozen=True)
class Jitter:
    """Deviation of stamps from even stamps."""

    usual: float
    largest: float

    def __str__(self) -> str:
        usual, largest = (number(100.0 * share, digits=2) for share in (self.usual, self.largest))
        return f"up to {usual} % of the sample time (19 of 20 stamps; the largest deviation is {largest} %)"


@dataclass(frozen=True)
class Clock:
    """The uniform grid of time of a log, segment by segment."""

    sample_time: float
    pieces: tuple[tuple[slice, np.ndarray], ...]
    stamps: np.ndarray
    uniform: bool
    rows: np.ndarray | slice
    notes: tuple[str, ...] = ()
    jitter: Jitter | None = None

    @property
    def time(self) -> np.ndarray:
        """The grid, all segments in one [s]."""
        return np.concatenate([grid for _, grid in self.pieces])

    @property
    def segments(self) -> tuple[slice, ...]:
        """The segments as slices of the grid."""
        return tuple(
            slice(int(a), int(b))
            for a, b in pairwise(np.cumsum([0, *(grid.size for _, grid in self.pieces)]))
        )

    def sampled(self, values: np.ndarray, lag: float = 0.0, *, smooth: bool = True) -> np.ndarray:
        """Return the values on the grid; the values were recorded later by `lag` [s]."""
        values = values[self.rows]
        parts = []
        for raw, grid in self.pieces:
            shift = (grid[0] + lag - self.stamps[raw][0]) / self.sample_time
            if self.uniform and abs(shift - round(shift)) < UNIFORM:
                parts.append(values[raw][round(shift) : round(shift) + grid.size])
            elif smooth:
                parts.append(self._spline(raw)(self.stamps[raw], values[raw])(grid + lag))
            else:
                parts.append(np.interp(grid + lag, self.stamps[raw], values[raw]))
        return np.concatenate(parts)

    def error_of(self, values: np.ndarray) -> float:
        """Return the root mean square error of resampling, in the unit of `values`, from every second sample."""
        values = values[self.rows]
        squares, count = 0.0, 0
        for raw, _ in self.pieces:
            stamps, recorded = self.stamps[raw], values[raw]
            inside = slice(1, stamps.size - 1 - stamps.size % 2, 2)
            guessed = self._spline(raw)(stamps[::2], recorded[::2])(stamps[inside])
            squares, count = (
                squares + float(np.sum((guessed - recorded[inside]) ** 2)),
                count + guessed.size,
            )
        return float(np.sqrt(squares / max(count, 1)))

    def _spline(self, raw: slice) -> Any:
        """Return the interpolant: a cubic spline, or a monotone interpolant if samples lie close together."""
        from scipy.interpolate import CubicSpline, PchipInterpolator

        # If steps are shorter than 0.2 of the sample time, a cubic spline overshoots.
        close = float(np.min(np.diff(self.stamps[raw]))) < 0.2 * self.sample_time
        return PchipInterpolator if close else CubicSpline


def clock_of(
    stamps: np.ndarray,
    place: str,
    *,
    delay: float = 0.0,
    sample_time: float | None = None,
    position: np.ndarray | None = None,
    repeats: np.ndarray | None = None,
) -> Clock:
    """Return the uniform grid of time on or near the recorded time stamps."""
    order = order_of(stamps, place)
    usual = median_step(order.stamps)
    if not SHORTEST <= usual <= LONGEST:
        raise InputError(
            f"has a usual time step of {usual:.6g} s",
            path=place,
            allowed=f"{SHORTEST:g} s to {LONGEST:g} s",
            mend="Correct the unit of the time column",
        )
    even, step = _rounded(order.stamps, usual)
    order = order if step else without_repeats(order, repeats, SHORTEST_SEGMENT, place)
    stamps = order.stamps
    steps = np.diff(stamps)
    gaps, uneven, counts, bridged = np.zeros(steps.size, dtype=bool), False, np.ones(steps.size), []
    parts = [] if step else rates_of(steps)
    rates = np.concatenate(
        [
            np.full(part.stop - part.start, np.median(steps[part]))
            for part in parts or [slice(0, steps.size)]
        ]
    )
    if parts:
        gaps = steps > (BRIDGED + GAP) * rates
    elif not step:
        gaps, uneven = _gaps(stamps, steps, usual)
    # A larger deviation of the median step from the usual step means more than a few missing rows.
    if not step and not parts and not uneven and abs(float(np.median(steps)) / usual - 1.0) < 0.1:
        gaps, counts, bridged = samples_between(stamps, usual)
    mean = float(np.diff(even).mean()) if step else float(steps[~gaps].sum() / counts[~gaps].sum())
    if parts:
        mean = sample_time or float(
            rates[max(parts, key=lambda part: stamps[part.stop] - stamps[part.start]).start]
        )
    # Significant digits of the sample time: further digits are rounding by the unit of the stamps.
    period = float(f"{mean:.12g}")
    if sample_time is not None and abs(period / sample_time - 1) > UNIFORM:
        raise InputError(
            f"has a time step of {period:.6g} s, unlike sample_time in the axis file",
            path=place,
            allowed=f"{sample_time:g} s",
            mend="Remove sample_time from [timing] to use this column, or the column of time from [columns] to use sample_time",
        )
    raws = [
        slice(a, b) for a, b in pairwise([0, *(np.flatnonzero(gaps) + 1).tolist(), stamps.size])
    ]
    usable = [raw for raw in raws if raw.stop - raw.start >= SHORTEST_SEGMENT]
    notes, jitter = list(order.notes), None
    if len(raws) > 1:
        ends = ", ".join(f"{stamps[raw.start - 1]:.6g} s" for raw in raws[1:6]) + (
            ", …" if len(raws) > 6 else ""
        )
        pauses = "1 gap" if len(raws) == 2 else f"{len(raws) - 1} gaps"
        notes.append(
            f"{pauses} in the time stamps (after {ends}): bristle splits the log into {len(usable)} segments"
        )
        if lost := stamps.size - sum(raw.stop - raw.start for raw in usable):
            notes.append(
                f"bristle ignores {lost} samples in segments shorter than {SHORTEST_SEGMENT} samples"
            )
    notes += bridged
    if step:
        stamps = even
        notes.append(
            f"time stamps are rounded to {step:.6g} s: bristle treats the samples as evenly spaced, {period:.6g} s apart"
        )
    elif parts:
        changes = ", ".join(
            f"{rates[part.start]:.6g} s until {stamps[part.stop]:.6g} s" for part in parts[:5]
        )
        notes.append(
            f"the sample time changes ({changes}): bristle resamples the log onto a uniform grid of {period:.6g} s"
        )
    else:
        places = np.concatenate([[0.0], np.cumsum(counts)])
        position = None if position is None else position[order.rows]
        stamps, jitter, remarks = _deviation(stamps, places, usable, period, uneven, position)
        notes += remarks
    pieces = []
    for raw in usable:  # the grid within the stamps that the delayed effort also covers
        first = stamps[raw][0] + period * np.ceil(max(-delay, 0.0) / period - UNIFORM)
        count = int(np.floor((stamps[raw][-1] - max(delay, 0.0) - first) / period + UNIFORM)) + 1
        if count >= SHORTEST_SEGMENT:
            pieces.append((raw, first + period * np.arange(count)))
    if not pieces:
        message = f"has fewer than {SHORTEST_SEGMENT} evenly spaced samples"
        message += f" in sequence after a shift by the delay of {delay:g} s" if delay else ""
        raise InputError(
            message,
            path=place,
            mend="Correct the delay in [timing] of the axis file, or record without gaps",
        )
    is_uniform = jitter is None and not parts and not np.any(counts > 1.0)
    return Clock(period, tuple(pieces), stamps, is_uniform, order.rows, tuple(notes), jitter)


# Ratio of two sample times; deviation of 9 of 10 steps in each part; steps of a part.
CHANGES, EVEN, FEWEST = (1.2, 0.05, 100)


def rates_of(steps: np.ndarray) -> list[slice]:
    """Return the parts of a log whose sample times differ; empty if it has only one, or if samples are uneven within a part."""
    if steps.min() <= 0.0 or steps.max() < CHANGES * steps.min():
        return []
    from scipy.ndimage import median_filter

    # Rows around a step: a median keeps the place of a change.
    usual = median_filter(steps, size=33, mode="nearest")
    edges = np.flatnonzero(np.abs(np.diff(np.log(usual))) > np.log(CHANGES)) + 1
    parts = [slice(a, b) for a, b in pairwise([0, *edges.tolist(), steps.size])]
    even = [
        np.quantile(np.abs(steps[part] / np.median(steps[part]) - 1.0), 0.9) < EVEN
        for part in parts
    ]
    sizes = [part.stop - part.start for part in parts]
    # Fewer slow rows than a tenth are rows with others missing between them.
    return parts if all(even) and min(sizes) >= FEWEST and max(sizes) < 0.9 * steps.size else []


def _gaps(stamps: np.ndarray, steps: np.ndarray, usual: float) -> tuple[np.ndarray, bool]:
    """Return the gaps among the steps, and whether samples are so uneven that only long pauses are gaps."""
    gaps = steps > GAP * usual
    candidates = np.flatnonzero(gaps)
    for rows in (1, 2, 4, 8, 16):  # rows after which late stamps are on time again
        # Later samples make up for a late stamp, not for a gap.
        at = candidates[candidates + 1 + rows < stamps.size]
        gaps[at[stamps[at + 1 + rows] - stamps[at] < (rows + GAP) * usual]] = False
    uneven = bool(gaps.mean() > 0.05)  # with a larger share of gaps, the samples are uneven
    return steps > 10.0 * float(
        np.median(steps)
    ) if uneven else gaps, uneven  # sample times of a pause that splits a log of uneven samples


def _rounded(stamps: np.ndarray, usual: float) -> tuple[np.ndarray, float]:
    """Return even stamps and the rounding step of the recorded ones; 0 if they are not rounded."""
    steps = np.diff(stamps)
    different = np.unique(np.round(steps[steps > 0] / usual, 6))
    # Rounded stamps have at most 100 different steps.
    step = usual * float(min([different[0], *np.diff(different)])) if different.size < 100 else 0.0
    if not step:
        return stamps, 0.0
    multiples = steps / step
    # Tolerance of a multiple of the step: 0.02.
    if step < UNIFORM * usual or np.abs(multiples - np.round(multiples)).max() > 0.02:
        return stamps, 0.0
    # Rounding spreads 0.05 or more of the steps evenly over a log; lost or repeated rows are rarer.
    if np.mean(np.round(multiples) != np.round(np.median(multiples))) < 0.05:
        return stamps, 0.0
    index = np.arange(stamps.size)
    slope = (stamps[-1] - stamps[0]) / index[-1]
    for _ in range(2):  # the ends are rounded, too: turn the line into the middle of its band
        error = stamps - slope * index
        slope += float(np.polyfit(index - index.mean(), error, 1)[0]) if error.any() else 0.0
    error = stamps - slope * index
    largest = float(np.ptp(error))
    # Of the step of the stamps: largest deviation by rounding of even samples.
    if largest > 1.05 * step or largest <= 2 * UNIFORM * usual:
        return stamps, 0.0
    return slope * index + 0.5 * float(error.max() + error.min()), step


def _deviation(
    stamps: np.ndarray,
    places: np.ndarray,
    raws: list[slice],
    period: float,
    uneven: bool,
    position: np.ndarray | None,
) -> tuple[np.ndarray, Jitter | None, list[str]]:
    """Return the times of the samples, their deviation from even times, and notes."""
    # `places` counts the samples, including interpolated lost rows.
    errors = [stamps[raw] - period * (places[raw] - places[raw.start]) for raw in raws]
    errors = [(error - error.mean()) / period for error in errors]
    if max((float(np.ptp(error)) for error in errors), default=0.0) <= 2 * UNIFORM:
        return stamps, None, []
    from scipy.ndimage import uniform_filter1d

    # Drift of a clock over 101 samples is not jitter.
    local = [error - uniform_filter1d(error, min(101, error.size)) for error in errors]
    sizes = np.abs(np.concatenate(local))
    jitter = Jitter(float(np.quantile(sizes, 0.95)), float(np.max(sizes)))
    if (
        not uneven
        and position is not None
        and _samples_are_even(stamps, places, raws, local, position)
    ):
        even = stamps.copy()
        for raw, error, off in zip(raws, errors, local, strict=True):
            # With interpolated rows, keep lasting shifts of the stamps: a miscounted row shifts few others.
            is_bridged = places[raw][-1] - places[raw.start] >= raw.stop - raw.start
            even[raw] = stamps[raw] - period * (off if is_bridged else error)
        note = f"time stamps jitter by {jitter}, but the position changes evenly: bristle treats the samples as evenly spaced"
        return even, None, [f"{note}, {period:.6g} s apart"]
    reason = "samples are unevenly spaced: their times deviate" if uneven else "time stamps jitter"
    return (
        stamps,
        jitter,
        [f"{reason} by {jitter}. bristle resamples the log onto a uniform grid of {period:.6g} s"],
    )


def _samples_are_even(
    stamps: np.ndarray,
    places: np.ndarray,
    raws: list[slice],
    local: list[np.ndarray],
    position: np.ndarray,
) -> bool:
    """Return whether the position moves evenly from row to row although its stamps are uneven."""
    by_row, by_stamp, count = 0.0, 0.0, 0
    for raw, error in zip(raws, local, strict=True):
        x, t = position[raw], stamps[raw]
        share = (t[1:-1] - t[:-2]) / (t[2:] - t[:-2])
        middle = x[1:-1]
        off = (np.abs(share - 0.5) > DEVIATES) & (np.abs(error[1:-1]) > DEVIATES)
        off &= places[raw][2:] - places[raw][:-2] == 2.0  # no lost row between them
        by_row += float(np.sum((middle - 0.5 * (x[:-2] + x[2:]))[off] ** 2))
        by_stamp += float(np.sum((middle - x[:-2] - share * (x[2:] - x[:-2]))[off] ** 2))
        count += int(off.sum())
    # Times less error with one time base than with the other.
    return count >= 20 and 4.0 * by_row < by_stamp
