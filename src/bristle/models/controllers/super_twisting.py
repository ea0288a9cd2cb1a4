r"""Super-twisting control: a sliding mode whose switching is integrated, so that the effort is continuous.

With the surface :math:`\varsigma = \dot e + \lambda e`

.. math::
    u = J\left[\ddot r + \lambda\,\dot e + K_1 \varsigma + k_1 \sqrt{|\varsigma|}\,\operatorname{sgn}\varsigma
    + w\right] + \hat F, \qquad \dot w = k_2 \operatorname{sgn}\varsigma

The law rejects a disturbance :math:`d` whose rate is bounded, :math:`|\dot d| < k_2`; a bound on its size is not enough.
Friction that reverses within a few samples exceeds this rate.

References
----------
.. [1] A. Levant, "Sliding order and sliding accuracy in sliding mode control", Int. J. Control 58(6), 1993.
   doi:10.1080/00207179308923053
"""

import math
from typing import Annotated, NamedTuple

from bristle.core import Controller, Variable, kernel
from bristle.models.controllers import quantities
from bristle.models.controllers.surface import surface_at
from bristle.models.controllers.velocity import motion_before


class Parameters(NamedTuple):
    """Parameters of the super-twisting law."""

    J: quantities.KnownInertia
    lambda_: quantities.SurfaceSlope
    K_1: quantities.ApproachRate
    k_1: Annotated[
        float, Variable("length^0.5/time^1.5", "gain on the square root of the surface", min=0.0)
    ]
    k_2: Annotated[float, Variable("length/time^3", "rate of the integrated switching", min=0.0)]
    estimator: quantities.Estimator = 0
    cutoff: quantities.Cutoff = math.inf
    limit: quantities.EffortLimit = math.inf


class State(NamedTuple):
    """State of the super-twisting law."""

    q: quantities.PositionBefore = 0.0
    v: quantities.VelocityBefore = 0.0
    w: Annotated[float, Variable("length/time^2", "integrated switching")] = 0.0


@kernel
def step(state, reference, measured, dt, p):
    """Return the effort [N or N*m] and the state, for one sample."""
    motion, e_dot, surface = surface_at(state, reference, measured, dt, p)
    side = 0.0 if surface == 0.0 else math.copysign(1.0, surface)
    w = state.w + p.k_2 * side * dt
    approach = p.lambda_ * e_dot + p.K_1 * surface + p.k_1 * math.sqrt(abs(surface)) * side
    demand = p.J * (reference.acceleration + approach + w) + reference.effort
    effort = max(-p.limit, min(p.limit, demand))
    if effort != demand and side * demand > 0.0:
        w = state.w
    return effort, State(motion.q, motion.v, w)


@kernel
def start(measured, velocity, acceleration, dt, p):
    """Return the state of a law that takes over a motion at `velocity` [m/s or rad/s] and `acceleration`."""
    before = motion_before(measured, velocity, acceleration, dt)
    return State(before.q, before.v, 0.0)


@kernel
def resume(state, reference, measured, effort, dt, p):
    """Return the state of a law after a known effort: the part that its surface does not explain is the integral."""
    if math.isnan(effort) or p.k_2 == 0.0 or p.J == 0.0:
        return state
    held = Parameters(p.J, p.lambda_, p.K_1, p.k_1, 0.0, p.estimator, p.cutoff, math.inf)
    without, _ = step(state, reference, measured, dt, held)
    return State(state.q, state.v, state.w + (effort - without) / p.J)


MODEL = super_twisting = Controller(
    name="super_twisting",
    description="second-order sliding mode with a continuous effort, and friction fed forward",
    Parameters=Parameters,
    State=State,
    step=step,
    start=start,
    resume=resume,
    reference="doi:10.1080/00207179308923053",
)
