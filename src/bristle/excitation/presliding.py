"""Pre-sliding: a conditioning slide, decaying loops, and pairs of triangles from small to large.

The slide and the decaying loops leave the contact in a known state: without them the first loops depend on what the
axis did before, and the error of the encoder is the same for all of them.
"""

from __future__ import annotations

import math

import numpy as np

from bristle.excitation.motion import Piece, in_time
from bristle.excitation.room import Room
from bristle.references import triangle

__all__ = ["conditioning", "missing", "pieces"]

PAIRS = 14
SMALLEST, LARGEST = 0.1, 0.97  # of the pre-sliding amplitude
COUNTS = 3.0  # of the encoder: no loop is smaller
SLIDE = 4.0  # times the pre-sliding amplitude: friction is saturated long before
SLIDE_TIME = 1.5  # [s]
DECAYING_CYCLES, DECAYED = 5, 0.15
LEG_SAMPLES = 25.0  # at least, in the shortest leg
LEG_TIME = 5.0  # [s] at most, for the longest leg: longer, and drift of the axis looks like friction
REST = 0.2  # [s]


def missing(room: Room) -> str:
    """Return why there is no such motion on this axis, and what to do; nothing where there is one."""
    if room.presliding is None:
        return (
            "the distance over which friction turns is not known: write presliding under [plant], or give a model; a "
            "slow reversal shows it"
        )
    if COUNTS * room.count > 0.5 * LARGEST * room.presliding:
        return (
            f"the encoder is too coarse: {COUNTS:.0f} of its steps of {room.told(room.count, 'length')} are no small "
            f"part of {room.told(room.presliding, 'length')}"
        )
    if room.travel is not None and room.travel < 2.0 * SLIDE * room.presliding:
        return f"it takes a travel of {room.told(2.0 * SLIDE * room.presliding, 'length')}"
    return ""


def conditioning(room: Room, purpose: str) -> Piece:
    """Return a slide to and fro that wipes out what the contact remembers."""
    assert room.presliding is not None
    amplitude = SLIDE * room.presliding
    return _triangle(room, purpose, "conditioning slide", amplitude, 4.0 * amplitude / SLIDE_TIME)


def pieces(room: Room, seconds: float) -> list[Piece]:
    """Return the motion, to last about so long [s]."""
    assert room.presliding is not None
    largest = LARGEST * room.presliding
    smallest = max(SMALLEST * room.presliding, COUNTS * room.count)
    # Evenly spaced: most of the time goes to the large loops, which hold most of the force.
    amplitudes = np.linspace(smallest, largest, PAIRS)
    slowest = 2.0 * largest / LEG_TIME
    fastest = min(2.0 * smallest / (LEG_SAMPLES * room.sample_time), room.velocity or math.inf)
    cycles = 2

    def make(speed: float) -> list[Piece]:
        decay = DECAYED ** (1.0 / (2 * DECAYING_CYCLES - 1))
        loops = _triangle(room, "presliding", "decaying loops", largest, speed, DECAYING_CYCLES, decay)
        pairs = [_triangle(room, "presliding", "triangles", one, speed, cycles) for one in amplitudes]
        return [conditioning(room, "presliding"), loops, *pairs]

    found = in_time(make, seconds, slowest, 1e-3 * slowest, fastest)
    if found[-1].speed < slowest <= (room.velocity or math.inf):
        cycles = 2 * max(round(slowest / found[-1].speed), 1)
        found = in_time(make, seconds, slowest, 1e-3 * slowest, fastest)
    return found


def _triangle(
    room: Room, purpose: str, name: str, amplitude: float, speed: float, cycles: int = 1, ratio: float = 1.0
) -> Piece:
    speed = min(speed, room.velocity or math.inf)
    shortest = 2.0 * amplitude * ratio ** (2 * cycles - 1)
    reference = triangle(
        kind=room.kind, amplitude=amplitude, velocity=speed, cycle_count=cycles, ratio=ratio,
        acceleration=room.corner(speed, shortest), jerk=room.jerk,
    )  # fmt: skip
    return Piece(purpose, name, reference, REST, speed, amplitude)
