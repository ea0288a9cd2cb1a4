"""What the number of measured branches brings, in words, numbers and a table."""

from __future__ import annotations

from typing import Any

import numpy as np

from bristle.core.typography import number
from bristle.paper.economy import WAYS, Economy
from bristle.paper.reproduced import Verdict, spread
from bristle.report.table import Table

__all__ = ["CAPTION", "numbers", "sentences", "table", "verdict"]

CAPTION = (
    "Error on motions that were not measured, over the number of branches measured",
    "Error on random motions that were not measured, of models made from more and more measured branches: the mean "
    "over seeds, and the range. Dotted: what a model that knew the mean of the rig would leave, because the rig does "
    "not repeat itself.",
)
AS_GOOD = 1.5  # ratio of errors up to which two numbers from few loops replace a surface from many


def _means(cost: Economy) -> dict[str, np.ndarray]:
    return {name: errors.mean(axis=1) for name, errors in cost.errors.items()}


def verdict(cost: Economy) -> Verdict:
    """Return whether the reformed Dahl model from the fewest branches does about as well as the surface from the most.

    In part, where an operator fitted to the same few branches does better.
    """
    means = _means(cost)
    few, many = float(means["reformed Dahl"][0]), float(means["tabulated surface"][-1])
    if few > AS_GOOD * many:
        return "refuted"
    return "found in part" if float(means["Prandtl-Ishlinskii"][0]) < few else "found"


def sentences(cost: Economy, still: Economy) -> list[str]:
    """Return in words what measuring more brings."""
    return [
        f"On motions that were not measured: {_both_ends(cost)}. A branch takes {number(cost.duration, digits=2)} s.",
        *_pairwise(cost),
        f"The scatter of the rig alone is {number(cost.floor, digits=2)} %; no model of it does better.",
        f"On a rig that repeated itself exactly: {_both_ends(still)}.",
    ]


def _pairwise(cost: Economy) -> list[str]:
    """Return in words how often the second way is nearer than the first, from the same records of fewest branches."""
    first, second = list(WAYS)[:2]
    gained = cost.errors[first][0] - cost.errors[second][0]
    if gained.size < 2:
        return []
    return [
        f"From the same {'branch' if cost.counts[0] == 1 else 'branches'}, {second} is nearer than {first} in "
        f"{np.count_nonzero(gained > 0.0)} of {gained.size} repetitions, by {spread(gained)} %."
    ]


def _both_ends(cost: Economy) -> str:
    """Return the errors from the fewest branches and from the most, in words."""
    ends = [0] if len(cost.counts) == 1 else [0, -1]
    ends_listed = [(cost.counts[row], _listed(cost, row)) for row in ends]
    return "; ".join(f"from {count} branch{'es' if count > 1 else ''} {listed}" for count, listed in ends_listed)


def _listed(cost: Economy, row: int) -> str:
    complete = {name: errors[row] for name, errors in cost.errors.items() if np.all(np.isfinite(errors[row]))}
    return ", ".join(f"{name} {_error_text(errors, 2)} %" for name, errors in complete.items())


def _error_text(errors: np.ndarray, digits: int) -> str:
    """Return errors over seeds as text: the mean and its spread, or the mean alone to so many digits."""
    return spread(errors) if errors.size > 1 else number(float(errors[0]), digits=digits)


def numbers(cost: Economy, still: Economy) -> dict[str, Any]:
    """Return the errors [%] for the summary, by the way to the model, in the order of the branches."""
    return {
        "branches": cost.counts,
        "error_percent": _means(cost),
        "error_deviation_percent": {name: _deviation(errors) for name, errors in cost.errors.items()},
        "error_percent_without_scatter": _means(still),
        "scatter_percent": cost.floor,
    }


def _deviation(errors: np.ndarray) -> np.ndarray:
    """Return the standard deviation over seeds, by the number of branches; nothing from a single one."""
    return np.std(errors, axis=1, ddof=1) if errors.shape[1] > 1 else np.zeros(errors.shape[0])


def table(cost: Economy, still: Economy) -> Table:
    """Return the errors side by side."""
    columns = [economy.errors[name] for economy in (cost, still) for name in WAYS]
    rows = [(str(count), *(spread(column[row], 0.1) for column in columns)) for row, count in enumerate(cost.counts)]
    heads = ("Branches", *WAYS, *(f"{name}, no scatter" for name in WAYS))
    caption = "Error on motions that were not measured [%], of the largest torque; mean and standard deviation over seeds"
    return Table(caption, heads, rows)
