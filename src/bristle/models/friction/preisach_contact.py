r"""The Preisach operator on the position: the hysteresis friction compensator of the source paper.

.. math:: F = f_h[x] + \sigma_2 v

Every motion deflects the contact, and the contact never slips. The model thus describes pre-sliding only: below the
force of sliding it equals `preisach_lugre`. It has no Stribeck effect and no break-away. For gross sliding use
`preisach_lugre`. The force of a step is the mean over the step; bristle divides a long step into parts. The parameter
``kernel`` also takes a hysteresis operator, measured or identified, whose parameters then replace ``s`` and ``f_p``.

References
----------
.. [1] "Pre-sliding friction control using the sliding mode controller with hysteresis friction compensator",
   equations (12) to (15).
.. [2] I. D. Mayergoyz, "Mathematical Models of Hysteresis", Springer, 1991. doi:10.1007/978-1-4612-3028-1
"""

from typing import Annotated, Any, NamedTuple

from bristle.core import Variable, kernel
from bristle.core.dispatch import operator_measure, operator_trial
from bristle.models.friction.deflection import TOLERANCE, mean_output
from bristle.models.friction.operator_kernel import (
    Form,
    Lean,
    Lengths,
    TakesOperator,
    leaning,
    slide,
)
from bristle.models.friction.quantities import ReversalStiffness, ViscousCoefficient
from bristle.models.hysteresis.everett import KERNELS, ClosedForm
from bristle.models.hysteresis.turning_points import (
    SMALLEST_CAPACITY,
    Stack,
    stack_commit,
    stack_size,
    stack_trial,
)


class Parameters(NamedTuple):
    """Parameters of the Preisach operator on the position."""

    s: ReversalStiffness
    f_p: Annotated[
        float,
        Variable(
            "force", "force at which the operator saturates", min=1e-12, excitation="presliding"
        ),
    ]
    sigma_2: ViscousCoefficient = 0.0
    kernel: Annotated[int, Variable("1", "Everett function of the operator", choices=KERNELS)] = 0
    exponent: Annotated[
        float, Variable("1", "Dahl exponent i of dahl_masing", min=0.1, max=5.0)
    ] = 2.0
    capacity: Annotated[
        int, Variable("1", "turning points remembered", min=SMALLEST_CAPACITY, max=100_000)
    ] = 256


class Damped(NamedTuple):
    """Parameters besides those of the kernel."""

    sigma_2: ViscousCoefficient = 0.0


class OverTurningPoints(NamedTuple):
    """Parameters over an operator with turning points."""

    operator: Any
    own: Damped
    lengths: Lengths


class OverStops(NamedTuple):
    """Parameters over stops in parallel."""

    operator: Any
    own: Damped
    lengths: Lengths


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and the move of the memory."""
    q = ClosedForm(p.kernel, p.s, p.f_p, p.exponent)
    scale = p.f_p / p.s
    f, move = stack_trial(state, memory, state.z + motion.v * dt, TOLERANCE * scale, q)
    return mean_output(state, memory, move.z, f, q, scale) + p.sigma_2 * motion.v, move


@kernel
def trial_over_turning_points(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step, and the move, over an operator with turning points."""
    f, move = operator_trial(state, memory, state.z + motion.v * dt, p.operator)
    q = operator_measure(p.operator)
    return mean_output(state, memory, move.z, f, q, p.lengths.turn) + p.own.sigma_2 * motion.v, move


@kernel
def trial_over_stops(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step, and the move, over stops in parallel."""
    u = state.z + motion.v * dt
    f, _ = operator_trial(state, memory, u, p.operator)
    stack, q = leaning(state, memory, p.operator)
    return mean_output(stack, memory, u, f, q, p.lengths.turn) + p.own.sigma_2 * motion.v, Lean(
        u, f
    )


@kernel
def commit_over_stops(state, memory, move, p):
    """Return the state after the step; every slider follows the position."""
    return slide(state, memory, move, p.operator)


@kernel
def commit(state, memory, move, p):
    """Return the state after the step; a reversal stores a turning point."""
    return stack_commit(state, memory, move)


def memory_size(p: Parameters) -> int:
    """Return the room for the turning points."""
    return stack_size(p.capacity)


MODEL = preisach_contact = TakesOperator(
    name="preisach_contact",
    description="a Preisach operator on the position: hysteresis with non-local memory, without gross sliding",
    Parameters=Parameters,
    State=Stack,
    trial=trial,
    commit=commit,
    memory_size=memory_size,
    reference="doi:10.1007/978-1-4612-3028-1",
    example={"s": 1e7, "f_p": 28.0, "sigma_2": 200.0},
    own=Damped,
    turning=Form(OverTurningPoints, Stack, trial_over_turning_points, commit),
    stops=Form(OverStops, Lean, trial_over_stops, commit_over_stops),
)
