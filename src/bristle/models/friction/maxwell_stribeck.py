r"""Maxwell-slip elements with limits that fall with speed and scatter from reversal to reversal.

.. math::
    F = \sum_i k_i e_i + \sigma_1 n_s v + \sigma_2 v, \qquad
    |k_i e_i| \le \nu_i\,\gamma\,G(v), \qquad G(v) = F_C + (F_S - F_C)\,e^{-(v/v_S)^2}

Each element sticks and stretches by :math:`e_i`, or slips at its share :math:`\nu_i` of the Stribeck curve. If the
limit falls below the force of an element, the force drops to the limit at once. :math:`n_s` is the share of the
elements that stick: micro-damping acts only in contacts that have not broken away. Real friction does not repeat
exactly. The model therefore draws :math:`\gamma = 1 + s\,\xi` anew at each reversal of the velocity, with :math:`\xi`
standard normal and `s` the parameter ``scatter``. Reversals below the speed :math:`v_r` do not count. Runs with equal
seeds are identical to the bit.

References
----------
.. [1] V. Lampaert, F. Al-Bender, J. Swevers, "A generalized Maxwell-slip friction model appropriate for control
   purposes", Proc. IEEE Int. Conf. Physics and Control, 2003. doi:10.1109/PHYCON.2003.1237071
"""

from typing import Annotated, NamedTuple

import numpy as np

from bristle.core import FrictionModel, Variable, kernel
from bristle.core.mathematics import direction, exp
from bristle.core.random_numbers import SEED_MAX, normal
from bristle.models.friction.maxwell_slip import RELATIONS
from bristle.models.friction.quantities import (
    CoulombForceAboveZero,
    ElementStiffness,
    StaticForceAboveZero,
    StribeckVelocity,
    ViscousCoefficient,
)
from bristle.models.friction.stribeck import STATIC_ABOVE_COULOMB

# Even with large scatter, a limit keeps a part of its value.
SMALLEST_SCALE = 0.05
BEYOND = 1e150  # times a limit: more than any force


class Parameters(NamedTuple):
    """Parameters of Maxwell-slip elements with Stribeck limits."""

    F_C: CoulombForceAboveZero
    F_S: StaticForceAboveZero
    v_S: StribeckVelocity
    k_i: ElementStiffness
    nu_i: Annotated[
        np.ndarray, Variable("1", "share of each element in the limit force", min=0.0, max=1.0)
    ]
    sigma_1: Annotated[
        float,
        Variable(
            "force*time/length",
            "micro-damping while all elements stick",
            min=0.0,
            excitation="presliding",
        ),
    ] = 0.0
    sigma_2: ViscousCoefficient = 0.0
    scatter: Annotated[
        float,
        Variable(
            "1",
            "relative standard deviation of the limit force between reversals",
            min=0.0,
            max=0.3,
        ),
    ] = 0.0
    v_r: Annotated[
        float, Variable("length/time", "speed above which a reversal counts", min=0.0)
    ] = 0.0
    seed: Annotated[int, Variable("1", "seed of the scatter", min=0, max=SEED_MAX)] = 0


class State(NamedTuple):
    """State in addition to the memory, which is the forces of the elements."""

    side: Annotated[float, Variable("1", "direction of the motion; 0 before the first")] = 0.0
    reversals: Annotated[int, Variable("1", "reversals so far", min=0)] = 0
    scale: Annotated[
        float, Variable("1", "factor on the limit since the last reversal", min=0.0)
    ] = 1.0


class Move(NamedTuple):
    """Result of a trial, applied by commit."""

    v: float
    way: float
    limit: float


@kernel
def reverses(state, v, p):
    """Return whether a step at the velocity `v` is the first after a reversal, or the very first."""
    return abs(v) > p.v_r and (direction(v) * state.side < 0.0 or state.side == 0.0)


@kernel(inline=False)
def drawn_scale(state, p):
    """Return the factor on the limit after the next reversal."""
    return max(1.0 + p.scatter * normal(p.seed, state.reversals), SMALLEST_SCALE)


@kernel
def limit_of(state, v, p):
    """Return the force [N or N*m] at which all elements slip at the velocity `v`.

    The first limit applies from the first step. A later limit applies from the step after the reversal that drew it:
    if the force jumped with the velocity within a step, an implicit step would have no solution.
    """
    ratio = v / p.v_S
    scale = drawn_scale(state, p) if state.side == 0.0 else state.scale
    return scale * (p.F_C + (p.F_S - p.F_C) * exp(-ratio * ratio))


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and the move."""
    v = motion.v
    side = direction(v)
    way = abs(v) * dt
    limit = limit_of(state, v, p)
    total, slipping = 0.0, 0.0
    for i in range(p.k_i.size):
        f_max = p.nu_i[i] * limit
        f = min(side * memory[i], f_max)
        rise = p.k_i[i] * way
        beyond = f + rise - f_max
        total += f + 0.5 * rise
        if beyond > 0.0:
            # It slips over the last part of the step, and the mean lacks its rise there.
            part = beyond / rise
            total -= 0.5 * beyond * part
            slipping += part
    sticking = 1.0 - slipping / p.k_i.size
    return side * total + (p.sigma_1 * sticking + p.sigma_2) * v, Move(v, way, limit)


@kernel
def commit(state, memory, move, p):
    """Pull every element by the displacement of the step; a reversal draws a new limit."""
    side = direction(move.v)
    # Without motion no limit, in either direction, changes an element.
    limit = move.limit if move.v != 0.0 else BEYOND * move.limit
    for i in range(p.k_i.size):
        memory[i] = side * min(side * memory[i] + p.k_i[i] * move.way, p.nu_i[i] * limit)
    return (
        State(side, state.reversals + 1, drawn_scale(state, p))
        if reverses(state, move.v, p)
        else state
    )


def memory_size(p: Parameters) -> int:
    """Return the number of elements."""
    return len(p.k_i)


MODEL = maxwell_stribeck = FrictionModel(
    name="maxwell_stribeck",
    description="spring-slider elements in parallel with Stribeck limits that scatter from reversal to reversal",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    memory_size=memory_size,
    relations=(*RELATIONS, STATIC_ABOVE_COULOMB),
    reference="doi:10.1109/PHYCON.2003.1237071",
    example={
        "F_C": 20.0,
        "F_S": 28.0,
        "v_S": 2e-3,
        "k_i": [6e6, 3e6, 1e6],
        "nu_i": [0.3, 0.4, 0.3],
        "sigma_1": 1e3,
        "sigma_2": 200.0,
        "scatter": 0.05,
        "v_r": 1e-7,
        "seed": 1,
    },
)
