"""Break-away: reversals from rest at several rates, in both directions, each until friction is saturated."""

from __future__ import annotations

import math

from bristle.excitation.motion import Piece, in_time
from bristle.excitation.presliding import conditioning
from bristle.excitation.presliding import missing as missing_for_presliding
from bristle.excitation.room import Room
from bristle.references import s_curve

__all__ = ["missing", "pieces"]

REACH = 5.0  # times the pre-sliding amplitude; two of them turn the contact over
RATES = (1.0, 4.0, 16.0)  # relative to the slowest
SAMPLES = 50.0  # at least, while the contact turns over
REST = 0.4  # [s]

missing = missing_for_presliding


def pieces(room: Room, seconds: float) -> list[Piece]:
    """Return the motion, to last about so long [s]."""
    assert room.presliding is not None
    turn = 2.0 * room.presliding
    most = min(turn / (SAMPLES * room.sample_time), room.velocity or math.inf)

    # The conditioning slide ends forward: the first ramp turns back.
    def make(speed: float) -> list[Piece]:
        return [
            conditioning(room, "break-away"),
            *(_ramp(room, side, min(rate * speed, most)) for rate in RATES for side in (-1.0, 1.0)),
        ]

    pace = turn / (0.2 * seconds)
    return in_time(make, seconds, pace, 1e-2 * pace, most)


def _ramp(room: Room, side: float, speed: float) -> Piece:
    assert room.presliding is not None
    distance = REACH * room.presliding
    reference = s_curve(
        kind=room.kind,
        distance=side * distance,
        velocity=speed,
        acceleration=room.corner(speed, room.presliding),
        jerk=room.jerk,
    )
    return Piece("break-away", "break-away ramp", reference, REST, speed, side * distance)
