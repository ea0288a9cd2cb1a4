r"""The Preisach operator with an Everett function in closed form.

.. math:: f = \iint_{\alpha \ge \beta} \mu(\alpha, \beta)\,\gamma_{\alpha\beta}[z]\,d\alpha\,d\beta

with relays :math:`\gamma_{\alpha\beta} = \pm 1` and a signed measure :math:`\mu`, equation (12) of the source paper.
bristle computes the integral exactly, from the turning points of the input, in amortised constant time
(`bristle.models.hysteresis.turning_points`). The Everett function represents the measure (`bristle.models.hysteresis.everett`).

References
----------
.. [1] I. D. Mayergoyz, "Mathematical Models of Hysteresis", Springer, 1991. doi:10.1007/978-1-4612-3028-1
"""

from typing import Annotated, NamedTuple

from bristle.core import HysteresisOperator, Variable, kernel
from bristle.models.hysteresis.everett import KERNELS, ClosedForm
from bristle.models.hysteresis.turning_points import (
    SMALLEST_CAPACITY,
    Stack,
    stack_commit,
    stack_size,
    stack_trial,
)

CAPACITY = Variable(
    "1",
    "largest number of stored turning points; beyond it the innermost pair is lost",
    min=SMALLEST_CAPACITY,
)
TOLERANCE = Variable(
    "1",
    "smallest stored reversal, over f_p/s, or over the range of the input in a table",
    min=0.0,
    max=1.0,
)


class Parameters(NamedTuple):
    """Parameters of the Preisach operator."""

    s: Annotated[
        float, Variable("force/length", "stiffness after a reversal", min=1e-12, nominal=1e6)
    ]
    f_p: Annotated[float, Variable("force", "force at saturation", min=1e-12)]
    kernel: Annotated[int, Variable("1", "Everett function", choices=KERNELS)] = 0
    exponent: Annotated[
        float, Variable("1", "Dahl exponent i of dahl_masing", min=0.1, max=5.0)
    ] = 2.0
    capacity: Annotated[int, CAPACITY] = 256
    tolerance: Annotated[float, TOLERANCE] = 1e-12


@kernel
def measure(p):
    """Return the measure, by its Everett function."""
    return ClosedForm(p.kernel, p.s, p.f_p, p.exponent)


@kernel
def trial(state, memory, u, p):
    """Return the output [N or N*m] at the input `u` [m or rad], and the move there."""
    return stack_trial(state, memory, u, p.tolerance * p.f_p / p.s, measure(p))


@kernel
def commit(state, memory, move, p):
    """Return the state after the move; a reversal stores where it turned."""
    return stack_commit(state, memory, move)


def memory_size(p: Parameters) -> int:
    """Return the room for the turning points."""
    return stack_size(p.capacity)


MODEL = preisach = HysteresisOperator(
    name="preisach",
    description="Preisach operator, computed from turning points, with an Everett function in closed form",
    Parameters=Parameters,
    State=Stack,
    trial=trial,
    commit=commit,
    memory_size=memory_size,
    measure=measure,
    reference="doi:10.1007/978-1-4612-3028-1",
    example={"s": 1.25e7, "f_p": 150.0, "kernel": "reformed_dahl_exact"},
)
