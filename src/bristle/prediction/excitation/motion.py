"""`ExcitationMotion`: a sequence of pieces from rest to rest, and the samples of the whole motion."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from bristle.core import Model, cached_property
from bristle.core.variable import Kind
from bristle.files.motion import Move


@dataclass(frozen=True)
class ExcitationPiece:
    """Part of a motion, from rest to rest.

    Parameters
    ----------
    purpose : str
        Purpose of the piece: a name of `bristle.prediction.excitation.PURPOSES`.
    name : str
        Kind of motion: ``"triangles"``, ``"constant velocity"``.
    reference : Model
        A reference that begins and ends at rest.
    rest : float
        Standstill before the piece [s].
    speed : float
        Velocity of the motion [m/s or rad/s]; the largest velocity of a chirp.
    amplitude : float
        Largest displacement from the start of the piece [m or rad].
    """

    purpose: str
    name: str
    reference: Model
    rest: float
    speed: float
    amplitude: float

    @cached_property
    def duration(self) -> float:
        """Duration of the motion without the rest [s]."""
        return self.reference.component.duration(self.reference.parameters)

    @cached_property
    def end(self) -> float:
        """End position relative to the start [m or rad]."""
        return float(self.sample(np.array([self.duration]))[0][0])

    def sample(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return position, velocity and acceleration at the times `t` [s] after the start of the motion."""
        return self.reference.component.sample(t, self.reference.parameters)


@dataclass(frozen=True)
class ExcitationMotion:
    """A motion to run on an axis, in its SI units.

    Parameters
    ----------
    pieces : tuple of ExcitationPiece
        Pieces in order.
    sample_time : float
        Time between samples [s].
    kind : {"translational", "rotational"}
        Kind of axis.
    start : float
        Position at the start [m or rad].
    rest : float
        Standstill at the end of the motion [s].
    """

    pieces: tuple[ExcitationPiece, ...]
    sample_time: float
    kind: Kind = "translational"
    start: float = 0.0
    rest: float = 0.5

    @cached_property
    def begins(self) -> np.ndarray:
        """Start times of the motion of each piece [s], shape (piece,)."""
        return np.cumsum([piece.rest + piece.duration for piece in self.pieces]) - [
            piece.duration for piece in self.pieces
        ]

    @property
    def duration(self) -> float:
        """Duration of the whole motion [s]."""
        return length_of(self.pieces) + self.rest

    @cached_property
    def time(self) -> np.ndarray:
        """Time of each sample [s]."""
        return self.sample_time * np.arange(int(self.duration / self.sample_time) + 1)

    @cached_property
    def _samples(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        position = np.full(self.time.size, self.start)
        velocity = np.zeros(self.time.size)
        acceleration = np.zeros(self.time.size)
        origin = self.start
        for piece, begin in zip(self.pieces, self.begins, strict=True):
            first, last = np.searchsorted(self.time, (begin, begin + piece.duration))
            x, velocity[first:last], acceleration[first:last] = piece.sample(
                self.time[first:last] - begin
            )
            position[first:last] = origin + x
            origin += piece.end
            position[last:] = origin
        return position, velocity, acceleration

    @property
    def position(self) -> np.ndarray:
        """Position at each sample [m or rad]."""
        return self._samples[0]

    @property
    def velocity(self) -> np.ndarray:
        """Velocity at each sample [m/s or rad/s]."""
        return self._samples[1]

    @property
    def acceleration(self) -> np.ndarray:
        """Acceleration at each sample [m/s^2 or rad/s^2]."""
        return self._samples[2]


def length_of(pieces: Sequence[ExcitationPiece]) -> float:
    """Return the duration of pieces, including their rests [s]."""
    return sum(piece.rest + piece.duration for piece in pieces)


def in_time(
    make: Callable[[float], list[ExcitationPiece]],
    seconds: float,
    pace: float,
    low: float,
    high: float,
) -> list[ExcitationPiece]:
    """Return pieces with the pace that gives this duration, limited to `low` to `high`."""
    for _ in range(12):
        pace = min(max(pace * length_of(make(pace)) / seconds, low), high)
    return make(pace)


def moves_of(motion: ExcitationMotion) -> tuple[tuple[Move, ...], tuple[str, ...]]:
    """Return the moves of a motion, and the purposes without moves."""
    moves: list[Move] = []
    left_out: list[str] = []
    origin = motion.start
    for piece in motion.pieces:
        if piece.name in ("chirp", "swept slide"):  # a sine has no legs of constant velocity
            left_out.append(piece.purpose)
        else:
            moves += _legs(piece, origin, piece.rest, motion.sample_time)
        origin += piece.end
    return tuple(moves), tuple(dict.fromkeys(left_out))


def _legs(piece: ExcitationPiece, origin: float, dwell: float, sample_time: float) -> list[Move]:
    """Return the legs of a piece, between turning points or rests."""
    time = np.linspace(
        0.0, piece.duration, max(int(np.ceil(8 * piece.duration / sample_time)), 2) + 1
    )
    position, velocity, acceleration = piece.sample(time)
    side = np.sign(velocity)
    side[np.abs(velocity) < 1e-6 * np.max(np.abs(velocity))] = 0.0
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
