r"""The Preisach operator by brute force: every relay of a grid is evaluated.

.. math:: f = \sum_{i \ge j} \mu_{ij}\,\gamma_{ij}[u]

This sum is the definition of the operator, equation (12) of the source paper. The sum is the reference for the
operators that use turning points: if the extremes of the input are levels of the grid, sum and operator agree to
rounding. Between the levels the output is a staircase. The computing time grows with the square of the number of
levels. With turning points the time does not depend on this number.

References
----------
.. [1] I. D. Mayergoyz, "Mathematical Models of Hysteresis", Springer, 1991. doi:10.1007/978-1-4612-3028-1
"""

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from bristle.core import (
    Amount,
    HysteresisOperator,
    InputError,
    Model,
    Relation,
    Variable,
    amount,
    everett,
    guarded,
    kernel,
    model,
    whole,
)


class Parameters(NamedTuple):
    """Parameters of the grid: its levels, and the weight of each cell between them."""

    levels: Annotated[np.ndarray, Variable("length", "inputs at the borders of the cells, rising")]
    weights: Annotated[
        np.ndarray,
        Variable(
            "force",
            "measure of each cell, row after row: in row i, alpha is in cell i and beta in cell 0 to i",
        ),
    ]


class State(NamedTuple):
    """The state is the memory: each relay, +1 or -1; 0 where the demagnetised state divides a cell in halves."""


class Move(NamedTuple):
    """Result of a trial, applied by commit."""

    u: float


@kernel
def relay(before, u, alpha, beta):
    """Return the relay that was at `before`, after a move of the input to `u`."""
    if u >= alpha:
        return 1.0
    if u <= beta:
        return -1.0
    return before


@kernel
def middle(levels, i):
    """Return the middle of cell `i`, where its relays switch."""
    return 0.5 * (levels[i] + levels[i + 1])


@kernel
def trial(state, memory, u, p):
    """Return the output [N or N*m] at the input `u` [m or rad], and the move there."""
    f = 0.0
    k = 0
    for i in range(p.levels.size - 1):
        for j in range(i + 1):
            f += p.weights[k] * relay(memory[k], u, middle(p.levels, i), middle(p.levels, j))
            k += 1
    return f, Move(u)


@kernel
def commit(state, memory, move, p):
    """Switch the relays."""
    k = 0
    for i in range(p.levels.size - 1):
        for j in range(i + 1):
            memory[k] = relay(memory[k], move.u, middle(p.levels, i), middle(p.levels, j))
            k += 1
    return state


@dataclass(frozen=True, kw_only=True)
class RelayGrid(HysteresisOperator):
    """A grid of relays, demagnetised: those below alpha = -beta are up."""

    def new_memory(self, parameters: Any) -> np.ndarray:
        """Return the relays of a demagnetised operator, shape (memory_size,)."""
        switch = 0.5 * (parameters.levels[1:] + parameters.levels[:-1])
        i, j = np.tril_indices(switch.size)
        total = switch[i] + switch[j]
        total[np.abs(total) <= 1e-9 * np.ptp(parameters.levels) / switch.size] = 0.0
        return -np.sign(total)


MODEL = relay_grid = RelayGrid(
    name="relay_grid",
    description="Preisach operator by brute force, one relay for each cell of a grid: the reference for other operators",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    memory_size=lambda p: len(p.weights),
    relations=(
        Relation(
            "levels that rise", lambda p: bool(np.all(np.diff(p.levels) > 0.0)), "Sort the levels"
        ),
        Relation(
            "n (n + 1)/2 weights for n cells",
            lambda p: 2 * len(p.weights) == (len(p.levels) - 1) * len(p.levels),
            "Use relays_of to get them from an operator",
        ),
    ),
    reference="doi:10.1007/978-1-4612-3028-1",
    example={"levels": [-1e-6, 0.0, 1e-6], "weights": [3.0, -1.0, 3.0]},
)


@guarded(
    operator=model("hysteresis"),
    extent=amount(Variable("length", "largest input", min=0.0), exclusive=True),
    count=whole(1, 1000),
)
def relays_of(operator: Model, extent: Amount, count: int) -> Model:
    """Return the grid of relays with the measure of an operator.

    Parameters
    ----------
    operator : Model
        An operator with an Everett function: `preisach` or `everett_table`.
    extent : float
        Largest input of the grid [m or rad].
    count : int
        Number of cells along a side; the levels are ``linspace(-extent, extent, count + 1)``.

    Returns
    -------
    Model
        A `relay_grid` operator.

    Raises
    ------
    InputError
        If the operator has no Everett function.
    """
    if operator.component.measure is None:
        raise InputError("has no Everett function", path="operator", value=operator.name)
    q = operator.component.measure(operator.parameters)
    levels = np.linspace(-extent, extent, count + 1)
    E = np.array(
        [[everett(a, b, q) if a > b else 0.0 for b in levels.tolist()] for a in levels.tolist()]
    )
    return MODEL(
        kind=operator.kind,
        levels=levels,
        weights=(E[1:, :-1] - E[:-1, :-1] - E[1:, 1:] + E[:-1, 1:])[np.tril_indices(count)],
    )
