r"""Pre-sliding for a static friction map: the force reverses over a distance, not in an instant.

The force of a static map jumps at a velocity reversal. On a real axis the contact deflects first. With
the one-sided limits :math:`F_\pm` of the map at rest and the distance :math:`d`

.. math::
    F = F_\text{map}(v) - F_{\operatorname{sgn} v} + \tfrac12(F_+ + F_-) + \tfrac12(F_+ - F_-)\,\zeta, \qquad
    \frac{d\zeta}{dx} = \frac{1 - \zeta\operatorname{sgn} v}{d}

In sliding, :math:`\zeta = \operatorname{sgn} v`, this model equals the map. Around a reversal it equals the model of Dahl
with exponent 1 and stiffness :math:`(F_+ - F_-)/2d`. A step at constant velocity is exact.

References
----------
.. [1] P. R. Dahl, "Solid friction damping of mechanical vibrations", AIAA Journal 14(12), 1976.
   doi:10.2514/3.61511
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from bristle.core import (
    Amount,
    FrictionModel,
    Model,
    Variable,
    amount,
    guarded,
    kernel,
    model as of_family,
)
from bristle.core.dispatch import friction_trial
from bristle.core.lazy import once
from bristle.core.mathematics import direction, relaxation
from bristle.core.surroundings import at_rest
from bristle.models.friction.enclosing import EnclosingModel, enclosed

PRESLIDING = "presliding"
DISTANCE = Variable("length", "distance over which the force reverses", min=1e-12)


class Parameters(NamedTuple):
    """Parameters of a static map with pre-sliding: those of the map, and the distance."""

    inner: Any
    distance: Annotated[float, DISTANCE]


class State(NamedTuple):
    """State of the contact."""

    zeta: Annotated[
        float, Variable("1", "deflection over its value in sliding", min=-1.0, max=1.0)
    ] = 0.0


class Move(NamedTuple):
    """Result of a trial, applied by commit."""

    zeta_next: float


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and the deflection at its end."""
    v = motion.v
    side = direction(v)
    at, _ = friction_trial(state, memory, motion, dt, p.inner)
    forward, _ = friction_trial(state, memory, at_rest(0.0, motion), dt, p.inner)
    backward, _ = friction_trial(state, memory, at_rest(-0.0, motion), dt, p.inner)
    ratio = abs(v) * dt / p.distance
    decay = relaxation(ratio)
    zeta_mean = state.zeta + (side - state.zeta) * (1.0 - decay)
    zeta_next = state.zeta + (side - state.zeta) * decay * ratio
    level = forward if side > 0.0 else backward
    force = at - level + 0.5 * (forward + backward) + 0.5 * (forward - backward) * zeta_mean
    return force, Move(zeta_next)


@kernel
def commit(state, memory, move, p):
    """Return the state after the step."""
    return State(move.zeta_next)


@dataclass(frozen=True, kw_only=True)
class PreslidingModel(EnclosingModel):
    """A static friction model whose force reverses over a distance."""

    def _made_by(self) -> tuple[Any, tuple[Any, ...]]:
        return presliding, (self.inner,)

    @property
    def beside(self) -> Mapping[str, Variable]:
        """The distance."""
        return {PRESLIDING: DISTANCE}

    def initial_state(self, parameters: Parameters) -> State:
        """Return the virgin state; the map inside has no state."""
        return State()

    def assemble(self, values: Mapping[str, Any]) -> Parameters:
        """Return the parameters of the kernels from the values of the user."""
        return Parameters(self.inside(values), values[PRESLIDING])

    def values(self, parameters: Parameters) -> dict[str, Any]:
        """Return the values of the user from the parameters of the kernels."""
        return self.inner.values(parameters.inner) | {PRESLIDING: parameters.distance}


@once
def presliding(model: FrictionModel) -> PreslidingModel:
    """Return the descriptor of a static `model` with pre-sliding."""
    return enclosed(
        PreslidingModel,
        model,
        name=model.name,
        description=f"{model.description}, with pre-sliding",
        Parameters=Parameters,
        State=State,
        trial=trial,
        commit=commit,
        example={},
    )


@guarded(friction=of_family("friction"))
def is_static(friction: Model) -> bool:
    """Return whether a friction model is a static map, without state and memory."""
    return (
        not friction.component.State._fields
        and friction.component.memory_size(friction.parameters) == 0
    )


@guarded(
    friction=of_family("friction"),
    distance=amount(Variable("length", "distance over which the force reverses")),
)
def with_presliding(friction: Model, distance: Amount) -> Model:
    """Return a static friction model whose force reverses over `distance` [m or rad]; return any other model unchanged.

    Raises
    ------
    InputError
        If the distance is not finite.
    """
    if distance <= 0.0 or not is_static(friction):
        return friction
    return Model(
        presliding(friction.component), Parameters(friction.parameters, distance), friction.kind
    )


@guarded(friction=of_family("friction"))
def without_presliding(friction: Model) -> Model:
    """Return the static model inside a model with a pre-sliding distance; return any other model unchanged."""
    if not isinstance(friction.component, PreslidingModel):
        return friction
    return Model(friction.component.inner, friction.parameters.inner, friction.kind)
