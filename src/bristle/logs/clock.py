"""The time base of a log: gaps split it, rows are put in order, and stamps that are not even are resampled."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from bristle.core.errors import InputError
from bristle.core.typography import number
from bristle.logs.turns import runs

LEAVE_OUT = "Leave the column of time out of the axis file and write sample_time in [timing]"


@dataclass(frozen=True)
class Order:
    """Rows in the order of time."""

    rows: np.ndarray | None
    stamps: np.ndarray
    notes: tuple[str, ...] = ()


def order_of(stamps: np.ndarray, place: str) -> Order:
    """Return the rows of a log in the order of time.

    Rows that stand the newest first are turned round, single ones out of place are sorted, and a clock that begins anew
    begins a second recording behind the first.
    """
    steps = np.diff(stamps)
    if not steps.any():
        raise InputError(f"stands still at {stamps[0]:.9g} s", path=place, mend=LEAVE_OUT)
    if not np.any(steps < 0):
        return Order(None, stamps)
    if np.all(steps <= 0):
        return Order(np.arange(stamps.size)[::-1], stamps[::-1], ("the newest row stands first: turned round",))
    backward = np.flatnonzero(steps < 0)
    # 32 rows within which a clock that stepped back is where it was, unless it began anew
    restarts = [int(i) for i in backward if stamps[i + 1 : i + 1 + 32].max() < stamps[i]]
    local = backward.size - len(restarts)
    if len(restarts) > 50 or local > 0.25 * steps.size:  # share of steps that run backward from which on stamps make no order
        before, behind = stamps[backward[0] : backward[0] + 2]
        raise InputError(
            f"is in no order: {backward.size} of its {steps.size} steps run backward, the first at sample "
            f"{backward[0] + 1} ({before:.9g} s, then {behind:.9g} s)",
            path=place,
            mend=f"{LEAVE_OUT}, if the rows are in order; else export them sorted",
        )
    notes = []
    if restarts:  # stamps go on where the clock began anew, after a pause
        # 10.0 sample times that a clock which began anew is taken to have stood
        stamps, pause = stamps.copy(), 10.0 * median_step(stamps[: restarts[0] + 1]) if restarts[0] > 1 else 0.0
        for last in restarts:
            stamps[last + 1 :] += stamps[last] + pause - stamps[last + 1]
        ends = ", ".join(str(i + 1) for i in restarts[:5])
        notes.append(f"the clock begins anew at row {ends}: taken as {len(restarts) + 1} recordings, one after another")
    if not local:
        return Order(None, stamps, tuple(notes))
    rows = np.argsort(stamps, kind="stable")
    notes.append(f"{local} {'row was' if local == 1 else 'rows were'} out of order: sorted by time")
    return Order(rows, stamps[rows], tuple(notes))


def median_step(stamps: np.ndarray) -> float:
    """Return the usual time between samples [s], which neither jitter nor rounded stamps change."""
    over = max(1, min(16, (stamps.size - 1) // 4))  # rows over which the usual step is taken
    return float(np.median(stamps[over:] - stamps[:-over])) / over


def without_repeats(order: Order, repeats: np.ndarray | None, fewest: int, place: str) -> Order:
    """Mend stamps that repeat that of the row before, and leave out rows that repeat all of it.

    A row with a reading of its own is a sample, whatever its stamp: it was stamped when a burst arrived, and lies
    between the stamps around the burst.
    """
    stamps, notes = order.stamps.copy(), list(order.notes)
    repeated = np.append(False, np.diff(stamps) <= 0)
    if not repeated.any():
        return order
    different = stamps.size - int(repeated.sum())
    if different < fewest:
        raise InputError(f"has {different} different stamps in {stamps.size} rows", path=place, mend=LEAVE_OUT)
    rows = np.arange(stamps.size) if order.rows is None else order.rows
    twice = repeated & (np.ones(stamps.size, dtype=bool) if repeats is None else repeats[rows])
    if count := int(twice.sum()):
        notes.append(f"{count} {'row repeats' if count == 1 else 'rows repeat'} the row before: left out")
        stamps, rows, repeated = stamps[~twice], rows[~twice], repeated[~twice]
    if late := int(repeated.sum()):
        sentence = "1 stamp is repeated and is" if late == 1 else f"{late} stamps are repeated and are"
        notes.append(f"{sentence} taken as between those around")
    spread, usual = stamps.copy(), median_step(stamps) if late else 0.0
    for run in runs(repeated):
        # Stamps of one burst lie evenly on the side of it where time is left.
        first, last = run.start - 1, run.stop - 1  # rows of one stamp
        size = last - first + 1
        before = spread[first - 1] if first else stamps[first] - size * usual
        after = stamps[last + 1] if last + 1 < stamps.size else stamps[last] + usual
        free = stamps[first] - before, after - stamps[first]
        if free[0] >= free[1]:  # stamped as the burst arrived
            spread[first : last + 1] = before + free[0] * np.arange(1, size + 1) / size
        else:
            spread[first : last + 1] = stamps[first] + free[1] * np.arange(size) / size
    return Order(rows if count else order.rows, spread, tuple(notes))


BRIDGED = 3  # rows lost on end that are interpolated: a longer pause splits the log
HALF = 0.5  # of the sample time: what the stamps behind a step are later by where a row was lost
UNIFORM = 0.01  # of the sample time: rounding of the stamps, left alone


def samples_between(stamps: np.ndarray, usual: float) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Return which steps are pauses that split the log, over how many samples each other step is, and what was bridged.

    A row that was lost moves all stamps behind it, a late one only itself: the medians of the stamps before and behind
    a step, against even ones, tell them apart. Few rows that were lost on end are bridged.
    """
    from scipy.ndimage import median_filter

    counts = np.ones(stamps.size - 1)
    reach = min(33, stamps.size)  # rows before a step, and behind it: 16 that came late and are made up for are no majority of them
    for _ in range(8):  # rows that were lost close together are found one after the other
        off = (stamps - usual * np.concatenate([[0.0], np.cumsum(counts)])) / usual
        # The medians of the values up to each, and of those from each on.
        before, behind = (median_filter(side, size=reach, origin=(reach - 1) // 2, mode="nearest") for side in (off, off[::-1]))
        before, behind = before[:-1], behind[::-1][1:]
        rise = behind - before
        late = np.flatnonzero(rise > HALF)
        if not late.size:
            break
        jumps = np.diff(off)
        for near in np.split(late, np.flatnonzero(np.diff(late) > 1) + 1):
            missing = np.round(jumps[near])
            if missing.min() >= 0.0 and abs(missing.sum() - (behind[near[-1]] - before[near[0]])) < HALF:
                counts[near] += missing  # single steps and the stamps around all of them agree
                continue
            at = near[np.argmax(jumps[near])]
            counts[at] += max(round(float(min(rise[near].max(), jumps[at]))), 1)
    # 0.1 of the rows: where more are missing none is bridged
    gaps = counts > (BRIDGED + 1.0 if np.sum(counts > 1.0) <= 0.1 * counts.size else 1.0)
    fraction = np.abs(np.diff(stamps) / usual - counts)
    # 0.99 of the steps being even: a pause of no whole number of samples is the clock's, and splits the log
    if np.quantile(fraction, 0.99) < UNIFORM:
        gaps |= (counts > 1.0) & (fraction > UNIFORM)
    counts[gaps] = 1.0
    lost = int(np.sum(counts - 1.0))
    rows = "1 row is" if lost == 1 else f"{lost} rows are"
    return gaps, counts, [f"{rows} missing, {BRIDGED} on end at most: interpolated between those around"] if lost else []


GAP = 1.5  # sample times: half of the least that a lost row adds is for jitter
SHORTEST_SEGMENT = 10  # samples
SHORTEST, LONGEST = 1e-12, 1e9  # sample time [s]: beyond them its square or its inverse is no number to reckon with
DEVIATES = 0.05  # of the sample time: stamps that tell whether they or the samples are off


@dataclass(frozen=True)
class Jitter:
    """By how much stamps deviate from even ones."""

    usual: float
    largest: float

    def __str__(self) -> str:
        usual, largest = (number(100.0 * share, digits=2) for share in (self.usual, self.largest))
        return f"{usual} % (19 of 20 stamps) and {largest} % (all)"


@dataclass(frozen=True)
class Clock:
    """The uniform grid of time of a log, segment by segment."""

    sample_time: float
    pieces: tuple[tuple[slice, np.ndarray], ...]
    stamps: np.ndarray
    uniform: bool
    notes: tuple[str, ...] = ()
    rows: np.ndarray | None = None
    jitter: Jitter | None = None

    @property
    def time(self) -> np.ndarray:
        """The grid, all segments in one [s]."""
        return np.concatenate([grid for _, grid in self.pieces])

    @property
    def segments(self) -> tuple[slice, ...]:
        """The segments as slices of the grid."""
        return tuple(slice(int(a), int(b)) for a, b in pairwise(np.cumsum([0, *(grid.size for _, grid in self.pieces)])))

    def sampled(self, values: np.ndarray, lag: float = 0.0, *, smooth: bool = True) -> np.ndarray:
        """Return recorded values on the grid, as they were recorded `lag` later [s]."""
        values = values if self.rows is None else values[self.rows]
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
        """Return by how much resampling may be wrong, root mean square, in the unit of `values`.

        Every second sample is taken from those beside it, twice as far apart as the grid needs them.
        """
        values = values if self.rows is None else values[self.rows]
        squares, count = 0.0, 0
        for raw, _ in self.pieces:
            stamps, recorded = self.stamps[raw], values[raw]
            inside = slice(1, stamps.size - 1 - stamps.size % 2, 2)
            guessed = self._spline(raw)(stamps[::2], recorded[::2])(stamps[inside])
            squares, count = squares + float(np.sum((guessed - recorded[inside]) ** 2)), count + guessed.size
        return float(np.sqrt(squares / max(count, 1)))

    def _spline(self, raw: slice) -> Any:
        """Return what goes between samples: a cubic spline, or where they lie close together one that keeps within."""
        from scipy.interpolate import CubicSpline, PchipInterpolator

        # 0.2 of the sample time: where steps are shorter, a cubic spline would overshoot
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
    """Return the uniform grid of time that recorded time stamps lie on or near."""
    order = order_of(stamps, place)
    usual = median_step(order.stamps)
    if not SHORTEST <= usual <= LONGEST:
        allowed = f"{SHORTEST:g} s to {LONGEST:g} s"
        raise InputError(f"steps by {usual:.6g} s", path=place, allowed=allowed, mend="Mend the unit of the time column")
    even, step = _rounded(order.stamps, usual)
    order = order if step else without_repeats(order, repeats, SHORTEST_SEGMENT, place)
    stamps = order.stamps
    steps = np.diff(stamps)
    gaps, uneven, counts, bridged = np.zeros(steps.size, dtype=bool), False, np.ones(steps.size), []
    if not step:
        gaps, uneven = _gaps(stamps, steps, usual)
    # Where the median step is off the usual one by more, more is missing than a few rows.
    if not step and not uneven and abs(float(np.median(steps)) / usual - 1.0) < 0.1:
        gaps, counts, bridged = samples_between(stamps, usual)
    mean = float(np.diff(even).mean()) if step else float(steps[~gaps].sum() / counts[~gaps].sum())
    period = float(f"{mean:.12g}")  # of the sample time that count: what the unit of the stamps leaves behind them is rounding
    if sample_time is not None and abs(period / sample_time - 1) > UNIFORM:
        mend = "Mend the unit of the time column, or sample_time in [timing]"
        raise InputError(f"steps by {period:.6g} s and the axis file says otherwise", path=place, allowed=f"{sample_time:g} s", mend=mend)
    raws = [slice(a, b) for a, b in pairwise([0, *(np.flatnonzero(gaps) + 1).tolist(), stamps.size])]
    usable = [raw for raw in raws if raw.stop - raw.start >= SHORTEST_SEGMENT]
    notes, jitter = list(order.notes), None
    if len(raws) > 1:
        ends = ", ".join(f"{stamps[raw.start - 1]:.6g} s" for raw in raws[1:6])
        pauses = "1 gap" if len(raws) == 2 else f"{len(raws) - 1} gaps"
        notes.append(f"{pauses} (the first after {ends}): split into {len(usable)} segments")
        if lost := stamps.size - sum(raw.stop - raw.start for raw in usable):
            notes.append(f"{lost} samples in segments shorter than {SHORTEST_SEGMENT} samples were left out")
    notes += bridged
    if step:
        stamps = even
        notes.append(f"time stamps are rounded to {step:.6g} s: the samples are taken as even, {period:.6g} s apart")
    else:
        places = np.concatenate([[0.0], np.cumsum(counts)])
        position = position if position is None or order.rows is None else position[order.rows]
        stamps, jitter, remarks = _deviation(stamps, places, usable, period, uneven, position)
        notes += remarks
    pieces = []
    for raw in usable:  # the grid within the stamps on which the effort, too, was recorded
        first = stamps[raw][0] + period * np.ceil(max(-delay, 0.0) / period - UNIFORM)
        count = int(np.floor((stamps[raw][-1] - max(delay, 0.0) - first) / period + UNIFORM)) + 1
        if count >= SHORTEST_SEGMENT:
            pieces.append((raw, first + period * np.arange(count)))
    if not pieces:
        message = f"has no stretch of {SHORTEST_SEGMENT} even samples" + (f" within a delay of {delay:g} s" if delay else "")
        raise InputError(message, path=place, mend="Mend the delay in [timing] of the axis file, or record without gaps")
    is_uniform = jitter is None and not np.any(counts > 1.0)
    return Clock(period, tuple(pieces), stamps, is_uniform, tuple(notes), order.rows, jitter)


def _gaps(stamps: np.ndarray, steps: np.ndarray, usual: float) -> tuple[np.ndarray, bool]:
    """Return which steps are gaps, and whether the samples are so uneven that only long pauses are."""
    gaps = steps > GAP * usual
    candidates = np.flatnonzero(gaps)
    for rows in (1, 2, 4, 8, 16):  # rows after which stamps that were only late are in time again
        # A sample that was stamped late is made up for by the next ones; a gap is not.
        at = candidates[candidates + 1 + rows < stamps.size]
        gaps[at[stamps[at + 1 + rows] - stamps[at] < (rows + GAP) * usual]] = False
    uneven = bool(gaps.mean() > 0.05)  # more steps than this being gaps, the samples are uneven
    return steps > 10.0 * float(np.median(steps)) if uneven else gaps, uneven  # sample times that split a log of uneven samples


def _rounded(stamps: np.ndarray, usual: float) -> tuple[np.ndarray, float]:
    """Return even stamps, and the step that the recorded ones are rounded to; 0 where they are something else."""
    steps = np.diff(stamps)
    different = np.unique(np.round(steps[steps > 0] / usual, 6))
    # 100 stamps with more different steps than this are not rounded ones
    step = usual * float(min([different[0], *np.diff(different)])) if different.size < 100 else 0.0
    if not step:
        return stamps, 0.0
    multiples = steps / step
    # 0.02 of the step of the stamps: how far a multiple of it may be off
    if step < UNIFORM * usual or np.abs(multiples - np.round(multiples)).max() > 0.02:
        return stamps, 0.0
    # 0.05 of all: rounding spreads them evenly over a log; fewer are lost or repeated rows
    if np.mean(np.round(multiples) != np.round(np.median(multiples))) < 0.05:
        return stamps, 0.0
    index = np.arange(stamps.size)
    slope = (stamps[-1] - stamps[0]) / index[-1]
    for _ in range(2):  # the ends are rounded too: the line is turned until it fits in the middle of its band
        error = stamps - slope * index
        slope += float(np.polyfit(index - index.mean(), error, 1)[0]) if error.any() else 0.0
    error = stamps - slope * index
    largest = float(np.ptp(error))
    if largest > 1.05 * step or largest <= 2 * UNIFORM * usual:  # of the step of the stamps: what rounding alone makes of even samples
        return stamps, 0.0
    return slope * index + 0.5 * float(error.max() + error.min()), step


def _deviation(
    stamps: np.ndarray, places: np.ndarray, raws: list[slice], period: float, uneven: bool, position: np.ndarray | None
) -> tuple[np.ndarray, Jitter | None, list[str]]:
    """Return the time of the samples, how far it is from even, and what is to be said of it."""
    # `places` are the samples counted, those that were lost and are bridged among them.
    errors = [stamps[raw] - period * (places[raw] - places[raw.start]) for raw in raws]
    errors = [(error - error.mean()) / period for error in errors]
    if max((float(np.ptp(error)) for error in errors), default=0.0) <= 2 * UNIFORM:
        return stamps, None, []
    from scipy.ndimage import uniform_filter1d

    # 101 samples over which a clock may drift and be no jitter
    local = [error - uniform_filter1d(error, min(101, error.size)) for error in errors]
    sizes = np.abs(np.concatenate(local))
    jitter = Jitter(float(np.quantile(sizes, 0.95)), float(np.max(sizes)))
    if not uneven and position is not None and _samples_are_even(stamps, places, raws, local, position):
        even = stamps.copy()
        for raw, error, off in zip(raws, errors, local, strict=True):
            # Where rows are bridged, what lasts in the stamps is kept: a row that was miscounted moves few others.
            is_bridged = places[raw][-1] - places[raw.start] >= raw.stop - raw.start
            even[raw] = stamps[raw] - period * (off if is_bridged else error)
        note = f"time stamps jitter by {jitter} of the sample time, and the position does not: the samples are taken as even"
        return even, None, [f"{note}, {period:.6g} s apart"]
    reason = "samples are uneven: their steps differ" if uneven else "time stamps jitter"
    return stamps, jitter, [f"{reason} by {jitter} of the sample time: resampled onto a uniform grid of {period:.6g} s"]


def _samples_are_even(stamps: np.ndarray, places: np.ndarray, raws: list[slice], local: list[np.ndarray], position: np.ndarray) -> bool:
    """Return whether the position moves evenly from row to row where it does not from stamp to stamp."""
    by_row, by_stamp, count = 0.0, 0.0, 0
    for raw, error in zip(raws, local, strict=True):
        x, t = position[raw], stamps[raw]
        share = (t[1:-1] - t[:-2]) / (t[2:] - t[:-2])
        middle = x[1:-1]
        off = (np.abs(share - 0.5) > DEVIATES) & (np.abs(error[1:-1]) > DEVIATES)
        off &= places[raw][2:] - places[raw][:-2] == 2.0  # no row was lost between them
        by_row += float(np.sum((middle - 0.5 * (x[:-2] + x[2:]))[off] ** 2))
        by_stamp += float(np.sum((middle - x[:-2] - share * (x[2:] - x[:-2]))[off] ** 2))
        count += int(off.sum())
    return count >= 20 and 4.0 * by_row < by_stamp  # times less error by one time base than by the other
