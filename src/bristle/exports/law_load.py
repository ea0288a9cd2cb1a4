"""The efforts of a law along the desired motion, as text: what it feeds forward, and what passes through friction."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.experiment import Feedforward
from bristle.friction.level import rises_with_effort
from bristle.plants import inertia
from bristle.plants.terms import Place, Termed, place_of

__all__ = ["Gravity", "Load", "loads_of"]


class Gravity(NamedTuple):
    """Gravity of a link [N or N*m], of a plant without cogging."""

    g_sin: float
    g_cos: float


class Load(NamedTuple):
    """An effort along the desired motion: of inertia, and of the place; what its parameters begin with."""

    prefix: str
    mass: float
    place: Any

    @property
    def numbers(self) -> tuple[float, ...]:
        """All numbers that it depends on."""
        return (self.mass, *(float(number) for part in self.place or () for number in np.atleast_1d(part)))

    def text(self, before: str, after: str) -> str:
        """Return it as text between two samples, by their places among those ahead; the present one has none."""
        parts = []
        if self.mass:
            parts.append(f"inertial({_ahead('acceleration', before)}, acceleration_ahead[{after}], p.{self.prefix}mass)")
        if self.place:
            kernel_name = "effort_at" if isinstance(self.place, Place) else "gravity_at"
            middle = f"0.5 * ({_ahead('position', before)} + place_ahead[{after}])"
            parts.append(f"{kernel_name}({middle}, p.{self.prefix}place)")
        return " + ".join(parts) or "0.0"


def _ahead(name: str, place: str) -> str:
    ahead = f"{'place' if name == 'position' else name}_ahead[{place}]"
    return name if not place else f"({ahead} if i > 0 else {name})" if "i" in place else ahead


def loads_of(feedforward: Feedforward, *, apart: bool = False) -> tuple[Load, Load]:
    """Return what is fed forward beside friction, and what passes through it: the same one where both are."""
    fed = Load("", float(feedforward.mass), _place(feedforward.plant))
    carries = feedforward.carries
    if feedforward.friction is None or carries is None or not rises_with_effort(feedforward.friction):
        return fed, fed
    if _base(carries) is not inertia:
        raise InputError(
            "carries more than inertia, gravity and cogging, which is not exported",
            path="feedforward.carries",
            value=carries.name,
            mend="Leave it out: what is fed forward passes on then",
        )
    carried = Load("carried_", float(carries.values["M"]), _place(carries))
    return fed, fed if carried.numbers == fed.numbers and not apart else carried


def _base(plant: Model) -> Any:
    return plant.component.inner if isinstance(plant.parameters, Termed) else plant.component


def _place(plant: Model | None) -> Any:
    """Return what the effort of a plant depends on at a place; None for nothing."""
    place = place_of(plant)
    if place.waves.size:
        return place
    return Gravity(place.g_sin, place.g_cos) if place.g_sin or place.g_cos else None
