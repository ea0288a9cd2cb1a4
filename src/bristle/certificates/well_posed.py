r"""Well-posedness: whether the deflection stays bounded in sliding.

A bristle that is fed by a hysteresis force saturating at :math:`f_p` stops deflecting where that force reaches what
friction can hold, :math:`F_S`. With :math:`f_p \le F_S` it never does, and the deflection grows for as long as the
body slides. The contact is slid slowly, ever farther, and the deflection is read.
"""

from __future__ import annotations

import math

import numpy as np

from bristle.certificates.certificate import Certificate, not_applicable
from bristle.certificates.operator import OperatorParameters
from bristle.certificates.quasi_static import CREEP, Holding
from bristle.core.contracts import Model
from bristle.core.typography import with_unit
from bristle.core.variable import unit_of, variables_of
from bristle.engine.contact import Contact

__all__ = ["well_posed"]

LEAST_RATIO = 1.05  # of f_p to F_S
FARTHEST = 1e6  # times the pre-sliding distance
GROWTH = 1.05


def well_posed(model: Model, holding: Holding) -> Certificate:
    """Return whether the deflection is bounded in sliding, and its bound [m, rad, or N, N*m where it is a force]."""
    if isinstance(model.parameters, OperatorParameters):
        return not_applicable("1", "An operator has no deflection of its own: its input is given")
    read = _Reading(model)
    unit = unit_of(read.quantity, model.kind)
    if not holding.has_presliding:
        return not_applicable(unit, "It has no deflection that could grow")
    bound = _bound(model, read, holding)
    saturation, static_force = model.values.get("f_p"), _static_force(model)
    if saturation is None or static_force is None:
        finite = math.isfinite(bound)
        advice = "Bounded for all parameters" if finite else "It grows for as long as the body slides: let it saturate"
        return Certificate(True, bound, unit, math.inf, finite, advice)
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


def _static_force(model: Model) -> float | None:
    """Return F_S, the larger one where it differs by direction."""
    return max((value for name, value in model.values.items() if name in ("F_S", "F_S_pos", "F_S_neg")), default=None)


class _Reading:
    """What is read of a contact: the deflection z where there is one, else the first state, else the force."""

    def __init__(self, model: Model) -> None:
        states = variables_of(model.component.State)
        self._name = "z" if "z" in states else next(iter(states), "")
        self._at = list(states).index(self._name) if states else 0
        self.quantity = states[self._name].quantity if states else "force"

    def __call__(self, contact: Contact, side: float) -> float:
        return abs(float(contact.state[self._at])) if self._name else abs(contact.force(side * 0.0))


def _bound(model: Model, read: _Reading, holding: Holding) -> float:
    """Return the largest deflection in slow sliding, either way; infinite where it still grows at the end."""
    largest = 0.0
    for side in (1.0, -1.0):
        contact = Contact(model)
        for reach in holding.distance * np.geomspace(1e-3, FARTHEST, 200):
            contact.move(side * reach - contact.x, CREEP)
        before = read(contact, side)
        contact.move(contact.x, CREEP)
        after = read(contact, side)
        if not after <= GROWTH * before:
            return math.inf
        largest = max(largest, after)
    return largest
