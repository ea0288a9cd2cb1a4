r"""The inverse of a Preisach operator: the displacement from the force, with the same turning points.

The branches of friction rise with the input (:math:`E` grows with :math:`\alpha - \beta`), so force and displacement
have the same turning points and share a stack. On a branch of a Masing kernel the displacement has a closed form,
:math:`z = z_n \pm 2\varphi^{-1}(|f - f_n|/2)` with the virgin curve :math:`\varphi`. On any other branch a search between
the ends of the branch finds the displacement. State and memory are those of the operator.

A force of :math:`f_p` or more has no displacement: the result is NaN, and `bristle.response` raises an error that names
the sample.

References
----------
.. [1] P. Krejčí, K. Kuhnen, "Inverse control of systems with hysteresis and creep", IEE Proc. Control Theory and
   Applications 148(3), 2001. doi:10.1049/ip-cta:20010375
"""

import math

from bristle.core import HysteresisOperator, InputError, Model, guarded, kernel, model
from bristle.core.mathematics import Bracket, bracket_guess, bracket_update, direction
from bristle.models.hysteresis.everett import REFORMED_DAHL_EXACT, loading_inverse
from bristle.models.hysteresis.inverse_prandtl_ishlinskii import inverse_of as inverse_of_stops
from bristle.models.hysteresis.prandtl_ishlinskii import prandtl_ishlinskii
from bristle.models.hysteresis.preisach import (
    Parameters as Forward,
    commit as forward_commit,
    measure,
    memory_size,
    preisach,
)
from bristle.models.hysteresis.turning_points import Stack, StackMove, branch_output, branch_with

ITERATIONS = 100
ROUNDING = 4.440892098500626e-16


class Parameters(Forward):
    """Parameters of the operator that is inverted."""


@kernel
def branch_toward(stack, memory, f):
    """Return the branch with the output `f`, reached from ``stack.f`` in one move."""
    side = math.copysign(1.0, f - stack.f) if f != stack.f else stack.side
    return branch_with(stack, memory, side, memory.size // 2, f)


@kernel
def input_on(branch, f, p):
    """Return the input at which a branch has the output `f`."""
    length = p.f_p / p.s
    if branch.depth == 0:
        # The virgin curve of the exact kernel is the locus of the tips, which has an inverse in closed form.
        shape = 1 if p.kernel == REFORMED_DAHL_EXACT else p.kernel
        return direction(f) * length * loading_inverse(abs(f) / p.f_p, shape, p.exponent)
    if p.kernel != REFORMED_DAHL_EXACT:
        half = 0.5 * abs(f - branch.f) / p.f_p
        return branch.z + 2.0 * branch.side * length * loading_inverse(half, p.kernel, p.exponent)
    return root_on(branch, f, p)


@kernel(inline=False)
def root_on(branch, f, p):
    """Return the input on a branch with the output `f`, between the ends of the branch."""
    q = measure(p)
    low, high = min(branch.z, branch.end), max(branch.z, branch.end)
    bracket = Bracket(
        low, branch_output(branch, low, q) - f, high, branch_output(branch, high, q) - f, 0.0
    )
    z = high
    for _ in range(ITERATIONS):
        z = bracket_guess(bracket)
        miss = branch_output(branch, z, q) - f
        bracket = bracket_update(bracket, z, miss)
        if miss == 0.0 or bracket.high - bracket.low <= ROUNDING * max(abs(low), abs(high)):
            break
    return z


@kernel
def trial(state, memory, u, p):
    """Return the displacement [m or rad] at the force `u` [N or N*m], and the move there."""
    if abs(u - state.f) <= p.tolerance * p.f_p and (u - state.f) * state.side < 0.0:
        return state.z, StackMove(state.z, state.f, state.side, state.depth)
    if abs(u) >= p.f_p:
        return math.nan, StackMove(state.z, state.f, state.side, state.depth)
    branch = branch_toward(state, memory, u)
    z = input_on(branch, u, p)
    return z, StackMove(z, u, branch.side, branch.depth)


@kernel
def commit(state, memory, move, p):
    """Return the state after the move; a reversal stores where it turned."""
    return forward_commit(state, memory, move, p)


MODEL = inverse_preisach = HysteresisOperator(
    name="inverse_preisach",
    description="the displacement from the force, by the turning points of a Preisach operator",
    Parameters=Parameters,
    State=Stack,
    trial=trial,
    commit=commit,
    memory_size=memory_size,
    input="force",
    output="length",
    reference="doi:10.1049/ip-cta:20010375",
    example={"s": 1.25e7, "f_p": 150.0, "kernel": "dahl_masing"},
)


@guarded(operator=model("hysteresis"))
def inverse_of(operator: Model) -> Model:
    """Return the inverse of an operator: from force to displacement.

    Parameters
    ----------
    operator : Model
        A `prandtl_ishlinskii` or `preisach` operator with parameters.

    Returns
    -------
    Model
        The operator from force [N or N*m] to displacement [m or rad].

    Raises
    ------
    InputError
        If there is no inverse.
    """
    if operator.component is prandtl_ishlinskii:
        return inverse_of_stops(operator)
    if operator.component is preisach:
        return MODEL(kind=operator.kind, **operator.values)
    raise InputError(
        "has no inverse in bristle",
        path="operator",
        value=operator.name,
        allowed="prandtl_ishlinskii, preisach",
    )
