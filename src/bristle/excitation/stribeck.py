"""Friction over velocity: to and fro at constant velocities, from creeping to the largest one, equally far apart."""

from __future__ import annotations

import math

import numpy as np

from bristle.excitation.motion import Piece, in_time
from bristle.excitation.room import Room
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


def missing(room: Room) -> str:
    """Return why there is no such motion on this axis, and what to do; nothing where there is one."""
    for value, what, where in (
        (room.velocity, "velocity", "velocity under [limits]"),
        (room.acceleration, "acceleration", "acceleration under [limits], or limit under [effort] and the moving mass"),
        (room.travel, "travel", "stroke under [limits], or give a travel"),
    ):
        if value is None:
            return f"how much {what} the axis allows is not known: write {where}"
    if _slowest(room, math.inf) * SPREAD > _fastest(room):
        return f"a travel of {room.told(room.travel or 0.0, 'length')} is too short for several velocities"
    return ""


def pieces(room: Room, seconds: float) -> list[Piece]:
    """Return the motion, to last about so long [s]."""
    assert room.acceleration is not None
    assert room.travel is not None
    acceleration, most = room.acceleration, 0.5 * room.travel
    fastest, least = _fastest(room), _shortest(room)

    def make(rate: float) -> list[Piece]:
        slowest = min(_slowest(room, seconds, rate), fastest / SPREAD)
        found = []
        for speed in np.geomspace(slowest, fastest, SPEEDS):
            braking = speed * speed / acceleration + speed * acceleration / room.jerk
            wanted = speed / (4.0 * rate)
            amplitude = min(max(wanted, least, 2.0 * braking), most)
            cycles = min(max(round(wanted / amplitude), 1), CYCLES_MOST)
            found.append(_sweep(room, float(speed), float(amplitude), cycles))
        return found

    pace = SPEEDS / seconds
    return in_time(make, seconds, pace, 1e-2 * pace, 1e3 * pace)


def _sweep(room: Room, speed: float, amplitude: float, cycles: int) -> Piece:
    reference = triangle(
        kind=room.kind,
        amplitude=amplitude,
        velocity=speed,
        cycle_count=cycles,
        acceleration=room.corner(speed, amplitude),
        jerk=room.jerk,
    )
    return Piece("stribeck", "constant velocity", reference, REST, speed, amplitude)


def _shortest(room: Room) -> float:
    """Return the amplitude of the shortest slide [m or rad]."""
    known = max(BEYOND_PRESLIDING * (room.presliding or 0.0), COUNTS * room.count)
    return min(known or TRAVEL_SHARE * (room.travel or 0.0), 0.5 * (room.travel or 0.0))


def _slowest(room: Room, seconds: float, rate: float = 0.0) -> float:
    """Return the smallest velocity of a slide that is long enough [m/s or rad/s]."""
    least = 4.0 * _shortest(room)
    if room.stribeck_velocity is not None:
        return max(BELOW_STRIBECK * room.stribeck_velocity, least / (SLOWEST_SHARE * seconds))
    return least * rate


def _fastest(room: Room) -> float:
    """Return the largest velocity at which half of a quarter of the loop is left for a steady slide [m/s or rad/s]."""
    assert room.velocity is not None
    assert room.acceleration is not None
    a, room_left = room.acceleration, 0.25 * (room.travel or 0.0)
    rise = a / room.jerk
    return min(room.velocity, 2.0 * room_left / (math.sqrt(rise * rise + 4.0 * room_left / a) + rise))
