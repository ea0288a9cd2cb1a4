r"""The Prandtl–Ishlinskii operator: stops in parallel, and a spring.

.. math:: f = k u + \sum_i w_i\,\mathcal S_{r_i}[u]

The virgin curve :math:`\varphi(x) = k x + \sum_i w_i \min(x, r_i)` describes the operator completely. Each branch is
:math:`f_n \pm 2\varphi(|u - u_n|/2)` (Masing's rule), so minor loops of equal width are congruent everywhere. This
operator is a Preisach operator whose measure depends on :math:`\alpha - \beta` only. Weights may have any sign; those
of friction are positive.

References
----------
.. [1] M. Brokate, J. Sprekels, "Hysteresis and Phase Transitions", Springer, 1996. doi:10.1007/978-1-4612-4048-8
"""

from typing import Annotated, NamedTuple

import numpy as np

from bristle.core import HysteresisOperator, Relation, Variable, kernel
from bristle.models.hysteresis.play import played


class Parameters(NamedTuple):
    """Parameters of the Prandtl–Ishlinskii operator."""

    thresholds: Annotated[
        np.ndarray, Variable("length", "deflection at which each stop slips", min=0.0)
    ]
    weights: Annotated[np.ndarray, Variable("force/length", "stiffness of each stop", nominal=1e6)]
    spring: Annotated[
        float, Variable("force/length", "stiffness of the spring, which never slips")
    ] = 0.0


class State(NamedTuple):
    """The state is the memory: the place of each slider."""


class Move(NamedTuple):
    """Result of a trial, applied by commit."""

    u: float


SAME_LENGTH = Relation(
    "thresholds and weights of the same length, at least 1",
    lambda p: len(p.thresholds) == len(p.weights) >= 1,
    "Give one threshold and one weight for each element",
)


@kernel
def force_of_sliders(places, u, p):
    """Return the force [N or N*m] at the input `u` [m or rad] of sliders at these places."""
    f = p.spring * u
    for i in range(p.thresholds.size):
        f += p.weights[i] * (u - played(places[i], u, p.thresholds[i]))
    return f


@kernel
def trial(state, memory, u, p):
    """Return the force [N or N*m] at the input `u` [m or rad], and the move there."""
    return force_of_sliders(memory, u, p), Move(u)


@kernel
def commit(state, memory, move, p):
    """Let every slider follow the input."""
    for i in range(p.thresholds.size):
        memory[i] = played(memory[i], move.u, p.thresholds[i])
    return state


MODEL = prandtl_ishlinskii = HysteresisOperator(
    name="prandtl_ishlinskii",
    description="stops in parallel: congruent loops, and an inverse in closed form",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    memory_size=lambda p: len(p.thresholds),
    relations=(SAME_LENGTH,),
    reference="doi:10.1007/978-1-4612-4048-8",
    example={"thresholds": [1e-6, 2e-6, 5e-6], "weights": [6e6, 3e6, 1e6], "spring": 1e5},
)
