"""Error on what was not fitted, time blocks or whole logs: how models of different size are compared."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from bristle.core.errors import InputError
from bristle.identification.regression import Regression
from bristle.identification.result import HeldOut
from bristle.identification.time_blocks import beside, time_blocks
from bristle.simulation.result import relative_error_percent

__all__ = ["held_out_error"]

ROWS_PER_BLOCK = 20


def held_out_error(
    regression: Regression, predicted: Callable[[np.ndarray], np.ndarray], blocks: int,
    report: Callable[[float], None] = lambda share: None,
) -> HeldOut:  # fmt: skip
    """Return the error on each of several time blocks, fitted to all others; of several logs, on each of them.

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
    log = regression.log_of_row
    if log[0] != log[-1]:
        return _held_out(regression, predicted, [log == one for one in np.unique(log)], 0, "logs", report)
    if count < blocks * (ROWS_PER_BLOCK + 2 * reach):
        raise InputError(
            "are too many for this log", path="blocks", value=blocks,
            allowed=f"2 to {max(count // (ROWS_PER_BLOCK + 2 * reach), 2)}, or 0 for no comparison on held-out blocks",
        )  # fmt: skip
    of, parts = time_blocks(regression, blocks)
    return _held_out(regression, predicted, parts, reach, of, report)


def _held_out(
    regression: Regression, predicted: Callable[[np.ndarray], np.ndarray], parts: Sequence[np.ndarray], reach: int,
    of: str, report: Callable[[float], None],
) -> HeldOut:  # fmt: skip
    errors, effort = [], regression.effort
    for number, part in enumerate(parts):
        report(number / len(parts))
        errors.append(relative_error_percent(effort[part], predicted(beside(part, reach))[part]))
    return HeldOut(tuple(errors), float(np.mean(errors)), float(np.std(errors, ddof=1)), of)
