"""The order of the rows of a log: by their stamps, as far as these make one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bristle.core.errors import InputError
from bristle.logs.turns import runs

__all__ = ["UNIFORM", "Order", "median_step", "order_of", "samples_between", "without_repeats"]

RECOVERY = 32  # rows within which a clock that stepped back is where it was, unless it began anew
MOST_RESTARTS = 50
DISORDER = 0.25  # share of steps that run backward from which on stamps make no order
LEAVE_OUT = "Leave the column of time out of the axis file and write sample_time in [timing]"
PAUSE = 10.0  # sample times that a clock which began anew is taken to have stood
WINDOW = 16  # rows over which the usual step is taken


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
    restarts = [int(i) for i in backward if stamps[i + 1 : i + 1 + RECOVERY].max() < stamps[i]]
    local = backward.size - len(restarts)
    if len(restarts) > MOST_RESTARTS or local > DISORDER * steps.size:
        before, behind = stamps[backward[0] : backward[0] + 2]
        raise InputError(
            f"is in no order: {backward.size} of its {steps.size} steps run backward, the first at sample "
            f"{backward[0] + 1} ({before:.9g} s, then {behind:.9g} s)",
            path=place,
            mend=f"{LEAVE_OUT}, if the rows are in order; else export them sorted",
        )
    notes = []
    if restarts:  # stamps go on where the clock began anew, after a pause
        stamps, pause = stamps.copy(), PAUSE * median_step(stamps[: restarts[0] + 1]) if restarts[0] > 1 else 0.0
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
    over = max(1, min(WINDOW, (stamps.size - 1) // 4))
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
MOST_LOST = 0.1  # of the rows: where more are missing none is bridged
HALF = 0.5  # of the sample time: what the stamps behind a step are later by where a row was lost
AROUND = 33  # rows before a step, and behind it: 16 that came late and are made up for are no majority of them
EXACT = 0.99  # of the steps being even: a pause of no whole number of samples is the clock's, and splits the log
UNIFORM = 0.01  # of the sample time: rounding of the stamps, left alone
PASSES = 8  # rows that were lost close together are found one after the other


def samples_between(stamps: np.ndarray, usual: float) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Return which steps are pauses that split the log, over how many samples each other step is, and what was bridged.

    A row that was lost moves all stamps behind it, a late one only itself: the medians of the stamps before and behind
    a step, against even ones, tell them apart. Few rows that were lost on end are bridged.
    """
    from scipy.ndimage import median_filter

    counts = np.ones(stamps.size - 1)
    reach = min(AROUND, stamps.size)
    for _ in range(PASSES):
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
    gaps = counts > (BRIDGED + 1.0 if np.sum(counts > 1.0) <= MOST_LOST * counts.size else 1.0)
    fraction = np.abs(np.diff(stamps) / usual - counts)
    if np.quantile(fraction, EXACT) < UNIFORM:
        gaps |= (counts > 1.0) & (fraction > UNIFORM)
    counts[gaps] = 1.0
    lost = int(np.sum(counts - 1.0))
    rows = "1 row is" if lost == 1 else f"{lost} rows are"
    return gaps, counts, [f"{rows} missing, {BRIDGED} on end at most: interpolated between those around"] if lost else []
