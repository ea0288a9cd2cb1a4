r"""Proportional-derivative control with a LuGre friction observer, corrected by the error.

With the error :math:`e = r - q`, the surface :math:`\varsigma = \dot e + \lambda e` and the velocity :math:`\hat v`

.. math::
    u = J\left[\ddot r + \lambda\,\dot e + K_1 \varsigma\right] + \sigma_0 \hat z + \sigma_2 \hat v + \hat F, \qquad
    \dot{\hat z} = \hat v - \sigma_0 \frac{|\hat v|}{G(\hat v)}\,\hat z + k\,\varsigma

with the Stribeck force :math:`G(v) = F_C + (F_S - F_C)\,e^{-(v/v_S)^2}`. The term with :math:`k` corrects the
deflection of the bristles in proportion to :math:`\varsigma`. Within a sample :math:`\hat v` and :math:`\varsigma` are
constant, and the step of :math:`\hat z` is exact. :math:`\hat F` is the feedforward.

References
----------
.. [1] C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, "A new model for control of systems with friction",
   IEEE Transactions on Automatic Control 40(3), 1995, section V. doi:10.1109/9.376053
"""

import math
from typing import Annotated, NamedTuple

from bristle.core import Controller, Variable, kernel
from bristle.core.mathematics import exp, relaxation
from bristle.models.controllers import quantities
from bristle.models.controllers.surface import surface_at
from bristle.models.controllers.velocity import motion_before


class Parameters(NamedTuple):
    """Parameters of the law with a friction observer."""

    J: quantities.KnownInertia
    lambda_: quantities.SurfaceSlope
    K_1: quantities.ApproachRate
    F_C: Annotated[float, Variable("force", "Coulomb friction force of the observer", min=1e-12)]
    F_S: Annotated[float, Variable("force", "static friction force of the observer", min=1e-12)]
    v_S: Annotated[float, Variable("length/time", "Stribeck velocity of the observer", min=1e-12)]
    sigma_0: Annotated[
        float, Variable("force/length", "bristle stiffness of the observer", min=0.0)
    ]
    sigma_2: Annotated[
        float, Variable("force*time/length", "viscous coefficient of the observer", min=0.0)
    ] = 0.0
    k: Annotated[
        float,
        Variable("1", "gain of the correction of the bristle deflection by the error", min=0.0),
    ] = 0.0
    estimator: quantities.Estimator = 0
    cutoff: quantities.Cutoff = math.inf
    limit: quantities.EffortLimit = math.inf


class State(NamedTuple):
    """State of the law with a friction observer."""

    q: quantities.PositionBefore = 0.0
    v: quantities.VelocityBefore = 0.0
    z: Annotated[float, Variable("length", "deflection of the bristles of the observer")] = 0.0


@kernel
def step(state, reference, measured, dt, p):
    """Return the effort [N or N*m] and the state, for one sample."""
    motion, e_dot, surface = surface_at(state, reference, measured, dt, p)
    ratio = motion.v / p.v_S
    G = p.F_C + (p.F_S - p.F_C) * exp(-ratio * ratio)
    slip = p.sigma_0 * abs(motion.v) / G * dt
    z = state.z * exp(-slip) + dt * relaxation(slip) * (motion.v + p.k * surface)
    friction = p.sigma_0 * z + p.sigma_2 * motion.v
    demand = (
        p.J * (reference.acceleration + p.lambda_ * e_dot + p.K_1 * surface)
        + friction
        + reference.effort
    )
    effort = max(-p.limit, min(p.limit, demand))
    return effort, State(motion.q, motion.v, state.z if effort != demand else z)


@kernel
def start(measured, velocity, acceleration, dt, p):
    """Return the state of a law that takes over a motion at `velocity` [m/s or rad/s] and `acceleration`."""
    before = motion_before(measured, velocity, acceleration, dt)
    return State(before.q, before.v)


MODEL = lugre_observer = Controller(
    name="lugre_observer",
    description="proportional-derivative law with a LuGre friction observer",
    Parameters=Parameters,
    State=State,
    step=step,
    start=start,
    reference="doi:10.1109/9.376053",
)
