r"""Viscous friction: a force in proportion to the velocity.

.. math:: F = F_v\,v

References
----------
.. [1] B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, "A survey of models, analysis tools and compensation
   methods for the control of machines with friction", Automatica 30(7), 1994. doi:10.1016/0005-1098(94)90209-7
"""

from typing import NamedTuple

from bristle.core import FrictionModel, kernel
from bristle.models.friction.quantities import ViscousCoefficient


class Parameters(NamedTuple):
    """Parameters of viscous friction."""

    F_v: ViscousCoefficient


class State(NamedTuple):
    """Viscous friction has no state."""


class Move(NamedTuple):
    """An empty move."""


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and an empty move."""
    return p.F_v * motion.v, Move()


@kernel
def commit(state, memory, move, p):
    """Return the state after the step, which is empty."""
    return state


MODEL = viscous = FrictionModel(
    name="viscous",
    description="force in proportion to the velocity",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    linear=True,
    reference="doi:10.1016/0005-1098(94)90209-7",
    example={"F_v": 200.0},
)
