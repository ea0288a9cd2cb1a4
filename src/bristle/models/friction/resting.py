r"""A rule for the force of a memoryless model at rest, the same wherever the model is evaluated along a motion.

At :math:`v = 0` a static map has no single force, but an interval between its one-sided limits :math:`F_-` and
:math:`F_+`. With :math:`s = \operatorname{sgn}` of the last nonzero velocity, 0 before any motion,

.. math:: F(0) = \tfrac12(F_+ + F_-) + \tfrac12 h s\,(F_+ - F_-)

``held``, :math:`h = 1`, keeps the force of the last direction of motion; ``middle``, :math:`h = 0`, drops to the
mean of both sides. The map itself remains without memory: the model around it stores the direction. A model with a
state has a single force at rest and needs neither rule. A speed below 0.1 nm/s is rest: rounded positions contain
such steps, and a single step at the end of a move would reverse the force.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from bristle.core import Variable, kernel
from bristle.core.contracts import STILL, FrictionModel, Model
from bristle.core.dimensions import canonical
from bristle.core.dispatch import friction_trial
from bristle.core.experiment import RESTS
from bristle.core.lazy import once
from bristle.core.surroundings import on_side
from bristle.models.friction.enclosing import EnclosingModel, enclosed
from bristle.models.friction.presliding import is_static

HELD = "rest_held"
"""Parameter of the rule."""
VISCOUS = canonical("force*time/length")
SHARE = Variable(
    "1", "at rest: 1 keeps the force of the last direction, 0 takes the middle", min=0.0, max=1.0
)


class Parameters(NamedTuple):
    """Parameters of a static map with a rule at rest."""

    inner: Any
    held: Annotated[float, SHARE]


class State(NamedTuple):
    """The direction of the last motion."""

    side: Annotated[
        float, Variable("1", "direction of the last motion, 0 before any", min=-1.0, max=1.0)
    ] = 0.0


class Move(NamedTuple):
    """Result of a trial, applied by commit."""

    side: float


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, by the rule at zero velocity."""
    v = motion.v
    if abs(v) <= STILL:
        forward, _ = friction_trial(state, memory, on_side(0.0, motion), dt, p.inner)
        backward, _ = friction_trial(state, memory, on_side(-0.0, motion), dt, p.inner)
        share = p.held * state.side
        return 0.5 * (1.0 + share) * forward + 0.5 * (1.0 - share) * backward, Move(state.side)
    force, _ = friction_trial(state, memory, motion, dt, p.inner)
    return force, Move(math.copysign(1.0, v))


@kernel
def commit(state, memory, move, p):
    """Return the state after the step."""
    return State(move.side)


@dataclass(frozen=True, kw_only=True)
class RestingModel(EnclosingModel):
    """A static friction model with a rule at rest."""

    def _made_by(self) -> tuple[Any, tuple[Any, ...]]:
        return resting, (self.inner,)

    @property
    def beside(self) -> Mapping[str, Variable]:
        """Share of the one-sided limit at rest."""
        return {HELD: SHARE}

    def initial_state(self, parameters: Parameters) -> State:
        """Return the virgin state: no motion yet."""
        return State()

    def assemble(self, values: Mapping[str, Any]) -> Parameters:
        """Return the parameters of the kernels from the values of the user."""
        return Parameters(self.inside(values), values[HELD])

    def values(self, parameters: Parameters) -> dict[str, Any]:
        """Return the values of the user from the parameters of the kernels."""
        return self.inner.values(parameters.inner) | {HELD: parameters.held}


@once
def resting(model: FrictionModel) -> RestingModel:
    """Return the descriptor of a static `model` with a rule at rest."""
    return enclosed(
        RestingModel,
        model,
        name=model.name,
        description=model.description,
        Parameters=Parameters,
        State=State,
        trial=trial,
        commit=commit,
        example={},
    )


def with_rest(friction: Model, rest: str) -> Model:
    """Return a memoryless friction model with a rule at rest; return any other model unchanged.

    Parameters
    ----------
    friction : Model
        The friction model.
    rest : {"held", "middle"}
        Its force at zero velocity.
    """
    component = friction.component
    if component.family != "friction" or component.rate is not None or not is_static(friction):
        return friction
    if {variable.quantity for variable in component.variables.values()} == {VISCOUS}:
        return friction  # no jump at rest
    return Model(
        resting(component),
        Parameters(friction.parameters, float(RESTS.index(rest) == 0)),
        friction.kind,
    )


def rest_rule(friction: Model) -> str:
    """Return the rule at rest of a model; empty for a model without a rule."""
    if not isinstance(friction.component, RestingModel):
        return ""
    return RESTS[0] if friction.parameters.held else RESTS[1]
