"""Motions made of legs at constant velocity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

__all__ = ["Leg", "Motion", "along"]


class Leg(NamedTuple):
    """A move to a position [m] at a speed [m/s], after which the axis turns."""

    target: float
    speed: float


@dataclass(frozen=True)
class Motion:
    """A motion on a uniform grid of time; arrays of shape (sample,), in SI units of the axis."""

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray

    @property
    def sample_time(self) -> float:
        """Time between samples [s]."""
        return float(self.time[1] - self.time[0])


def along(
    legs: Sequence[Leg], acceleration: float, sample_time: float, start: float = 0.0
) -> Motion:
    """Return the motion along legs, each with a trapezoid of velocity; a short one does not reach its speed.

    Parameters
    ----------
    legs : sequence of Leg
        Where to, and how fast.
    acceleration : float
        Of every change of speed [m/s^2 or rad/s^2].
    sample_time : float
        Time between samples [s].
    start : float
        Position at the beginning [m or rad].

    Returns
    -------
    Motion
        Its time begins at 0; position and velocity are exact at the samples.
    """
    durations, changes, at = [], [], start
    for leg in legs:
        way = leg.target - at
        top = min(leg.speed, math.sqrt(acceleration * abs(way)))
        if top > 0.0:
            ramp = top / acceleration
            durations += [ramp, abs(way) / top - ramp, ramp]
            changes += [math.copysign(acceleration, way), 0.0, -math.copysign(acceleration, way)]
        at = leg.target
    return _sampled(np.array(durations), np.array(changes), sample_time, start)


def _sampled(durations: np.ndarray, accelerations: np.ndarray, dt: float, start: float) -> Motion:
    edges = np.concatenate([[0.0], np.cumsum(durations)])
    velocity = np.concatenate([[0.0], np.cumsum(accelerations * durations)])
    way = velocity[:-1] * durations + 0.5 * accelerations * durations**2
    position = start + np.concatenate([[0.0], np.cumsum(way)])
    time = dt * np.arange(math.floor(edges[-1] / dt) + 1)
    part = np.minimum(np.searchsorted(edges, time, side="right") - 1, durations.size - 1)
    into = time - edges[part]
    a = accelerations[part]
    return Motion(
        time,
        position[part] + velocity[part] * into + 0.5 * a * into**2,
        velocity[part] + a * into,
        a,
    )
