r"""The Dahl model: friction that grows with displacement until it slides.

.. math::
    \frac{dF}{dx} = \sigma_0 \left|1 - \frac{F}{F_C}\operatorname{sgn} v\right|^{i}
                    \operatorname{sgn}\!\left(1 - \frac{F}{F_C}\operatorname{sgn} v\right)

plus :math:`\sigma_2 v`. With :math:`r = 1 - (F/F_C)\operatorname{sgn} v` a step in one direction is closed:
:math:`r_1 = r_0\,[1 + (i-1)\kappa |r_0|^{i-1}]^{-1/(i-1)}`, :math:`\kappa = \sigma_0|\Delta x|/F_C`
(:math:`r_0 e^{-\kappa}` for :math:`i = 1`). The end of a step is exact for every step size; the mean force is
exponentially fitted: exact for :math:`i = 1`, of second order otherwise.

References
----------
.. [1] P. R. Dahl, "Solid friction damping of mechanical vibrations", AIAA Journal 14(12), 1976.
   doi:10.2514/3.61511
"""

from typing import Annotated, NamedTuple

from bristle.core.contracts import FrictionModel
from bristle.core.kernel import kernel
from bristle.core.mathematics import direction, exp, fitted_weight, power
from bristle.core.variable import Variable
from bristle.friction.quantities import CoulombForceAboveZero, ViscousCoefficient


class Parameters(NamedTuple):
    """Parameters of the Dahl model."""

    sigma_0: Annotated[
        float, Variable("force/length", "stiffness at rest", min=1e-9, nominal=1e6, excitation="presliding")
    ]
    F_C: CoulombForceAboveZero
    sigma_2: ViscousCoefficient = 0.0
    exponent: Annotated[float, Variable("1", "Dahl exponent i, the shape of the curve", min=0.1, max=5.0)] = 1.0


class State(NamedTuple):
    """State of the Dahl model."""

    F: Annotated[float, Variable("force", "displacement-dependent part of the friction force")] = 0.0


class Move(NamedTuple):
    """What a trial hands to commit."""

    F_next: float


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and the force at its end."""
    side = direction(motion.v)
    kappa = p.sigma_0 * abs(motion.v) * dt / p.F_C
    r = 1.0 - side * state.F / p.F_C
    steepness = power(abs(r), p.exponent - 1.0)
    if p.exponent == 1.0:
        r_next = r * exp(-kappa)
    else:
        base = 1.0 + (p.exponent - 1.0) * kappa * steepness
        r_next = r * power(base, -1.0 / (p.exponent - 1.0))
    weight = fitted_weight(p.exponent * kappa * steepness)
    r_mean = r + weight * (r_next - r)
    return side * p.F_C * (1.0 - r_mean) + p.sigma_2 * motion.v, Move(side * p.F_C * (1.0 - r_next))


@kernel
def commit(state, memory, move, p):
    """Return the state after the step."""
    return State(move.F_next)


@kernel
def rate(state, motion, p):
    """Return the force [N or N*m] and the time derivative of the state [N/s or N*m/s]."""
    r = 1.0 - direction(motion.v) * state.F / p.F_C
    slope = p.sigma_0 * power(abs(r), p.exponent) * direction(r)
    return state.F + p.sigma_2 * motion.v, State(slope * motion.v)


MODEL = FrictionModel(
    name="dahl",
    description="friction that grows with displacement until it slides; drifts under a ripple",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    rate=rate,
    reference="doi:10.2514/3.61511",
    example={"sigma_0": 1e7, "F_C": 20.0, "sigma_2": 200.0, "exponent": 1.5},
)
