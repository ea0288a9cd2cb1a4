r"""Certificates of slow motion: bounded deflection in sliding, drift below break-away, closure of a minor loop.

A bristle that is fed by a hysteresis force saturating at :math:`f_p` stops deflecting where that force reaches what
friction can hold, :math:`F_S`. With :math:`f_p \le F_S` it never does, and the deflection grows for as long as the
body slides. The contact is slid slowly, ever farther, and the deflection is read.

Drift: under a force that goes up and down below break-away a real contact settles into a closed loop and stays; a model
that slips a little at every force walks on. Closure: loaded, moved half of the way back and forth again, a real contact
comes back to the force that it had; a model without a memory of where it turned misses it.
"""

import math
from collections.abc import Callable

import numpy as np

from bristle.certificates.certificate import Certificate, OperatorParameters, not_applicable
from bristle.certificates.quasi_static import CREEP, Holding, Path
from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.typography import number, with_unit
from bristle.core.variable import unit_of, variables_of
from bristle.engine.contact import Contact

LEAST_RATIO = 1.05  # of f_p to F_S, and of a deflection that grows to what it was at half the distance
CREEPING = 1e-6  # of the displacement to the upper force, in a cycle: more is drift
MISSING = 1e-3  # of break-away: a loop that misses more is not closed


def well_posed(model: Model, holding: Holding) -> Certificate:
    """Return whether the deflection is bounded in sliding, and its bound [m, rad, or N, N*m where it is a force]."""
    if isinstance(model.parameters, OperatorParameters):
        return not_applicable("1", "An operator has no deflection of its own: its input is given")
    # The deflection z is read where there is one, else the first state, else the force.
    states = variables_of(model.component.State)
    name = "z" if "z" in states else next(iter(states), "")
    unit = unit_of(states[name].quantity if name else "force", model.kind)

    def read(contact: Contact, side: float) -> float:
        return abs(float(contact.state[list(states).index(name)])) if name else abs(contact.force(side * 0.0))

    if not holding.has_presliding:
        return not_applicable(unit, "It has no deflection that could grow")
    bound = _bound(model, read, holding)
    # F_S, the larger one where it differs by direction.
    static_force = max((value for name, value in model.values.items() if name in ("F_S", "F_S_pos", "F_S_neg")), default=None)
    saturation = model.values.get("f_p")
    if saturation is None or static_force is None:
        advice = "Bounded for all parameters" if math.isfinite(bound) else "It grows for as long as the body slides: let it saturate"
        return Certificate(True, bound, unit, math.inf, math.isfinite(bound), advice)
    least = LEAST_RATIO * static_force
    at_least = model.component(kind=model.kind, validate=False, **(model.values | {"f_p": least}))
    passed = bool(saturation >= least * (1.0 - 1e-12) and math.isfinite(bound))
    share = f"{100.0 * (saturation / static_force - 1.0):.3g}"
    raised = f"raise f_p to {with_unit(least, unit_of('force', model.kind), 4)} at least"
    if passed:
        advice = f"f_p lies {share} % above F_S"
    elif math.isfinite(bound):
        advice = f"f_p lies only {share} % above F_S: {raised}"
    else:
        advice = f"The deflection grows for as long as the body slides: {raised}"
    return Certificate(True, bound, unit, _bound(at_least, read, holding), passed, advice)


def _bound(model: Model, read: Callable[[Contact, float], float], holding: Holding) -> float:
    """Return the largest deflection in slow sliding, either way; infinite where it still grows at the end."""
    largest = 0.0
    for side in (1.0, -1.0):
        contact = Contact(model)
        for reach in holding.distance * np.geomspace(1e-3, 1e6, 200):
            contact.move(side * reach - contact.x, CREEP)
        before = read(contact, side)
        contact.move(contact.x, CREEP)
        after = read(contact, side)
        if not after <= LEAST_RATIO * before:
            return math.inf
        largest = max(largest, after)
    return largest


def drift(model: Model, holding: Holding, ripple: tuple[float, float] | None, is_magnet: bool) -> Certificate:
    """Return the displacement per settled cycle [m or rad] under a force between two levels [N or N*m]."""
    unit = unit_of("length", model.kind)
    if is_magnet:
        return not_applicable(unit, "Its loops run the other way around, as a magnet's: no force holds it")
    if not holding.breaks_away:
        return not_applicable(unit, "It has no break-away force: any force moves it, or it is a spring to the end")
    low, high = ripple or tuple(map(holding.level, (0.3, 0.6)))
    if not holding.backward < low < high < holding.forward:
        raise InputError(
            "must be two forces at which the contact rests, the lower first",
            path="force_ripple",
            value=(low, high),
            allowed=f"above {holding.backward:.6g} and below {holding.forward:.6g} {unit_of('force', model.kind)}",
        )
    if not holding.has_presliding:
        return Certificate(True, 0.0, unit, 0.0, True, "It rests: nothing moves below break-away")
    path = Path(model, holding)
    path.to_force(high)
    threshold = CREEPING * abs(path.x)
    moved = 0.0
    for _ in range(100):
        start, before = path.x, moved
        path.to_force(low)
        path.to_force(high)
        moved = path.x - start
        if abs(moved - before) <= 1e-5 * abs(moved) or abs(moved) <= 1e-3 * threshold:
            break
    passed = abs(moved) <= threshold
    advice = "It stays where it is put"
    if not passed:
        creep = with_unit(abs(moved) * 36_000, unit)
        advice = f"It creeps {creep} in an hour at 10 Hz: take maxwell_slip, gms, or preisach_lugre with its gate"
    return Certificate(True, moved, unit, threshold, passed, advice)


def closure(model: Model, holding: Holding, loop: tuple[float, float] | None) -> Certificate:
    """Return the force missing at the return to `x1` over ``0 -> x1 -> x2 -> x1``, as a fraction of break-away."""
    if not holding.has_presliding:
        return not_applicable("1", "Its force does not build up over a distance: there is no minor loop")
    x1, x2 = loop or default_loop(model, holding)
    if not (math.isfinite(x1) and math.isfinite(x2) and x1 != 0.0 and x2 / x1 < 1.0):
        raise InputError(
            "must be where the loop turns first, away from 0, and then, back from there",
            path="loop",
            value=(x1, x2),
            allowed=f"such as (3e-6, 1.5e-6) {unit_of('length', model.kind)}",
        )
    path = Path(model, holding)
    path.to_position(x1)
    loaded = path.force
    path.to_position(x2)
    path.to_position(x1)
    missing = math.copysign(1.0, x1) * (path.force - loaded) / holding.half
    passed = abs(missing) <= MISSING
    advice = "It comes back to the force that it had"
    if not passed:
        share = number(100.0 * abs(missing), digits=3)
        advice = (
            f"{share} % of break-away is missing at the return: take maxwell_slip, gms, or preisach_lugre with a gate "
            "that is closed up to this load"
        )
    return Certificate(True, missing, "1", MISSING, passed, advice)


def default_loop(model: Model, holding: Holding) -> tuple[float, float]:
    """Return where to turn [m or rad]: at 0.85 of break-away, and halfway back."""
    path = Path(model, holding)
    path.to_force(holding.level(0.85))
    return path.x, 0.5 * path.x
