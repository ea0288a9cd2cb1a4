"""A motion as a list of moves: what a motion controller or an NC program runs, where it takes no set points.

Each move goes to a position at a velocity, as ``MC_MoveAbsolute`` of PLCopen motion control does [1]_.

References
----------
.. [1] PLCopen, "Function blocks for motion control", version 2.0, 2011. https://plcopen.org/technical-activities/motion-control
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bristle.excitation.motion import ExcitationMotion, ExcitationPiece

__all__ = ["Move", "moves_of"]

FINER = 8  # times the rate of the samples, for turning points between them
RESTS = 1e-6  # of the largest velocity: standstill
CONTINUOUS = ("chirp",)
"""Pieces that no list of moves is: a sine is not made of legs of one velocity."""


class Move(NamedTuple):
    """To a position at a velocity, in SI of the kind of axis."""

    purpose: str
    dwell: float
    target: float
    velocity: float
    acceleration: float


def moves_of(motion: ExcitationMotion) -> tuple[tuple[Move, ...], tuple[str, ...]]:
    """Return the moves of a motion, and the purposes that are none."""
    moves: list[Move] = []
    left_out: list[str] = []
    origin = motion.start
    for piece in motion.pieces:
        if piece.name in CONTINUOUS:
            left_out.append(piece.purpose)
        else:
            moves += _legs(piece, origin, piece.rest, motion.sample_time)
        origin += piece.end
    return tuple(moves), tuple(dict.fromkeys(left_out))


def _legs(piece: ExcitationPiece, origin: float, dwell: float, sample_time: float) -> list[Move]:
    """Return the legs of a piece, from one turning point or standstill to the next."""
    time = np.linspace(0.0, piece.duration, max(int(np.ceil(FINER * piece.duration / sample_time)), 2) + 1)
    position, velocity, acceleration = piece.sample(time)
    side = np.sign(velocity)
    side[np.abs(velocity) < RESTS * np.max(np.abs(velocity))] = 0.0
    bounds = np.flatnonzero(np.diff(side, prepend=0.0, append=0.0))
    moves: list[Move] = []
    for first, last in pairwise(bounds.tolist()):
        if side[first] == 0.0:
            dwell += float(time[last] - time[first])
            continue
        leg = slice(first, last)
        end = float(side[first] * np.max(side[first] * position[first : last + 1]))
        moves.append(
            Move(
                piece.purpose,
                dwell if dwell > 2.0 * sample_time else 0.0,
                origin + end,
                float(np.max(np.abs(velocity[leg]))),
                float(np.max(np.abs(acceleration[leg]))),
            )
        )
        dwell = 0.0
    return moves
