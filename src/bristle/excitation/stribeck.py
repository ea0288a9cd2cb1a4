"""Friction over velocity: to and fro at constant velocities, from creeping to the largest one, equally far apart."""

from __future__ import annotations

import math

import numpy as np

from bristle.excitation.limits import MotionLimits
from bristle.excitation.motion import ExcitationPiece, in_time
from bristle.references import triangle

__all__ = ["missing", "pieces"]

SPEEDS = 10
BEYOND_PRESLIDING = 5.0  # times the pre-sliding amplitude: the shortest slide
COUNTS = 200.0  # of the encoder: the shortest slide
TRAVEL_SHARE = 0.01  # the shortest slide where neither is known
SLOWEST_SHARE = 0.3  # of the time, for the slowest velocity
BELOW_STRIBECK = 0.2  # of the Stribeck velocity, where it is known
SPREAD = 3.0  # the largest velocity over the smallest, at least
CYCLES_MOST = 6
REST = 0.2  # [s]


def missing(limits: MotionLimits) -> str:
    """Return why there is no such motion on this axis, and what to do; nothing where there is one."""
    for value, quantity, remedy in (
        (limits.velocity, "velocity", "velocity under [limits]"),
        (limits.acceleration, "acceleration", "acceleration under [limits], or limit under [effort] and the moving mass"),
        (limits.travel, "travel", "stroke under [limits], or give a travel"),
    ):
        if value is None:
            return f"how much {quantity} the axis allows is not known: write {remedy}"
    if _slowest(limits, math.inf) * SPREAD > _fastest(limits):
        return f"a travel of {limits.in_unit(limits.travel or 0.0, 'length')} is too short for several velocities"
    return ""


def pieces(limits: MotionLimits, seconds: float) -> list[ExcitationPiece]:
    """Return the motion, to last about so long [s]."""
    assert limits.acceleration is not None
    assert limits.travel is not None
    acceleration, most = limits.acceleration, 0.5 * limits.travel
    fastest, least = _fastest(limits), _shortest(limits)

    def make(rate: float) -> list[ExcitationPiece]:
        slowest = min(_slowest(limits, seconds, rate), fastest / SPREAD)
        sweeps = []
        for speed in np.geomspace(slowest, fastest, SPEEDS):
            braking = speed * speed / acceleration + speed * acceleration / limits.jerk
            ideal = speed / (4.0 * rate)
            amplitude = min(max(ideal, least, 2.0 * braking), most)
            cycles = min(max(round(ideal / amplitude), 1), CYCLES_MOST)
            sweeps.append(_sweep(limits, float(speed), float(amplitude), cycles))
        return sweeps

    pace = SPEEDS / seconds
    return in_time(make, seconds, pace, 1e-2 * pace, 1e3 * pace)


def _sweep(limits: MotionLimits, speed: float, amplitude: float, cycles: int) -> ExcitationPiece:
    reference = triangle(
        kind=limits.kind,
        amplitude=amplitude,
        velocity=speed,
        cycle_count=cycles,
        acceleration=limits.corner(speed, amplitude),
        jerk=limits.jerk,
    )
    return ExcitationPiece("stribeck", "constant velocity", reference, REST, speed, amplitude)


def _shortest(limits: MotionLimits) -> float:
    """Return the amplitude of the shortest slide [m or rad]."""
    smallest = max(BEYOND_PRESLIDING * (limits.presliding or 0.0), COUNTS * limits.count)
    return min(smallest or TRAVEL_SHARE * (limits.travel or 0.0), 0.5 * (limits.travel or 0.0))


def _slowest(limits: MotionLimits, seconds: float, rate: float = 0.0) -> float:
    """Return the smallest velocity of a slide that is long enough [m/s or rad/s]."""
    least = 4.0 * _shortest(limits)
    if limits.stribeck_velocity is not None:
        return max(BELOW_STRIBECK * limits.stribeck_velocity, least / (SLOWEST_SHARE * seconds))
    return least * rate


def _fastest(limits: MotionLimits) -> float:
    """Return the largest velocity at which half of a quarter of the loop is left for a steady slide [m/s or rad/s]."""
    assert limits.velocity is not None
    assert limits.acceleration is not None
    a, room_left = limits.acceleration, 0.25 * (limits.travel or 0.0)
    rise = a / limits.jerk
    return min(limits.velocity, 2.0 * room_left / (math.sqrt(rise * rise + 4.0 * room_left / a) + rise))
