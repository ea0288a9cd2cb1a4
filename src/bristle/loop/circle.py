"""A circle run by two axes of one kind: what friction does to it where an axis reverses."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from bristle.core.contracts import Model
from bristle.core.experiment import Experiment, Variant
from bristle.core.status import Status
from bristle.loop.assessment import motion_of, top_speed
from bristle.references import circle
from bristle.simulation import simulate

__all__ = ["Circle", "circle_of", "run_circles"]

AROUND = math.radians(30.0)  # to either side of a reversal
SAMPLES_LEAST = 400  # in a revolution


@dataclass(frozen=True)
class Circle:
    """One revolution; arrays of shape (sample,).

    Parameters
    ----------
    variant : str
        Name of the loop.
    radius, feed : float
        Of the circle [m or rad], and along it [m/s or rad/s].
    angle : ndarray
        Along the circle, ascending from 0 to 2 pi [rad].
    deviation : ndarray
        Distance from the centre less the radius, of the axes themselves [m or rad].
    """

    variant: str
    radius: float
    feed: float
    angle: np.ndarray
    deviation: np.ndarray

    @property
    def peak_to_peak(self) -> float:
        """Largest less smallest deviation [m or rad]."""
        return float(np.ptp(self.deviation))

    @property
    def glitches(self) -> tuple[float, ...]:
        """Swing of the deviation around each reversal: at 0, 90, 180 and 270 degrees [m or rad]."""
        apart = (np.abs((self.angle - turn + np.pi) % (2.0 * np.pi) - np.pi) for turn in 0.5 * np.pi * np.arange(4))
        return tuple(float(np.ptp(self.deviation[distance <= AROUND])) for distance in apart)


def circle_of(variant: Variant) -> tuple[float, float]:
    """Return radius [m or rad] and feed [m/s or rad/s] of the circle that a reference stands for.

    Of a circle its own; of another motion half its travel, and its largest velocity.
    """
    reference = variant.reference
    if reference.name == "circle":
        return reference.values["radius"], reference.values["feed"]
    return 0.5 * float(np.ptp(motion_of(variant)[0][:-1])), top_speed(variant)


def run_circles(
    variants: tuple[Variant, ...], radius: float, feed: float, progress: Callable[[float, str], None] | None = None
) -> tuple[Circle, ...]:
    """Return the circle that each of some loops runs, on both axes.

    The two axes are alike, but each has noise and irregularities of its own.

    Parameters
    ----------
    variants : tuple of Variant
        The loops.
    radius, feed : float
        Of the circle [m or rad], and along it [m/s or rad/s].
    progress : callable, optional
        Called with the share done and the name of what comes next.
    """
    runs = [_axis(variant, radius, feed, axis) for variant in variants for axis in ("x", "y")]
    result = simulate(Experiment("circle", variants[0].plant.kind, tuple(runs)), progress)
    circles = []
    for variant in variants:
        x, y = (result.variants[f"{variant.name}, {axis}"] for axis in ("x", "y"))
        if Status.NOT_FINITE in (x.status, y.status):
            continue
        count = min(round(2.0 * math.pi * radius / feed / variant.run.sample_time), x.time.size)
        angle = np.arctan2(y.reference[-count:], x.reference[-count:]) % (2.0 * np.pi)
        deviation = np.hypot(x.position[-count:], y.position[-count:]) - radius
        order = np.argsort(angle, kind="stable")
        circles.append(Circle(variant.name, radius, feed, angle[order], deviation[order]))
    return tuple(circles)


def is_sampled(variant: Variant, radius: float, feed: float) -> bool:
    """Return whether a circle is run slowly enough for its samples to show it."""
    return 2.0 * math.pi * radius / feed >= SAMPLES_LEAST * variant.run.sample_time


def _axis(variant: Variant, radius: float, feed: float, axis: str) -> Variant:
    revolution = 2.0 * math.pi * radius / feed
    return replace(
        variant,
        name=f"{variant.name}, {axis}",
        reference=circle(kind=variant.plant.kind, radius=radius, feed=feed, axis=axis),
        friction=_seeded(variant.friction, axis),
        table=None if variant.table is None else _seeded(variant.table, axis),
        sensor=_seeded(variant.sensor, axis),
        disturbance=None,
        injected=None,
        learning=None,
        run=replace(variant.run, duration=2.0 * revolution, settle=revolution, seeds=1),
    )


def _seeded(model: Model, axis: str) -> Model:
    """Return a model with noise of its own on the second axis."""
    if axis == "x" or "seed" not in model.values:
        return model
    return model.with_values(seed=model.values["seed"] + 1)
