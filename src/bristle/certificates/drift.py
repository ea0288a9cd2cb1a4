"""Drift: whether the contact creeps under a force that never reaches break-away.

The force goes up and down between two levels. A real contact settles into a closed loop and stays; a model that slips a
little at every force walks on, cycle after cycle.
"""

from __future__ import annotations

from bristle.certificates.certificate import Certificate, not_applicable
from bristle.certificates.quasi_static import Holding, Path
from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.typography import with_unit
from bristle.core.variable import unit_of

__all__ = ["DEFAULT_RIPPLE", "drift"]

DEFAULT_RIPPLE = (0.3, 0.6)  # shares of break-away
ALLOWED = 1e-6  # of the displacement to the upper force
CYCLES = 100
HOUR = 36_000  # cycles in an hour of a ripple of 10 Hz


def drift(model: Model, holding: Holding, ripple: tuple[float, float] | None, is_magnet: bool) -> Certificate:
    """Return the displacement per settled cycle [m or rad] under a force between two levels [N or N*m]."""
    unit = unit_of("length", model.kind)
    if is_magnet:
        return not_applicable(unit, "Its loops run the other way around, as a magnet's: no force holds it")
    if not holding.breaks_away:
        return not_applicable(unit, "It has no break-away force: any force moves it, or it is a spring to the end")
    low, high = ripple or tuple(map(holding.level, DEFAULT_RIPPLE))
    _refuse_break_away(low, high, holding, unit_of("force", model.kind))
    if not holding.has_presliding:
        return Certificate(True, 0.0, unit, 0.0, True, "It rests: nothing moves below break-away")
    path = Path(model, holding)
    path.to_force(high)
    threshold = ALLOWED * abs(path.x)
    moved = _per_settled_cycle(path, low, high, threshold)
    passed = abs(moved) <= threshold
    advice = "It stays where it is put"
    if not passed:
        creep = with_unit(abs(moved) * HOUR, unit)
        advice = f"It creeps {creep} in an hour at 10 Hz: take maxwell_slip, gms, or preisach_lugre with its gate"
    return Certificate(True, moved, unit, threshold, passed, advice)


def _per_settled_cycle(path: Path, low: float, high: float, negligible: float) -> float:
    moved = 0.0
    for _ in range(CYCLES):
        start, before = path.x, moved
        path.to_force(low)
        path.to_force(high)
        moved = path.x - start
        if abs(moved - before) <= 1e-5 * abs(moved) or abs(moved) <= 1e-3 * negligible:
            break
    return moved


def _refuse_break_away(low: float, high: float, holding: Holding, unit: str) -> None:
    if not holding.backward < low < high < holding.forward:
        raise InputError(
            "must be two forces at which the contact rests, the lower first",
            path="force_ripple",
            value=(low, high),
            allowed=f"above {holding.backward:.6g} and below {holding.forward:.6g} {unit}",
        )
