r"""The position-velocity cascade of servo drives, with anti-windup and feedforward.

.. math::
    v_\text{cmd} &= k_p\,(r - q) + k_{ff}\,\hat{\dot r} \\
    u &= k_v\,(v_\text{cmd} - \hat v) + I + u_{ff}, \qquad
    I \leftarrow I + k_i\,(v_\text{cmd} - \hat v)\,T_s \\
    \hat v &= \frac{q_k - q_{k-m}}{m\,T_s}, \qquad \hat{\dot r} = \frac{r_k - r_{k-m}}{m\,T_s}

with :math:`u` limited to :math:`\pm u_\text{max}`. The integral :math:`I` stops while the limit is reached and the
error would increase :math:`I` further (conditional integration). :math:`u_{ff}` is the feedforward of the reference:
inertia and friction along the desired trajectory. With ``averaging = 2``, which is :math:`m`, the velocity is the
backward difference of the mean of two samples. A difference lags by half of its span. Measured and commanded velocity
therefore use the same samples: unequal lags would cause an error in proportion to the acceleration.

References
----------
.. [1] G. Ellis, "Control System Design Guide", 4th ed., Butterworth-Heinemann, 2012.
   doi:10.1016/C2010-0-65994-3
"""

import math
from typing import Annotated, NamedTuple

from bristle.core import Controller, Variable, kernel
from bristle.models.controllers.quantities import EffortLimit
from bristle.models.controllers.velocity import samples_before


class Parameters(NamedTuple):
    """Parameters of the cascade."""

    k_p: Annotated[float, Variable("1/time", "position gain", min=0.0, nominal=100.0)]
    k_v: Annotated[float, Variable("force*time/length", "velocity gain", min=0.0, nominal=100.0)]
    k_i: Annotated[
        float, Variable("force/length", "integral gain of the velocity loop", min=0.0)
    ] = 0.0
    k_ff: Annotated[
        float, Variable("1", "share of the reference velocity fed forward", min=0.0, max=2.0)
    ] = 0.0
    limit: EffortLimit = math.inf
    averaging: Annotated[
        int, Variable("1", "number of samples in the velocity difference", min=1, max=2)
    ] = 1


class State(NamedTuple):
    """State of the cascade."""

    q_1: Annotated[float, Variable("length", "measured position one sample ago")] = 0.0
    q_2: Annotated[float, Variable("length", "measured position two samples ago")] = 0.0
    integral: Annotated[float, Variable("force", "integral part of the effort")] = 0.0
    r_1: Annotated[float, Variable("length", "desired position one sample ago")] = 0.0
    r_2: Annotated[float, Variable("length", "desired position two samples ago")] = 0.0


@kernel
def step(state, reference, measured, dt, p):
    """Return the effort [N or N*m] and the state, for one sample."""
    if p.averaging == 2:
        v_hat = (measured - state.q_2) / (2.0 * dt)
        r_dot = (reference.position - state.r_2) / (2.0 * dt)
    else:
        v_hat = (measured - state.q_1) / dt
        r_dot = (reference.position - state.r_1) / dt
    v_error = p.k_p * (reference.position - measured) + p.k_ff * r_dot - v_hat
    integral = state.integral + p.k_i * v_error * dt
    demand = p.k_v * v_error + integral + reference.effort
    effort = max(-p.limit, min(p.limit, demand))
    if effort != demand and v_error * demand > 0.0:
        integral = state.integral
        effort = max(-p.limit, min(p.limit, p.k_v * v_error + integral + reference.effort))
    return effort, State(measured, state.q_1, integral, reference.position, state.r_1)


@kernel
def start(measured, velocity, acceleration, dt, p):
    """Return the state of a cascade that takes over a motion at `velocity` [m/s or rad/s] and `acceleration`."""
    before, two_before = samples_before(measured, velocity, acceleration, dt)
    return State(before, two_before, 0.0)


@kernel
def resume(state, reference, measured, effort, dt, p):
    """Return the state of a cascade after it has followed a reference with a known effort."""
    r_1, r_2 = samples_before(reference.position, reference.velocity, reference.acceleration, dt)
    followed = State(state.q_1, state.q_2, state.integral, r_1, r_2)
    if math.isnan(effort) or p.k_i == 0.0:
        return followed
    proportional = Parameters(p.k_p, p.k_v, 0.0, p.k_ff, math.inf, p.averaging)
    without, _ = step(followed, reference, measured, dt, proportional)
    return State(state.q_1, state.q_2, state.integral + effort - without, r_1, r_2)


MODEL = cascade = Controller(
    name="cascade",
    description="position-velocity cascade with anti-windup and feedforward, as in servo drives",
    Parameters=Parameters,
    State=State,
    step=step,
    start=start,
    resume=resume,
    reference="doi:10.1016/C2010-0-65994-3",
)
