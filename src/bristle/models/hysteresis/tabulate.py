r"""Tables of an Everett function: from a function, or from measured reversal curves.

With the output :math:`f_\alpha` at the turn of the ascending branch at :math:`\alpha`, and :math:`f_{\alpha\beta}` when
the input has returned to :math:`\beta`, the Everett function is
:math:`E(\alpha, \beta) = \tfrac12(f_\alpha - f_{\alpha\beta})`.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from bristle.core import InputError, Model
from bristle.core.edge import CURVE, KIND, Amount, among, amount, guarded, many, whole
from bristle.core.variable import KINDS, Kind, Variable
from bristle.models.hysteresis.everett_table import MODEL
from bristle.models.hysteresis.reversal_table import MODEL as REVERSAL_TABLE, Curves

NODES = 101


SIZES = {"rows": whole(3, 10_000), "columns": whole(3, 10_000), "kind": KIND}


@guarded(extent=amount(Variable("length", "largest input", min=0.0), exclusive=True), **SIZES)
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
    (alpha, beta, d), table = _nodes(extent, rows, columns), np.zeros((rows, columns))
    for at in np.ndindex(rows, columns):
        table[at] = _value_of(everett, float(alpha[at]), float(beta[at])) if at[1] else 0.0
    return MODEL(kind=kind, extent=extent, E=table.ravel(), upper=_upper(table, d), **settings)


def _value_of(everett: Callable[[float, float], float], alpha: float, beta: float) -> float:
    try:
        value = float(everett(alpha, beta))
    except (TypeError, ValueError) as error:
        raise InputError(
            f"must return a number for alpha and beta ({error})", path="everett"
        ) from None
    if not math.isfinite(value):
        raise InputError(
            "returns no finite number",
            path="everett",
            value=f"{value} for alpha = {alpha:g} and beta = {beta:g}",
        )
    return value


@guarded(curves=many(CURVE, least=2), **SIZES)
def from_reversal_curves(
    curves: Sequence[tuple[Any, Any]],
    *,
    rows: int = NODES,
    columns: int = NODES,
    kind: Kind = "translational",
    **settings: Any,
) -> Model:
    """Return the operator with these descending first-order reversal curves.

    Parameters
    ----------
    curves : sequence of (u, f)
        Each curve begins at its turn on the ascending major branch and descends to the smallest input, which all curves
        share, within a range symmetric to 0: input [m or rad] and output [N or N*m], both of shape (sample,).
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
        If there are fewer than two curves, or a curve does not descend.
    """
    # Each mirrored curve rises; sorted by the turn.
    read = sorted(
        (_curve(u, f, -1.0, index) for index, (u, f) in enumerate(curves)),
        key=lambda curve: -curve.u[0],
    )
    alphas = np.array([-curve.u[0] for curve in read])
    if np.any(np.diff(alphas) <= 0.0):
        raise InputError(
            "contains two curves from the same turn", path="curves", value=f"{alphas.tolist()}"
        )
    extent = max(float(alphas[-1]), *(float(curve.u[-1]) for curve in read))
    (alpha, beta, d), table = _nodes(extent, rows, columns), np.zeros((rows, columns))
    drops, following = alpha - beta, np.clip(np.searchsorted(alphas, alpha), 1, alphas.size - 1)
    for right in range(1, alphas.size):
        # Between curves at the same drop: there E is smooth, and zero at zero drop.
        at = following == right
        low, high = (
            np.interp(drops[at], u - u[0], 0.5 * (f - f[0])) for u, f in read[right - 1 : right + 1]
        )
        share = np.clip(
            (alpha[at] - alphas[right - 1]) / (alphas[right] - alphas[right - 1]), 0.0, 1.0
        )
        table[at] = low + share * (high - low)
    return MODEL(kind=kind, extent=extent, E=table.ravel(), upper=_upper(table, d), **settings)


def _nodes(extent: float, rows: int, columns: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return inputs [m or rad] at the nodes of a table, alpha and beta of shape (rows, columns), and their distances by column."""
    if rows % 2 == 0:
        raise InputError(
            "must be odd", path="rows", value=rows, allowed="odd, >= 3", mend=f"Take {rows + 1}"
        )
    d = 2.0 * extent * np.linspace(0.0, 1.0, columns) ** 2
    c = np.linspace(-1.0, 1.0, rows)[:, None] * (2.0 * extent - d)
    return 0.5 * (c + d), 0.5 * (c - d), d


def _upper(table: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Return the integral of the measure above alpha = -beta: that of the derivative of E by alpha along the line."""
    middle, rows = table.shape[0] // 2, table.shape[0]
    span = d[-1] - d[:-1]
    across = (table[middle + 1] - table[middle - 1])[:-1] * (rows - 1) / (4.0 * span)
    across = np.append(across, across[-1])
    return 0.5 * (
        table[middle]
        + np.concatenate([[0.0], np.cumsum(0.5 * (across[1:] + across[:-1]) * np.diff(d))])
    )


COLUMNS = 257


class Curve(NamedTuple):
    """A reversal curve, mirrored if necessary so that it rises."""

    u: np.ndarray
    f: np.ndarray


@guarded(
    curves=many(CURVE, least=2), columns=whole(2, 10**5), kind=among(*KINDS, "magnetic", "piezo")
)
def table_of_curves(
    curves: Sequence[tuple[Any, Any]],
    *,
    columns: int = COLUMNS,
    kind: Kind = "translational",
    **settings: Any,
) -> Model:
    """Return the operator with these first-order reversal curves.

    Every curve comes from saturation on the side to which it returns: the first samples of all curves are on the major
    branch. The largest input of all counts as saturation. The measure may have any sign.

    Parameters
    ----------
    curves : sequence of (u, f)
        Input [m, rad or T] and output [N, N*m or A*m^2] of each curve, shape (sample,), from its reversal on; all
        rise or all fall.
    columns : int
        Number of nodes along each curve.
    kind : {"translational", "rotational", "magnetic", "piezo"}
        Quantities of input and output.
    **settings
        ``capacity`` and ``tolerance`` of the operator.

    Returns
    -------
    Model
        A `reversal_table` operator; its output along each curve equals the data.

    Raises
    ------
    InputError
        If there are fewer than two curves, a curve is not monotone, or some rise and some fall.
    """
    first = np.asarray(curves[0][0], dtype=float)
    side = -1.0 if first.size > 1 and first[-1] < first[0] else 1.0
    read = sorted(
        (_curve(u, f, side, index) for index, (u, f) in enumerate(curves)),
        key=lambda curve: curve.u[0],
    )
    last = max(read, key=lambda curve: curve.u[-1])
    top, saturation = float(last.u[-1]), float(last.f[-1])
    # Two reversals closer than this share of the range of inputs are the same.
    distinct = _apart([curve for curve in read if curve.u[0] < top], 1e-9 * (top - read[0].u[0]))
    share = np.linspace(0.0, 1.0, columns)
    rows = [
        0.5 * (np.interp(curve.u[0] + share * np.ptp(curve.u), curve.u, curve.f) - curve.f[0])
        for curve in distinct
    ]
    E_top = np.array([*(0.5 * (saturation - curve.f[0]) for curve in distinct), 0.0])
    table = Curves(
        reversals=np.array([*(curve.u[0] for curve in distinct), top]),
        ends=np.array([*(curve.u[-1] for curve in distinct), top]),
        E=np.concatenate([*rows, np.zeros(columns)]),
        E_top=E_top,
        side=side,
        offset=side * (saturation - float(E_top[0])),
    )
    return REVERSAL_TABLE(kind=kind, **table._asdict(), **settings)


def _curve(u: Any, f: Any, side: float, index: int) -> Curve:
    path, output = side * np.asarray(u, dtype=float), side * np.asarray(f, dtype=float)
    if (
        path.ndim != 1
        or path.shape != output.shape
        or path.size < 2
        or not np.all(np.diff(path) > 0.0)
    ):
        way = "rise" if side > 0.0 else "fall"
        raise InputError(
            f"must {way} throughout, and so must every other curve",
            path=f"curves[{index}]",
            mend="Begin each curve at its reversal, and remove curves of one sample",
        )
    return Curve(path, output)


def _apart(curves: list[Curve], least: float) -> list[Curve]:
    """Return the curves without repeated reversals."""
    distinct: list[Curve] = []
    for curve in curves:
        if not distinct or curve.u[0] - distinct[-1].u[0] > least:
            distinct.append(curve)
    if len(distinct) < 2:
        raise InputError(
            "must contain at least two curves that start at different inputs",
            path="curves",
            value=len(curves),
        )
    return distinct
