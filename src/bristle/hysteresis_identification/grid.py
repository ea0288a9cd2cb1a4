r"""The Preisach measure on a grid of cells, from data, by least squares with a sign for each cell.

On the diagonal the measure is a spring and positive. Off it, a magnet has a positive measure and friction a negative
one: relays that all add up the same way cannot give a force that opposes every reversal. The textbook condition
:math:`\mu \ge 0` everywhere fits a friction no better than a spring would. Neither sign is assumed here: both are
fitted, and the data choose.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.hysteresis import preisach_grid
from bristle.hysteresis_identification.trace import Rows, outputs_of, stacked, trace_of
from bristle.hysteresis_identification.weights import NormalEquations
from bristle.logs.curves import Curves

__all__ = ["SIGNS", "GridFit", "fit_grid"]

SIGNS = ("magnet", "friction", "textbook")
CELLS = 30
ROWS_MOST = 10_000  # of a regressor: beyond, samples are left out evenly


class GridFit(NamedTuple):
    """A Preisach operator from data: the sign off the diagonal, and the share of cells that no curve crosses."""

    operator: Model
    sign: str
    rms: float
    unseen: float


def fit_grid(recorded: Curves, *, cells: int = CELLS, sign: str | None = None, rows: Rows = None) -> GridFit:
    """Fit the measure of each cell of a grid to recorded hysteresis.

    Parameters
    ----------
    recorded : Curves
        Input and output.
    cells : int
        Number of cells L along a side of the grid, L (L + 1)/2 in all.
    sign : {"magnet", "friction", "textbook"}, optional
        Sign of the measure off the diagonal; ``textbook`` holds the diagonal for relays of the middle of its cells as
        well, not for springs. Magnet or friction, whatever fits better, where not given.
    rows : sequence of ndarray, optional
        Which samples of each curve are fitted; all of them where not given.

    Raises
    ------
    InputError
        If the input does not move, or there is no such sign.
    """
    if cells != int(cells) or not 2 <= cells <= 100:
        raise InputError("must be a whole number", path="cells", value=cells, allowed="2 to 100")
    if sign is not None and sign not in SIGNS:
        raise InputError("no such sign", path="sign", value=sign, allowed=", ".join(SIGNS))
    low, high = _range_of(recorded)
    features = _Cells(low, high, int(cells), relays=sign == "textbook")
    traces = [trace_of(curve.u, recorded.history(curve)) for curve in recorded.curves]
    thinned = _thinned([np.arange(curve.u.size) for curve in recorded.curves] if rows is None else rows)
    equations = NormalEquations.of(stacked(traces, features, thinned), outputs_of(recorded, thinned))
    tried = {name: equations.solve(features.signs(name)) for name in ((sign,) if sign else ("magnet", "friction"))}
    chosen = min(tried, key=lambda name: tried[name].rms)
    best = tried[chosen]
    operator = preisach_grid(kind=recorded.kind, low=low, high=high, E=features.everett(best.weights), offset=best.offset)
    return GridFit(operator, chosen, best.rms, float(np.mean(equations.scale == 0.0)))


def _thinned(rows: Sequence[np.ndarray]) -> list[np.ndarray]:
    step = max(sum(part.size for part in rows) // ROWS_MOST, 1)
    return [part[::step] for part in rows]


def _range_of(recorded: Curves) -> tuple[float, float]:
    low, high = recorded.low, recorded.high
    if recorded.start == "virgin":
        low, high = min(low, -high), max(high, -low)
    if not high > low:
        raise InputError("does not move", path="input", value=high)
    return low, high


class _Cells:
    """The cells of a grid, as functions of (alpha, beta)."""

    def __init__(self, low: float, high: float, count: int, *, relays: bool) -> None:
        self.low, self.high, self.count, self.relays = low, high, count, relays
        self.i, self.j = np.tril_indices(count)
        self.diagonal = np.flatnonzero(self.i == self.j)

    def __call__(self, alpha: np.ndarray, beta: np.ndarray) -> np.ndarray:
        """Return the share of each cell that lies in the triangle of (alpha, beta), shape (sample, cell)."""
        cell = np.arange(self.count)
        size = (self.high - self.low) / self.count
        a = np.clip((alpha[:, None] - self.low) / size - cell, 0.0, 1.0)
        b = np.clip(cell + 1.0 - (beta[:, None] - self.low) / size, 0.0, 1.0)
        shares = a[:, self.i] * b[:, self.j]
        inside = np.maximum(a + b - 1.0, 0.0)
        shares[:, self.diagonal] = inside**2 if self.relays else inside
        return shares

    def signs(self, name: str) -> np.ndarray:
        """Return the sign of each cell: positive on the diagonal, negative off it for friction."""
        signs = np.ones(self.i.size)
        if name == "friction":
            signs[self.i != self.j] = -1.0
        return signs

    def everett(self, weights: np.ndarray) -> np.ndarray:
        """Return the Everett function at the levels, in the order of `preisach_grid`."""
        mass = np.zeros((self.count, self.count))
        mass[self.i, self.j] = weights
        # The triangle of (i + 1, j) holds the cells of rows up to i and columns from j on.
        summed = np.cumsum(np.cumsum(mass, axis=0)[:, ::-1], axis=1)[:, ::-1]
        return summed[self.i, self.j]
