"""A table along measured first-order reversal curves: what a `reversal_table` operator is made of."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from bristle.core.contracts import Model
from bristle.core.edge import CURVE, among, guarded, many, whole
from bristle.core.errors import InputError
from bristle.core.variable import KINDS, Kind
from bristle.hysteresis.reversal_table import MODEL, Curves

COLUMNS = 257
REVERSAL_TOLERANCE = 1e-9  # of the range of inputs: two reversals that are one


class Curve(NamedTuple):
    """A reversal curve, mirrored if need be so that it rises."""

    u: np.ndarray
    f: np.ndarray


@guarded(curves=many(CURVE, least=2), columns=whole(2, 10**5), kind=among(*KINDS, "magnetic", "piezo"))
def table_of_curves(curves: Sequence[tuple[Any, Any]], *, columns: int = COLUMNS, kind: Kind = "translational", **settings: Any) -> Model:
    """Return the operator that has these first-order reversal curves.

    Every curve comes from saturation on the side that it returns to: the major branch is what the first samples of all
    curves lie on. The largest input of all is taken for saturation. Nothing is assumed of the sign of the measure.

    Parameters
    ----------
    curves : sequence of (u, f)
        Input [m, rad or T] and output [N, N*m or A*m^2] of each curve, shape (sample,), from its reversal on; all
        rise or all fall.
    columns : int
        Number of nodes along each curve.
    kind : {"translational", "rotational", "magnetic", "piezo"}
        What the units are.
    **settings
        ``capacity`` and ``tolerance`` of the operator.

    Returns
    -------
    Model
        A `reversal_table` operator; the output that it has along each curve is that of the data.

    Raises
    ------
    InputError
        If there are fewer than two curves, one is not monotone, or some rise and some fall.
    """
    side = _side(curves[0])
    read = sorted((_curve(u, f, side, index) for index, (u, f) in enumerate(curves)), key=lambda curve: curve.u[0])
    last = max(read, key=lambda curve: curve.u[-1])
    top, saturation = float(last.u[-1]), float(last.f[-1])
    distinct = _apart([curve for curve in read if curve.u[0] < top], REVERSAL_TOLERANCE * (top - read[0].u[0]))
    share = np.linspace(0.0, 1.0, columns)
    rows = [0.5 * (np.interp(curve.u[0] + share * np.ptp(curve.u), curve.u, curve.f) - curve.f[0]) for curve in distinct]
    table = Curves(
        reversals=np.array([*(curve.u[0] for curve in distinct), top]),
        ends=np.array([*(curve.u[-1] for curve in distinct), top]),
        E=np.concatenate([*rows, np.zeros(columns)]),
        E_top=np.array([*(0.5 * (saturation - curve.f[0]) for curve in distinct), 0.0]),
        side=side,
        offset=0.0,
    )
    return MODEL(kind=kind, **table._asdict() | {"offset": side * (saturation - float(table.E_top[0]))}, **settings)


def _side(curve: tuple[Any, Any]) -> float:
    path = np.asarray(curve[0], dtype=float)
    return -1.0 if path.size > 1 and path[-1] < path[0] else 1.0


def _curve(u: Any, f: Any, side: float, index: int) -> Curve:
    path, output = side * np.asarray(u, dtype=float), side * np.asarray(f, dtype=float)
    if path.ndim != 1 or path.shape != output.shape or path.size < 2 or not np.all(np.diff(path) > 0.0):
        way, mend = "rise" if side > 0.0 else "fall", "Begin each curve at its reversal; leave out curves of one sample"
        raise InputError(f"must {way} throughout, as the first one does", path=f"curves[{index}]", mend=mend)
    return Curve(path, output)


def _apart(curves: list[Curve], least: float) -> list[Curve]:
    """Return the curves without those that turned where another one did."""
    distinct: list[Curve] = []
    for curve in curves:
        if not distinct or curve.u[0] - distinct[-1].u[0] > least:
            distinct.append(curve)
    if len(distinct) < 2:
        raise InputError("needs curves that turned at different inputs", path="curves", value=len(curves))
    return distinct
