r"""The play operator, or backlash: the output of a link with a gap of width :math:`2r`.

.. math:: w = \max(u - r, \min(u + r, w^-))

with :math:`w^-` the output before the move. The output is the only memory of the operator.

References
----------
.. [1] A. Visintin, "Differential Models of Hysteresis", Springer, 1994. doi:10.1007/978-3-662-11557-2
"""

from typing import Annotated, NamedTuple

from bristle.core import HysteresisOperator, Variable, kernel


class Parameters(NamedTuple):
    """Parameters of the play operator."""

    r: Annotated[float, Variable("length", "half of the width of the gap", min=0.0)]


class State(NamedTuple):
    """State of the play operator."""

    w: Annotated[float, Variable("length", "output")] = 0.0


class Move(NamedTuple):
    """Result of a trial, applied by commit."""

    w: float


@kernel
def played(w, u, r):
    """Return the output of a play of half gap `r` that was at `w`, after a move of the input to `u`."""
    return max(u - r, min(u + r, w))


@kernel
def trial(state, memory, u, p):
    """Return the output [m or rad] at the input `u` [m or rad], and the move there."""
    w = played(state.w, u, p.r)
    return w, Move(w)


@kernel
def commit(state, memory, move, p):
    """Return the state after the move."""
    return State(move.w)


MODEL = play = HysteresisOperator(
    name="play",
    description="play, or backlash: a link with a gap",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    output="length",
    reference="doi:10.1007/978-3-662-11557-2",
    example={"r": 1e-6},
)
