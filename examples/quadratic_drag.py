r"""A friction model of your own: Coulomb friction and a drag that grows with the square of the speed.

.. math:: F = F_C \operatorname{sgn} v + F_q\,v\,|v|

Check it with ``bristle check quadratic_drag.py``; fit it with ``bristle identify LOG --model quadratic_drag.py``.
"""

from typing import Annotated, NamedTuple

from bristle.core import FrictionModel, Variable, kernel
from bristle.core.mathematics import direction


class Parameters(NamedTuple):
    F_C: Annotated[
        float,
        Variable(
            "force", "Coulomb friction force", min=0.0, directional=True, excitation="sliding"
        ),
    ]
    F_q: Annotated[
        float,
        Variable(
            "force*time^2/length^2",
            "drag over the square of the speed",
            min=0.0,
            excitation="speed",
        ),
    ]


class State(NamedTuple):
    """A static map has no state."""


class Move(NamedTuple):
    """Nothing to commit."""


@kernel
def trial(state, memory, motion, dt, p):
    v = motion.v
    return p.F_C * direction(v) + p.F_q * v * abs(v), Move()


@kernel
def commit(state, memory, move, p):
    return state


MODEL = FrictionModel(
    name="quadratic_drag",
    description="Coulomb friction and a drag that grows with the square of the speed",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    example={"F_C": 20.0, "F_q": 125.0},
)
