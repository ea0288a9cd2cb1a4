r"""Slots that raise the level of dry friction: with the effort transmitted to the load, and with the angle of a screw.

.. math::
    F = F_\text{model} + \frac{c_T |\tau| + \sum_{i=1,2} h_{c,i} \cos i\varphi + h_{s,i} \sin i\varphi}{F_C}
        \left(F_\text{model} - F_v v\right)

With ``+transmitted`` the friction of teeth and nuts grows with the effort :math:`\tau` that reaches the load: the effort
of the drive minus friction. In sliding the level is :math:`F_C + c_T |\tau|`; all forces of a contact with memory rise by
the same factor. With ``+ripple`` the level varies once and twice per turn of the screw, :math:`\varphi = 2\pi x/p` with
the pitch `p`. Unlike the forces of ``+periodic`` and of motor cogging, this force changes sign with the motion.
Viscous friction :math:`F_v v` does not change.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from bristle.core import FrictionModel, Model, Variable, kernel
from bristle.core.dispatch import friction_trial
from bristle.core.lazy import once
from bristle.core.mathematics import cos, sin
from bristle.core.surroundings import OF_MOTION
from bristle.models.friction.enclosing import CoefficientsModel, enclosed
from bristle.models.friction.variation import PITCH, SMALLEST_FACTOR

TWO_PI = 2.0 * math.pi
TRANSMITTED = Variable(
    "1",
    "additional friction per unit of effort transmitted to the load",
    nominal=0.1,
    excitation="place",
)


class Rise(NamedTuple):
    """Coefficients of all slots, zero for absent slots, with the level and the viscous part of the model."""

    c_T: Annotated[float, TRANSMITTED] = 0.0
    pitch: Annotated[float, PITCH] = 1.0
    h_c1: Annotated[
        float,
        Variable(
            "force", "variation of the friction level once per turn, cosine", excitation="place"
        ),
    ] = 0.0
    h_s1: Annotated[
        float,
        Variable(
            "force", "variation of the friction level once per turn, sine", excitation="place"
        ),
    ] = 0.0
    h_c2: Annotated[
        float,
        Variable(
            "force", "variation of the friction level twice per turn, cosine", excitation="place"
        ),
    ] = 0.0
    h_s2: Annotated[
        float,
        Variable(
            "force", "variation of the friction level twice per turn, sine", excitation="place"
        ),
    ] = 0.0
    level: Annotated[float, Variable("force", "level of sliding friction of the model")] = 1.0
    viscous: Annotated[float, Variable("force*time/length", "viscous friction of the model")] = 0.0


LEVELS: dict[str, tuple[str, ...]] = {
    "transmitted": ("c_T",),
    "ripple": ("pitch", "h_c1", "h_s1", "h_c2", "h_s2"),
}
"""The parameters of each slot."""
RISES_WITH = {
    "transmitted": "the effort transmitted to the load",
    "ripple": "the angle of the screw",
}
"""Causes of a higher level, in words."""
SURROUNDINGS = {name: OF_MOTION[name] for name in LEVELS if name in OF_MOTION}


class Risen(NamedTuple):
    """Parameters of a model whose level rises."""

    inner: Any
    rise: Rise


@kernel
def share_at(x, transmitted, q):
    """Return the relative rise of the level at a position [m or rad] and an effort [N or N*m]."""
    phase = TWO_PI * x / q.pitch
    c, s = cos(phase), sin(phase)
    ripple = q.h_c1 * c + q.h_s1 * s + q.h_c2 * (c * c - s * s) + q.h_s2 * 2.0 * s * c
    return max((q.c_T * abs(transmitted) + ripple) / q.level, SMALLEST_FACTOR - 1.0)


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] of the model, with its level at the middle of the step."""
    force, move = friction_trial(state, memory, motion, dt, p.inner)
    share = share_at(motion.x - 0.5 * dt * motion.v, motion.transmitted, p.rise)
    return force + share * (force - p.rise.viscous * motion.v), move


@dataclass(frozen=True, kw_only=True)
class RisenModel(CoefficientsModel):
    """A friction model with slots that raise its level."""

    coefficients = Rise
    of_slot = LEVELS
    without_default = ("pitch",)
    depends_on = SURROUNDINGS

    def _made_by(self) -> tuple[Any, tuple[Any, ...]]:
        return _risen, (self.inner, self.slots)

    def assemble(self, values: Mapping[str, Any]) -> Risen:
        """Return the parameters of the kernels from the values of the user."""
        level, viscous = (values[name] if name else 0.0 for name in _dry_and_viscous(self.inner))
        # A level of zero has no relative change.
        rise = {"level": level or math.inf, "viscous": viscous} | {
            name: values[name] for name in self.own
        }
        return Risen(self.inside(values), Rise(**rise))


def _dry_and_viscous(model: FrictionModel) -> tuple[str, str]:
    """Return the names of the level of sliding friction and of the viscous friction of a model, empty if absent."""
    kinds = {
        (variable.quantity, variable.excitation): name
        for name, variable in reversed(model.variables.items())
    }
    return kinds.get(("force", "sliding"), ""), kinds.get(("force*time/length", "speed"), "")


def has_level(model: FrictionModel) -> bool:
    """Return whether a model has a level of sliding friction; without a level these slots have no effect."""
    return bool(_dry_and_viscous(model)[0])


def viscous_of(model: FrictionModel) -> str:
    """Return the name of the viscous friction of a model, empty if absent."""
    return _dry_and_viscous(model)[1]


def rises_with_effort(friction: Model) -> bool:
    """Return whether the level of a friction model rises with the effort transmitted to the load."""
    return TRANSMITTED in friction.component.variables.values()


def risen(model: FrictionModel, slots: Iterable[str]) -> FrictionModel:
    """Return `model` with those slots that raise its level; the model itself if there are none."""
    chosen = tuple(slot for slot in LEVELS if slot in set(slots))
    return _risen(model, chosen) if chosen else model


@once
def _risen(model: FrictionModel, slots: tuple[str, ...]) -> RisenModel:
    return enclosed(
        RisenModel,
        model,
        name="+".join((model.name, *slots)),
        description=f"{model.description}, its level rising with {' and '.join(RISES_WITH[slot] for slot in slots)}",
        Parameters=Risen,
        trial=trial,
        example=dict(model.example)
        | {name: _EXAMPLE[name] for slot in slots for name in LEVELS[slot]},
        slots=slots,
    )


_EXAMPLE = {"c_T": 0.1, "pitch": 5e-3, "h_c1": 0.7, "h_s1": -0.3, "h_c2": 0.3, "h_s2": 0.2}
