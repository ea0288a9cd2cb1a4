"""Loops as a rig would record them: positions in counts of the encoder, torques with noise."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bristle.core.contracts import Model
from bristle.paper.setting import Setting
from bristle.paper.torque_bench import led
from bristle.paper.walk import Walk, walk

__all__ = ["Record", "measured", "measured_loop"]

SWEEP = 6  # rounds of falling amplitude
APART = 5e-8  # of the table between two readings [m]


class Record(NamedTuple):
    """What was read while the table moved from turning point to turning point."""

    x: np.ndarray
    torque: np.ndarray
    turns: np.ndarray
    actual: Walk

    def since(self, turn: int) -> Record:
        """Return what was read from a turning point on."""
        return self.part(int(self.turns[turn]), self.x.size, turn)

    def part(self, start: int, end: int, turn: int) -> Record:
        """Return what was read from one sample to another, and the turning points from one on."""
        part = slice(start, end)
        turns = self.turns[turn:]
        turns = turns[turns < end] - start
        actual = Walk(self.actual.x[part], self.actual.torque[part], turns)
        return Record(self.x[part], self.torque[part], turns, actual)


def measured(setting: Setting, friction: Model, turns: Iterable[float], generator: np.random.Generator) -> Record:
    """Return the record of a motion of the table."""
    resolution, noise = setting["measurement", "resolution"], setting["measurement", "noise"]
    sensed, actual = _moved(setting, friction, list(turns))
    read = resolution * np.round(sensed.x / resolution) if resolution > 0.0 else sensed.x
    return Record(read, sensed.torque + noise * generator.standard_normal(sensed.torque.size), sensed.turns, actual)


def _moved(setting: Setting, friction: Model, turns: list[float]) -> tuple[Walk, Walk]:
    """Return what the torque sensor reads over the position, and friction itself: the same where there is no bench."""
    speed = setting["measurement", "speed"]
    if "bench" not in setting.numbers:
        path = walk(friction, turns, speed, setting.arm, step=APART)
        return path, path
    sensor, actual, _ = led(setting, friction, turns, speed)
    travelled = np.cumsum(np.abs(np.diff(sensor.x, prepend=0.0)))
    now_and_then = np.searchsorted(travelled, np.arange(0.0, travelled[-1], APART))
    read = np.union1d(now_and_then, sensor.turns)
    ends = np.searchsorted(read, sensor.turns)
    return Walk(sensor.x[read], sensor.torque[read], ends), Walk(actual.x[read], actual.torque[read], ends)


def measured_loop(setting: Setting, friction: Model, amplitude: float, rounds: int, generator: np.random.Generator) -> list[Record]:
    """Return the last rounds of a symmetric loop, after a sweep from the largest one down to it.

    The sweep is what puts loops of every amplitude around one middle, where both directions are not alike.
    """
    largest = float(np.max(setting["measurement", "amplitudes"]))
    falling = np.linspace(largest, amplitude, SWEEP).repeat(2)
    sweep = falling * np.tile([1.0, -1.0], SWEEP)
    record = measured(setting, friction, [*sweep, *([amplitude, -amplitude] * rounds)], generator)
    starts = record.turns[sweep.size - 1 :: 2]
    return [record.part(a, b + 1, sweep.size + 2 * k) for k, (a, b) in enumerate(pairwise(starts.tolist()))]
