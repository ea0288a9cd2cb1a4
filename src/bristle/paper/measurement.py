"""Loops as a rig would record them: positions in counts of the encoder, torques with noise."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bristle.core.contracts import Model
from bristle.paper.setting import Setting
from bristle.paper.walk import walk

__all__ = ["Record", "measured", "measured_loop"]

SWEEP = 6  # rounds of falling amplitude


class Record(NamedTuple):
    """What was read while the table moved from turning point to turning point.

    Parameters
    ----------
    x : ndarray, shape (sample,)
        Position of the table [m], in counts.
    torque : ndarray, shape (sample,)
        Torque [N*m].
    turns : ndarray of int, shape (turn,)
        The samples at which the table turned.
    """

    x: np.ndarray
    torque: np.ndarray
    turns: np.ndarray

    def since(self, turn: int) -> Record:
        """Return what was read from a turning point on."""
        start = int(self.turns[turn])
        return Record(self.x[start:], self.torque[start:], self.turns[turn:] - start)


def measured(setting: Setting, friction: Model, turns: Iterable[float], generator: np.random.Generator) -> Record:
    """Return the record of a motion of the table.

    Parameters
    ----------
    setting : Setting
        The experiment: speed, resolution and noise.
    friction : Model
        The contact, virgin.
    turns : iterable of float
        Where the table turns [m].
    generator : numpy.random.Generator
        Where the noise comes from.
    """
    resolution, noise = setting["measurement", "resolution"], setting["measurement", "noise"]
    done = walk(friction, turns, setting["measurement", "speed"], setting.arm, step=5e-8)
    read = resolution * np.round(done.x / resolution) if resolution > 0.0 else done.x
    return Record(read, done.torque + noise * generator.standard_normal(done.torque.size), done.turns)


def measured_loop(
    setting: Setting, friction: Model, amplitude: float, rounds: int, generator: np.random.Generator
) -> list[Record]:
    """Return the last rounds of a symmetric loop, after a sweep from the largest one down to it.

    The sweep is what puts loops of every amplitude around one middle, where both directions are not alike.

    Parameters
    ----------
    setting : Setting
        The experiment: amplitudes, speed, resolution and noise.
    friction : Model
        The contact, virgin.
    amplitude : float
        Of the loop [m].
    rounds : int
        How many rounds are returned.
    generator : numpy.random.Generator
        Where the noise comes from.
    """
    largest = float(np.max(setting["measurement", "amplitudes"]))
    falling = np.linspace(largest, amplitude, SWEEP).repeat(2)
    sweep = falling * np.tile([1.0, -1.0], SWEEP)
    record = measured(setting, friction, [*sweep, *([amplitude, -amplitude] * rounds)], generator)
    starts = record.turns[sweep.size - 1 :: 2]
    return [
        Record(record.x[a : b + 1], record.torque[a : b + 1], np.array([b - a])) for a, b in pairwise(starts.tolist())
    ]
