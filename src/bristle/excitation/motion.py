"""`ExcitationMotion`: pieces from rest to rest, one after the other, and the samples of the whole."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from bristle.core.contracts import Model
from bristle.core.lazy import cached_property
from bristle.core.variable import Kind
from bristle.files.motion import Move


@dataclass(frozen=True)
class ExcitationPiece:
    """A part of a motion, from rest to rest.

    Parameters
    ----------
    purpose : str
        What it serves: a name of `bristle.excitation.PURPOSES`.
    name : str
        What it is: ``"triangles"``, ``"constant velocity"``.
    reference : Model
        A reference that begins and ends at rest.
    rest : float
        Standstill before it [s].
    speed : float
        At which it moves [m/s or rad/s]; the largest one of a chirp.
    amplitude : float
        How far it goes from where it begins [m or rad].
    """

    purpose: str
    name: str
    reference: Model
    rest: float
    speed: float
    amplitude: float

    @cached_property
    def duration(self) -> float:
        """How long it moves [s]."""
        return self.reference.component.duration(self.reference.parameters)

    @cached_property
    def end(self) -> float:
        """Where it ends, from where it begins [m or rad]."""
        return float(self.sample(np.array([self.duration]))[0][0])

    def sample(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return position, velocity and acceleration at the times `t` [s] since it began to move."""
        return self.reference.component.sample(t, self.reference.parameters)


@dataclass(frozen=True)
class ExcitationMotion:
    """A motion to run on an axis, in SI of its kind.

    Parameters
    ----------
    pieces : tuple of ExcitationPiece
        In order.
    sample_time : float
        Time between samples [s].
    kind : {"translational", "rotational"}
        Kind of axis.
    start : float
        Where it begins [m or rad].
    rest : float
        Standstill at its end [s].
    """

    pieces: tuple[ExcitationPiece, ...]
    sample_time: float
    kind: Kind = "translational"
    start: float = 0.0
    rest: float = 0.5

    @cached_property
    def begins(self) -> np.ndarray:
        """When each piece begins to move [s], shape (piece,)."""
        return np.cumsum([piece.rest + piece.duration for piece in self.pieces]) - [piece.duration for piece in self.pieces]

    @property
    def duration(self) -> float:
        """How long the whole takes [s]."""
        return length_of(self.pieces) + self.rest

    @cached_property
    def time(self) -> np.ndarray:
        """Time of each sample [s]."""
        return self.sample_time * np.arange(int(self.duration / self.sample_time) + 1)

    @cached_property
    def _samples(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        position, velocity, acceleration = np.full(self.time.size, self.start), *np.zeros((2, self.time.size))
        origin = self.start
        for piece, begin in zip(self.pieces, self.begins, strict=True):
            first, last = np.searchsorted(self.time, (begin, begin + piece.duration))
            x, velocity[first:last], acceleration[first:last] = piece.sample(self.time[first:last] - begin)
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
    """Return how long pieces take, their rests included [s]."""
    return sum(piece.rest + piece.duration for piece in pieces)


def in_time(make: Callable[[float], list[ExcitationPiece]], seconds: float, pace: float, low: float, high: float) -> list[ExcitationPiece]:
    """Return pieces made at the pace at which they take this time, as far as it lies between `low` and `high`."""
    for _ in range(12):
        pace = min(max(pace * length_of(make(pace)) / seconds, low), high)
    return make(pace)


def moves_of(motion: ExcitationMotion) -> tuple[tuple[Move, ...], tuple[str, ...]]:
    """Return the moves of a motion, and the purposes that are none."""
    moves: list[Move] = []
    left_out: list[str] = []
    origin = motion.start
    for piece in motion.pieces:
        if piece.name == "chirp":  # a sine is not made of legs of one velocity
            left_out.append(piece.purpose)
        else:
            moves += _legs(piece, origin, piece.rest, motion.sample_time)
        origin += piece.end
    return tuple(moves), tuple(dict.fromkeys(left_out))


def _legs(piece: ExcitationPiece, origin: float, dwell: float, sample_time: float) -> list[Move]:
    """Return the legs of a piece, from one turning point or standstill to the next."""
    time = np.linspace(0.0, piece.duration, max(int(np.ceil(8 * piece.duration / sample_time)), 2) + 1)
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
