r"""The Maxwell-slip model: spring-slider elements in parallel, with non-local memory.

.. math::
    F = \sum_i k_i e_i + \sigma_2 v, \qquad \dot e_i = v \text{ while } |k_i e_i| < \nu_i F_C, \text{ else } 0

Each element sticks and stretches by :math:`e_i`, or slips at its share :math:`\nu_i` of the Coulomb force. A loop
inside a larger loop closes exactly. The mean force of a step at constant velocity is exact.

References
----------
.. [1] V. Lampaert, F. Al-Bender, J. Swevers, "A generalized Maxwell-slip friction model appropriate for control
   purposes", Proc. IEEE Int. Conf. Physics and Control, 2003. doi:10.1109/PHYCON.2003.1237071
"""

from typing import Annotated, NamedTuple

import numpy as np

from bristle.core import FrictionModel, Relation, Variable, kernel
from bristle.models.friction.quantities import (
    CoulombForceAboveZero,
    ElementStiffness,
    ViscousCoefficient,
)


class Parameters(NamedTuple):
    """Parameters of the Maxwell-slip model."""

    F_C: CoulombForceAboveZero
    k_i: ElementStiffness
    nu_i: Annotated[
        np.ndarray, Variable("1", "share of each element in the Coulomb force", min=0.0, max=1.0)
    ]
    sigma_2: ViscousCoefficient = 0.0


class State(NamedTuple):
    """The state is the memory: the deflection of each element."""


class Move(NamedTuple):
    """Result of a trial, applied by commit."""

    dx: float


RELATIONS = (
    Relation(
        "k_i and nu_i of the same length, at least 1",
        lambda p: len(p.k_i) == len(p.nu_i) >= 1,
        "Give one stiffness and one share for each element",
        structural=True,
    ),
    Relation(
        "sum of nu_i = 1",
        lambda p: abs(float(np.sum(p.nu_i)) - 1.0) <= 1e-9,
        "Divide each value of nu_i by the sum of all",
    ),
)


@kernel
def stretched(e, dx, limit):
    """Return the deflection [m or rad] of an element at `e` after a displacement `dx`."""
    if dx > 0.0:
        return min(e + dx, max(limit, e))
    return max(e + dx, min(-limit, e))


@kernel
def slip(level, stiffness):
    """Return the deflection [m or rad] at which an element slips; 0 without stiffness, as an identified element may have."""
    return level / stiffness if stiffness > 0.0 else 0.0


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and the displacement."""
    dx = motion.v * dt
    total = 0.0
    lag = 0.0
    for i in range(p.k_i.size):
        e = memory[i]
        e_next = stretched(e, dx, slip(p.nu_i[i] * p.F_C, p.k_i[i]))
        total += p.k_i[i] * e_next
        lag += p.k_i[i] * (e_next - e) * (e_next - e)
    if dx != 0.0:
        total -= 0.5 * lag / dx
    return total + p.sigma_2 * motion.v, Move(dx)


@kernel
def commit(state, memory, move, p):
    """Stretch every element by the displacement of the step."""
    for i in range(p.k_i.size):
        memory[i] = stretched(memory[i], move.dx, slip(p.nu_i[i] * p.F_C, p.k_i[i]))
    return state


def memory_size(p: Parameters) -> int:
    """Return the number of elements."""
    return len(p.k_i)


MODEL = maxwell_slip = FrictionModel(
    name="maxwell_slip",
    description="spring-slider elements in parallel: non-local memory, closes its loops",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    memory_size=memory_size,
    relations=RELATIONS,
    reference="doi:10.1109/PHYCON.2003.1237071",
    example={"F_C": 20.0, "k_i": [6e6, 3e6, 1e6], "nu_i": [0.3, 0.4, 0.3], "sigma_2": 200.0},
)
