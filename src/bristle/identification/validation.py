"""Error on what was not fitted, time blocks or whole logs: how models of different size are compared."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bristle.core.diagnostic import Diagnostic
from bristle.core.held_out import HeldOut
from bristle.identification.estimation import Estimation
from bristle.identification.settings import Settings
from bristle.simulation.result import relative_error_percent

__all__ = ["TOO_SHORT", "held_out_error"]

TOO_SHORT = Diagnostic("too-short")


def held_out_error(
    estimation: Estimation, blocks: int, settings: Settings, report: Callable[[float], None] = lambda share: None
) -> HeldOut:
    """Return the error on each of several parts of a log, fitted to all others; of several logs, on each of them.

    Parameters
    ----------
    estimation : Estimation
        What was fitted, and how it is fitted to some rows.
    blocks : int
        Parts of a single log, at least 2.
    settings : Settings
        The thresholds.
    report : callable
        Is told the share of the work done.

    Raises
    ------
    InputError
        If the log is too short for so many blocks.
    """
    name, folds = estimation.problem.parts_of(blocks, settings)
    measured, errors = estimation.problem.measured, []
    for number, fold in enumerate(folds):
        report(number / len(folds))
        predicted = measured - estimation.residual_without(fold.fitted)
        errors.append(relative_error_percent(measured[fold.held_out], predicted[fold.held_out]))
    return HeldOut(tuple(errors), float(np.mean(errors)), float(np.std(errors, ddof=1)), name)
