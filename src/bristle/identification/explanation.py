"""The result of `explain`: parts of the effort with their evidence, numbers with intervals, tables of forces."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from bristle.core.typography import number, scale_of, with_unit
from bristle.core.variable import Kind, unit_of

LEAST_SHARE = 0.005  # smallest share of a part in the verdict
OF_CHANNEL = "channel "  # before the name of a recorded channel with which the level changes
WHOLE_ORDER = 0.02  # waves a turn: distance of an order from a whole number

LABELS = {
    "coulomb": "Coulomb",
    "stribeck": "falling with speed",
    "viscous": "viscous",
    "offset": "constant",
    "known": "known columns",
    "cable": "cable",
    "spring": "spring",
    "cubic": "cubic spring",
    "gravity": "gravity",
    "curve": "force over position",
    "level": "along the axis",
    "load": "with load",
    "warmup": "warm-up",
}
DOUBTS = {
    "not_saturated": "The stroke is only a few slip lengths, so no row shows saturated friction. Delay, inertia and "
    "Coulomb friction remain unknown. Record longer strokes, or state the mass.",
    "reverses_fast": "The axis reverses so fast that filtered samples mix both directions. Delay, inertia and Coulomb "
    "friction remain unknown. Record longer strokes, or sample faster.",
    "no_inertia": "The inertial force is too small beside friction, so inertia and delay remain unknown. Record faster moves.",
    "one_direction": "The axis moves in one direction, so Coulomb friction and a constant force look alike. Record both directions.",
    "delay_at_edge": "The delay is at the end of its search range, so delay and inertia remain unknown. Record faster "
    "moves, or correct the time of the effort.",
    "loaded": "Friction rises with the force that it transmits, so this stage does not tell Coulomb and viscous friction from "
    "the load. Identify a model with it, such as lugre+transmitted.",
}
"""Reason for unknown numbers -> sentence."""
UNKNOWN = {
    "not_saturated": ("M", "F_C", "sliding", "F_v", "delay"),
    "reverses_fast": ("M", "F_C", "sliding", "F_v", "delay"),
    "no_inertia": ("M", "delay"),
    "one_direction": ("F_C", "sliding"),
    "delay_at_edge": ("M", "delay"),
    "loaded": ("F_C", "sliding", "F_v"),
}
"""Reason for unknown numbers -> these numbers."""


class Evidence(NamedTuple):
    """Rise of the held-out error without a term.

    `gain` is an amplitude over the rms of friction, `z` the mean logarithm of the ratio of errors over its standard error.
    """

    gain: float
    z: float


class Interval(NamedTuple):
    """A value and the half-width of its 95 % interval, in SI units."""

    value: float
    half_width: float

    def text(self, unit: str) -> str:
        """Return the value with its half-width in a readable unit."""
        scale = scale_of(unit, self.value)
        value = number(self.value * scale.factor, self.half_width * scale.factor)
        half_width = number(self.half_width * scale.factor, digits=2)
        return f"{value} ± {half_width} {scale.unit}"

    def times(self, factor: float) -> Interval:
        """Return the interval of a multiple."""
        return Interval(self.value * factor, self.half_width * abs(factor))


@dataclass(frozen=True)
class Friction:
    """Friction of the simplest law beside the found terms.

    Parameters
    ----------
    F_C : Interval
        Coulomb friction [N or N*m].
    F_v : Interval
        Viscous friction [N*s/m or N*m*s/rad].
    sliding : Interval
        Coulomb friction and the limit of the cable [N or N*m].
    """

    F_C: Interval
    F_v: Interval
    sliding: Interval


@dataclass(frozen=True)
class Part:
    r"""A part of the effort without inertia.

    Parameters
    ----------
    name : str
        Name of the part, such as ``"coulomb"``, ``"spring"`` or ``"ripple 400"``.
    rms : float
        Root mean square of its force in the rows [N or N*m].
    share : float
        `rms` over the sum of the rms of all parts.
    evidence : Evidence or None
        Evidence of a term; None for friction and the constant force, which are always fitted.
    frequency : float
        Waves per length of a ripple [1/m or 1/rad]; 0 for other parts.
    wave : tuple of float
        Factors of the cosine and the sine of :math:`2 \pi` `frequency` `x` of a ripple [N or N*m], relative to friction for
        a ripple of friction; empty for other parts.
    """

    name: str
    rms: float
    share: float
    evidence: Evidence | None
    frequency: float
    wave: tuple[float, ...] = ()

    def label(self, kind: Kind) -> str:
        """Return the words for this part."""
        if self.name.startswith(OF_CHANNEL):
            return f"with {self.name.removeprefix(OF_CHANNEL)}"
        if not self.frequency:
            return LABELS[self.name]
        words = "ripple"
        if self.name.startswith("level"):
            words = "friction ripple"
        return f"{words} {wave_text(self.frequency, kind)}"


def wave_text(frequency: float, kind: Kind) -> str:
    """Return the wavelength of a ripple, or its order in a turn."""
    wavelength = 1.0 / frequency
    if kind == "translational":
        return with_unit(wavelength, "m")
    order = 2.0 * math.pi * frequency
    if abs(order - round(order)) < WHOLE_ORDER * max(1.0, 0.1 * order):
        return f"of order {round(order)}"
    return with_unit(wavelength, "rad")


@dataclass(frozen=True, eq=False)
class Curve:
    """A table of a force or of a relative level.

    Parameters
    ----------
    over : str
        Quantity of `at`: ``"length"``, ``"length/time"`` or ``"time"``.
    at : ndarray, shape (point,)
        Position, travel, velocity or time in SI units of the axis.
    of : str
        Quantity of `values`: ``"force"``, or ``"1"`` for a relative level.
    values : ndarray, shape (point,)
        Force [N or N*m], or level of friction over its mean.
    """

    over: str
    at: np.ndarray
    of: str
    values: np.ndarray


@dataclass(frozen=True, eq=False)
class Explanation:
    """The parts of the effort of a log, and its numbers; see `explain`.

    Parameters
    ----------
    kind : {"translational", "rotational"}
        Kind of axis.
    parts : tuple of Part
        Parts of the effort without inertia, the largest first.
    filter : Evidence or None
        Evidence that effort and position passed different filters; None if the log does not show it.
    rejected : mapping of str to Evidence
        Terms that the log does not show.
    M : Interval or None
        Inertia [kg or kg*m^2]; None, like the numbers below, if a doubt leaves it unknown.
    F_C : Interval or None
        Coulomb friction [N or N*m].
    sliding : Interval or None
        Coulomb friction and the limit of the cable [N or N*m]: known better than its parts if both slip alike.
    F_v : Interval or None
        Viscous friction [N*s/m or N*m*s/rad].
    delay : Interval or None
        Time by which the effort was recorded late [s].
    inertia : float
        Rms inertial force [N or N*m].
    effort : float
        Rms effort [N or N*m].
    unexplained : float
        Rms residual [N or N*m].
    floor : float
        Rms error of held-out parts of the log [N or N*m].
    curves : mapping of str to Curve
        ``"position"``: force without ripples; ``"level"``: relative level of friction along the axis; ``"time"``: relative level over time;
        ``"speed"``: steady friction; ``"travel"``: friction after a slow reversal.
    doubts : tuple of str
        Reasons for unknown numbers: ``"not_saturated"``, ``"reverses_fast"``, ``"no_inertia"``, ``"delay_at_edge"``, ``"one_direction"``,
        ``"loaded"``.
    """

    kind: Kind
    parts: tuple[Part, ...]
    filter: Evidence | None
    rejected: Mapping[str, Evidence]
    M: Interval | None
    F_C: Interval | None
    sliding: Interval | None
    F_v: Interval | None
    delay: Interval | None
    inertia: float
    effort: float
    unexplained: float
    floor: float
    curves: Mapping[str, Curve]
    doubts: tuple[str, ...]

    @property
    def terms(self) -> list[Part]:
        """Parts that the log shows beside friction, inertia and a constant force."""
        return [part for part in self.parts if part.evidence is not None]

    @property
    def verdict(self) -> str:
        """The parts in one line, such as ``82 % Coulomb, 9 % cable, 6 % along the axis, 2 % ripple 2.5 mm``."""
        shares = dict[str, float]()
        for part in self.parts:
            label = part.label(self.kind)
            shares[label] = shares.get(label, 0.0) + part.share
        ranked = sorted(shares.items(), key=lambda entry: -entry[1])
        visible = [(label, share) for label, share in ranked if share >= LEAST_SHARE]
        return ", ".join(f"{percent(share)} % {label}" for label, share in visible)

    @property
    def notes(self) -> list[str]:
        """Sentences on unknown numbers."""
        return [DOUBTS[code] for code in self.doubts]

    @property
    def numbers(self) -> dict[str, tuple[Interval | None, str]]:
        """The numbers with their units, by name."""
        units = {
            "M": "mass",
            "F_C": "force",
            "F_C_and_cable": "force",
            "F_v": "force*time/length",
            "delay": "time",
        }
        values = (self.M, self.F_C, self.sliding, self.F_v, self.delay)
        named = zip(units.items(), values, strict=True)
        numbers = {name: (value, unit_of(unit, self.kind)) for (name, unit), value in named}
        if not any(part.name == "cable" for part in self.parts):
            del numbers["F_C_and_cable"]
        return numbers

    def as_data(self, *, tables: bool = True) -> dict[str, Any]:
        """Return the result as plain data, with its `tables` if wanted."""
        curves = {name: curve_data(curve, self.kind) for name, curve in self.curves.items()}
        with_tables = {"curves": curves} if tables else {}
        return with_tables | {
            "verdict": self.verdict,
            "parts": [part_data(part, self.kind) for part in self.parts],
            "filter": filter_data(self.filter),
            "rejected": {
                name: entry._asdict()
                for name, entry in self.rejected.items()
                if name in LABELS or name.startswith(OF_CHANNEL)
            },
            "numbers": {
                name: number_data(value, unit) for name, (value, unit) in self.numbers.items()
            },
            "inertia": self.inertia,
            "effort": self.effort,
            "unexplained": self.unexplained,
            "unexplained_share": self.unexplained / self.effort,
            "floor": self.floor,
            "doubts": list(self.doubts),
            "notes": self.notes,
        }


def explanation_of(
    *,
    kind: Kind,
    parts: Sequence[Part],
    rejected: Mapping[str, Evidence],
    M: Interval,
    friction: Friction,
    delay: Interval,
    doubts: tuple[str, ...],
    **facts: Any,
) -> Explanation:
    """Return the result; with a doubt, the numbers of the rows at speed are unknown."""
    facts |= {"kind": kind, "parts": tuple(parts), "rejected": rejected, "doubts": doubts}
    numbers: dict[str, Interval | None] = {"M": M, "delay": delay}
    numbers |= {"F_C": friction.F_C, "sliding": friction.sliding, "F_v": friction.F_v}
    for doubt in doubts:
        numbers |= dict.fromkeys(UNKNOWN[doubt])
    return Explanation(**numbers, **facts)


def percent(share: float) -> str:
    """Return a share as a percentage, with a decimal below 1 %."""
    if share < 0.01:
        return f"{100.0 * share:.1f}"
    return f"{100.0 * share:.0f}"


def part_data(part: Part, kind: Kind) -> dict[str, Any]:
    """Return a part as plain data."""
    data: dict[str, Any] = {"name": part.name, "label": part.label(kind), "rms": part.rms}
    data |= {"share": part.share, "gain": None, "z": None, "wavelength": None, "wave": None}
    if part.evidence is not None:
        data |= part.evidence._asdict()
    if part.frequency:
        data |= {"wavelength": 1.0 / part.frequency, "wave": list(part.wave)}
    return data


def filter_data(evidence: Evidence | None) -> dict[str, float] | None:
    """Return the evidence of different filters as plain data."""
    if evidence is None:
        return None
    return evidence._asdict()


def number_data(interval: Interval | None, unit: str) -> dict[str, Any]:
    """Return a number with its unit as plain data."""
    if interval is None:
        return {"value": None, "half_width": None, "unit": unit}
    return interval._asdict() | {"unit": unit}


def curve_data(curve: Curve, kind: Kind) -> dict[str, Any]:
    """Return a table as plain data."""
    return {
        "at": curve.at.tolist(),
        "at_unit": unit_of(curve.over, kind),
        "values": curve.values.tolist(),
        "unit": unit_of(curve.of, kind),
    }
