r"""Wind-up of an elastic screw along the desired motion of its table, one sample at a time.

The force :math:`f` of the screw in a step gives the travel by which the motor leads the table,
:math:`f / k + g \operatorname{sgn} f`. A weighted mean over the samples around each sample is the twist :math:`w`. The
motor leads by :math:`\theta = w - \frac{d}{k}\,\dot w`, and its effort without friction is

.. math:: J\,(\ddot x_r + \ddot\theta) + r\,k\,D_g(r w)

The memory holds the leads inside the mean, then the last twists. Before the first sample, the lead is constant. The
same kernels run along the motion of a simulated loop and in every exported law.
"""

import math
from typing import Annotated, NamedTuple

import numpy as np

from bristle.core import Variable, kernel

AROUND = 3  # twists on each side of a sample that its outputs need


class WindUp(NamedTuple):
    """Both masses, the screw, and the weights of the mean."""

    M: Annotated[float, Variable("mass of travel", "mass of the table fed forward", min=0.0)]
    k: Annotated[
        float, Variable("force of travel/travel", "stiffness of the screw fed forward", min=1.0)
    ]
    d: Annotated[
        float, Variable("force of travel*time/travel", "damping of the screw fed forward", min=0.0)
    ]
    gap: Annotated[float, Variable("travel", "half of the backlash fed forward", min=0.0)]
    arm: Annotated[
        float, Variable("travel/length", "travel for one radian of the motor", min=1e-12)
    ]
    J: Annotated[float, Variable("mass", "inertia of the motor fed forward", min=0.0)]
    clear: Annotated[
        float, Variable("force of travel", "force of the screw that changes its flank", min=0.0)
    ]
    weights: Annotated[np.ndarray, Variable("1", "weights of the mean, with the sum 1")]


class Wound(NamedTuple):
    """State of the wind-up after a step."""

    side: Annotated[
        float, Variable("1", "flank of the screw: 1 or -1, 0 in the middle of the gap")
    ] = 0.0
    lead: Annotated[float, Variable("travel", "travel by which the motor leads the table")] = 0.0


@kernel
def wind(state, memory, force, first, p):
    """Return the wind-up after a step with a force of the screw [N]; `memory` receives the next twist [rad]."""
    side = math.copysign(1.0, force) if abs(force) > p.clear else state.side
    lead = force / p.k + p.gap * side
    mean = lead if first else 0.5 * (lead + state.lead)
    size, twist = p.weights.size, 0.0
    for i in range(size):
        memory[i] = mean if first or i == size - 1 else memory[i + 1]
        twist = twist + p.weights[i] * memory[i]
    twist = twist / p.arm
    for i in range(size, memory.size):
        memory[i] = twist if first or i == memory.size - 1 else memory[i + 1]
    return Wound(side, lead)


@kernel
def lead_at(memory, at, dt, p):
    """Return the angle [rad] by which the motor leads at a place of the memory; the damper takes its share of the force."""
    return memory[at] - p.d / p.k * ((memory[at + 1] - memory[at - 1]) / (2.0 * dt))


@kernel
def rate_at(memory, at, dt, p):
    """Return the rate [rad/s] of the lead at a place of the memory."""
    return (lead_at(memory, at + 1, dt, p) - lead_at(memory, at - 1, dt, p)) / (2.0 * dt)


@kernel
def bend_at(memory, at, dt, p):
    """Return the acceleration [rad/s^2] of the lead at a place of the memory."""
    return (rate_at(memory, at + 1, dt, p) - rate_at(memory, at - 1, dt, p)) / (2.0 * dt)


@kernel
def winding_effort(memory, at, acceleration, dt, p):
    """Return the effort [N*m] in the step after a place of the memory, for its mean desired acceleration [rad/s^2]."""
    stretched = 0.5 * p.arm * (memory[at] + memory[at + 1])
    pull = p.k * (stretched - max(-p.gap, min(p.gap, stretched)))
    return (
        p.J * (acceleration + (rate_at(memory, at + 1, dt, p) - rate_at(memory, at, dt, p)) / dt)
        + p.arm * pull
    )
