r"""The path of a friction force to the drive: share, asymmetry, offset and limits.

.. math:: u_\text{ff} = F_0 + \sigma_2 v + h\,C\,(1 + a \operatorname{sgn} C) + u_0, \qquad C = \hat F - F_0 - \sigma_2 v

limited in amplitude and in rate. The constant part :math:`F_0` and the viscous part :math:`\sigma_2 v` are fed forward whole, the
contact force `C` with a share `h`. With :math:`F_0 = \sigma_2 = 0` the share scales the force. The asymmetry and the offset
are for differences between the directions that the model lacks.

An integrating controller takes the load of a resting axis over. Without :math:`h \to 0` its effort and the feed add up at the
next reversal, and the axis jumps by about `F/K`, the friction over the stiffness of the position loop. Therefore the share
returns to the gain `g` with a travel constant :math:`s_r`, and fades at rest with a time constant :math:`\tau`:

.. math::
    \Delta h = (g - h) \frac{|\Delta x|}{s_r + |\Delta x|} \text{ in motion}, \qquad
    \Delta h = -h \frac{\Delta t}{\tau + \Delta t} \text{ at rest}

With :math:`s_r = 0` the share is the gain.

At rest the force of a set-valued model is the reaction to the applied force, anywhere between its two
one-sided limits. No model knows the applied force, so the middle is fed forward. The contact does not move, and its
state does not change with either limit. The same kernel runs along a desired motion, in a loop along the measured
motion, and in every export.
"""

import math
from typing import Annotated, Any, NamedTuple

from bristle.core import Variable, kernel
from bristle.core.contracts import STILL, Motion
from bristle.core.dispatch import friction_commit, friction_trial
from bristle.core.experiment import FEEDFORWARD


class Shape(NamedTuple):
    """Shape of the feedforward of a friction force."""

    gain: Annotated[float, FEEDFORWARD["gain"]] = 1.0
    offset: Annotated[float, FEEDFORWARD["offset"]] = 0.0
    asymmetry: Annotated[float, FEEDFORWARD["asymmetry"]] = 0.0
    limit: Annotated[float, FEEDFORWARD["limit"]] = math.inf
    rate_limit: Annotated[float, FEEDFORWARD["rate_limit"]] = math.inf
    return_distance: Annotated[float, FEEDFORWARD["return_distance"]] = 0.0
    fade_time: Annotated[float, FEEDFORWARD["fade_time"]] = math.inf
    constant: Annotated[
        float, Variable("force", "constant part of the friction, fed forward whole")
    ] = 0.0
    viscous: Annotated[
        float, Variable("force*time/length", "viscous part of the friction, fed forward whole")
    ] = 0.0


FIELDS = len(Shape._fields)


class Rule(NamedTuple):
    """The share of the friction that an exported compensator feeds forward, as in `Shape`."""

    gain: Annotated[float, FEEDFORWARD["gain"]] = 1.0
    return_distance: Annotated[float, FEEDFORWARD["return_distance"]] = 0.0
    fade_time: Annotated[float, FEEDFORWARD["fade_time"]] = 0.5
    constant: Annotated[
        float, Variable("force", "constant part of the friction, fed forward whole")
    ] = 0.0
    viscous: Annotated[
        float, Variable("force*time/length", "viscous part of the friction, fed forward whole")
    ] = 0.0


@kernel
def form_of(n):
    """Return a shape from a vector of its fields."""
    return Shape(n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7], n[8])


@kernel
def share_after(share, v, dt, shape):
    """Return the share `h` of the contact force after a step at a velocity [m/s or rad/s]."""
    if shape.return_distance == 0.0:
        return shape.gain
    if abs(v) <= STILL:
        return share - share * dt / (shape.fade_time + dt)
    way = abs(v) * dt
    return share + (shape.gain - share) * way / (shape.return_distance + way)


@kernel
def unscaled_at(v, shape):
    """Return the force [N or N*m] that is fed forward whole at a velocity: the constant and the viscous part of the friction."""
    if shape.constant == 0.0 and shape.viscous == 0.0:
        return 0.0
    return shape.constant + shape.viscous * v


WHOLE = Rule()
"""All of the friction."""


def feedforward_of(rule: Rule) -> dict[str, Any]:
    """Return the entries of a `Feedforward` with the share of a rule; empty if it feeds the whole friction."""
    if rule == WHOLE:
        return {}
    share: dict[str, Any] = {"gain": rule.gain, "scaled": "contact"}
    if rule.return_distance:
        share |= {"return_distance": rule.return_distance, "fade_time": rule.fade_time}
    return share


class Portion(NamedTuple):
    """The share of the contact force after a step, and the effort that is fed forward."""

    share: Annotated[float, Variable("1", "share of the contact force")] = 0.0
    effort: Annotated[float, Variable("force", "effort fed forward")] = 0.0


@kernel
def portion(force, share, v, dt, rule):
    """Return the share of the contact force and the effort [N or N*m] after a step at a velocity, for a friction `force`."""
    now = share_after(share, v, dt, rule)
    unscaled = unscaled_at(v, rule)
    return Portion(now, unscaled + now * (force - unscaled))


@kernel
def shaped(force, unscaled, share, before, dt, shape):
    """Return the effort [N or N*m] fed forward for a friction `force`; `before` is that of the last sample."""
    contact = force - unscaled
    demand = (
        unscaled
        + share * contact * (1.0 + shape.asymmetry * math.copysign(1.0, contact))
        + shape.offset
    )
    demand = max(-shape.limit, min(shape.limit, demand))
    change = shape.rate_limit * dt
    return max(before - change, min(before + change, demand))


@kernel
def compensate(state, memory, motion, share, before, dt, shape, p):
    """Return the effort [N or N*m] fed forward for a step of a motion, and the share and the state of the compensator after it.

    `share` and `before` are share and effort of the last sample, `p` are the parameters of the friction model.
    """
    force, move = friction_trial(state, memory, motion, dt, p)
    if motion.v == 0.0:
        reverse = Motion(-motion.v, motion.x, motion.load, motion.temperature, motion.transmitted)
        force = 0.5 * (force + friction_trial(state, memory, reverse, dt, p)[0])
    share = share_after(share, motion.v, dt, shape)
    effort = shaped(force, unscaled_at(motion.v, shape), share, before, dt, shape)
    return effort, share, friction_commit(state, memory, move, p)
