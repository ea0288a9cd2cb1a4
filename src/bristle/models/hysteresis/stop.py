r"""The stop operator: a spring that slips at a deflection of :math:`r`, the complement of the play.

.. math:: w = u - \max(u - r, \min(u + r, y^-)), \qquad |w| \le r

The state is the position :math:`y` of the slider, and :math:`y^-` its position before the move. Rounding errors
therefore do not add up over many moves.

References
----------
.. [1] A. Visintin, "Differential Models of Hysteresis", Springer, 1994. doi:10.1007/978-3-662-11557-2
"""

from typing import Annotated, NamedTuple

from bristle.core import HysteresisOperator, Variable, kernel
from bristle.models.hysteresis.play import played


class Parameters(NamedTuple):
    """Parameters of the stop operator."""

    r: Annotated[float, Variable("length", "deflection at which the spring slips", min=0.0)]


class State(NamedTuple):
    """State of the stop operator."""

    y: Annotated[float, Variable("length", "place of the slider")] = 0.0


class Move(NamedTuple):
    """Result of a trial, applied by commit."""

    y: float


@kernel
def trial(state, memory, u, p):
    """Return the deflection [m or rad] at the input `u` [m or rad], and the move there."""
    y = played(state.y, u, p.r)
    return u - y, Move(y)


@kernel
def commit(state, memory, move, p):
    """Return the state after the move."""
    return State(move.y)


MODEL = stop = HysteresisOperator(
    name="stop",
    description="stop: the deflection of a spring that slips",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    output="length",
    reference="doi:10.1007/978-3-662-11557-2",
    example={"r": 1e-6},
)
