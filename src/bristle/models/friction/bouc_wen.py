r"""The Bouc-Wen model as friction: smooth hysteresis, with minor loops that do not close.

.. math::
    F = \alpha s\,x + (1 - \alpha)\,f + \sigma_2 v, \qquad
    \frac{df}{dx} = s\left[1 - \left|\frac{f}{F_C}\right|^n\left(\gamma + \beta \operatorname{sgn}(v f)\right)\right]

with :math:`\gamma = 1 - \beta`, so that :math:`f \to F_C \operatorname{sgn} v` in sliding. The usual amplitudes of
``bouc_wen_classic`` are redundant. This model derives them from the stiffness :math:`s` and the force :math:`F_C`. With
:math:`\alpha = 0` (the default) the contact has no elastic restoring force and slides freely. For :math:`\beta \ge 1/2`
the model dissipates energy. A smaller :math:`\beta` makes the slope in unloading less than :math:`s`. Under a small
cycle of a force that keeps its sign, the contact creeps: the model violates Drucker's postulate and has no return-point
memory.

References
----------
.. [1] Y.-K. Wen, "Method for random vibration of hysteretic systems", Journal of the Engineering Mechanics Division
   102(2), 1976. doi:10.1061/JMCEA3.0002106
"""

from typing import Annotated, NamedTuple

from bristle.core import FrictionModel, Variable, kernel
from bristle.core.mathematics import direction
from bristle.models.friction.quantities import CoulombForceAboveZero, ViscousCoefficient
from bristle.models.friction.slip_law import SlipLaw, slip, stretch


class Parameters(NamedTuple):
    """Parameters of the Bouc-Wen model."""

    s: Annotated[
        float,
        Variable(
            "force/length", "stiffness at rest", min=1e-9, nominal=1e6, excitation="presliding"
        ),
    ]
    F_C: CoulombForceAboveZero
    exponent: Annotated[
        float, Variable("1", "exponent n, how sharp the knee is", min=1.0, max=20.0)
    ] = 2.0
    beta: Annotated[
        float, Variable("1", "share of the slip that depends on the direction", min=0.5, max=1.0)
    ] = 0.5
    alpha: Annotated[
        float, Variable("1", "share of the stiffness that never yields", min=0.0, max=1.0)
    ] = 0.0
    sigma_2: ViscousCoefficient = 0.0


class State(NamedTuple):
    """State of the Bouc-Wen model."""

    f: Annotated[float, Variable("force", "hysteretic part of the friction force")] = 0.0


class Move(NamedTuple):
    """Result of a trial, applied by commit."""

    f_next: float


@kernel
def slip_law(p):
    """Return the slip law. In unloading the slope is 1 - (gamma - beta) |f/F_C|^n, and beta exceeds gamma."""
    return SlipLaw(-1.0, p.exponent, 2.0 * p.beta - 1.0)


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and the hysteretic force at its end."""
    v = motion.v
    side = direction(v)
    stretched = stretch(side * state.f / p.F_C, p.s * abs(v) * dt / p.F_C, slip_law(p))
    hysteretic = state.f + side * p.F_C * stretched.mean_change
    elastic = p.s * (motion.x - 0.5 * v * dt)
    force = p.alpha * elastic + (1.0 - p.alpha) * hysteretic + p.sigma_2 * v
    return force, Move(state.f + side * p.F_C * stretched.change)


@kernel
def commit(state, memory, move, p):
    """Return the state after the step."""
    return State(move.f_next)


@kernel
def rate(state, motion, p):
    """Return the force [N or N*m] and the time derivative of the state [N/s or N*m/s]."""
    v = motion.v
    share = slip(direction(v) * state.f / p.F_C, slip_law(p))
    force = p.alpha * p.s * motion.x + (1.0 - p.alpha) * state.f + p.sigma_2 * v
    return force, State(p.s * v * (1.0 - share))


MODEL = bouc_wen = FrictionModel(
    name="bouc_wen",
    description="smooth hysteresis with a knee of any sharpness; drifts and does not close minor loops",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    rate=rate,
    reference="doi:10.1061/JMCEA3.0002106",
    example={"s": 1e7, "F_C": 20.0, "exponent": 2.0, "beta": 0.6, "sigma_2": 200.0},
)
