"""Pre-sliding: a conditioning slide, decaying loops, and pairs of triangles from small to large.

The slide and the decaying loops leave the contact in a known state: without them the first loops depend on what the
axis did before, and the error of the encoder is the same for all of them.
"""

from __future__ import annotations

import math

import numpy as np

from bristle.excitation.limits import MotionLimits
from bristle.excitation.motion import ExcitationPiece, in_time
from bristle.references import triangle

__all__ = ["conditioning", "missing", "pieces"]

PAIRS = 14
SMALLEST, LARGEST = 0.1, 0.97  # of the pre-sliding amplitude
COUNTS = 3.0  # of the encoder: no loop is smaller
FOLLOWED = 0.5  # of the largest loop, by which a controller that follows no closer spoils them all
SLIDE = 4.0  # times the pre-sliding amplitude: friction is saturated long before
SLIDE_TIME = 1.5  # [s]
DECAYING_CYCLES, DECAYED = 5, 0.15
LEG_SAMPLES = 25.0  # at least, in the shortest leg
LEG_TIME = 5.0  # [s] at most, for the longest leg: longer, and drift of the axis looks like friction
REST = 0.2  # [s]


def missing(limits: MotionLimits) -> str:
    """Return why there is no such motion on this axis, and what to do; nothing where there is one."""
    if limits.presliding is None:
        return (
            "the distance over which friction turns is not known: write presliding under [plant], or give a model; a slow reversal shows it"
        )
    if COUNTS * limits.count > 0.5 * LARGEST * limits.presliding:
        return (
            f"the encoder is too coarse: {COUNTS:.0f} of its steps of {limits.in_unit(limits.count, 'length')} are no "
            f"small part of {limits.in_unit(limits.presliding, 'length')}"
        )
    if limits.followed > FOLLOWED * LARGEST * limits.presliding:
        return (
            f"the controller follows such loops no closer than {limits.in_unit(limits.followed, 'length')}, which is "
            f"no small part of {limits.in_unit(limits.presliding, 'length')}: raise its gains for this motion, or add "
            "integral action"
        )
    if limits.travel is not None and limits.travel < 2.0 * SLIDE * limits.presliding:
        return f"it takes a travel of {limits.in_unit(2.0 * SLIDE * limits.presliding, 'length')}"
    return ""


def conditioning(limits: MotionLimits, purpose: str) -> ExcitationPiece:
    """Return a slide to and fro that wipes out what the contact remembers."""
    assert limits.presliding is not None
    amplitude = SLIDE * limits.presliding
    return _triangle(limits, purpose, "conditioning slide", amplitude, 4.0 * amplitude / SLIDE_TIME)


def pieces(limits: MotionLimits, seconds: float) -> list[ExcitationPiece]:
    """Return the motion, to last about so long [s]."""
    assert limits.presliding is not None
    largest = LARGEST * limits.presliding
    smallest = max(SMALLEST * limits.presliding, COUNTS * limits.count, limits.followed)
    # Evenly spaced: most of the time goes to the large loops, which hold most of the force.
    amplitudes = np.linspace(smallest, largest, PAIRS)
    slowest = 2.0 * largest / LEG_TIME
    fastest = min(2.0 * smallest / (LEG_SAMPLES * limits.sample_time), limits.velocity or math.inf)
    cycles = 2

    def make(speed: float) -> list[ExcitationPiece]:
        decay = DECAYED ** (1.0 / (2 * DECAYING_CYCLES - 1))
        loops = _triangle(limits, "presliding", "decaying loops", largest, speed, DECAYING_CYCLES, decay)
        pairs = [_triangle(limits, "presliding", "triangles", amplitude, speed, cycles) for amplitude in amplitudes]
        return [conditioning(limits, "presliding"), loops, *pairs]

    planned = in_time(make, seconds, slowest, 1e-3 * slowest, fastest)
    if planned[-1].speed < slowest <= (limits.velocity or math.inf):
        cycles = 2 * max(round(slowest / planned[-1].speed), 1)
        planned = in_time(make, seconds, slowest, 1e-3 * slowest, fastest)
    return planned


def _triangle(
    limits: MotionLimits, purpose: str, name: str, amplitude: float, speed: float, cycles: int = 1, ratio: float = 1.0
) -> ExcitationPiece:
    speed = min(speed, limits.velocity or math.inf)
    shortest = 2.0 * amplitude * ratio ** (2 * cycles - 1)
    reference = triangle(
        kind=limits.kind,
        amplitude=amplitude,
        velocity=speed,
        cycle_count=cycles,
        ratio=ratio,
        acceleration=limits.corner(speed, shortest),
        jerk=limits.jerk,
    )
    return ExcitationPiece(purpose, name, reference, REST, speed, amplitude)
