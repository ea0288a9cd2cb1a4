r"""The Preisach operator with a tabulated Everett function, for measured hysteresis of any sign.

The table is over :math:`c = \alpha + \beta` and :math:`d = \alpha - \beta`, and linear between its nodes. :math:`d` is
spaced quadratically, :math:`c` evenly over its range :math:`\pm(2X - d)`. A table of the same size over
:math:`(\alpha, \beta)` would have an error of nearly 2 % of saturation, because the kink at :math:`\alpha = \beta`
crosses its cells. In this table the kink is an edge, and the error is 2e-4 of saturation at 101 by 101 nodes.

Outside :math:`[-X, X]` the measure is zero: the output stays constant. Inside, the demagnetised operator follows the
measure above the line :math:`\alpha = -\beta`. The integral of this measure is the parameter `upper`, which the
constructors in `bristle.models.hysteresis.tabulate` compute. The measure may therefore have any sign and need not be
symmetric.
"""

import math
from typing import Annotated, NamedTuple

import numpy as np

from bristle.core import HysteresisOperator, Relation, Variable, kernel
from bristle.core.dispatch import register
from bristle.models.hysteresis.preisach import CAPACITY, TOLERANCE
from bristle.models.hysteresis.turning_points import Stack, stack_commit, stack_size, stack_trial


class Surface(NamedTuple):
    """A measure by a table of its Everett function."""

    extent: float
    E: np.ndarray
    upper: np.ndarray


class Parameters(NamedTuple):
    """Parameters of the Preisach operator with a tabulated Everett function."""

    extent: Annotated[
        float, Variable("length", "largest input X that the table covers", min=1e-12, nominal=1e-5)
    ]
    E: Annotated[
        np.ndarray,
        Variable(
            "force",
            "Everett function, row after row, with c = alpha + beta, d = alpha - beta: c/(2X - d) from -1 to 1 over the rows, "
            "d = 2X (j/n)^2 along each row",
        ),
    ]
    upper: Annotated[
        np.ndarray, Variable("force", "integral of the measure above alpha = -beta, for each d")
    ]
    capacity: Annotated[int, CAPACITY] = 256
    tolerance: Annotated[float, TOLERANCE] = 1e-12


class Cell(NamedTuple):
    """Place of a point in the table: the lower corner of its cell, its place in the cell, the size of the cell there."""

    i: int
    j: int
    along_c: float
    along_d: float
    size_c: float
    size_d: float
    lean: float  # c over 2X - d: change of the place along c with d


@kernel
def cell_of(alpha, beta, q):
    """Return the cell of the table that contains (alpha, beta), both inside [-X, X]."""
    columns = q.upper.size
    rows = q.E.size // columns
    n = columns - 1
    wide = 2.0 * q.extent
    d = alpha - beta
    j = min(int(n * math.sqrt(d / wide)), n - 1)
    low, high = wide * (j / n) * (j / n), wide * ((j + 1) / n) * ((j + 1) / n)
    # At d = 2X all rows meet in one point.
    span = max(wide - d, 1e-12 * wide)
    lean = max(-1.0, min((alpha + beta) / span, 1.0))
    r = 0.5 * (lean + 1.0) * (rows - 1)
    i = min(int(r), rows - 2)
    return Cell(i, j, r - i, (d - low) / (high - low), 2.0 * span / (rows - 1), high - low, lean)


@kernel
def value(alpha, beta, q):
    """Return E(alpha, beta) [N or N*m] from the table, alpha >= beta [m or rad]."""
    high, low = max(-q.extent, min(alpha, q.extent)), max(-q.extent, min(beta, q.extent))
    cell = cell_of(high, low, q)
    at = cell.i * q.upper.size + cell.j
    past = at + q.upper.size
    first = q.E[at] + cell.along_d * (q.E[at + 1] - q.E[at])
    second = q.E[past] + cell.along_d * (q.E[past + 1] - q.E[past])
    return first + cell.along_c * (second - first)


@kernel
def slope(alpha, beta, side, q):
    """Return the derivative of E with respect to its moving end [N/m or N*m/rad]: alpha for side > 0, else -beta."""
    if side > 0.0 and alpha > q.extent:
        return 0.0
    if side <= 0.0 and beta < -q.extent:
        return 0.0
    high, low = max(-q.extent, min(alpha, q.extent)), max(-q.extent, min(beta, q.extent))
    cell = cell_of(high, low, q)
    at = cell.i * q.upper.size + cell.j
    past = at + q.upper.size
    first, second = q.E[at + 1] - q.E[at], q.E[past + 1] - q.E[past]
    across, further = q.E[past] - q.E[at], q.E[past + 1] - q.E[at + 1]
    by_c = (across + cell.along_d * (further - across)) / cell.size_c
    by_d = (first + cell.along_c * (second - first)) / cell.size_d + cell.lean * by_c
    return by_d + by_c if side > 0.0 else by_d - by_c


@kernel
def above(d, q):
    """Return the measure of the triangle between -d/2 and d/2 that lies above alpha = -beta."""
    cell = cell_of(0.5 * d, -0.5 * d, q)
    return q.upper[cell.j] + cell.along_d * (q.upper[cell.j + 1] - q.upper[cell.j])


@kernel
def virgin(u, q):
    """Return the output [N or N*m] at the first input `u` [m or rad] of a demagnetised operator."""
    z = max(-q.extent, min(u, q.extent))
    saturation = value(q.extent, -q.extent, q)
    remanent = saturation - 2.0 * above(2.0 * q.extent, q)
    if z > 0.0:
        return remanent + 2.0 * above(2.0 * z, q)
    return remanent - 2.0 * (value(-z, z, q) - above(-2.0 * z, q))


@kernel
def virgin_slope(u, q):
    """Return the derivative of `virgin` [N/m or N*m/rad]."""
    z = abs(u)
    if z > q.extent:
        return 0.0
    cell = cell_of(z, -z, q)
    part = 4.0 * (q.upper[cell.j + 1] - q.upper[cell.j]) / cell.size_d
    if u > 0.0:
        return part
    return 2.0 * (slope(z, -z, 1.0, q) + slope(z, -z, -1.0, q)) - part


register(
    "everett",
    Surface,
    {"value": value, "slope": slope, "virgin": virgin, "virgin_slope": virgin_slope},
)


@kernel
def measure(p):
    """Return the measure, by its Everett function."""
    return Surface(p.extent, p.E, p.upper)


@kernel
def trial(state, memory, u, p):
    """Return the output [N or N*m] at the input `u` [m or rad], and the move there."""
    return stack_trial(state, memory, u, p.tolerance * p.extent, measure(p))


@kernel
def commit(state, memory, move, p):
    """Return the state after the move; a reversal stores where it turned."""
    return stack_commit(state, memory, move)


RELATIONS = (
    Relation(
        "E with an odd number of rows (at least 3), each as long as upper (at least 3)",
        lambda p: (
            len(p.upper) >= 3
            and len(p.E) % len(p.upper) == 0
            and len(p.E) // len(p.upper) % 2 == 1
            and len(p.E) >= 3 * len(p.upper)
        ),
        "Build the table with bristle.models.hysteresis.tabulated or from_reversal_curves",
    ),
    Relation(
        "E = 0 at alpha = beta",
        lambda p: not np.any(p.E[:: len(p.upper)]),
        "Set the first column of E to zero: its triangles have no area",
    ),
)

MODEL = everett_table = HysteresisOperator(
    name="everett_table",
    description="Preisach operator, computed from turning points, with an Everett function tabulated from data",
    Parameters=Parameters,
    State=Stack,
    trial=trial,
    commit=commit,
    memory_size=lambda p: stack_size(p.capacity),
    measure=measure,
    relations=RELATIONS,
    reference="doi:10.1007/978-1-4612-3028-1",
    example={
        "extent": 1e-5,
        "E": [0.0, 6.0, 10.0, 0.0, 6.0, 10.0, 0.0, 6.0, 10.0],
        "upper": [0.0, 3.0, 5.0],
    },
)
