r"""The friction of the simulated axis: thirty spring-slider elements with limits that fall with speed.

.. math::
    F = \sum_i f_i + \frac{F_v\,v}{1 + |v|/v_v}, \qquad
    |f_i| \le \alpha_i\,\gamma_\pm S(v), \qquad S(v) = F_C + (F_S - F_C)\,e^{-(v/v_S)^2}

Element `i` has the stiffness :math:`\alpha_i F_S / r_i` and breaks away after :math:`r_i`. The oil film thins with
speed. No model fitted by the demonstration has this structure: identification must be tested on friction that differs
from its model. This file is also an example of a user's model.
"""

from typing import Annotated, NamedTuple

import numpy as np

from bristle.core import FrictionModel, Relation, Variable, exp, kernel
from bristle.models.friction import spectrum


class Parameters(NamedTuple):
    """Parameters of the simulated axis."""

    F_C: Annotated[float, Variable("force", "Coulomb friction force", min=1e-9)]
    F_S: Annotated[float, Variable("force", "static (break-away) friction force", min=1e-9)]
    v_S: Annotated[float, Variable("length/time", "Stribeck velocity", min=1e-9)]
    F_v: Annotated[
        float, Variable("force*time/length", "viscous friction coefficient at rest", min=0.0)
    ]
    v_v: Annotated[
        float, Variable("length/time", "speed at which the viscous friction is halved", min=1e-9)
    ]
    forward: Annotated[float, Variable("1", "factor on the limits in forward motion", min=0.0)]
    backward: Annotated[float, Variable("1", "factor on the limits in backward motion", min=0.0)]
    alpha_i: Annotated[
        np.ndarray, Variable("1", "share of each element in the force", min=0.0, max=1.0)
    ]
    r_i: Annotated[np.ndarray, Variable("length", "break-away distance of each element", min=1e-12)]


class State(NamedTuple):
    """State and memory: the force of each element over its share."""


class Move(NamedTuple):
    """The result of a trial for commit."""

    dx: float
    limit: float


@kernel
def limit_of(v, p):
    """Return the force limit [N or N*m] of all elements together, in the direction of `v`."""
    ratio = v / p.v_S
    side = p.forward if v > 0.0 else p.backward
    return side * (p.F_C + (p.F_S - p.F_C) * exp(-ratio * ratio))


@kernel
def pulled(f, dx, stiffness, limit):
    """Return the force of an element with the force `f` after a displacement `dx`; a falling limit lowers it."""
    if dx > 0.0:
        return min(f + stiffness * dx, limit)
    if dx < 0.0:
        return max(f + stiffness * dx, -limit)
    return f


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] of a step at constant velocity."""
    v = motion.v
    dx = v * dt
    limit = limit_of(v, p)
    total = 0.0
    for i in range(p.r_i.size):
        f = memory[i]
        total += 0.5 * p.alpha_i[i] * (f + pulled(f, dx, p.F_S / p.r_i[i], limit))
    return total + p.F_v * v / (1.0 + abs(v) / p.v_v), Move(dx, limit)


@kernel
def commit(state, memory, move, p):
    """Pull every element by the displacement of the step."""
    for i in range(p.r_i.size):
        memory[i] = pulled(memory[i], move.dx, p.F_S / p.r_i[i], move.limit)
    return state


def memory_size(p: Parameters) -> int:
    """Return the number of elements."""
    return len(p.r_i)


SHARES, DISTANCES = spectrum(30, 7e-6, seed=7)

MODEL = FrictionModel(
    name="simulated_axis",
    description="thirty spring-slider elements with limits that fall with speed, and an oil film that thins",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    memory_size=memory_size,
    relations=(
        Relation("F_S >= F_C", lambda p: p.F_S >= p.F_C, "Raise F_S or lower F_C"),
        Relation(
            "alpha_i and r_i of the same length",
            lambda p: len(p.alpha_i) == len(p.r_i),
            "Give one value of each per element",
            structural=True,
        ),
    ),
    example={
        "F_C": 32.0,
        "F_S": 41.0,
        "v_S": 6e-3,
        "F_v": 260.0,
        "v_v": 0.6,
        "forward": 1.06,
        "backward": 0.94,
        "alpha_i": SHARES.tolist(),
        "r_i": DISTANCES.tolist(),
    },
)
