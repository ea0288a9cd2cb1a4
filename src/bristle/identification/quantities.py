"""Quantities of a plant with two masses, with their 95 % intervals."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from bristle.core.variable import Kind, unit_of
from bristle.identification.elasticity import DAMPING, KAPPA, M_1, M_2, Masses
from bristle.identification.lost_motion import Hysteresis, LostMotion
from bristle.identification.two_encoders import FACTOR, half_width

if TYPE_CHECKING:
    from bristle.identification.elasticity import Elastic

JUDGED = ("motor", "load", "stiffness")
MOST_ERROR = 0.25  # relative half-width of a mass or of the stiffness above which a log does not show two masses
MASS: Mapping[Kind, str] = {"translational": "mass", "rotational": "moment of inertia"}


class Quantity(NamedTuple):
    """A value with the half-width of its 95 % interval, unit and meaning; a play or a nut of 0 is smaller than its half-width."""

    name: str
    value: float
    half_width: float
    unit: str
    meaning: str


def quantities_of(
    masses: Masses, lost: LostMotion | None, kind: Kind, step: float, *, measured: bool = False
) -> tuple[Quantity, ...]:
    """Return values with intervals and units; without play if the lost motion is unknown. A `measured` motor is a screw behind a sensor."""
    value, error = masses.values.tolist(), masses.errors.tolist()
    damping_error = math.hypot(
        masses.stiffness * error[DAMPING],
        masses.damping * masses.stiffness_error / masses.stiffness,
    )
    hertz = 0.5 / math.pi / math.sqrt(value[KAPPA])
    unit = {
        name: unit_of(name, kind)
        for name in ("mass", "force/length", "force*time/length", "length")
    }
    of_lost_motion = list[Quantity]()
    if lost is not None:
        size, bound = lost.play if lost.clear else 0.0, lost.nut + FACTOR * lost.nut_error
        width = half_width(size, lost.play_error) if lost.clear else max(lost.play, step)
        nut, nut_width = (lost.nut, FACTOR * lost.nut_error) if lost.nut_is_clear else (0.0, bound)
        of_lost_motion = [
            Quantity("play", size, width, unit["length"], "play"),
            Quantity("nut", nut, nut_width, "1", "friction of the nut per force of the coupling"),
        ]
        if lost.hysteresis is not None:
            of_lost_motion += _of_hysteresis(
                lost.hysteresis, half_width(masses.stiffness, masses.stiffness_error), kind
            )
    mass, half = unit["mass"], half_width(value[M_1], error[M_1])
    motor = Quantity("motor", value[M_1], half, mass, f"{MASS[kind]} of the motor")
    if measured:
        size, half = (value[M_1], half) if value[M_1] > half else (0.0, value[M_1] + half)
        motor = Quantity("screw", size, half, mass, f"{MASS[kind]} between sensor and coupling")
    return (
        motor,
        Quantity(
            "load",
            value[M_2],
            half_width(value[M_2], error[M_2]),
            mass,
            f"{MASS[kind]} of the load",
        ),
        Quantity(
            "stiffness",
            masses.stiffness,
            half_width(masses.stiffness, masses.stiffness_error),
            unit["force/length"],
            "stiffness",
        ),
        Quantity(
            "damping",
            masses.damping,
            half_width(masses.damping, damping_error),
            unit["force*time/length"],
            "damping",
        ),
        *of_lost_motion,
        Quantity(
            "antiresonance",
            hertz,
            half_width(hertz, 0.5 * hertz * error[KAPPA] / value[KAPPA]),
            "Hz",
            "antiresonance",
        ),
    )


def _of_hysteresis(loop: Hysteresis, half_width: float, kind: Kind) -> Sequence[Quantity]:
    """Return width, loss and stiffness of a coupling with hysteresis; `half_width` is that of its stiffness."""
    share, per_length = FACTOR * loop.error / loop.width, unit_of("force/length", kind)
    softer = share * (loop.small - loop.large)
    return (
        Quantity(
            "hysteresis",
            loop.width,
            share * loop.width,
            unit_of("force", kind),
            "width of the hysteresis of the coupling",
        ),
        Quantity(
            "loss",
            loop.loss,
            share * loop.loss,
            unit_of("force*length", kind),
            "loss of the coupling per cycle over the range of the log",
        ),
        Quantity(
            "small_stiffness",
            loop.small,
            math.hypot(softer, half_width),
            per_length,
            "stiffness in small motions",
        ),
        Quantity(
            "large_stiffness",
            loop.large,
            math.hypot(softer, half_width),
            per_length,
            "stiffness in large motions",
        ),
    )


def quantities_of_response(coupling: Elastic | None, kind: Kind) -> tuple[Quantity, ...]:
    """Return the quantities of a coupling that one encoder shows; empty without its masses."""
    if coupling is None or isinstance(coupling.masses, str):
        return ()
    hertz = {"value": coupling.antiresonance, "half_width": coupling.antiresonance_half_width}
    quantities = quantities_of(coupling.masses, None, kind, 0.0)
    return tuple(
        quantity._replace(**hertz) if quantity.name == "antiresonance" else quantity
        for quantity in quantities
    )


def unsure_of(quantities: Sequence[Quantity]) -> str:
    """Return the reason why masses and stiffness are not well known; empty if they are."""
    judged = [quantity for quantity in quantities if quantity.name in JUDGED]
    widest = max(judged, key=lambda quantity: quantity.half_width / quantity.value)
    percent = 100.0 * widest.half_width / widest.value
    return (
        ""
        if percent < 100.0 * MOST_ERROR
        else f"the log determines the {widest.meaning} only within {percent:.0f} %"
    )
