r"""The path of a friction force to the drive: gain, asymmetry, offset and limits.

.. math:: u_\text{ff} = g\,\hat F\,(1 + a \operatorname{sgn} \hat F) + u_0

limited in amplitude and in rate. A gain below 1 leaves a margin for errors of the model; the asymmetry and
the offset are for differences between the directions that the model lacks.

At rest the force of a set-valued model is the reaction to the applied force, anywhere between its two
one-sided limits. No model knows the applied force, so the middle is fed forward. The contact does not move, and its
state does not change with either limit. The same kernel runs along a desired motion, in a loop along the measured
motion, and in every export.
"""

import math
from typing import Annotated, NamedTuple

from bristle.core.contracts import Motion
from bristle.core.dispatch import friction_commit, friction_trial
from bristle.core.experiment import FEEDFORWARD
from bristle.core.kernel import kernel


class Shape(NamedTuple):
    """Shape of the feedforward of a friction force."""

    gain: Annotated[float, FEEDFORWARD["gain"]] = 1.0
    offset: Annotated[float, FEEDFORWARD["offset"]] = 0.0
    asymmetry: Annotated[float, FEEDFORWARD["asymmetry"]] = 0.0
    limit: Annotated[float, FEEDFORWARD["limit"]] = math.inf
    rate_limit: Annotated[float, FEEDFORWARD["rate_limit"]] = math.inf


@kernel
def shaped(force, before, dt, shape):
    """Return the effort [N or N*m] fed forward for a friction `force`; `before` is that of the last sample."""
    demand = shape.gain * force * (1.0 + shape.asymmetry * math.copysign(1.0, force)) + shape.offset
    demand = max(-shape.limit, min(shape.limit, demand))
    change = shape.rate_limit * dt
    return max(before - change, min(before + change, demand))


@kernel
def compensate(state, memory, motion, before, dt, shape, p):
    """Return the effort [N or N*m] fed forward for a step of a motion, and the state of the compensator after it.

    `before` is the effort of the last sample, `p` the parameters of the friction model.
    """
    force, move = friction_trial(state, memory, motion, dt, p)
    if motion.v == 0.0:
        reverse = Motion(-motion.v, motion.x, motion.load, motion.temperature, motion.transmitted)
        force = 0.5 * (force + friction_trial(state, memory, reverse, dt, p)[0])
    return shaped(force, before, dt, shape), friction_commit(state, memory, move, p)
