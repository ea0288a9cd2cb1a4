"""Limits of a motion of an axis, and a prior of the axis before its measurement."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from bristle.core import Axis, InputError, with_unit
from bristle.core.contracts import Model, make_model
from bristle.core.variable import Kind, unit_of
from bristle.engine import force_along, settled
from bristle.models.friction import find, is_static, with_presliding
from bristle.models.plants import inertia

TURNED = 0.98  # share of the change of force at which a reversal counts as complete
# A bristle reverses by that share over ln(2 / (2 (1 - TURNED))) of its length; the amplitude of a loop is half of it.
LENGTHS = 0.5 * math.log(1.0 / (1.0 - TURNED))
LEAST = 1e-9  # m, rad, and their derivatives: smaller motions do not exist
MARGIN = 0.9  # usable share of a limit: the loop overshoots


@dataclass(frozen=True)
class MotionLimits:
    """Usable limits of a motion, in SI units of the axis; None if unknown.

    Parameters
    ----------
    kind : {"translational", "rotational"}
        Kind of axis.
    sample_time : float
        Time between samples [s].
    travel : float or None
        Range of the motion, half of it on each side of its start [m or rad].
    velocity : float or None
        Largest velocity [m/s or rad/s].
    acceleration : float or None
        Largest acceleration [m/s^2 or rad/s^2].
    jerk : float
        Largest jerk [m/s^3 or rad/s^3]; infinite without a limit.
    count : float
        Step of the encoder [m or rad]; 0 if unknown.
    presliding : float or None
        Amplitude at which friction saturates at both ends of a loop [m or rad].
    resonance : float or None
        Resonance frequency of the mass on the contact [Hz].
    stribeck_velocity : float or None
        Velocity over which friction falls from break-away to Coulomb friction [m/s or rad/s].
    followed : float
        Tracking error of the controller in slow motion before sliding [m or rad]; 0 if unknown.
    integral : bool
        Whether the controller has integral action.
    """

    kind: Kind
    sample_time: float
    travel: float | None = None
    velocity: float | None = None
    acceleration: float | None = None
    jerk: float = math.inf
    count: float = 0.0
    presliding: float | None = None
    resonance: float | None = None
    stribeck_velocity: float | None = None
    followed: float = 0.0
    integral: bool = False

    @property
    def reach(self) -> float:
        """Pre-sliding amplitude [m or rad]; 0 if unknown."""
        return self.presliding or 0.0

    @property
    def extent(self) -> float:
        """Range of the motion [m or rad]; 0 if unknown."""
        return self.travel or 0.0

    @property
    def fastest(self) -> float:
        """Largest velocity [m/s or rad/s], infinite if unknown."""
        return self.velocity or math.inf

    @property
    def largest_acceleration(self) -> float:
        """Largest acceleration [m/s^2 or rad/s^2], infinite if unknown."""
        return self.acceleration or math.inf

    def corner(self, speed: float, leg: float) -> float:
        """Return the acceleration at the ends of a leg of this length [m or rad], if the ends take a tenth of the leg."""
        return min(2.0 * speed * speed / (0.1 * leg), self.largest_acceleration)

    def in_unit(self, value: float, quantity: str) -> str:
        """Return a value with its unit on this axis."""
        return with_unit(value, unit_of(quantity, self.kind))


def limits_of(
    axis: Axis, prior: Prior, sample_time: float, travel: float | None, start: float | None = None
) -> MotionLimits:
    """Return the limits of a motion."""
    stroke = None
    if axis.stroke:
        stroke = axis.stroke[1] - axis.stroke[0]
    for path, value in (
        ("travel", travel),
        ("limits.velocity", axis.velocity_limit),
        ("limits.acceleration", axis.acceleration_limit),
        ("limits.jerk", axis.jerk_limit),
        ("limits.stroke", stroke),
    ):
        if value is not None and value < LEAST:
            raise InputError(
                "is too small for a motion",
                path=path,
                value=value,
                allowed=f">= {LEAST:g} in SI",
                mend="Check the unit",
            )

    if axis.stroke and math.ulp(max(map(abs, axis.stroke))) > LEAST:
        raise InputError(
            "is so far from zero that positions have too few digits",
            path="limits.stroke",
            value=axis.stroke,
            mend="Measure positions from a point near the stroke",
        )
    if axis.stroke and start is not None:
        stroke = 2.0 * min(start - axis.stroke[0], axis.stroke[1] - start)
        if stroke < LEAST:
            raise InputError(
                "leaves no travel on one side of the start",
                path="start",
                value=start,
                allowed=f"between {axis.stroke[0]:g} and {axis.stroke[1]:g}, in SI",
            )
    if travel is not None and stroke is not None and travel > stroke:
        raise InputError(
            "is more than the stroke of the axis",
            path="travel",
            value=travel,
            allowed=f"up to {with_unit(stroke, unit_of('length', axis.kind))}",
        )
    if travel is None:
        travel = _usable(stroke)
    acceleration = axis.acceleration_limit
    most = effort_limit(axis)
    if acceleration is None and most is not None and prior.mass_known:
        acceleration = 0.5 * most / prior.plant.values["M"]
    return MotionLimits(
        kind=axis.kind,
        sample_time=sample_time,
        travel=travel,
        velocity=_usable(axis.velocity_limit),
        acceleration=_usable(acceleration),
        jerk=axis.jerk_limit or math.inf,
        count=axis.resolution or 0.0,
        presliding=prior.presliding,
        resonance=prior.resonance,
        stribeck_velocity=prior.stribeck_velocity,
        integral=axis.controller is not None and axis.controller.values.get("k_i", 0.0) > 0.0,
    )


def _usable(limit: float | None) -> float | None:
    if limit is None:
        return None
    return MARGIN * limit


@dataclass(frozen=True)
class Prior:
    """Assumed plant with friction, until the axis is measured.

    Parameters
    ----------
    plant, friction : Model
        The assumed plant and its friction.
    presliding : float or None
        Amplitude at which friction saturates at both ends of a loop [m or rad]; None if unknown.
    resonance : float or None
        Resonance frequency of the mass on the contact [Hz]; None if mass or stiffness is a guess.
    stribeck_velocity : float or None
        Velocity over which friction falls from break-away to Coulomb friction [m/s or rad/s]; None if unknown.
    assumed : tuple of str
        Assumed values.
    mass_known : bool
        Whether the mass is known: the controller is tuned to it.
    """

    plant: Model
    friction: Model
    presliding: float | None
    resonance: float | None
    stribeck_velocity: float | None
    assumed: tuple[str, ...]
    mass_known: bool = True


def prior_of(axis: Axis, plant: Model | None = None, friction: Model | None = None) -> Prior:
    """Return the prior of an axis: a given model, or a model from its limits and its pre-sliding distance."""
    kind = axis.kind
    most = effort_limit(axis)
    distance = axis.presliding
    force = 1.0
    if friction is None and most is not None:
        force = 0.1 * most
    mass = axis.mass
    if plant is not None:
        mass = plant.values["M"]
    assumed = ()
    mass_known = mass is not None
    if mass is None:
        accelerating = force
        if most is not None:
            accelerating = 0.5 * most
        mass = accelerating / (axis.acceleration_limit or 1.0)
        noun = "inertia"
        if kind == "translational":
            noun = "mass"
        assumed = (f"{noun} of {with_unit(mass, unit_of('mass', kind))}",)
    if friction is None:
        static = 1.25 * force
        length = (distance or 20.0 * (axis.resolution or 1e-6)) / LENGTHS
        fastest = axis.velocity_limit or 1e4 * length
        stiffness = static / length
        values = {
            "F_C": force,
            "F_S": static,
            "v_S": 0.01 * fastest,
            "sigma_0": stiffness,
            "sigma_1": 0.4 * math.sqrt(stiffness * mass),  # a damping ratio of 0.2
            "sigma_2": 0.5 * force / fastest,  # half of the Coulomb friction at the largest speed
        }
        simulated = make_model(find("lugre"), values, kind=kind, validate=True)
        assumed += (
            f"Coulomb friction of {with_unit(force, unit_of('force', kind))}",
            "lugre with the usual proportions",
        )
        if most is None or not distance:  # a guess
            stiffness = 0.0
        stribeck_velocity = None
    else:
        simulated = friction
        stribeck_velocity = friction.values.get("v_S")
        if is_static(friction) and distance:
            simulated = with_presliding(friction, distance / LENGTHS)
        else:
            distance = turning_distance(friction)
        stiffness = 0.0
        if distance:  # stiffness of the contact from the virgin state
            step = 1e-3 * distance
            dt = 1e9
            first, second = force_along(simulated, np.full(2, step / dt), dt)
            stiffness = float(second - first) / step
    resonance = None
    if stiffness and mass_known:
        resonance = math.sqrt(stiffness / mass) / (2.0 * math.pi)
    return Prior(
        plant or make_model(inertia, {"M": mass}, kind=kind, validate=True),
        simulated,
        distance,
        resonance,
        stribeck_velocity,
        assumed,
        mass_known,
    )


def effort_limit(axis: Axis) -> float | None:
    """Return the largest effort of an axis, or of its controller [N or N*m]; None if both are unknown."""
    if axis.effort_limit is not None:
        return axis.effort_limit
    if axis.controller is None:
        return None
    limit = axis.controller.values.get("limit", math.inf)
    if math.isfinite(limit):
        return limit
    return None


def turning_distance(friction: Model) -> float | None:
    """Return half the distance [m or rad] over which the force reverses after a slow reversal; None for a static map."""
    if is_static(friction):
        return None
    path = np.geomspace(1e-10, 1e-1, 1801)
    dt = 1e9
    velocity = -np.diff(path, prepend=0.0) / dt
    state, memory = settled(friction, float(path[-1]) / dt)
    force = force_along(friction, velocity, dt, state=state, memory=memory)
    return 0.5 * float(
        path[np.argmax(np.abs(force - force[0]) >= TURNED * abs(force[-1] - force[0]))]
    )
