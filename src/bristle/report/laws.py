"""A control law and what is fed forward beside it, in the lines that a person types in."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from bristle.core.typography import with_unit
from bristle.core.variable import unit_of
from bristle.files.components import key_of
from bristle.report.design_tables import at_the_motor
from bristle.report.front import fixed
from bristle.report.symbols import GREEK

if TYPE_CHECKING:
    from bristle.core.experiment import Variant

__all__ = ["law_lines"]


def law_lines(variant: Variant) -> list[str]:
    """Return the gains of a loop, at its motor too where that is known, and what is fed forward."""
    fed = variant.feedforward
    lines = [f"law {variant.controller.name}: {', '.join(_gains(variant))}"]
    if fed.friction is not None:
        share = "" if fed.gain == 1.0 else f" × {fed.gain:g}"
        lines.append(f"friction fed forward: {fed.friction.name}{share}, along the {fed.along} motion")
    if fed.mass > 0.0:
        lines.append(f"acceleration × {fixed(fed.mass, unit_of('mass', variant.plant.kind))} fed forward")
    return lines


def _gains(variant: Variant) -> list[str]:
    law, gains = variant.controller, []
    for name, value in law.values.items():
        if isinstance(value, (str, bool)) or not isinstance(value, (int, float)) or not 0.0 < abs(value) < math.inf:
            continue
        unit, key = law.component.variables[name].unit(law.kind), key_of(name)
        text = f"{GREEK.get(key, key)} {with_unit(float(value), unit, 4)}".replace(" ", "\u00a0")
        motor = at_the_motor(float(value), unit, variant)
        gains.append(f"{text} ({motor})" if motor else text)
    return gains
