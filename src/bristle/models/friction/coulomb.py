r"""Coulomb friction: a constant force against the motion, and at rest any force up to it.

.. math:: F = F_C \operatorname{sgn} v, \qquad F \in [-F_C, F_C] \text{ at } v = 0

References
----------
.. [1] B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, "A survey of models, analysis tools and compensation
   methods for the control of machines with friction", Automatica 30(7), 1994. doi:10.1016/0005-1098(94)90209-7
"""

from typing import NamedTuple

from bristle.core import FrictionModel, kernel
from bristle.core.mathematics import direction
from bristle.models.friction.quantities import CoulombForce


class Parameters(NamedTuple):
    """Parameters of Coulomb friction."""

    F_C: CoulombForce


class State(NamedTuple):
    """Coulomb friction has no state."""


class Move(NamedTuple):
    """An empty move."""


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and an empty move."""
    return p.F_C * direction(motion.v), Move()


@kernel
def commit(state, memory, move, p):
    """Return the state after the step, which is empty."""
    return state


MODEL = coulomb = FrictionModel(
    name="coulomb",
    description="constant force against the motion; holds the axis at rest without creep",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    linear=True,
    reference="doi:10.1016/0005-1098(94)90209-7",
    example={"F_C": 20.0},
)
