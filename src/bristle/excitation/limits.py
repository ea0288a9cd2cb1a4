"""`MotionLimits`: what the limits of an axis and its encoder leave to a motion."""

from __future__ import annotations

import math
from dataclasses import dataclass

from bristle.core.axis import Axis
from bristle.core.errors import InputError
from bristle.core.typography import with_unit
from bristle.core.variable import Kind, unit_of
from bristle.excitation.prior import Prior, effort_limit

__all__ = ["MotionLimits", "limits_of"]

LEAST = 1e-9  # m, rad, and their derivatives: no axis moves by less
MARGIN = 0.9  # of a limit that is used: the loop overshoots
CORNER = 0.1  # of a slow leg, that its corners take: a jump of the velocity would shake the axis


@dataclass(frozen=True)
class MotionLimits:
    """What a motion may use, in SI of the kind of axis; None where nothing says it.

    Parameters
    ----------
    kind : {"translational", "rotational"}
        Kind of axis.
    sample_time : float
        Time between samples [s].
    travel : float or None
        Distance within which the motion stays, half of it to either side of its start [m or rad].
    velocity, acceleration : float or None
        Largest ones [m/s or rad/s, m/s^2 or rad/s^2].
    jerk : float
        Largest one [m/s^3 or rad/s^3]; infinite where there is no limit.
    count : float
        Step of the encoder [m or rad]; 0 where not known.
    presliding : float or None
        Amplitude at which friction saturates at either end of a loop [m or rad].
    resonance : float or None
        Frequency at which the mass moves on the contact [Hz].
    stribeck_velocity : float or None
        Velocity over which friction falls [m/s or rad/s].
    followed : float
        How closely the controller follows slow motion before sliding [m or rad]; 0 where not known.
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

    def corner(self, speed: float, leg: float) -> float:
        """Return the acceleration at the ends of a leg of this length [m or rad], as gentle as it leaves time for."""
        return min(2.0 * speed * speed / (CORNER * leg), self.acceleration or math.inf)

    def in_unit(self, value: float, quantity: str) -> str:
        """Return a value with its unit on this axis."""
        return with_unit(value, unit_of(quantity, self.kind))


def limits_of(axis: Axis, prior: Prior, sample_time: float, travel: float | None, start: float | None = None) -> MotionLimits:
    """Return what a motion may use."""
    for path, value in (
        ("travel", travel),
        ("limits.velocity", axis.velocity_limit),
        ("limits.acceleration", axis.acceleration_limit),
        ("limits.jerk", axis.jerk_limit),
        ("limits.stroke", axis.stroke and axis.stroke[1] - axis.stroke[0]),
    ):
        if value is not None and value < LEAST:
            raise InputError("is too small for a motion", path=path, value=value, allowed=f">= {LEAST:g} in SI", mend="Is the unit right?")
    stroke = axis.stroke[1] - axis.stroke[0] if axis.stroke else None
    if axis.stroke and math.ulp(max(map(abs, axis.stroke))) > LEAST:
        raise InputError(
            "is so far from zero that positions in it have too few digits",
            path="limits.stroke",
            value=axis.stroke,
            mend="Count positions from where the axis is",
        )
    if axis.stroke and start is not None:
        stroke = 2.0 * min(start - axis.stroke[0], axis.stroke[1] - start)
        if stroke < LEAST:
            raise InputError(
                "leaves no room to either side",
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
    acceleration, most = axis.acceleration_limit, effort_limit(axis)
    if acceleration is None and most is not None and prior.mass_known:
        acceleration = 0.5 * most / prior.plant.values["M"]
    return MotionLimits(
        kind=axis.kind,
        sample_time=sample_time,
        travel=travel if travel is not None else stroke and MARGIN * stroke,
        velocity=axis.velocity_limit and MARGIN * axis.velocity_limit,
        acceleration=acceleration and MARGIN * acceleration,
        jerk=axis.jerk_limit or math.inf,
        count=axis.resolution or 0.0,
        presliding=prior.presliding,
        resonance=prior.resonance,
        stribeck_velocity=prior.stribeck_velocity,
    )
