r"""Passivity: whether friction can return more energy than its bristles have stored.

With the energy of the bristles as storage, the power lost at velocity :math:`v` and bristle force :math:`f`,
:math:`q = f \operatorname{sgn} v`, is at least

.. math:: W = |v|\,q\,\Phi + \sigma_1(v)\,v^2 (1 - \Phi) + \sigma_2 v^2

where :math:`\dot z = v (1 - \Phi)`. It is negative if bristles charged to :math:`F_S` are released at speed.
:math:`W \ge 0` everywhere needs

.. math:: \sigma_2 \ge \sup_{v > 0,\ |q| \le F_S} \left[\sigma_1(v)\,(\Phi - 1) - \frac{q\,\Phi}{|v|}\right]

With constant :math:`\sigma_1` this is :math:`\sigma_1 (F_S - F_C)/F_C` for :math:`\Phi = q/G` [1]_ and for a gate that
ends there, and :math:`\sigma_1 [(F_S/F_C)^n - 1]` for :math:`\Phi = (q/G)^n`. With :math:`\sigma_1(v) = \sigma_1
e^{-(v/v_d)^2}` it is 0 if :math:`\sigma_1 v_d \le 4\sqrt{2e}\,F_C`.

No viscous coefficient suffices if energy is returned at arbitrarily slow motion. `bouc_wen` with
:math:`\beta < \tfrac12` returns energy in its loops. `reformed_dahl` is stiff after every reversal: charged by many short
strokes and released in a long stroke, it returns more energy than it took, because it is softer on the long stroke. An
element of `gms` that slips approaches :math:`\nu_i F_S` by time alone. If it slips in a short fast stroke at
:math:`\nu_i F_C` and its force rises while it hardly moves, it gains :math:`\nu_i^2 (F_S^2 - F_C^2)/(2 k_i)`, which it
returns at the reversal. Both are counter-examples, so the verdict is final.

References
----------
.. [1] N. Barabanov, R. Ortega, "Necessary and sufficient conditions for passivity of the LuGre friction model", IEEE
   Transactions on Automatic Control 45(4), 2000. doi:10.1109/9.847131
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from bristle.core import Model, unit_of, with_unit
from bristle.models.friction.lugre import Parameters as OfLuGre, micro_damping, stribeck_force
from bristle.models.friction.slip_law import slip
from bristle.models.friction.slots import Slotted
from bristle.models.friction.variation import Varied
from bristle.simulation.certificates.certificate import (
    Certificate,
    OperatorParameters,
    not_applicable,
)

DECADES = (-6.0, 12.0)  # of the speed, over the Stribeck velocity


class Damping(NamedTuple):
    """Viscous coefficient of a model, and the least value for passivity [N*s/m or N*m*s/rad]."""

    present: float
    needed: float = 0.0
    because: str = "The hysteresis of the model returns energy at every speed"


def passive(model: Model, is_magnet: bool) -> Certificate:
    """Return the viscous coefficient [N*s/m or N*m*s/rad], with the least value for passivity as its limit."""
    unit = unit_of("force*time/length", model.kind)
    if is_magnet:
        return not_applicable(
            unit, "Its loops run in the opposite sense, like those of a magnet: it is not friction"
        )
    sides = [damping_of(p) for p in _in_each_direction(model)]
    dampings = [side for side in sides if side is not None]
    if len(dampings) < len(sides):
        return not_applicable(
            unit, "No condition is known for this model: see dissipation for a numerical search"
        )
    worst = min(dampings, key=lambda damping: damping.present - damping.needed)
    passed = worst.present >= worst.needed * (1.0 - 1e-9)
    if not math.isfinite(worst.needed):
        advice = f"{worst.because}: no viscous coefficient can compensate this"
    elif not passed:
        advice = (
            "Bristles charged at rest and released at speed return energy: "
            f"raise sigma_2 to at least {with_unit(worst.needed, unit, 4)}"
        )
    elif worst.needed > 0.0:
        advice = f"sigma_2 exceeds the least value for passivity by {with_unit(worst.present - worst.needed, unit)}"
    else:
        advice = "Passive for any viscous coefficient"
    return Certificate(True, worst.present, unit, worst.needed, passed, advice)


def _in_each_direction(model: Model) -> list:
    """Return the parameters of a model forward and backward, or its only ones, without a variation along the axis."""
    p = model.parameters
    if isinstance(p, OperatorParameters):
        p = p.operator
    sides = [p]
    if isinstance(p, Slotted):
        sides = [p.forward, p.backward]
    # A variation along the axis is a factor on the whole force, or a force whose work the return path gives back.
    return [side.inner if isinstance(side, Varied) else side for side in sides]


def needed_damping(
    F_S: float,
    v_S: float,
    G: Callable[[float], float],
    sigma_1: Callable[[float], float],
    slip: Callable[[float, float], float],
) -> float:
    r"""Return the least viscous coefficient [N*s/m or N*m*s/rad] at which no power is returned.

    The supremum is searched on a grid, and from each of its peaks on refined grids.

    Parameters
    ----------
    F_S : float
        Largest force of the bristles [N or N*m].
    v_S : float
        Stribeck velocity, the scale of the speeds [m/s or rad/s].
    G, sigma_1 : callable
        Stribeck force [N or N*m] and micro-damping [N*s/m or N*m*s/rad] at a speed.
    slip : callable
        :math:`\Phi` as a function of the bristle force along the motion and of G [N or N*m].
    """

    def needed(decade: float, q: float) -> float:
        v = v_S * 10.0**decade
        share = slip(q, G(v))
        return sigma_1(v) * (share - 1.0) - q * share / v  # the bracket above

    if sigma_1(0.0) == 0.0:
        return 0.0
    decades = np.linspace(*DECADES, 91)
    forces = np.linspace(-F_S, F_S, 41)
    values = np.array([[needed(decade, q) for q in forces] for decade in decades])
    crests = np.pad(np.max(values, axis=1), 1, constant_values=-math.inf)
    peaks = np.flatnonzero((crests[1:-1] >= crests[:-2]) & (crests[1:-1] >= crests[2:]))
    starts = [(float(decades[i]), float(forces[np.argmax(values[i])])) for i in peaks]
    steps = (float(decades[1] - decades[0]), float(forces[1] - forces[0]))
    return max(0.0, *(_summit(needed, start, steps, F_S) for start in starts))


def _summit(
    height: Callable[[float, float], float],
    start: tuple[float, float],
    steps: tuple[float, float],
    F_S: float,
) -> float:
    """Return the largest value around a point, by refined grids."""
    x, q = start
    dx, dq = steps
    for _ in range(20):
        nodes = [
            (
                min(max(x + i * dx / 4.0, DECADES[0]), DECADES[1]),
                min(max(q + j * dq / 4.0, -F_S), F_S),
            )
            for i in range(-4, 5)
            for j in range(-4, 5)
        ]
        x, q = max(nodes, key=lambda node: height(*node))
        dx = 0.4 * dx
        dq = 0.4 * dq
    return height(x, q)


def damping_of(p: Any) -> Damping | None:
    """Return the `Damping` of a model with parameters `p`; None if no condition is known."""
    condition = CONDITIONS.get(type(p).__module__)
    return None if condition is None else condition(p)


def _of_bristles(p: Any, phi: Callable[[float, float], float]) -> Damping:
    needed = needed_damping(
        p.F_S, p.v_S, lambda v: stribeck_force(v, p), lambda v: micro_damping(v, p), phi
    )
    return Damping(p.sigma_2, needed)


def _of_composite(p: Any) -> Damping | None:
    from bristle.models.friction.preisach_lugre import OverStops, OverTurningPoints, slip_law

    if isinstance(p, OverTurningPoints):
        return None
    if isinstance(p, OverStops):
        if damping_of(p.operator) is None:
            return None
        p = p.own
    law = slip_law(p)
    return _of_bristles(p, lambda q, G: slip(q / G, law))


def _of_elastoplastic(p: Any) -> Damping | None:
    # The threshold of slip does not matter: below sliding bristles return no energy, and beyond it they slip as LuGre's.
    constant = p._asdict() | {"v_d": math.inf}
    return damping_of(OfLuGre(**{name: constant[name] for name in OfLuGre._fields}))


FRICTION = "bristle.models.friction"
HYSTERESIS = "bristle.models.hysteresis"
CHARGED = "Short strokes charge the bristles, and a long stroke then returns more energy"
REGAINED = "An element that slips regains its static force without moving, unless F_S = F_C"
CONDITIONS: dict[str, Callable[[Any], Damping | None]] = {
    f"{FRICTION}.coulomb": lambda p: Damping(0.0),
    f"{FRICTION}.viscous": lambda p: Damping(p.F_v),
    f"{FRICTION}.coulomb_viscous": lambda p: Damping(p.F_v),
    f"{FRICTION}.stribeck": lambda p: Damping(p.F_v),
    f"{FRICTION}.dahl": lambda p: Damping(p.sigma_2),
    f"{FRICTION}.maxwell_slip": lambda p: Damping(p.sigma_2),
    f"{HYSTERESIS}.preisach": lambda p: Damping(0.0),
    f"{HYSTERESIS}.stop": lambda p: Damping(0.0),
    f"{HYSTERESIS}.prandtl_ishlinskii": lambda p: (
        Damping(0.0) if min(*p.weights, p.spring) >= 0.0 else None
    ),
    f"{FRICTION}.bouc_wen": lambda p: Damping(p.sigma_2, 0.0 if p.beta >= 0.5 else math.inf),
    f"{FRICTION}.reformed_dahl": lambda p: Damping(p.sigma_2, math.inf, CHARGED),
    f"{FRICTION}.gms": lambda p: Damping(p.sigma_2, math.inf if p.F_S > p.F_C else 0.0, REGAINED),
    f"{FRICTION}.lugre": lambda p: _of_bristles(p, lambda q, G: q / G),
    f"{FRICTION}.elastoplastic": _of_elastoplastic,
    f"{FRICTION}.preisach_lugre": _of_composite,
}
"""Known conditions, by the module of the class of the parameters."""
