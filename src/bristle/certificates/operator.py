"""A hysteresis operator taken as friction: the position is its input, the force its output."""

from __future__ import annotations

from typing import Any, NamedTuple

from bristle.certificates.quasi_static import Holding, Path
from bristle.core.contracts import FrictionModel, Model
from bristle.core.dispatch import operator_commit, operator_trial, register
from bristle.core.kernel import kernel

__all__ = ["Held", "as_friction", "gives_energy"]


class Held(NamedTuple):
    """Parameters of an operator taken as friction: those of the operator."""

    operator: Any


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean of the output over a step, by Simpson's rule, and the move of the operator."""
    dx = motion.v * dt
    before, _ = operator_trial(state, memory, motion.x - dx, p.operator)
    halfway, _ = operator_trial(state, memory, motion.x - 0.5 * dx, p.operator)
    after, move = operator_trial(state, memory, motion.x, p.operator)
    return (before + 4.0 * halfway + after) / 6.0, move


@kernel
def commit(state, memory, move, p):
    """Return the state of the operator after the step."""
    return operator_commit(state, memory, move, p.operator)


register("friction", Held, {"trial": trial, "commit": commit})


def as_friction(operator: Model) -> Model:
    """Return a hysteresis operator with parameters as a friction model."""
    component = operator.component
    held = FrictionModel(
        name=component.name,
        description=component.description,
        Parameters=Held,
        State=component.State,
        trial=trial,
        commit=commit,
        memory_size=lambda p: component.memory_size(p.operator),
        reference=component.reference,
        module=component.module,
    )
    return Model(held, Held(operator.parameters), operator.kind)


def gives_energy(model: Model, holding: Holding) -> bool:
    """Return whether a symmetric loop gives energy, as that of a magnet does when its output is taken for a force."""
    if not holding.has_presliding:
        return False
    path = Path(model, holding)
    work = 0.0
    for turn in (holding.distance, -holding.distance, holding.distance):
        start = path.x
        _, force = path.to_position(turn)
        # The first leg is virgin and no part of the loop.
        work += float(force.mean()) * (turn - start) if start else 0.0
    return work < -1e-9 * holding.half * holding.distance
