"""Typical magnitudes of a log: by them parameters of unknown magnitude are scaled, bounded and drawn."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from bristle.core.dimensions import exponents_of
from bristle.core.variable import Variable
from bristle.identification.dataset import Dataset

__all__ = ["Scales", "scales_of", "stroke_of"]

SLOWEST_SHARE = 0.01  # of the samples are slower than the smallest Stribeck velocity sought
STRIBECK_SHARE = 1.0 / 3.0  # of the greatest speed: beyond, the log would not show the level that friction falls to


class Scales(NamedTuple):
    """Typical magnitudes of a log, in SI."""

    force: float
    peak: float
    speed: float
    slowest: float
    acceleration: float
    stroke: float
    shortest: float
    duration: float
    sample_time: float

    def magnitude(self, variable: Variable) -> float:
        """Return a typical value of a parameter [SI]: where nothing else is known of it, by its exponents."""
        if variable.excitation == "drive":
            return variable.nominal
        typical = {
            "length": math.sqrt(self.stroke * self.shortest),
            "length/time": math.sqrt(self.slowest * self.speed),
            "force/length": self.force / math.sqrt(self.stroke * self.shortest),
            "1/length": 1.0 / self.stroke,
            "time": math.sqrt(self.sample_time * self.duration),
            "1/time": 1.0 / math.sqrt(self.sample_time * self.duration),
            "force/time": self.force / math.sqrt(self.sample_time * self.duration),
        }
        powers = exponents_of(variable.quantity)
        if variable.quantity in typical or not powers or set(powers) - {"force", "length", "time"}:
            return typical.get(variable.quantity, variable.nominal)
        length, time = powers.get("length", 0.0), powers.get("time", 0.0)
        # A speed and an acceleration have every power of a length and a time between them.
        parts = (
            (self.force, powers.get("force", 0.0)), (self.speed, 2.0 * length + time),
            (self.acceleration, -length - time),
        )  # fmt: skip
        above, below = (math.prod(part ** max(sign * power, 0.0) for part, power in parts) for sign in (1.0, -1.0))
        return above / below

    def range(self, variable: Variable) -> tuple[float, float]:
        """Return between which values a positive parameter of unknown magnitude is sought [SI]."""
        return {
            "length": (self.shortest, self.stroke),
            "length/time": (self.slowest, max(STRIBECK_SHARE * self.speed, 2.0 * self.slowest)),
            "force/length": (self.force / self.stroke, self.force / self.shortest),
            "time": (self.sample_time, self.duration),
            "1/time": (1.0 / self.duration, 1.0 / self.sample_time),
            "force/time": (self.force / self.duration, self.force / self.sample_time),
        }.get(variable.quantity, (1e-3 * self.magnitude(variable), 1e2 * self.magnitude(variable)))


def stroke_of(dataset: Dataset) -> float:
    """Return how far the axis goes within a segment of the log [m or rad]."""
    return max(float(np.ptp(segment.position)) for segment in dataset.segments)


def scales_of(dataset: Dataset, force: float) -> Scales:
    """Return the typical magnitudes of a log, for a friction force of this magnitude [N or N*m]."""
    speeds = np.abs(dataset.all_velocities)
    speeds = speeds[speeds > 0.0]
    speed = float(np.quantile(speeds, 0.995))
    slowest = max(float(np.quantile(speeds, SLOWEST_SHARE)), 1e-4 * speed)
    stroke = stroke_of(dataset)
    return Scales(
        force=force,
        peak=float(np.max(np.abs(dataset.effort))),
        speed=speed,
        slowest=slowest,
        acceleration=max(float(np.sqrt(np.mean(dataset.acceleration**2))), 1e-9 * speed / dataset.sample_time),
        stroke=stroke,
        shortest=min(max(dataset.resolution, slowest * dataset.sample_time), 0.1 * stroke),
        duration=float(np.ptp(dataset.time)),
        sample_time=dataset.sample_time,
    )
