r"""The Preisach operator on a grid of cells, for identification from data, with a measure of either sign.

Levels divide the inputs from `low` to `high` evenly. A cell off the diagonal has a uniform density. A cell on the
diagonal has its whole measure on the line :math:`\alpha = \beta`: a spring between its two levels. The Everett function
is therefore bilinear between the levels. The parameter `E` contains the values of this function at the levels:

.. math:: E(\alpha_i, \beta_j) = \sum_{j \le l \le k < i} \mu_{kl}

The output is continuous; relays at the middle of the cells (`bristle.models.hysteresis.relay_grid`) would give a staircase.
Outside the levels the measure is zero: the output stays constant. The virgin curve of the demagnetised state is
:math:`f_0 \pm E(|u|, -|u|)`, as for a measure symmetric to :math:`\alpha = -\beta`.

References
----------
.. [1] I. D. Mayergoyz, "Mathematical Models of Hysteresis", Springer, 1991. doi:10.1007/978-1-4612-3028-1
"""

import math
from typing import Annotated, NamedTuple

import numpy as np

from bristle.core import HysteresisOperator, Relation, Variable, kernel
from bristle.core.dispatch import register
from bristle.models.hysteresis.demagnetised import virgin, virgin_slope
from bristle.models.hysteresis.preisach import CAPACITY, TOLERANCE
from bristle.models.hysteresis.turning_points import Stack, stack_commit, stack_size, stack_trial

OUTPUT_OFFSET = Variable("force", "output half-way between both saturations")


class Grid(NamedTuple):
    """A measure by cells: its Everett function at the levels."""

    low: float
    high: float
    E: np.ndarray
    offset: float


class Parameters(NamedTuple):
    """Parameters of the Preisach operator on a grid."""

    low: Annotated[float, Variable("length", "smallest input of the grid")]
    high: Annotated[float, Variable("length", "largest input of the grid")]
    E: Annotated[
        np.ndarray,
        Variable(
            "force",
            "Everett function at the levels, row after row: in row i, alpha is level i + 1 and beta is level 0 to i",
        ),
    ]
    offset: Annotated[float, OUTPUT_OFFSET] = 0.0
    capacity: Annotated[int, CAPACITY] = 256
    tolerance: Annotated[float, TOLERANCE] = 1e-12


@kernel
def cell_count(size):
    """Return the number of cells along a side for this many values of E."""
    return int(0.5 * (math.sqrt(8.0 * size + 1.0) - 1.0) + 0.5)


@kernel
def node(i, j, q):
    """Return E at the levels i and j."""
    return q.E[(i - 1) * i // 2 + j] if i > j else 0.0


@kernel
def grid_coordinate(u, n, q):
    """Return the place of an input, in cells from the lowest level; outside the grid the place of its edge."""
    return max(0.0, min((u - q.low) / (q.high - q.low), 1.0)) * n


@kernel
def value(alpha, beta, q):
    """Return E(alpha, beta) [N or N*m], alpha >= beta [m or rad]."""
    n = cell_count(q.E.size)
    at_alpha, at_beta = grid_coordinate(alpha, n, q), grid_coordinate(beta, n, q)
    i, j = min(int(at_alpha), n - 1), min(int(at_beta), n - 1)
    a, b = at_alpha - i, at_beta - j
    if i == j:
        return node(i + 1, i, q) * (a - b)
    left = node(i, j, q) + a * (node(i + 1, j, q) - node(i, j, q))
    right = node(i, j + 1, q) + a * (node(i + 1, j + 1, q) - node(i, j + 1, q))
    return left + b * (right - left)


@kernel
def slope(alpha, beta, side, q):
    """Return the derivative of E with respect to its moving end [N/m or N*m/rad]: alpha for side > 0, else -beta."""
    if (side > 0.0 and alpha > q.high) or (side <= 0.0 and beta < q.low):
        return 0.0
    n = cell_count(q.E.size)
    at_alpha, at_beta = grid_coordinate(alpha, n, q), grid_coordinate(beta, n, q)
    i, j = min(int(at_alpha), n - 1), min(int(at_beta), n - 1)
    a, b = at_alpha - i, at_beta - j
    size = (q.high - q.low) / n
    if i == j:
        return node(i + 1, i, q) / size
    if side > 0.0:
        left, right = node(i + 1, j, q) - node(i, j, q), node(i + 1, j + 1, q) - node(i, j + 1, q)
        return (left + b * (right - left)) / size
    lower, upper = node(i, j, q) - node(i, j + 1, q), node(i + 1, j, q) - node(i + 1, j + 1, q)
    return (lower + a * (upper - lower)) / size


register(
    "everett",
    Grid,
    {"value": value, "slope": slope, "virgin": virgin, "virgin_slope": virgin_slope},
)


@kernel
def measure(p):
    """Return the measure, by its Everett function."""
    return Grid(p.low, p.high, p.E, p.offset)


@kernel
def trial(state, memory, u, p):
    """Return the output [N or N*m] at the input `u` [m or rad], and the move there."""
    return stack_trial(state, memory, u, p.tolerance * (p.high - p.low), measure(p))


@kernel
def commit(state, memory, move, p):
    """Return the state after the move; a reversal stores where it turned."""
    return stack_commit(state, memory, move)


RELATIONS = (
    Relation("low < high", lambda p: p.low < p.high, "Exchange low and high", structural=True),
    Relation(
        "n (n + 1)/2 values of E for n cells along a side",
        lambda p: (
            len(p.E) >= 1 and cell_count(len(p.E)) * (cell_count(len(p.E)) + 1) == 2 * len(p.E)
        ),
        "Give each row of E one more value than the row before",
        structural=True,
    ),
)

MODEL = preisach_grid = HysteresisOperator(
    name="preisach_grid",
    description="Preisach operator from a measure of either sign in each cell of a grid",
    Parameters=Parameters,
    State=Stack,
    trial=trial,
    commit=commit,
    memory_size=lambda p: stack_size(p.capacity),
    measure=measure,
    relations=RELATIONS,
    reference="doi:10.1007/978-1-4612-3028-1",
    example={"low": -1e-5, "high": 1e-5, "E": [3.0, 4.0, 2.0, 6.0, 5.0, 3.0]},
)
