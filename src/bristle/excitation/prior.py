"""What is believed of an axis before it is measured: enough to design a motion and to rehearse it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import Model, make_model
from bristle.core.typography import with_unit
from bristle.core.variable import unit_of
from bristle.engine import force_along, settled
from bristle.friction import find, is_static, with_presliding
from bristle.plants import inertia

__all__ = ["Prior", "effort_limit", "prior_of", "turning_distance"]

FRICTION_SHARE = 0.1  # of the largest effort, where no model says what friction takes
STATIC_OVER_COULOMB = 1.25
STRIBECK_SHARE = 0.01  # of the largest speed
DAMPING_RATIO = 0.2  # of the contact, by its micro-damping
TURNED = 0.98  # share of the change of force by which a reversal counts as over
# A bristle turns by that share over ln(2 / (2 (1 - TURNED))) of its length; half of it is the amplitude of a loop.
LENGTHS = 0.5 * math.log(1.0 / (1.0 - TURNED))


@dataclass(frozen=True)
class Prior:
    """A plant with friction that is taken for the axis until it is measured.

    Parameters
    ----------
    plant, friction : Model
        The mechanism.
    presliding : float or None
        Amplitude at which friction saturates at either end of a loop [m or rad]; None where nothing says so.
    resonance : float or None
        Frequency at which the mass moves on the contact [Hz]; None where mass or stiffness is a guess.
    stribeck_velocity : float or None
        Velocity over which friction falls [m/s or rad/s]; None where nothing says so.
    assumed : tuple of str
        What nobody said.
    mass_known : bool
        Whether the mass is no guess: the loop of a controller is tuned to it.
    """

    plant: Model
    friction: Model
    presliding: float | None
    resonance: float | None
    stribeck_velocity: float | None
    assumed: tuple[str, ...]
    mass_known: bool = True


def prior_of(axis: Axis, plant: Model | None = None, friction: Model | None = None) -> Prior:
    """Return what is believed of an axis: a model of it, or one made of its limits and its pre-sliding distance."""
    kind, most, distance = axis.kind, effort_limit(axis), axis.presliding
    force = 1.0 if friction is not None or most is None else FRICTION_SHARE * most
    mass, assumed = _mass(axis, plant, force)
    mass_known = plant is not None or axis.mass is not None
    if friction is None:
        static, length = STATIC_OVER_COULOMB * force, (distance or 20.0 * (axis.resolution or 1e-6)) / LENGTHS
        fastest, stiffness = axis.velocity_limit or 1e4 * length, static / length
        values = {
            "F_C": force,
            "F_S": static,
            "v_S": STRIBECK_SHARE * fastest,
            "sigma_0": stiffness,
            "sigma_1": 2.0 * DAMPING_RATIO * math.sqrt(stiffness * mass),
            "sigma_2": 0.5 * force / fastest,  # half of the Coulomb friction at the largest speed
        }
        simulated = make_model(find("lugre"), values, kind=kind, validate=True)
        assumed += (f"Coulomb friction of {with_unit(force, unit_of('force', kind))}", "lugre with the usual proportions")
        stiffness, stribeck_velocity = stiffness if most is not None and distance else 0.0, None
    else:
        simulated, stribeck_velocity = friction, friction.values.get("v_S")
        if is_static(friction) and distance:
            simulated = with_presliding(friction, distance / LENGTHS)
        else:
            distance = turning_distance(friction)
        stiffness = _stiffness(simulated, distance) if distance else 0.0
    return Prior(
        plant or make_model(inertia, {"M": mass}, kind=kind, validate=True),
        simulated,
        distance,
        math.sqrt(stiffness / mass) / (2.0 * math.pi) if stiffness and mass_known else None,
        stribeck_velocity,
        assumed,
        mass_known,
    )


def effort_limit(axis: Axis) -> float | None:
    """Return the largest effort of an axis, or else of its controller [N or N*m]; None where neither says it."""
    if axis.effort_limit is not None:
        return axis.effort_limit
    limit = axis.controller.values.get("limit", math.inf) if axis.controller is not None else math.inf
    return limit if math.isfinite(limit) else None


def _mass(axis: Axis, plant: Model | None, force: float) -> tuple[float, tuple[str, ...]]:
    """Return the moving mass [kg or kg*m^2], and what is assumed of it."""
    if plant is not None:
        return plant.values["M"], ()
    if axis.mass is not None:
        return axis.mass, ()
    most = effort_limit(axis)
    mass = (0.5 * most if most is not None else force) / (axis.acceleration_limit or 1.0)
    word = "mass" if axis.kind == "translational" else "inertia"
    return mass, (f"{word} of {with_unit(mass, unit_of('mass', axis.kind))}",)


def turning_distance(friction: Model) -> float | None:
    """Return half the distance over which the force of a model turns after a slow reversal [m or rad].

    None for a static map, which turns at once.
    """
    if is_static(friction):
        return None
    path, dt = np.geomspace(1e-10, 1e-1, 1801), 1e9
    velocity = -np.diff(path, prepend=0.0) / dt
    state, memory = settled(friction, float(path[-1]) / dt)
    force = force_along(friction, velocity, dt, state=state, memory=memory)
    turned = np.abs(force - force[0]) >= TURNED * abs(force[-1] - force[0])
    return 0.5 * float(path[np.argmax(turned)])


def _stiffness(friction: Model, distance: float) -> float:
    """Return the stiffness of the contact before it was ever pulled at [N/m or N*m/rad]."""
    step, dt = 1e-3 * distance, 1e9
    force = force_along(friction, np.full(2, step / dt), dt)
    return float(force[1] - force[0]) / step
