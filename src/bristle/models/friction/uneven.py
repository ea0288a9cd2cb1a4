r"""Variations of a contact that its log did not show: another level, scatter, a wave along the axis, creep.

A layer around any friction model. It varies everything but the constant part :math:`u_0`, and adds a branch that
creeps:

.. math::
    F = u_0 + \ell\,\gamma\left(1 + w \sin\frac{2\pi x}{\lambda}\right)(F_\text{model} - u_0) + f_c, \qquad
    \dot f_c = k_c v - f_c/\tau

Each reversal draws a new value :math:`1 + s\,\xi`, with :math:`\xi` standard normal, and the factor :math:`\gamma`
approaches that value as the contact moves: after the travel :math:`d` the difference has fallen to :math:`1/e`. Friction
thus remains continuous, for any model inside. The branch is a spring in series with a damper: it yields to a lasting force.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from bristle.core import FrictionModel, Model, Variable, kernel, variables_of
from bristle.core.dispatch import friction_commit, friction_trial
from bristle.core.documented import relations_of
from bristle.core.lazy import cached_property, once
from bristle.core.mathematics import direction, sin
from bristle.core.random_numbers import SEED_MAX, normal
from bristle.core.read_only import ReadOnly

TWO_PI = 2.0 * math.pi
SMALLEST_FACTOR = 0.05
SLOWEST_REVERSAL = 5e-8  # [m/s]: slower ones are noise


class Contact(NamedTuple):
    """Parameters of the layer."""

    level: Annotated[float, Variable("1", "factor on friction", min=0.01)] = 1.0
    unevenness: Annotated[
        float, Variable("1", "standard deviation of the level by reversal", min=0.0, max=0.3)
    ] = 0.0
    travel: Annotated[
        float, Variable("length", "travel after which 1/e of a change of level is left", min=1e-9)
    ] = 1e-6
    wave: Annotated[
        float, Variable("1", "amplitude of the wave of the level", min=0.0, max=0.9)
    ] = 0.0
    wavelength: Annotated[float, Variable("length", "length of the wave", min=1e-9)] = 1.0
    k_creep: Annotated[
        float, Variable("force/length", "stiffness of the branch that creeps", min=0.0)
    ] = 0.0
    tau: Annotated[float, Variable("time", "time constant of that branch", min=1e-6)] = 1.0
    seed: Annotated[int, Variable("1", "seed of the scatter", min=0, max=SEED_MAX)] = 0


class Uneven(NamedTuple):
    """Parameters of a model in the layer."""

    inner: Any
    own: Contact


class State(NamedTuple):
    """State of the model inside; direction and count of reversals; the factor and its target; the creeping force."""

    inner: Any
    side: Annotated[float, Variable("1", "direction of the motion; 0 before the first")] = 0.0
    reversals: Annotated[int, Variable("1", "reversals so far", min=0)] = 0
    scale: Annotated[float, Variable("1", "factor of the scatter", min=0.0)] = 1.0
    aim: Annotated[float, Variable("1", "target of the factor of the scatter", min=0.0)] = 1.0
    factor: Annotated[float, Variable("1", "factor on friction, all causes together", min=0.0)] = (
        1.0
    )
    creeping: Annotated[float, Variable("force", "force of the branch that creeps")] = 0.0


class Move(NamedTuple):
    """Result of a trial, applied by commit."""

    inner: Any
    x: float
    v: float
    dt: float


@kernel
def creeping_after(f, v, dt, q):
    """Return the force [N or N*m] of the branch that creeps after a step at constant velocity (trapezoidal rule)."""
    half = 0.5 * dt / q.tau
    return (f * (1.0 - half) + q.k_creep * v * dt) / (1.0 + half)


# The solvers do not inline either: some models inside take a minute to compile there.
@kernel(inline=False)
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step, at the level at the beginning of the step."""
    force, move = friction_trial(state.inner, memory, motion, dt, p.inner)
    creeping = 0.5 * (state.creeping + creeping_after(state.creeping, motion.v, dt, p.own))
    return p.inner.offset + state.factor * (force - p.inner.offset) + creeping, Move(
        move, motion.x, motion.v, dt
    )


@kernel(inline=False)
def commit(state, memory, move, p):
    """Return the state after the step; a reversal draws the next level."""
    q, way = p.own, abs(move.v) * move.dt
    inner = friction_commit(state.inner, memory, move.inner, p.inner)
    side, reversals, aim = state.side, state.reversals, state.aim
    if abs(move.v) > SLOWEST_REVERSAL and (side == 0.0 or direction(move.v) * side < 0.0):
        side, aim = (
            direction(move.v),
            max(1.0 + q.unevenness * normal(q.seed, reversals), SMALLEST_FACTOR),
        )
        reversals += 1
    share = way / (q.travel + way)
    scale = state.scale + share * (aim - state.scale)
    factor = q.level * scale * (1.0 + q.wave * sin(TWO_PI * move.x / q.wavelength))
    return State(
        inner,
        side,
        reversals,
        scale,
        aim,
        factor,
        creeping_after(state.creeping, move.v, move.dt, q),
    )


@dataclass(frozen=True, kw_only=True)
class UnevenModel(FrictionModel):
    """A friction model with an offset, in the layer."""

    inner: FrictionModel

    def _made_by(self) -> tuple[Any, tuple[Any, ...]]:
        return _uneven, (self.inner,)

    @cached_property
    def variables(self) -> ReadOnly[str, Variable]:
        """Description of each parameter: those of the model and those of the layer, with one seed for both."""
        return ReadOnly(variables_of(Contact) | dict(self.inner.variables))

    @property
    def defaults(self) -> dict[str, Any]:
        """Default values of the parameters."""
        return Contact._field_defaults | self.inner.defaults

    def initial_state(self, parameters: Uneven) -> State:
        """Return the virgin state, at the level where the motion begins."""
        return State(self.inner.initial_state(parameters.inner), factor=parameters.own.level)

    def is_array(self, name: str) -> bool:
        """Return whether this parameter is a 1-D array."""
        return name in self.inner.variables and self.inner.is_array(name)

    def is_integer(self, name: str) -> bool:
        """Return whether this parameter is a whole number."""
        return name == "seed" or (name in self.inner.variables and self.inner.is_integer(name))

    def assemble(self, values: Mapping[str, Any]) -> Uneven:
        """Return the parameters of the kernels from the values of the user."""
        inner = {name: values[name] for name in self.inner.variables}
        return Uneven(
            self.inner.assemble(inner), Contact(**{name: values[name] for name in Contact._fields})
        )

    def values(self, parameters: Uneven) -> dict[str, Any]:
        """Return the values of the user from the parameters of the kernels."""
        return parameters.own._asdict() | self.inner.values(parameters.inner)


def uneven(friction: Model, **values: Any) -> Model:
    """Return a friction model with scatter, a wave along the axis and creep; without values for these causes, return it unchanged."""
    return _uneven(friction.component)(kind=friction.kind, **(dict(friction.values) | values))


@once
def _uneven(model: FrictionModel) -> UnevenModel:
    return UnevenModel(
        name=f"{model.name}, uneven",
        description=f"{model.description}, at a level that scatters, varies along the axis, and creeps",
        Parameters=Uneven,
        State=State,
        trial=trial,
        commit=commit,
        memory_size=lambda p: model.memory_size(p.inner),
        relations=relations_of(model),
        inner=model,
    )
