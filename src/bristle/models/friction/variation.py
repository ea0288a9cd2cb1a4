r"""Slots that let friction vary: with the place on the axis, the angle of a screw, the load and the temperature.

.. math::
    F = \left(1 + p_1 \xi + p_2 \xi^2 + k_L (L - 1) + k_T (T - T_0)\right) F_\text{model}
        + a_1 \xi + a_2 \xi^2 + \sum_{i=1,2} c_i \cos i\varphi + s_i \sin i\varphi

with :math:`\xi = (x - x_0)/x_L`, limited to :math:`\pm 1` beyond the identified range, :math:`\varphi =
2\pi x/\text{pitch}`, the load :math:`L` over its nominal value and :math:`T_0` = 293.15 K. The slot ``+position`` has a
factor and an additive force, such as the force of a cable or a cover. In a log of motion in one direction only, the two
are confounded. Each part is linear in its coefficients.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from bristle.core import Variable, kernel
from bristle.core.contracts import NOMINAL_TEMPERATURE, FrictionModel, Motion, Relation
from bristle.core.dimensions import exponents_of
from bristle.core.dispatch import friction_rate, friction_trial
from bristle.core.documented import relations_of
from bristle.core.lazy import once
from bristle.core.mathematics import cos, sin
from bristle.core.surroundings import OF_MOTION
from bristle.models.friction.enclosing import CoefficientsModel, enclosed

SMALLEST_FACTOR = 0.01
TWO_PI = 2.0 * math.pi
# Known from the log or the axis file, never fitted.
MIDDLE = Variable("length", "middle of the range of positions")
HALF_RANGE = Variable("length", "half of the range of positions", min=1e-12)
PITCH = Variable("length", "travel per turn of the screw", min=1e-12)


class Place(NamedTuple):
    """Coefficients of all variations; zero for absent slots."""

    x_0: Annotated[float, MIDDLE] = 0.0
    x_L: Annotated[float, HALF_RANGE] = 1.0
    p_1: Annotated[
        float,
        Variable(
            "1", "relative change of friction along x, linear part", nominal=0.1, excitation="place"
        ),
    ] = 0.0
    p_2: Annotated[
        float,
        Variable(
            "1",
            "relative change of friction along x, quadratic part",
            nominal=0.1,
            excitation="place",
        ),
    ] = 0.0
    a_1: Annotated[
        float, Variable("force", "additive force along x, linear part", excitation="place")
    ] = 0.0
    a_2: Annotated[
        float, Variable("force", "additive force along x, quadratic part", excitation="place")
    ] = 0.0
    pitch: Annotated[float, PITCH] = 1.0
    c_1: Annotated[
        float,
        Variable(
            "force",
            "additive force once per turn, cosine of the angle",
            directional=True,
            excitation="place",
        ),
    ] = 0.0
    s_1: Annotated[
        float,
        Variable(
            "force",
            "additive force once per turn, sine of the angle",
            directional=True,
            excitation="place",
        ),
    ] = 0.0
    c_2: Annotated[
        float,
        Variable(
            "force",
            "additive force twice per turn, cosine of the angle",
            directional=True,
            excitation="place",
        ),
    ] = 0.0
    s_2: Annotated[
        float,
        Variable(
            "force",
            "additive force twice per turn, sine of the angle",
            directional=True,
            excitation="place",
        ),
    ] = 0.0
    k_L: Annotated[
        float,
        Variable("1", "relative change of friction at twice the nominal load", excitation="load"),
    ] = 0.0
    k_T: Annotated[
        float,
        Variable(
            "1/temperature",
            "relative change of friction per kelvin",
            nominal=1e-2,
            excitation="temperature",
        ),
    ] = 0.0


VARIATIONS: dict[str, tuple[str, ...]] = {
    "position": ("x_0", "x_L", "p_1", "p_2", "a_1", "a_2"),
    "periodic": ("pitch", "c_1", "s_1", "c_2", "s_2"),
    "load": ("k_L",),
    "temperature": ("k_T",),
}
"""The parameters of each slot."""
LIKE_A_SPRING = {"a_1": "spring_1", "a_2": "spring_2"}
"""Additive force along the axis -> the same force of a plant with a spring."""
ADDS = {
    "periodic": "an additive force that depends on the angle of the screw, the same in both directions"
}
"""The additive forces of slots, in words."""
VARIES_WITH = {name: name for name in VARIATIONS if name not in ADDS}
"""The causes of a variation of friction, in words."""
SURROUNDINGS = {name: OF_MOTION[name] for name in VARIATIONS if name in Motion._field_defaults}
"""Surroundings of each slot that depends on more than the position."""


def is_factor(variable: Variable) -> bool:
    """Return whether a coefficient of a slot multiplies friction; the others add a force to it."""
    return variable.excitation in ("place", *SURROUNDINGS) and "force" not in exponents_of(
        variable.quantity
    )


class Varied(NamedTuple):
    """Parameters of a model that varies."""

    inner: Any
    place: Place


@kernel
def share_of(x, q):
    """Return the position over half the range, from -1 to 1."""
    return max(-1.0, min((x - q.x_0) / q.x_L, 1.0))


@kernel
def factor_at(x, load, temperature, q):
    """Return the factor of friction at a position, a load and a temperature."""
    xi = share_of(x, q)
    causes = q.k_L * (load - 1.0) + q.k_T * (temperature - NOMINAL_TEMPERATURE)
    return max(1.0 + xi * (q.p_1 + xi * q.p_2) + causes, SMALLEST_FACTOR)


@kernel
def force_at(x, q):
    """Return the additive force [N or N*m] at a position [m or rad]."""
    xi = share_of(x, q)
    phase = TWO_PI * x / q.pitch
    c, s = cos(phase), sin(phase)
    once, twice = q.c_1 * c + q.s_1 * s, q.c_2 * (c * c - s * s) + q.s_2 * 2.0 * s * c
    return xi * (q.a_1 + xi * q.a_2) + once + twice


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] of the model at the middle of the step, with its variation."""
    force, move = friction_trial(state, memory, motion, dt, p.inner)
    x = motion.x - 0.5 * dt * motion.v
    return factor_at(x, motion.load, motion.temperature, p.place) * force + force_at(
        x, p.place
    ), move


@kernel
def rate(state, motion, p):
    """Return the force [N or N*m] of the model with its variation, and the rate of its state."""
    force, d_state = friction_rate(state, motion, p.inner)
    factor = factor_at(motion.x, motion.load, motion.temperature, p.place)
    return factor * force + force_at(motion.x, p.place), d_state


@dataclass(frozen=True, kw_only=True)
class VariedModel(CoefficientsModel):
    """A friction model with slots that let it vary."""

    coefficients = Place
    of_slot = VARIATIONS
    without_default = ("x_L", "pitch")
    depends_on = SURROUNDINGS

    def _made_by(self) -> tuple[Any, tuple[Any, ...]]:
        return _varied, (self.inner, self.slots)


def varied(model: FrictionModel, slots: Iterable[str]) -> FrictionModel:
    """Return `model` with those slots that let it vary; the model itself if there are none."""
    chosen = tuple(slot for slot in VARIATIONS if slot in set(slots))
    return _varied(model, chosen) if chosen else model


@once
def _varied(model: FrictionModel, slots: tuple[str, ...]) -> VariedModel:
    return enclosed(
        VariedModel,
        model,
        name="+".join((model.name, *slots)),
        description=", ".join((model.description, *_in_words(slots))),
        Parameters=Varied,
        trial=trial,
        rate=rate if model.rate else None,
        relations=(*relations_of(model), *_relations(slots)),
        # A factor times a coefficient of the model is not linear in both.
        linear=model.linear and slots == ("periodic",),
        example=dict(model.example)
        | {name: _EXAMPLE[name] for slot in slots for name in VARIATIONS[slot]},
        slots=slots,
    )


def _in_words(slots: tuple[str, ...]) -> list[str]:
    """Return the effects of slots on a model, in words."""
    causes = [VARIES_WITH[slot] for slot in slots if slot in VARIES_WITH]
    return [
        *([f"varying with {' and '.join(causes)}"] if causes else []),
        *(f"with {ADDS[slot]}" for slot in slots if slot in ADDS),
    ]


_EXAMPLE = {
    "x_0": 0.1,
    "x_L": 0.1,
    "p_1": 0.05,
    "p_2": -0.08,
    "a_1": 0.6,
    "a_2": 0.4,
    "pitch": 5e-3,
    "c_1": 0.7,
    "s_1": -0.3,
    "c_2": 0.3,
    "s_2": 0.2,
    "k_L": 0.8,
    "k_T": -0.01,
}


def _relations(slots: tuple[str, ...]) -> tuple[Relation, ...]:
    if "position" not in slots:
        return ()
    return (
        Relation(
            "1 + p_1 xi + p_2 xi^2 > 0 for xi from -1 to 1",
            lambda p: _least_factor(p.place) > SMALLEST_FACTOR,
            "Give smaller p_1 and p_2: friction must not change its sign along the axis",
        ),
    )


def _least_factor(q: Place) -> float:
    turn = -0.5 * q.p_1 / q.p_2 if q.p_2 else 0.0
    at = (-1.0, 1.0, max(-1.0, min(turn, 1.0)))
    return min(1.0 + xi * (q.p_1 + xi * q.p_2) for xi in at)
