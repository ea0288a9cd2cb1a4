"""A friction model whose level is drawn anew at each reversal: a truth whose half-cycles are not alike.

A reversal is one once the motion has gone back some way: a body that trembles within the deflection of its contact, as
the steps of an encoder make it do, does not meet another surface each time.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

from bristle.core import FrictionModel, Model, kernel
from bristle.core.contracts import make_model
from bristle.core.dispatch import friction_commit, friction_trial
from bristle.core.random_numbers import normal
from bristle.core.variable import Variable

__all__ = ["scattering"]

LEAST = 0.3
OWN = {
    "scatter": Variable(
        "1", "standard deviation of the level from reversal to reversal", min=0.0, max=0.3
    ),
    "way": Variable("length", "way back from which a reversal counts as one", min=0.0),
    "seed": Variable("1", "seed of the scatter", min=0),
}


class Parameters(NamedTuple):
    inner: Any
    scatter: float
    way: float
    seed: int


class State(NamedTuple):
    inner: Any
    side: float
    farthest: float
    reversals: int
    scale: float


class Move(NamedTuple):
    inner: Any
    x: float


@kernel
def trial(state, memory, motion, dt, p):
    force, move = friction_trial(state.inner, memory, motion, dt, p.inner)
    return state.scale * force, Move(move, motion.x)


@kernel
def commit(state, memory, move, p):
    inner = friction_commit(state.inner, memory, move.inner, p.inner)
    back = state.side * (state.farthest - move.x)
    if state.reversals > 0 and back <= p.way:
        farthest = move.x if back < 0.0 else state.farthest
        return State(inner, state.side, farthest, state.reversals, state.scale)
    scale = max(1.0 + p.scatter * normal(p.seed, state.reversals), LEAST)
    side = -state.side if state.reversals > 0 else 1.0
    return State(inner, side, move.x, state.reversals + 1, scale)


@dataclass(frozen=True, kw_only=True)
class ScatteringModel(FrictionModel):
    inner: FrictionModel

    @property
    def variables(self) -> dict[str, Variable]:
        return self.inner.variables | OWN

    @property
    def defaults(self) -> dict[str, Any]:
        return self.inner.defaults

    def is_array(self, name: str) -> bool:
        return name not in OWN and self.inner.is_array(name)

    def is_integer(self, name: str) -> bool:
        return name == "seed" or (name not in OWN and self.inner.is_integer(name))

    def assemble(self, values: Mapping[str, Any]) -> Parameters:
        inner = self.inner.assemble({name: values[name] for name in self.inner.variables})
        return Parameters(inner, *(values[name] for name in OWN))

    def values(self, parameters: Parameters) -> dict[str, Any]:
        return self.inner.values(parameters.inner) | {
            name: getattr(parameters, name) for name in OWN
        }

    def initial_state(self, p: Parameters) -> State:
        return State(self.inner.initial_state(p.inner), 0.0, 0.0, 0, 1.0)

    def new_memory(self, p: Parameters) -> Any:
        return self.inner.new_memory(p.inner)


@cache
def _scattering(inner: FrictionModel) -> ScatteringModel:
    return ScatteringModel(
        name=f"scattering-{inner.name}",
        description="friction whose level scatters",
        Parameters=Parameters,
        State=State,
        trial=trial,
        commit=commit,
        inner=inner,
    )


def scattering(model: Model, scatter: float, seed: int, way: float = 0.5e-6) -> Model:
    """Return a friction model whose force has another scale after each reversal by more than a `way` [m]."""
    values = dict(model.values) | {"scatter": scatter, "way": way, "seed": seed}
    return make_model(_scattering(model.component), values, kind=model.kind, validate=False)
