"""Error on time blocks that were not fitted: how models with different numbers of parameters are compared."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from bristle.core.errors import InputError
from bristle.identification.problem import Problem
from bristle.identification.result import HeldOut
from bristle.identification.solution import Solution
from bristle.simulation.result import relative_error_percent

__all__ = ["held_out_error"]

ROWS_PER_BLOCK = 20


def held_out_error(
    problem: Problem, solve: Callable[[np.ndarray], Solution], blocks: int,
    report: Callable[[float], None] = lambda share: None,
) -> HeldOut:  # fmt: skip
    """Return the error on each of several contiguous blocks, fitted to all others.

    Parameters
    ----------
    problem : Problem
        The problem.
    solve : callable
        Returns the solution on some rows, given as an array of bool.
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
    count, reach = problem.regression.effort.size, problem.regression.reach
    if count < blocks * (ROWS_PER_BLOCK + 2 * reach):
        raise InputError(
            "are too many for this log", path="blocks", value=blocks,
            allowed=f"2 to {max(count // (ROWS_PER_BLOCK + 2 * reach), 2)}, or 0 for no comparison on held-out blocks",
        )  # fmt: skip
    edges = np.linspace(0, count, blocks + 1).astype(int)
    errors = []
    for number, (first, last) in enumerate(pairwise(edges.tolist())):
        report(number / blocks)
        fitted = np.ones(count, dtype=bool)
        fitted[max(first - reach, 0) : last + reach] = False
        values = problem.unknowns.complete(solve(fitted).values)
        block = slice(first, last)
        errors.append(relative_error_percent(problem.regression.effort[block], problem.predicted(values)[block]))
    spread = float(np.std(errors, ddof=1)) if blocks > 1 else 0.0
    return HeldOut(tuple(errors), float(np.mean(errors)), spread)
