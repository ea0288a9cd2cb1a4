"""Break-away: reversals from rest at several rates, in both directions, each until friction is saturated."""

from __future__ import annotations

import math

from bristle.excitation.limits import MotionLimits
from bristle.excitation.motion import ExcitationPiece, in_time
from bristle.excitation.presliding import conditioning
from bristle.excitation.presliding import missing as missing_for_presliding
from bristle.references import s_curve

__all__ = ["missing", "pieces"]

REACH = 5.0  # times the pre-sliding amplitude; two of them turn the contact over
RATES = (1.0, 4.0, 16.0)  # relative to the slowest
SAMPLES = 50.0  # at least, while the contact turns over
REST = 0.4  # [s]

missing = missing_for_presliding


def pieces(limits: MotionLimits, seconds: float) -> list[ExcitationPiece]:
    """Return the motion, to last about so long [s]."""
    assert limits.presliding is not None
    turn = 2.0 * limits.presliding
    most = min(turn / (SAMPLES * limits.sample_time), limits.velocity or math.inf)

    # The conditioning slide ends forward: the first ramp turns back.
    def make(speed: float) -> list[ExcitationPiece]:
        return [
            conditioning(limits, "break-away"),
            *(_ramp(limits, side, min(rate * speed, most)) for rate in RATES for side in (-1.0, 1.0)),
        ]

    pace = turn / (0.2 * seconds)
    return in_time(make, seconds, pace, 1e-2 * pace, most)


def _ramp(limits: MotionLimits, side: float, speed: float) -> ExcitationPiece:
    assert limits.presliding is not None
    distance = REACH * limits.presliding
    reference = s_curve(
        kind=limits.kind, distance=side * distance, velocity=speed, acceleration=limits.corner(speed, limits.presliding), jerk=limits.jerk
    )
    return ExcitationPiece("break-away", "break-away ramp", reference, REST, speed, side * distance)
