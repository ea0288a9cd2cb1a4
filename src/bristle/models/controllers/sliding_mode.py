r"""Sliding mode control with a boundary layer and friction compensation, (19) to (23) of the source paper.

With the error :math:`e = r - q` and the surface :math:`\varsigma = \dot e + \lambda e` (s in the source paper)

.. math::
    u = J\left[\ddot r + \lambda\,\dot e + K_1 \varsigma + K_2\,\mathrm{sat}(\varsigma/\phi)\right] + \hat F, \qquad
    \dot\varsigma = -K_1 \varsigma - K_2\,\mathrm{sat}(\varsigma/\phi) + \frac{F - \hat F}{J}

For :math:`\phi = 0`, sat is the sign function. :math:`\hat F` is the feedforward. The law reaches and keeps the surface
only if :math:`K_2` exceeds the uncompensated friction over the inertia, :math:`K_2 > \sup|F - \hat F|/J`. With a
smaller :math:`K_2` the law acts inside the layer as a proportional-derivative law of high gain,
:math:`J\lambda(K_1 + K_2/\phi)`. With :math:`K_2 = 0` the law is a proportional-derivative law.

References
----------
.. [1] "Pre-sliding friction control using the sliding mode controller with hysteresis friction compensator",
   equations (19) to (23).
.. [2] J.-J. E. Slotine, W. Li, "Applied Nonlinear Control", Prentice Hall, 1991, chapter 7.
"""

import math
from typing import Annotated, NamedTuple

from bristle.core import Controller, Variable, kernel
from bristle.models.controllers import quantities
from bristle.models.controllers.surface import surface_at
from bristle.models.controllers.velocity import motion_before


class Parameters(NamedTuple):
    """Parameters of the sliding mode law."""

    J: quantities.KnownInertia
    lambda_: quantities.SurfaceSlope
    K_1: quantities.ApproachRate
    K_2: Annotated[float, Variable("length/time^2", "switching gain", min=0.0, nominal=1e-2)] = 0.0
    phi: Annotated[
        float,
        Variable("length/time", "width of the boundary layer; 0 for the sign function", min=0.0),
    ] = 0.0
    estimator: quantities.Estimator = 0
    cutoff: quantities.Cutoff = math.inf
    limit: quantities.EffortLimit = math.inf


class State(NamedTuple):
    """State of the sliding mode law."""

    q: quantities.PositionBefore = 0.0
    v: quantities.VelocityBefore = 0.0


@kernel
def saturated(surface, phi):
    """Return the surface over the boundary layer, limited to 1; its sign if there is no layer."""
    if abs(surface) >= phi:
        return 0.0 if surface == 0.0 else math.copysign(1.0, surface)
    return surface / phi


@kernel
def step(state, reference, measured, dt, p):
    """Return the effort [N or N*m] and the state, for one sample."""
    motion, e_dot, surface = surface_at(state, reference, measured, dt, p)
    acceleration = (
        reference.acceleration
        + p.lambda_ * e_dot
        + p.K_1 * surface
        + p.K_2 * saturated(surface, p.phi)
    )
    effort = max(-p.limit, min(p.limit, p.J * acceleration + reference.effort))
    return effort, State(motion.q, motion.v)


@kernel
def start(measured, velocity, acceleration, dt, p):
    """Return the state of a law that takes over a motion at `velocity` [m/s or rad/s] and `acceleration`."""
    before = motion_before(measured, velocity, acceleration, dt)
    return State(before.q, before.v)


MODEL = sliding_mode = Controller(
    name="sliding_mode",
    description="sliding mode with boundary layer, velocity from the measured position, and friction fed forward",
    Parameters=Parameters,
    State=State,
    step=step,
    start=start,
)
