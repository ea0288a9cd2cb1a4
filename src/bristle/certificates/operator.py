"""A hysteresis operator taken as friction: the position is its input, the force its output."""

from __future__ import annotations

from typing import Any, NamedTuple

from bristle.core.contracts import FrictionModel, Model
from bristle.core.dispatch import operator_commit, operator_trial, register
from bristle.core.kernel import kernel

__all__ = ["OperatorParameters", "as_friction"]


class OperatorParameters(NamedTuple):
    """Parameters of an operator taken as friction: those of the operator."""

    operator: Any


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean of the output at both ends of a step, and the move of the operator."""
    before, _ = operator_trial(state, memory, motion.x - motion.v * dt, p.operator)
    after, move = operator_trial(state, memory, motion.x, p.operator)
    return 0.5 * (before + after), move


@kernel
def commit(state, memory, move, p):
    """Return the state of the operator after the step."""
    return operator_commit(state, memory, move, p.operator)


register("friction", OperatorParameters, {"trial": trial, "commit": commit})


def as_friction(operator: Model) -> Model:
    """Return a hysteresis operator with parameters as a friction model."""
    component = operator.component
    friction = FrictionModel(
        name=component.name,
        description=component.description,
        Parameters=OperatorParameters,
        State=component.State,
        trial=trial,
        commit=commit,
        memory_size=lambda p: component.memory_size(p.operator),
        reference=component.reference,
        module=component.module,
    )
    return Model(friction, OperatorParameters(operator.parameters), operator.kind)
