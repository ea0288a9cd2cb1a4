"""The order of the rows of a log: by their stamps, as far as these make one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bristle.core.errors import InputError

__all__ = ["Order", "median_step", "order_of"]

RECOVERY = 32  # rows within which a clock that stepped back is where it was, unless it began anew
MOST_RESTARTS = 50
DISORDER = 0.25  # share of steps that run backward from which on stamps make no order
PAUSE = 10.0  # sample times that a clock which began anew is taken to have stood
WINDOW = 16  # rows over which the usual step is taken


@dataclass(frozen=True)
class Order:
    """Rows in the order of time.

    Parameters
    ----------
    rows : ndarray or None
        Index of each row in the file, in the order of time; None where all stand in it already.
    stamps : ndarray
        Their stamps [s], which do not fall.
    notes : tuple of str
        What was sorted, turned round or put behind.
    """

    rows: np.ndarray | None
    stamps: np.ndarray
    notes: tuple[str, ...] = ()


def order_of(stamps: np.ndarray, place: str) -> Order:
    """Return the rows of a log in the order of time.

    Rows that stand the newest first are turned round, single ones out of place are sorted, and a clock that begins anew
    begins a second recording behind the first.

    Raises
    ------
    InputError
        If the stamps stand still, or are in no order.
    """
    steps = np.diff(stamps)
    if not steps.any():
        raise InputError(
            f"stands still at {stamps[0]:.9g} s", path=place,
            mend="Leave the column of time out of the axis file and write sample_time in [timing]",
        )  # fmt: skip
    if not np.any(steps < 0):
        return Order(None, stamps)
    if np.all(steps <= 0):
        return Order(np.arange(stamps.size)[::-1], stamps[::-1], ("the newest row stands first: turned round",))
    backward = np.flatnonzero(steps < 0)
    restarts = [int(i) for i in backward if stamps[i + 1 : i + 1 + RECOVERY].max() < stamps[i]]
    local = backward.size - len(restarts)
    if len(restarts) > MOST_RESTARTS or local > DISORDER * steps.size:
        raise InputError(
            f"is in no order: {backward.size} of its {steps.size} steps run backward, the first at sample "
            f"{backward[0] + 1} ({stamps[backward[0]]:.9g} s, then {stamps[backward[0] + 1]:.9g} s)",
            path=place,
            mend="Leave the column of time out of the axis file and write sample_time in [timing], if the rows are in "
            "order; else export them sorted",
        )
    notes = []
    if restarts:
        stamps = _put_behind(stamps, restarts)
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


def _put_behind(stamps: np.ndarray, restarts: list[int]) -> np.ndarray:
    """Return stamps that go on where the clock began anew, after a pause."""
    moved = stamps.copy()
    pause = PAUSE * median_step(stamps[: restarts[0] + 1]) if restarts[0] > 1 else 0.0
    for last in restarts:
        moved[last + 1 :] += moved[last] + pause - moved[last + 1]
    return moved
