r"""Proportional-derivative control with friction that is fed forward ahead of each reversal of the desired motion.

With the error :math:`e = r - q` and the surface :math:`\varsigma = \dot e + \lambda e`

.. math::
    u = J\left[\ddot r + \lambda\,\dot e + K_1 \varsigma\right] + c + F_v \dot r + \hat F

The compensation :math:`c` is Stribeck's force along the motion that is expected after a lead :math:`T`:

.. math::
    r_T &= r + T \dot r + \tfrac12 T^2 \ddot r, \qquad v_T = \dot r + T \ddot r, \qquad s = \operatorname{sgn} v_T \\
    c &= s\left(F_C + (F_S - F_C)\,e^{-(v_T/v_S)^2}\right)
         \left(1 - (1 - s\,s_0)\,e^{-|r_T - r_0|/x_0}\right)

:math:`s_0` is the direction before the last reversal, :math:`r_0` the position of this reversal. :math:`\hat F` is the
feedforward. With :math:`x_0 = 0` the law has Stribeck's parameters and the lead only, like the pre-compensation by Xiao,
Wan and Qin [1]_. Only its abstract was readable: it minimises a predicted error. The equations are derived here.

The lead covers the lag of the drive. Friction with pre-sliding reverses late, over a distance. There a lead alone
increases the quadrant glitches, and the distance :math:`x_0` reduces them. On simulated circles with a drive lag of 2 ms
(``python -m benchmarks.laws circles``), distance and lead leave glitches of 0.58 µm, and a Maxwell slip fed forward
1.40 µm. On a slow circle with a lag of 0.2 ms, the Maxwell slip is better: 0.58 instead of 1.36 µm. The law remembers
one reversal only. Within pre-sliding it fails: there feed a model with memory forward.

References
----------
.. [1] Q. Xiao, M. Wan, X. Qin, "Pre-compensation of friction for CNC machine tools through constructing a nonlinear
   model predictive scheme", Chinese Journal of Mechanical Engineering 36, 119, 2023.
"""

import math
from typing import Annotated, NamedTuple

from bristle.core import Controller, Variable, exp, kernel
from bristle.models.controllers import quantities
from bristle.models.controllers.surface import surface_at
from bristle.models.controllers.velocity import motion_before


class Parameters(NamedTuple):
    """Parameters of the law that compensates ahead of a reversal."""

    J: quantities.KnownInertia
    lambda_: quantities.SurfaceSlope
    K_1: quantities.ApproachRate
    F_C: Annotated[float, Variable("force", "Coulomb friction force fed forward", min=0.0)]
    F_S: Annotated[float, Variable("force", "static friction force fed forward", min=0.0)]
    v_S: Annotated[float, Variable("length/time", "Stribeck velocity fed forward", min=1e-12)]
    F_v: Annotated[
        float, Variable("force*time/length", "viscous coefficient fed forward", min=0.0)
    ] = 0.0
    lead: Annotated[
        float, Variable("time", "time by which the compensation leads the desired motion", min=0.0)
    ] = 0.0
    x_0: Annotated[float, Variable("length", "distance over which friction reverses", min=0.0)] = (
        0.0
    )
    estimator: quantities.Estimator = 0
    cutoff: quantities.Cutoff = math.inf
    limit: quantities.EffortLimit = math.inf


class State(NamedTuple):
    """State of the law that compensates ahead of a reversal."""

    q: quantities.PositionBefore = 0.0
    v: quantities.VelocityBefore = 0.0
    turn: Annotated[float, Variable("length", "position of the last reversal")] = 0.0
    side: Annotated[int, Variable("1", "direction of the motion: 1 or -1, 0 before it moves")] = 0
    side_before: Annotated[int, Variable("1", "direction before the last reversal")] = 0


@kernel
def compensation(state, reference, p):
    """Return the friction [N or N*m] of the expected motion, the last reversal, and the directions after and before it."""
    x = reference.position + p.lead * (reference.velocity + 0.5 * p.lead * reference.acceleration)
    v = reference.velocity + p.lead * reference.acceleration
    turn, side, side_before = state.turn, state.side, state.side_before
    now = 1 if v > 0.0 else (-1 if v < 0.0 else side)
    if now != side:
        turn, side, side_before = x, now, side
    left = exp(-abs(x - turn) / p.x_0) if p.x_0 > 0.0 else 0.0
    ratio = v / p.v_S
    level = p.F_C + (p.F_S - p.F_C) * exp(-ratio * ratio)
    return side * level * (1.0 - (1.0 - side * side_before) * left), turn, side, side_before


@kernel
def step(state, reference, measured, dt, p):
    """Return the effort [N or N*m] and the state, for one sample."""
    motion, e_dot, surface = surface_at(state, reference, measured, dt, p)
    c, turn, side, side_before = compensation(state, reference, p)
    pull = p.J * (reference.acceleration + p.lambda_ * e_dot + p.K_1 * surface)
    effort = max(-p.limit, min(p.limit, pull + c + p.F_v * reference.velocity + reference.effort))
    return effort, State(motion.q, motion.v, turn, side, side_before)


@kernel
def start(measured, velocity, acceleration, dt, p):
    """Return the state of a law that takes over a motion at `velocity` [m/s or rad/s] and `acceleration`."""
    before = motion_before(measured, velocity, acceleration, dt)
    side = 1 if velocity > 0.0 else (-1 if velocity < 0.0 else 0)
    return State(before.q, before.v, measured, side, side)


MODEL = predictive_reversal = Controller(
    name="predictive_reversal",
    description="proportional-derivative law with friction fed forward ahead of each reversal",
    Parameters=Parameters,
    State=State,
    step=step,
    start=start,
)
