r"""Coulomb and viscous friction: the usual model for tuning drives.

.. math:: F = F_C \operatorname{sgn} v + F_v\,v, \qquad F \in [-F_C, F_C] \text{ at } v = 0

References
----------
.. [1] A. Janot, P.-O. Vandanjon, M. Gautier, "A generic instrumental variable approach for industrial robot
   identification", IEEE Transactions on Control Systems Technology 22(1), 2014. doi:10.1109/TCST.2013.2246163
"""

from typing import NamedTuple

from bristle.core import FrictionModel, kernel
from bristle.core.mathematics import direction
from bristle.models.friction.quantities import CoulombForce, ViscousCoefficient


class Parameters(NamedTuple):
    """Parameters of Coulomb and viscous friction."""

    F_v: ViscousCoefficient
    F_C: CoulombForce


class State(NamedTuple):
    """Coulomb and viscous friction has no state."""


class Move(NamedTuple):
    """An empty move."""


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and an empty move."""
    return p.F_C * direction(motion.v) + p.F_v * motion.v, Move()


@kernel
def commit(state, memory, move, p):
    """Return the state after the step, which is empty."""
    return state


MODEL = coulomb_viscous = FrictionModel(
    name="coulomb_viscous",
    description="constant force against the motion plus a force proportional to velocity",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    linear=True,
    reference="doi:10.1109/TCST.2013.2246163",
    example={"F_v": 200.0, "F_C": 20.0},
)
