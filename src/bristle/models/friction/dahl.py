r"""The Dahl model: friction that grows with displacement until the contact slides.

.. math::
    \frac{dF}{dx} = \sigma_0 \left|1 - \frac{F}{F_C}\operatorname{sgn} v\right|^{i}
                    \operatorname{sgn}\!\left(1 - \frac{F}{F_C}\operatorname{sgn} v\right)

plus the viscous force :math:`\sigma_2 v`. With :math:`r = 1 - (F/F_C)\operatorname{sgn} v` a step :math:`\Delta x` in
one direction has a closed form: :math:`r_1 = r_0\,[1 + (i-1)\kappa |r_0|^{i-1}]^{-1/(i-1)}`,
:math:`\kappa = \sigma_0|\Delta x|/F_C` (:math:`r_0 e^{-\kappa}` for :math:`i = 1`). The force at the end of the step and
its mean are exact for every step size.

References
----------
.. [1] P. R. Dahl, "Solid friction damping of mechanical vibrations", AIAA Journal 14(12), 1976.
   doi:10.2514/3.61511
"""

from typing import Annotated, NamedTuple

from bristle.core import FrictionModel, Variable, kernel
from bristle.core.mathematics import direction, exp, hyperbolic_mean, power, relaxation
from bristle.models.friction.quantities import CoulombForceAboveZero, ViscousCoefficient


class Parameters(NamedTuple):
    """Parameters of the Dahl model."""

    sigma_0: Annotated[
        float,
        Variable(
            "force/length", "stiffness at rest", min=1e-9, nominal=1e6, excitation="presliding"
        ),
    ]
    F_C: CoulombForceAboveZero
    sigma_2: ViscousCoefficient = 0.0
    exponent: Annotated[
        float, Variable("1", "Dahl exponent i, the shape of the curve", min=0.1, max=5.0)
    ] = 1.0


class State(NamedTuple):
    """State of the Dahl model."""

    F: Annotated[float, Variable("force", "displacement-dependent part of the friction force")] = (
        0.0
    )


class Move(NamedTuple):
    """Result of a trial, applied by commit."""

    F_next: float


@kernel
def decayed(r, kappa, i):
    r"""Return r after :math:`dr/d\kappa = -|r|^{i-1} r` over `kappa` >= 0, and its mean, both exact.

    With :math:`u = (i-1)\,\kappa\,|r|^{i-1}` and :math:`L = \ln(1 + u)/(i - 1)` it decays by :math:`e^{-L}`. For an
    exponent below 1 it reaches 0 at a finite `kappa`, and stays there.
    """
    if i == 1.0:
        return r * exp(-kappa), r * relaxation(kappa)
    steepness = power(abs(r), i - 1.0)
    u = (i - 1.0) * kappa * steepness
    if u <= -1.0:
        return 0.0, r / ((2.0 - i) * kappa * steepness)
    mean = hyperbolic_mean(u)
    logarithm = kappa * steepness * mean
    if i <= 2.0:
        return r * (1.0 - logarithm * relaxation(logarithm)), r * mean * relaxation(
            (2.0 - i) * logarithm
        )
    grown = (i - 2.0) * logarithm
    return r * exp(-logarithm), r * mean * exp(grown) * relaxation(grown)


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and the force at its end."""
    side = direction(motion.v)
    kappa = p.sigma_0 * abs(motion.v) * dt / p.F_C
    r_next, r_mean = decayed(1.0 - side * state.F / p.F_C, kappa, p.exponent)
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


MODEL = dahl = FrictionModel(
    name="dahl",
    description="friction that grows with displacement until the contact slides; drifts under a force ripple",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    rate=rate,
    reference="doi:10.2514/3.61511",
    example={"sigma_0": 1e7, "F_C": 20.0, "sigma_2": 200.0, "exponent": 1.5},
)
