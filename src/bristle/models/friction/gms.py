r"""The generalised Maxwell-slip model: Maxwell-slip elements that slip by the Stribeck curve and lag behind it.

.. math::
    F = \sum_i F_i + \sigma_2 v, \qquad
    \dot F_i = \begin{cases} k_i v & \text{sticking, until } |F_i| = \nu_i G(v) \\
    C \left(\nu_i \operatorname{sgn} v - F_i/G(v)\right) & \text{slipping, until } v \text{ changes sign}\end{cases}

with :math:`G(v) = F_C + (F_S - F_C)\,e^{-(v/v_S)^2}`. Pre-sliding has the non-local memory of Maxwell slip. In sliding
the attraction :math:`C` makes the force follow the Stribeck curve with a lag, and
in steady sliding :math:`F_{ss} = G(v) \operatorname{sgn} v + \sigma_2 v`. A step at constant velocity is exact, and so is
its mean force.

References
----------
.. [1] F. Al-Bender, V. Lampaert, J. Swevers, "The generalized Maxwell-slip model: a novel model for friction
   simulation and compensation", IEEE Transactions on Automatic Control 50(11), 2005. doi:10.1109/TAC.2005.858676
"""

from typing import Annotated, NamedTuple

import numpy as np

from bristle.core import FrictionModel, Variable, kernel
from bristle.core.mathematics import direction, relaxation
from bristle.models.friction.lugre import stribeck_force
from bristle.models.friction.maxwell_slip import RELATIONS
from bristle.models.friction.quantities import (
    CoulombForceAboveZero,
    ElementStiffness,
    StaticForceAboveZero,
    StribeckVelocity,
    ViscousCoefficient,
)
from bristle.models.friction.stribeck import STATIC_ABOVE_COULOMB


class Parameters(NamedTuple):
    """Parameters of the generalised Maxwell-slip model."""

    F_C: CoulombForceAboveZero
    F_S: StaticForceAboveZero
    v_S: StribeckVelocity
    C: Annotated[
        float,
        Variable(
            "force/time",
            "attraction to the Stribeck curve",
            min=1e-9,
            nominal=1e3,
            excitation="stribeck",
        ),
    ]
    k_i: ElementStiffness
    nu_i: Annotated[
        np.ndarray, Variable("1", "share of each element in the Stribeck force", min=0.0, max=1.0)
    ]
    sigma_2: ViscousCoefficient = 0.0


class State(NamedTuple):
    """The state is the memory: the force of each element, then its direction of slip, 0 while it sticks."""


class Move(NamedTuple):
    """Result of a trial, applied by commit: the motion, the Stribeck force [N or N*m], the mean of the decay towards it."""

    v: float
    dt: float
    G: float
    decay: float


class Element(NamedTuple):
    """One element after a step: force at its end, mean force, and the direction in which it slips."""

    F: float
    mean: float
    slips: float


@kernel
def element_after(f, slips, v, dt, k, limit, attraction, decay):
    """Return the `Element` after a step at constant velocity, with forces [N or N*m] along the motion.

    `limit` [N or N*m] is its share of the Stribeck force, `attraction` [1/s] its relaxation rate, `decay` the mean
    decay over the step, which is the same for every element.
    """
    if not slips and f < limit:
        ramp = k * v * dt
        if f + ramp < limit:
            return Element(f + ramp, f + 0.5 * ramp, 0.0)
        stuck = (limit - f) / ramp
        return Element(limit, stuck * 0.5 * (f + limit) + (1.0 - stuck) * limit, 1.0)
    return Element(f + (limit - f) * decay * attraction * dt, f + (limit - f) * (1.0 - decay), 1.0)


@kernel
def element(memory, i, v, dt, G, decay, p):
    """Return the `Element` number `i` after a step at constant velocity."""
    side = direction(v)
    slips = memory[p.k_i.size + i] == side
    return element_after(
        side * memory[i], slips, abs(v), dt, p.k_i[i], p.nu_i[i] * G, p.C / G, decay
    )


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and the motion."""
    v = motion.v
    G = stribeck_force(v, p)
    decay = relaxation(p.C / G * dt)
    total = 0.0
    for i in range(p.k_i.size):
        total += element(memory, i, v, dt, G, decay, p).mean
    return direction(v) * total + p.sigma_2 * v, Move(v, dt, G, decay)


@kernel
def commit(state, memory, move, p):
    """Let every element stretch or slip by the motion of the step; without motion all elements stick."""
    side = direction(move.v)
    if move.v == 0.0:
        # An element slips until the velocity passes zero; at rest it keeps its force, on either side.
        for i in range(p.k_i.size):
            memory[p.k_i.size + i] = 0.0
        return state
    for i in range(p.k_i.size):
        after = element(memory, i, move.v, move.dt, move.G, move.decay, p)
        memory[i] = side * after.F
        memory[p.k_i.size + i] = side * after.slips
    return state


def memory_size(p: Parameters) -> int:
    """Return two numbers for each element: its force and the direction in which it slips."""
    return 2 * len(p.k_i)


MODEL = gms = FrictionModel(
    name="gms",
    description="Maxwell-slip elements that follow the Stribeck curve with a lag: non-local memory, does not drift",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    memory_size=memory_size,
    relations=(STATIC_ABOVE_COULOMB, *RELATIONS),
    reference="doi:10.1109/TAC.2005.858676",
    example={
        "F_C": 20.0,
        "F_S": 28.0,
        "v_S": 2e-3,
        "C": 2e3,
        "k_i": [6e6, 3e6, 1e6],
        "nu_i": [0.3, 0.4, 0.3],
        "sigma_2": 800.0,
    },
)
