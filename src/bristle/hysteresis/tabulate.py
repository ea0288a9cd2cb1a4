r"""Tables of an Everett function: from the function itself, or from measured reversal curves.

With the output :math:`f_\alpha` where the ascending branch turned at :math:`\alpha`, and :math:`f_{\alpha\beta}` when
the input has come back to :math:`\beta`, the Everett function is
:math:`E(\alpha, \beta) = \tfrac12(f_\alpha - f_{\alpha\beta})`.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from bristle.core.contracts import Model
from bristle.core.edge import CURVE, FUNCTION, KIND, Amount, amount, guarded, many, whole
from bristle.core.errors import InputError
from bristle.core.variable import Kind, Variable
from bristle.hysteresis.everett_table import MODEL

NODES = 101


SIZES = {"rows": whole(3, 10_000), "columns": whole(3, 10_000), "kind": KIND}


@guarded(everett=FUNCTION, extent=amount(Variable("length", "largest input", min=0.0), exclusive=True), **SIZES)
def tabulated(
    everett: Callable[[float, float], float],
    extent: Amount,
    *,
    rows: int = NODES,
    columns: int = NODES,
    kind: Kind = "translational",
    **settings: Any,
) -> Model:
    """Return the operator whose Everett function is `everett`, tabulated.

    Parameters
    ----------
    everett : callable
        E(alpha, beta) [N or N*m] for -extent <= beta <= alpha <= extent [m or rad]; 0 at alpha = beta.
    extent : float
        Largest input that the table covers [m or rad].
    rows, columns : int
        Number of nodes along alpha + beta, odd, and along alpha - beta.
    kind : {"translational", "rotational"}
        The kind of axis.
    **settings
        ``capacity`` and ``tolerance`` of the operator.

    Returns
    -------
    Model
        An `everett_table` operator.

    Examples
    --------
    >>> from bristle import response
    >>> magnet = tabulated(lambda alpha, beta: 0.25 * (alpha - beta) ** 2, 1.0)
    >>> response(magnet, [1.0, 0.0, -1.0]).round(3)
    array([ 1. ,  0.5, -1. ])
    """
    nodes = _nodes(extent, rows, columns)
    table = np.zeros((rows, columns))
    for at in np.ndindex(rows, columns):
        table[at] = everett(float(nodes.alpha[at]), float(nodes.beta[at])) if at[1] else 0.0
    return _operator(nodes, table, kind, settings)


@guarded(curves=many(CURVE, least=2), **SIZES)
def from_reversal_curves(
    curves: Sequence[tuple[Any, Any]], *, rows: int = NODES, columns: int = NODES, kind: Kind = "translational", **settings: Any
) -> Model:
    """Return the operator that has these descending first-order reversal curves.

    Parameters
    ----------
    curves : sequence of (u, f)
        Each curve begins where the ascending major branch turned and descends to the same smallest input, all within
        the same range, symmetric to 0: input [m or rad] and output [N or N*m], both of shape (sample,).
    rows, columns : int
        Number of nodes along alpha + beta, odd, and along alpha - beta.
    kind : {"translational", "rotational"}
        The kind of axis.
    **settings
        ``capacity`` and ``tolerance`` of the operator.

    Returns
    -------
    Model
        An `everett_table` operator.

    Raises
    ------
    InputError
        If there are fewer than two curves, or one does not descend.
    """
    read = sorted((_curve(u, f, index) for index, (u, f) in enumerate(curves)), key=lambda curve: curve[0])
    alphas = np.array([alpha for alpha, _, _ in read])
    extent = max(float(alphas[-1]), *(float(drop[-1] - alpha) for alpha, drop, _ in read))
    nodes = _nodes(extent, rows, columns)
    drops, table = nodes.alpha - nodes.beta, np.zeros((rows, columns))
    following = np.clip(np.searchsorted(alphas, nodes.alpha), 1, alphas.size - 1)
    for right in range(1, alphas.size):
        # Between curves at the same drop: there E is smooth, and zero where the drop is.
        at = following == right
        low, high = (np.interp(drops[at], drop, E) for _, drop, E in read[right - 1 : right + 1])
        share = np.clip((nodes.alpha[at] - alphas[right - 1]) / (alphas[right] - alphas[right - 1]), 0.0, 1.0)
        table[at] = low + share * (high - low)
    return _operator(nodes, table, kind, settings)


class _Nodes(NamedTuple):
    """Inputs [m or rad] at the nodes of a table, of shape (rows, columns), and their distances by column."""

    extent: float
    alpha: np.ndarray
    beta: np.ndarray
    d: np.ndarray


def _nodes(extent: float, rows: int, columns: int) -> _Nodes:
    if rows % 2 == 0:
        raise InputError("must be odd", path="rows", value=rows, allowed="odd, >= 3", mend=f"Take {rows + 1}")
    d = 2.0 * extent * np.linspace(0.0, 1.0, columns) ** 2
    c = np.linspace(-1.0, 1.0, rows)[:, None] * (2.0 * extent - d)
    return _Nodes(extent, 0.5 * (c + d), 0.5 * (c - d), d)


def _operator(nodes: _Nodes, table: np.ndarray, kind: Kind, settings: dict[str, Any]) -> Model:
    return MODEL(kind=kind, extent=nodes.extent, E=table.ravel(), upper=_upper(table, nodes.d), **settings)


def _curve(u: Any, f: Any, index: int) -> tuple[float, np.ndarray, np.ndarray]:
    """Return where a curve turned, how far it has come down, and E there."""
    path, output = np.asarray(u, dtype=float), np.asarray(f, dtype=float)
    if path.ndim != 1 or path.shape != output.shape or path.size < 2 or not np.all(np.diff(path) < 0.0):
        raise InputError("must descend: inputs that fall, each with its output", path=f"curves[{index}]", mend="Sort by input")
    return float(path[0]), path[0] - path, 0.5 * (output[0] - output)


def _upper(table: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Return the integral of the measure above alpha = -beta: that of the derivative of E by alpha along the line."""
    middle, rows = table.shape[0] // 2, table.shape[0]
    span = d[-1] - d[:-1]
    across = (table[middle + 1] - table[middle - 1])[:-1] * (rows - 1) / (4.0 * span)
    across = np.append(across, across[-1])
    return 0.5 * (table[middle] + np.concatenate([[0.0], np.cumsum(0.5 * (across[1:] + across[:-1]) * np.diff(d))]))
