"""Error on what was not fitted, time blocks or whole logs: how models of different size are compared."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from bristle.core.errors import InputError
from bristle.identification.regression import Regression
from bristle.identification.result import HeldOut
from bristle.simulation.result import relative_error_percent

__all__ = ["held_out_error"]

ROWS_PER_BLOCK = 20


def held_out_error(
    regression: Regression, predicted: Callable[[np.ndarray], np.ndarray], blocks: int,
    report: Callable[[float], None] = lambda share: None,
) -> HeldOut:  # fmt: skip
    """Return the error on each of several contiguous blocks, fitted to all others; of several logs, on each of them.

    Parameters
    ----------
    regression : Regression
        The rows.
    predicted : callable
        Returns the effort of every row [N or N*m] as predicted by a fit to some rows, given as an array of bool.
    blocks : int
        Number of blocks, at least 2.
    report : callable
        Is told the share of the work done.

    Notes
    -----
    Rows next to a block share samples with it through the filters; they are fitted by neither side.

    Raises
    ------
    InputError
        If the log is too short for so many blocks.
    """
    count, reach = regression.effort.size, regression.reach
    logs = np.flatnonzero(np.diff(regression.log_of_row)) + 1
    if logs.size:
        return _held_out(regression, predicted, [0, *logs.tolist(), count], 0, "logs", report)
    if count < blocks * (ROWS_PER_BLOCK + 2 * reach):
        raise InputError(
            "are too many for this log", path="blocks", value=blocks,
            allowed=f"2 to {max(count // (ROWS_PER_BLOCK + 2 * reach), 2)}, or 0 for no comparison on held-out blocks",
        )  # fmt: skip
    edges = np.linspace(0, count, blocks + 1).astype(int).tolist()
    return _held_out(regression, predicted, edges, reach, "time blocks", report)


def _held_out(
    regression: Regression, predicted: Callable[[np.ndarray], np.ndarray], edges: list[int], reach: int, of: str,
    report: Callable[[float], None],
) -> HeldOut:  # fmt: skip
    errors, count = [], len(edges) - 1
    for number, (first, last) in enumerate(pairwise(edges)):
        report(number / count)
        fitted = np.ones(edges[-1], dtype=bool)
        fitted[max(first - reach, 0) : last + reach] = False
        block = slice(first, last)
        errors.append(relative_error_percent(regression.effort[block], predicted(fitted)[block]))
    return HeldOut(tuple(errors), float(np.mean(errors)), float(np.std(errors, ddof=1)), of)
