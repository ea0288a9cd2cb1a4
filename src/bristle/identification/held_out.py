"""Error on what was not fitted, time blocks or whole logs: how models of different size are compared."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from bristle.core.diagnostic import Diagnostic
from bristle.core.errors import InputError
from bristle.identification.dataset import Dataset
from bristle.identification.result import HeldOut
from bristle.identification.settings import DEFAULT, Settings
from bristle.identification.time_blocks import BLOCKS, beside, time_blocks
from bristle.simulation.result import relative_error_percent

__all__ = ["TOO_SHORT", "blocks_for", "held_out_error"]

TOO_SHORT = Diagnostic("too-short")


def blocks_for(dataset: Dataset, asked: int | None, settings: Settings = DEFAULT) -> int:
    """Return how many time blocks are held out: as asked, else five, fewer of a short log, 0 where none has room."""
    if asked is not None or dataset.log_of_row[0] != dataset.log_of_row[-1]:
        return BLOCKS if asked is None else asked
    room = _room(dataset, settings)
    return min(room, BLOCKS) if room > 1 else 0


def _room(dataset: Dataset, settings: Settings) -> int:
    return dataset.effort.size // (int(settings.held_out_rows) + 2 * dataset.reach)


def held_out_error(
    dataset: Dataset, predicted: Callable[[np.ndarray], np.ndarray], blocks: int,
    report: Callable[[float], None] = lambda share: None, settings: Settings = DEFAULT,
) -> HeldOut:  # fmt: skip
    """Return the error on each of several time blocks, fitted to all others; of several logs, on each of them.

    Parameters
    ----------
    dataset : Dataset
        The rows.
    predicted : callable
        Returns the effort of every row [N or N*m] as predicted by a fit to some rows, given as an array of bool.
    blocks : int
        Number of blocks, at least 2.
    report : callable
        Is told the share of the work done.
    settings : Settings
        The thresholds.

    Notes
    -----
    Rows next to a block share samples with it through the filters; they are fitted by neither side.

    Raises
    ------
    InputError
        If the log is too short for so many blocks.
    """
    log, reach = dataset.log_of_row, dataset.reach
    if log[0] != log[-1]:
        return _held_out(dataset, predicted, [log == one for one in np.unique(log)], 0, "logs", report)
    if blocks > (room := _room(dataset, settings)):
        raise InputError(
            "are too many for this log", path="blocks", value=blocks,
            allowed=f"2 to {max(room, 2)}, or 0 for no comparison on held-out blocks",
        )  # fmt: skip
    of, parts = time_blocks(dataset, blocks)
    return _held_out(dataset, predicted, parts, reach, of, report)


def _held_out(
    dataset: Dataset, predicted: Callable[[np.ndarray], np.ndarray], parts: Sequence[np.ndarray], reach: int,
    of: str, report: Callable[[float], None],
) -> HeldOut:  # fmt: skip
    errors, effort = [], dataset.effort
    for number, part in enumerate(parts):
        report(number / len(parts))
        errors.append(relative_error_percent(effort[part], predicted(beside(part, reach))[part]))
    return HeldOut(tuple(errors), float(np.mean(errors)), float(np.std(errors, ddof=1)), of)
