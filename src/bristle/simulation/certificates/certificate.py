"""The result of a certificate."""

from dataclasses import dataclass
from typing import Any, NamedTuple

from bristle.core import FrictionModel, Model, kernel
from bristle.core.dispatch import operator_commit, operator_trial, register


@dataclass(frozen=True)
class Certificate:
    """The result of one test of a model.

    Parameters
    ----------
    applies : bool
        Whether the test makes sense for this model.
    value : float or None
        The result of the test, in `unit`; None if the test does not apply.
    unit : str
        SI unit of `value` and `threshold`.
    threshold : float or None
        The limit of `value`.
    passed : bool or None
        Whether `value` is within its limit; None if the test does not apply.
    advice : str
        One line: the meaning of the number and, on failure, the remedy.
    """

    applies: bool
    value: float | None
    unit: str
    threshold: float | None
    passed: bool | None
    advice: str


def not_applicable(unit: str, reason: str) -> Certificate:
    """Return the certificate of a test that does not make sense for a model."""
    return Certificate(False, None, unit, None, None, reason)


class OperatorParameters(NamedTuple):
    """Parameters of an operator that acts as friction."""

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
