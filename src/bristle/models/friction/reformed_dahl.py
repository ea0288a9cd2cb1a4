r"""The reformed Dahl model, (16) and (17) of the source paper: hysteresis in closed form, with local memory.

After a reversal at the force :math:`f_r`, moving forward by :math:`d` from there,

.. math::
    f = f_r + \frac{P\,s\,d}{P + s\,d}, \quad P = f_p - f_r, \qquad
    \frac{df}{dx} = s\left(\frac{f_p - f}{f_p - f_r}\right)^2

Motion backward is the mirror image. The slope at every reversal is :math:`s`, unlike in Dahl's model with exponent 2.
A symmetric loop between :math:`\pm x_r` closes at the force
:math:`f_r = \tfrac{f_p}{2}\left[\sqrt{(1+k)^2 + 4k} - (1+k)\right]`, :math:`k = s x_r/f_p`. Other minor loops do not
close. After an inner loop the model does not return to the outer loop (no return-point memory). Loops of equal
width at different forces differ in height (no congruency). The kernel ``reformed_dahl_exact`` of the Preisach operators
has equal symmetric loops, and in addition return-point memory and congruency. The force at the end of a step and its
mean are exact for every step size.

References
----------
.. [1] "Pre-sliding friction control using the sliding mode controller with hysteresis friction compensator",
   equations (16) and (17).
.. [2] P. R. Dahl, "Solid friction damping of mechanical vibrations", AIAA Journal 14(12), 1976.
   doi:10.2514/3.61511
"""

from typing import Annotated, NamedTuple

from bristle.core import FrictionModel, Variable, kernel
from bristle.core.mathematics import direction, hyperbolic_mean
from bristle.models.friction.quantities import ReversalStiffness, ViscousCoefficient


class Parameters(NamedTuple):
    """Parameters of the reformed Dahl model."""

    s: ReversalStiffness
    f_p: Annotated[
        float,
        Variable("force", "limit of the force", min=1e-12, directional=True, excitation="sliding"),
    ]
    sigma_2: ViscousCoefficient = 0.0


class State(NamedTuple):
    """State of the reformed Dahl model."""

    f: Annotated[float, Variable("force", "hysteretic part of the friction force")] = 0.0
    f_r: Annotated[float, Variable("force", "force at the last reversal")] = 0.0
    side: Annotated[float, Variable("1", "direction of the last motion, 0 if there was none")] = 0.0


class Move(NamedTuple):
    """Result of a trial, applied by commit."""

    f_next: float
    f_r: float
    side: float


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and its branch."""
    side = direction(motion.v)
    f_r = state.f_r if side == state.side else state.f
    rise = side * (p.f_p - side * state.f)
    # A force at its limit may stay there to the last digit while the direction changes twice: the span is zero.
    span = max(p.f_p - side * f_r, 1e-15 * p.f_p)
    kappa = p.s * abs(motion.v) * dt * abs(rise) / (span * span)
    force = state.f + rise * (1.0 - hyperbolic_mean(kappa)) + p.sigma_2 * motion.v
    if kappa == 0.0:
        return force, Move(state.f, state.f_r, state.side)
    return force, Move(state.f + rise * kappa / (1.0 + kappa), f_r, side)


@kernel
def commit(state, memory, move, p):
    """Return the state after the step."""
    return State(move.f_next, move.f_r, move.side)


MODEL = reformed_dahl = FrictionModel(
    name="reformed_dahl",
    description="hysteresis in closed form that remembers its last reversal only",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    reference="doi:10.2514/3.61511",
    example={"s": 1e7, "f_p": 20.0, "sigma_2": 200.0},
)
