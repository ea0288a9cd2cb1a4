r"""Friction as a sum of elasto-slip elements (Maxwell slip), and its force error along moves.

.. math:: F = \sum_i k_i z_i + \operatorname{sgn}(v) D + c v + F_0, \qquad
    -(1 - \rho) d_i \le z_i \le (1 + \rho) d_i

Each element deflects by :math:`z_i` with the motion, until it slips at its yield deflection. The ratio :math:`\rho`
makes friction asymmetric: elements of equal limits that start deflected by :math:`-\rho d_i` behind the constant force
:math:`\rho k_i d_i` are identical to it. Maxwell slip and stops in parallel are such a sum. For any other model with
pre-sliding, stiffness and damping are the non-negative least-squares fit along moves from rest to rest, over 1, 3, 10 and
30 pre-sliding distances and at full speed. A static model has dry friction D instead of elements. The moves of a model whose
force grows without bound end where its stiffness has doubled.
"""

import math
from typing import NamedTuple

import numpy as np

from bristle.core import InputError, Model, non_negative, number, with_unit
from bristle.core.dimensions import Kind, unit_of
from bristle.engine import force_along, interpreted
from bristle.engine.contact import steady_force
from bristle.exports.described import Request
from bristle.exports.moves import fastest_of, hardening_distance, moves_for, turning_distance
from bristle.identification.parameters import offset_of
from bristle.models.friction import base_of, is_static, unvaried
from bristle.models.friction.slots import by_direction

COUNT = 24  # of elements offered to the fit
EXACT = 1e-6  # an error [%] that rounding explains
# Yield deflection over the pre-sliding distance.
SMALLEST = 0.01
LARGEST = 10.0
DRY = ("coulomb", "viscous", "coulomb_viscous")
STOPS = ("kernel_weights", "kernel_thresholds", "kernel_spring")


class Elements(NamedTuple):
    """Elements in parallel: stiffness [N/m or N*m/rad] and yield deflection [m or rad], inf for a spring that never slips.

    The others are the ratio of asymmetry, the viscous coefficient, the dry friction, and the constant force.
    """

    stiffness: np.ndarray
    yields: np.ndarray
    ratio: float
    damping: float
    dry: float
    constant: float

    @property
    def whole_constant(self) -> float:
        """Constant force of a scene: with the force that makes elements of equal limits asymmetric."""
        slips = np.isfinite(self.yields)
        return float(
            self.constant + self.ratio * (self.dry + self.stiffness[slips] @ self.yields[slips])
        )


class Deviation(NamedTuple):
    """Error of the elements along moves: rms and largest force error in % of the level [N or N*m].

    The level is the sliding friction; of a model without sliding friction, the largest force along the moves. The `reach`
    [m or rad] is the farthest position of a model whose force grows without bound.
    """

    rms: float
    largest: float
    level: float
    reach: float = 0.0

    @property
    def is_exact(self) -> bool:
        """Whether rounding explains the error."""
        return self.largest < EXACT

    def text(self, kind: Kind) -> str:
        """Return the error as a sentence."""
        if self.is_exact:
            return "the scene has the force of the model: no error along moves inside and outside pre-sliding"
        rms, largest = (number(share, digits=3) for share in (self.rms, self.largest))
        if self.reach:
            reach = with_unit(self.reach, unit_of("length", kind))
            beyond = (
                "beyond, the force of the model grows without bound, and that of the scene does not"
            )
            return f"force error along moves within {reach}: {rms} % rms, at most {largest} % of the largest force; {beyond}"
        return f"force error along moves inside and outside pre-sliding: {rms} % rms, at most {largest} % of the sliding friction"


def elements_of(request: Request) -> tuple[Elements, Deviation]:
    """Return the elements of a friction model, frozen at nominal load and temperature, and their error along moves."""
    model = unvaried(request.model)
    fastest = fastest_of(request)
    reach = 0.0
    offset = offset_of(model.component.variables, model.values)
    try:
        sides = [steady_force(model, side * 1e-3 * fastest) - offset for side in (1.0, -1.0)]
        x, dt, _ = moves_for(request)
    except InputError:  # the force grows without bound in sliding
        reach = hardening_distance(model, fastest)
        sides = [0.0, 0.0]
        x, dt, _ = moves_for(request, reach)
    v = np.diff(x) / dt
    try:
        with interpreted():  # compiling would take longer
            force = force_along(model, v, dt, x[1:])
    except InputError as error:
        raise InputError(
            "has no finite force along moves", path="mjcf", value=model.name, mend="Use --to c"
        ) from error
    largest = float(np.max(np.abs(force - offset)))
    level = 0.5 * (sides[0] - sides[1]) or largest or 1.0
    ratio = float(np.clip(0.5 * sum(sides) / level, -0.999, 0.999))
    elements = elements_in(model, offset)
    if elements is None:
        distance = reach / LARGEST or turning_distance(model, request.axis, fastest)[0]
        if is_static(model):
            yields = np.empty(0)
        else:
            yields = distance * np.geomspace(SMALLEST, LARGEST, COUNT)
        elements = _fitted(x, dt, force - offset, yields, ratio)._replace(constant=offset)
    error = 100.0 / level * (force - elements_force(elements, x, dt))[v != 0.0]
    return elements, Deviation(
        float(np.sqrt(np.mean(error**2))), float(np.max(np.abs(error))), float(level), reach
    )


def elements_in(model: Model, offset: float) -> Elements | None:
    """Return the elements or the dry friction that a model consists of, with the mean damping; None if it is no such sum."""
    values = model.values
    base = base_of(model.component).name
    level, damping, viscous = (
        [float(values[key]) for key in by_direction(model.component, name) if key in values]
        for name in ("F_C", "sigma_2", "F_v")
    )
    damping = float(np.mean(damping or viscous or 0.0))
    mean = 0.0
    if level:
        mean = 0.5 * (level[0] + level[-1])
    ratio = 0.0
    if mean:
        ratio = 0.5 * (level[0] - level[-1]) / mean
    if base in DRY:
        return Elements(np.empty(0), np.empty(0), ratio, damping, mean, offset)
    if base == "maxwell_slip":
        return Elements(
            values["k_i"], mean * values["nu_i"] / values["k_i"], ratio, damping, 0.0, offset
        )
    if (
        base.startswith("preisach_contact")
        and STOPS[0] in values
        and np.min(values[STOPS[0]]) >= 0.0
    ):
        weights, thresholds, spring = (np.atleast_1d(values[name]) for name in STOPS)
        return Elements(
            np.append(weights, spring), np.append(thresholds, math.inf), 0.0, damping, 0.0, offset
        )
    return None


def elements_force(elements: Elements, x: np.ndarray, dt: float) -> np.ndarray:
    """Return the mean force [N or N*m] of elements over each step along positions [m or rad]."""
    dry = elements.dry * (np.sign(np.diff(x)) + elements.ratio * (np.diff(x) != 0.0))
    return (
        _columns(x, elements.yields, elements.ratio) @ elements.stiffness
        + dry
        + elements.damping * np.diff(x) / dt
        + elements.constant
    )


def _fitted(
    x: np.ndarray, dt: float, force: np.ndarray, yields: np.ndarray, ratio: float
) -> Elements:
    """Return the elements, or without yields the dry friction, and the damping that fit a force along positions best."""
    dx = np.diff(x)
    if yields.size:
        dry = np.zeros((dx.size, 1))
    else:
        dry = (np.sign(dx) + ratio * (dx != 0.0))[:, None]
    # Columns of similar size: the force of each element over its force at yield, and damping at full speed.
    A = np.hstack([_columns(x, yields, ratio) / yields, dry, dx[:, None] / np.max(dx)])
    shares = non_negative(A[dx != 0.0], force[dx != 0.0])
    return Elements(
        shares[:-2] / yields, yields, ratio, shares[-1] * dt / np.max(dx), shares[-2], 0.0
    )


def _columns(x: np.ndarray, yields: np.ndarray, ratio: float) -> np.ndarray:
    """Return the mean deflection [m or rad] of each element over each step."""
    low = -(1.0 - ratio) * yields
    high = (1.0 + ratio) * yields
    z = np.zeros(yields.size)
    columns = np.empty((x.size - 1, yields.size))
    for k, dx in enumerate(np.diff(x).tolist()):
        after = np.clip(z + dx, low, high)
        # An element slips over the last part of the step, and the mean lacks its rise there.
        columns[k] = after
        if dx:
            columns[k] = after - 0.5 * (after - z) ** 2 / dx
        z = after
    return columns
