r"""A hysteresis operator plus a constant output.

.. math:: w = H[u] + w_0

Loops recorded with a bias, such as that of a torque sensor, need an operator and this constant. Operators with an
``offset`` parameter do not need it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, NamedTuple

from bristle.core import HysteresisOperator, Model, Variable, kernel
from bristle.core.dispatch import operator_commit, operator_trial
from bristle.core.documented import Enclosing, relations_of
from bristle.core.lazy import once

CONSTANT = "offset"
VARIABLE = Variable("force", "constant added to the output of the operator")


class Parameters(NamedTuple):
    """Parameters of an operator with a constant."""

    inner: Any
    constant: Annotated[float, VARIABLE]


@kernel
def trial(state, memory, u, p):
    """Return the output at the input `u`, and the move there."""
    w, move = operator_trial(state, memory, u, p.inner)
    return w + p.constant, move


@kernel
def commit(state, memory, move, p):
    """Commit the move of the operator inside."""
    return operator_commit(state, memory, move, p.inner)


@dataclass(frozen=True, kw_only=True)
class BesideConstant(Enclosing, HysteresisOperator):
    """An operator around another operator, with a constant added to its output.

    Parameters
    ----------
    inner : HysteresisOperator
        The operator inside.
    """

    inner: HysteresisOperator

    def _made_by(self) -> tuple[Any, tuple[Any, ...]]:
        return beside_constant, (self.inner,)

    @property
    def beside(self) -> Mapping[str, Variable]:
        """The constant, in the unit of the output."""
        return {CONSTANT: replace(VARIABLE, quantity=self.output)}

    def assemble(self, values: Mapping[str, Any]) -> Parameters:
        """Return the parameters of the kernels from the values of the user."""
        return Parameters(self.inside(values), values[CONSTANT])

    def values(self, parameters: Parameters) -> dict[str, Any]:
        """Return the values of the user from the parameters of the kernels."""
        return self.inner.values(parameters.inner) | {CONSTANT: parameters.constant}


@once
def beside_constant(operator: HysteresisOperator) -> BesideConstant:
    """Return the descriptor of an operator with a constant."""
    return BesideConstant(
        name=operator.name,
        description=operator.description,
        Parameters=Parameters,
        State=operator.State,
        trial=trial,
        commit=commit,
        memory_size=lambda p: operator.memory_size(p.inner),
        input=operator.input,
        output=operator.output,
        reference=operator.reference,
        relations=relations_of(operator),
        module=operator.module,
        example=dict(operator.example) | {CONSTANT: 0.0},
        inner=operator,
    )


def with_constant(operator: Model, constant: float) -> Model:
    """Return an operator with a constant added to its output, in the unit of the output.

    Parameters
    ----------
    operator : Model
        A hysteresis operator with parameters.
    constant : float
        The constant; with 0 the operator is returned unchanged.
    """
    if not constant:
        return operator
    if CONSTANT in operator.values:
        return operator.with_values(**{CONSTANT: operator.values[CONSTANT] + constant})
    return Model(
        beside_constant(operator.component),
        Parameters(operator.parameters, float(constant)),
        operator.kind,
    )
