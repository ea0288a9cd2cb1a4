r"""Static friction with the Stribeck effect: the force falls from break-away to Coulomb as the body speeds up.

.. math::
    F = G(v) \operatorname{sgn} v + F_v\,v, \qquad G(v) = F_C + (F_S - F_C)\,e^{-|v/v_S|^{\delta_S}}

At rest :math:`F \in [-F_S, F_S]`.

References
----------
.. [1] B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, "A survey of models, analysis tools and compensation
   methods for the control of machines with friction", Automatica 30(7), 1994. doi:10.1016/0005-1098(94)90209-7
"""

from typing import Annotated, NamedTuple

from bristle.core import FrictionModel, Relation, Variable, kernel
from bristle.core.mathematics import direction, exp, power
from bristle.models.friction.quantities import (
    CoulombForce,
    StaticForce,
    StribeckVelocity,
    ViscousCoefficient,
)


class Parameters(NamedTuple):
    """Parameters of static friction with the Stribeck effect."""

    F_C: CoulombForce
    F_S: StaticForce
    v_S: StribeckVelocity
    F_v: ViscousCoefficient
    delta_S: Annotated[
        float, Variable("1", "exponent of the Stribeck curve", min=0.1, max=10.0)
    ] = 2.0


class State(NamedTuple):
    """A static model has no state."""


class Move(NamedTuple):
    """An empty move."""


STATIC_ABOVE_COULOMB = Relation(
    "F_S >= F_C",
    lambda p: p.F_S >= p.F_C,
    "Raise F_S or lower F_C; if friction rises with speed, set validate=False",
)


@kernel
def stribeck_force(v, F_C, F_S, v_S, delta_S):
    r"""Return :math:`G(v) = F_C + (F_S - F_C) e^{-|v/v_S|^{\delta_S}}` [N or N*m]."""
    return F_C + (F_S - F_C) * exp(-power(abs(v) / v_S, delta_S))


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and an empty move."""
    G = stribeck_force(motion.v, p.F_C, p.F_S, p.v_S, p.delta_S)
    return G * direction(motion.v) + p.F_v * motion.v, Move()


@kernel
def commit(state, memory, move, p):
    """Return the state after the step, which is empty."""
    return state


MODEL = stribeck = FrictionModel(
    name="stribeck",
    description="static map from velocity to force that falls from break-away to Coulomb friction",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    relations=(STATIC_ABOVE_COULOMB,),
    reference="doi:10.1016/0005-1098(94)90209-7",
    example={"F_C": 20.0, "F_S": 28.0, "v_S": 2e-3, "F_v": 200.0},
)
