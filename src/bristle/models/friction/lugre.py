r"""The LuGre model: bristles that deflect, slip and have the Stribeck effect; (1) to (4) of the source paper.

.. math::
    \dot z = v\left(1 - \frac{\sigma_0 z}{G(v)}\operatorname{sgn} v\right), \qquad
    F = \sigma_0 z + \sigma_1(v)\,\dot z + \sigma_2 v, \qquad
    G(v) = F_C + (F_S - F_C)\,e^{-(v/v_S)^2}

with :math:`\sigma_1(v) = \sigma_1 e^{-(v/v_d)^2}`, constant for :math:`v_d = \infty`. In steady sliding the deflection is
:math:`|z| = G/\sigma_0` and the force :math:`F_{ss} = G(v)\operatorname{sgn} v + \sigma_2 v`. Some texts write a bristle
function :math:`g(v)` with :math:`\sigma_0 g = G`. A formula that divides by :math:`g` *and* keeps
:math:`\sigma_0 z` in the numerator counts :math:`\sigma_0` twice; the form above does not. A step at constant
velocity is exact for every step size.

References
----------
.. [1] C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, "A new model for control of systems with friction",
   IEEE Transactions on Automatic Control 40(3), 1995. doi:10.1109/9.376053
.. [2] "Pre-sliding friction control using the sliding mode controller with hysteresis friction compensator",
   equations (1) to (4).
"""

import math
from typing import Annotated, NamedTuple

from bristle.core import FrictionModel, Variable, kernel
from bristle.core.mathematics import decay, direction, relaxation
from bristle.models.friction.quantities import (
    BristleStiffness,
    CoulombForceAboveZero,
    FadingVelocity,
    MicroDamping,
    StaticForceAboveZero,
    StribeckVelocity,
    ViscousCoefficient,
)
from bristle.models.friction.stribeck import STATIC_ABOVE_COULOMB


class Parameters(NamedTuple):
    """Parameters of the LuGre model."""

    F_C: CoulombForceAboveZero
    F_S: StaticForceAboveZero
    v_S: StribeckVelocity
    sigma_0: BristleStiffness
    sigma_1: MicroDamping = 0.0
    sigma_2: ViscousCoefficient = 0.0
    v_d: FadingVelocity = math.inf


class State(NamedTuple):
    """State of the LuGre model."""

    z: Annotated[float, Variable("length", "mean deflection of the bristles", nominal=1e-6)] = 0.0


class Move(NamedTuple):
    """Result of a trial, applied by commit."""

    z_next: float


class Piece(NamedTuple):
    """Constant until the velocity reverses: its direction."""

    side: float


@kernel
def stribeck_force(v, p):
    r"""Return :math:`G(v) = F_C + (F_S - F_C) e^{-(v/v_S)^2}` [N or N*m]."""
    ratio = v / p.v_S
    return p.F_C + (p.F_S - p.F_C) * decay(ratio * ratio)


@kernel
def micro_damping(v, p):
    r"""Return :math:`\sigma_1(v) = \sigma_1 e^{-(v/v_d)^2}` [N*s/m or N*m*s/rad]."""
    if math.isinf(p.v_d):
        return p.sigma_1
    ratio = v / p.v_d
    return p.sigma_1 * decay(ratio * ratio)


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and the deflection at its end."""
    v = motion.v
    dx = v * dt
    sliding = direction(v) * stribeck_force(v, p)
    inverse = 1.0 / sliding
    elastic = p.sigma_0 * state.z
    decay = relaxation(p.sigma_0 * dx * inverse)
    share = (1.0 - elastic * inverse) * decay
    force = (
        elastic
        + (sliding - elastic) * (1.0 - decay)
        + micro_damping(v, p) * (v * share)
        + p.sigma_2 * v
    )
    return force, Move(state.z + dx * share)


@kernel
def commit(state, memory, move, p):
    """Return the state after the step."""
    return State(move.z_next)


@kernel
def rate(state, motion, p):
    """Return the force [N or N*m] and the time derivative of the state [m/s or rad/s]."""
    force, d_state, _ = flow(state, Piece(direction(motion.v)), motion, p)
    return force, d_state


@kernel
def piece(state, memory, motion, p):
    """Return the state, all of which varies, and the direction of motion, constant until a reversal."""
    return state, Piece(direction(motion.v))


@kernel
def flow(contact, piece, motion, p):
    """Return the force [N or N*m], the rate of the deflection [m/s or rad/s], and the velocity as margin to a reversal."""
    v = motion.v
    z_dot = v * (1.0 - piece.side * p.sigma_0 * contact.z / stribeck_force(v, p))
    return (
        p.sigma_0 * contact.z + micro_damping(v, p) * z_dot + p.sigma_2 * v,
        State(z_dot),
        piece.side * v,
    )


@kernel
def arrival(state, memory, contact, p):
    """Return the move to the deflection at a reversal."""
    return Move(contact.z)


MODEL = lugre = FrictionModel(
    name="lugre",
    description="bristles with the Stribeck effect; drifts under a force ripple and does not close minor loops",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    rate=rate,
    piece=piece,
    flow=flow,
    arrival=arrival,
    relations=(STATIC_ABOVE_COULOMB,),
    reference="doi:10.1109/9.376053",
    example={
        "F_C": 20.0,
        "F_S": 28.0,
        "v_S": 2e-3,
        "sigma_0": 1e7,
        "sigma_1": 1e3,
        "sigma_2": 200.0,
        "v_d": 0.05,
    },
)
