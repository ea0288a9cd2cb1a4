r"""The elastoplastic model: bristles that do not slip until their deflection reaches a threshold.

.. math::
    \dot z = v\left(1 - \alpha(z, v)\,\frac{\sigma_0 z}{G(v)}\operatorname{sgn} v\right), \qquad
    F = \sigma_0 z + \sigma_1\,\dot z + \sigma_2 v

Up to the break-away deflection :math:`z_{ba}`, and while the motion unloads the bristles, :math:`\alpha = 0`. From
:math:`z_{ba}` to the deflection in sliding, :math:`G(v)/\sigma_0`, :math:`\alpha` rises as a half wave of a sine; beyond,
:math:`\alpha = 1`. Below the threshold :math:`z_{ba}` the contact is a spring: it neither drifts nor dissipates energy,
and has no hysteresis. The threshold does not depend on the velocity. It must therefore lie below the smallest
deflection in sliding, :math:`\sigma_0 z_{ba} < F_C`; otherwise :math:`\alpha` would jump.

References
----------
.. [1] P. Dupont, V. Hayward, B. Armstrong, F. Altpeter, "Single state elastoplastic friction models", IEEE
   Transactions on Automatic Control 47(5), 2002. doi:10.1109/TAC.2002.1000274
"""

from typing import Annotated, NamedTuple

from bristle.core import FrictionModel, Relation, Variable, kernel
from bristle.core.mathematics import direction
from bristle.models.friction.lugre import stribeck_force
from bristle.models.friction.quantities import (
    BristleStiffness,
    CoulombForceAboveZero,
    MicroDamping,
    StaticForceAboveZero,
    StribeckVelocity,
    ViscousCoefficient,
)
from bristle.models.friction.slip_law import SlipLaw, slip, stretch
from bristle.models.friction.stribeck import STATIC_ABOVE_COULOMB


class Parameters(NamedTuple):
    """Parameters of the elastoplastic model."""

    F_C: CoulombForceAboveZero
    F_S: StaticForceAboveZero
    v_S: StribeckVelocity
    sigma_0: BristleStiffness
    z_ba: Annotated[
        float,
        Variable(
            "length",
            "deflection at which slip begins",
            min=0.0,
            nominal=1e-6,
            excitation="presliding",
        ),
    ]
    sigma_1: MicroDamping = 0.0
    sigma_2: ViscousCoefficient = 0.0


class State(NamedTuple):
    """State of the elastoplastic model."""

    z: Annotated[float, Variable("length", "mean deflection of the bristles", nominal=1e-6)] = 0.0


class Move(NamedTuple):
    """Result of a trial, applied by commit."""

    z_next: float


THRESHOLD_BELOW_SLIDING = Relation(
    "sigma_0 * z_ba < F_C",
    lambda p: p.sigma_0 * p.z_ba < p.F_C,
    "Lower z_ba: the bristles must begin to slip before the contact slides",
)


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and the deflection at its end."""
    v = motion.v
    side = direction(v)
    G = stribeck_force(v, p)
    law = SlipLaw(p.sigma_0 * p.z_ba / G, 1.0, 1.0)
    stretched = stretch(side * p.sigma_0 * state.z / G, p.sigma_0 * abs(v) * dt / G, law)
    z_step = side * G * stretched.change / p.sigma_0
    z_dot = z_step / dt if dt > 0.0 else 0.0
    bristles = p.sigma_0 * state.z + side * G * stretched.mean_change
    return bristles + p.sigma_1 * z_dot + p.sigma_2 * v, Move(state.z + z_step)


@kernel
def commit(state, memory, move, p):
    """Return the state after the step."""
    return State(move.z_next)


@kernel
def rate(state, motion, p):
    """Return the force [N or N*m] and the time derivative of the state [m/s or rad/s]."""
    v = motion.v
    G = stribeck_force(v, p)
    law = SlipLaw(p.sigma_0 * p.z_ba / G, 1.0, 1.0)
    z_dot = v * (1.0 - slip(direction(v) * p.sigma_0 * state.z / G, law))
    return p.sigma_0 * state.z + p.sigma_1 * z_dot + p.sigma_2 * v, State(z_dot)


MODEL = elastoplastic = FrictionModel(
    name="elastoplastic",
    description="bristles that slip only above a threshold; below the threshold neither drift nor hysteresis",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    rate=rate,
    relations=(STATIC_ABOVE_COULOMB, THRESHOLD_BELOW_SLIDING),
    reference="doi:10.1109/TAC.2002.1000274",
    example={
        "F_C": 20.0,
        "F_S": 28.0,
        "v_S": 2e-3,
        "sigma_0": 1e7,
        "z_ba": 1.4e-6,
        "sigma_1": 1e3,
        "sigma_2": 800.0,
    },
)
