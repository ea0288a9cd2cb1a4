r"""Proportional-derivative control with a disturbance observer, which feeds back the force that the model lacks.

With the error :math:`e = r - q` and the surface :math:`\varsigma = \dot e + \lambda e`

.. math::
    u = J\left[\ddot r + \lambda\,\dot e + K_1 \varsigma\right] + \hat F + \hat d, \qquad
    \hat d = \frac{g}{s + g}\left(u - \hat F - J \dot{\hat v}\right)

The model of the observer is the inertia and the friction feedforward :math:`\hat F`. The observer estimates the rest of
the force, :math:`\hat d`. It needs no derivative of the velocity: :math:`\hat d = z - g J \hat v` with
:math:`\dot z = g\,(u - \hat F + g J \hat v - z)`. The observer uses the limited effort, so it does not wind up.

References
----------
.. [1] K. Ohnishi, M. Shibata, T. Murakami, "Motion control for advanced mechatronics", IEEE/ASME Transactions on
   Mechatronics 1(1), 1996. doi:10.1109/3516.491410
"""

import math
from typing import Annotated, NamedTuple

from bristle.core import Controller, Variable, kernel
from bristle.core.mathematics import expm1
from bristle.models.controllers import quantities
from bristle.models.controllers.surface import surface_at
from bristle.models.controllers.velocity import motion_before


class Parameters(NamedTuple):
    """Parameters of the law with a disturbance observer."""

    J: quantities.KnownInertia
    lambda_: quantities.SurfaceSlope
    K_1: quantities.ApproachRate
    g: Annotated[float, Variable("1/time", "bandwidth of the observer", min=0.0, nominal=60.0)]
    estimator: quantities.Estimator = 0
    cutoff: quantities.Cutoff = math.inf
    limit: quantities.EffortLimit = math.inf


class State(NamedTuple):
    """State of the law with a disturbance observer."""

    q: quantities.PositionBefore = 0.0
    v: quantities.VelocityBefore = 0.0
    z: Annotated[
        float, Variable("force", "estimate of the disturbance and the momentum's part")
    ] = 0.0
    feedback: Annotated[
        float, Variable("force", "effort one sample ago, minus the feedforward")
    ] = 0.0


@kernel
def step(state, reference, measured, dt, p):
    """Return the effort [N or N*m] and the state, for one sample."""
    motion, e_dot, surface = surface_at(state, reference, measured, dt, p)
    momentum = p.g * p.J * motion.v
    z = state.z - expm1(-p.g * dt) * (state.feedback + momentum - state.z)
    demand = (
        p.J * (reference.acceleration + p.lambda_ * e_dot + p.K_1 * surface)
        + z
        - momentum
        + reference.effort
    )
    effort = max(-p.limit, min(p.limit, demand))
    return effort, State(motion.q, motion.v, z, effort - reference.effort)


@kernel
def start(measured, velocity, acceleration, dt, p):
    """Return the state of a law that takes over a motion at `velocity` [m/s or rad/s] and `acceleration`."""
    before = motion_before(measured, velocity, acceleration, dt)
    return State(before.q, before.v, p.g * p.J * before.v, p.J * acceleration)


@kernel
def resume(state, reference, measured, effort, dt, p):
    """Return the state of a law after a known effort: the part beyond its inertia was a disturbance."""
    if math.isnan(effort):
        return state
    feedback = effort - reference.effort
    return State(state.q, state.v, state.z + feedback - state.feedback, feedback)


MODEL = disturbance_observer = Controller(
    name="disturbance_observer",
    description="proportional-derivative law with a disturbance observer, and friction fed forward",
    Parameters=Parameters,
    State=State,
    step=step,
    start=start,
    resume=resume,
    reference="doi:10.1109/3516.491410",
)
