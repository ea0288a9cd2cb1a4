"""Closure: whether a minor loop comes back to the force that it left.

The contact is loaded, goes back half of the way, and returns. A real one remembers where it turned and comes back
to the force that it had; a model without such a memory misses it.
"""

from __future__ import annotations

import math

from bristle.certificates.certificate import Certificate, not_applicable
from bristle.certificates.quasi_static import Holding, Path
from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.typography import number
from bristle.core.variable import unit_of

__all__ = ["closure"]

LOAD = 0.85  # of break-away
BACK = 0.5  # of the displacement
ALLOWED = 1e-3  # of break-away


def closure(model: Model, holding: Holding, loop: tuple[float, float] | None) -> Certificate:
    """Return the force missing at the return to `x1` over ``0 -> x1 -> x2 -> x1``, as a fraction of break-away."""
    if not holding.has_presliding:
        return not_applicable("1", "Its force does not build up over a distance: there is no minor loop")
    x1, x2 = loop or default_loop(model, holding)
    _refuse_odd_loop(x1, x2, unit_of("length", model.kind))
    path = Path(model, holding)
    path.to_position(x1)
    loaded = path.force
    path.to_position(x2)
    path.to_position(x1)
    missing = math.copysign(1.0, x1) * (path.force - loaded) / holding.half
    passed = abs(missing) <= ALLOWED
    advice = "It comes back to the force that it had"
    if not passed:
        share = number(100.0 * abs(missing), digits=3)
        advice = (
            f"{share} % of break-away is missing at the return: take maxwell_slip, gms, or preisach_lugre with a gate "
            "that is closed up to this load"
        )
    return Certificate(True, missing, "1", ALLOWED, passed, advice)


def default_loop(model: Model, holding: Holding) -> tuple[float, float]:
    """Return where to turn [m or rad]: at 0.85 of break-away, and halfway back."""
    path = Path(model, holding)
    path.to_force(holding.level(LOAD))
    return path.x, (1.0 - BACK) * path.x


def _refuse_odd_loop(x1: float, x2: float, unit: str) -> None:
    if not (math.isfinite(x1) and math.isfinite(x2) and x1 != 0.0 and x2 / x1 < 1.0):
        raise InputError(
            "must be where the loop turns first, away from 0, and then, back from there",
            path="loop",
            value=(x1, x2),
            allowed=f"such as (3e-6, 1.5e-6) {unit}",
        )
