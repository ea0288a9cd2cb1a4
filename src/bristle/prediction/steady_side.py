"""One direction of motion: the friction that a model settles to over speed, and where straight lines follow it best."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise

import numpy as np

from bristle.core.contracts import Model
from bristle.engine.steady import steady_force

__all__ = ["placed", "resolved_side", "steady_side"]

NEAREST = 1e-6  # of the largest speed: the first of the points after rest
SLOWEST = 1e-9  # of the largest speed: what stands for rest
CURVES = 16  # to be remembered: a report asks for the same ones again and again
HALVINGS = 40
STRAIGHT = 1e-6  # of the largest force: a deviation that is none
COARSE, FINEST = 48, 800  # points before any is put between them, and with all of those
RESOLVED = 2e-5  # of the largest force: so far a point between two others may be off the line through them
BETWEEN = 0.4  # of the way: the middle of an S lies on its chord


@lru_cache(maxsize=CURVES)
def steady_side(model: Model, direction: float, fastest: float, fine: int) -> np.ndarray:
    """Return speed, ascending from 0, and the force along the motion at each, dense near rest; shape (point, 2)."""
    speeds = np.union1d(fastest * np.geomspace(NEAREST, 1.0, fine // 2), np.linspace(0.0, fastest, fine // 2))
    forces = [direction * steady_force(model, direction * max(v, SLOWEST * fastest)) for v in speeds.tolist()]
    curve = np.column_stack([speeds, forces])
    curve.setflags(write=False)
    return curve


@lru_cache(maxsize=CURVES)
def resolved_side(model: Model, direction: float, fastest: float) -> tuple[np.ndarray, float]:
    """Return `steady_side` with points between its own until straight lines follow, and how far those are off at most."""
    forces = dict(steady_side(model, direction, fastest, COARSE).tolist())
    allowed = RESOLVED * max(map(abs, forces.values()))
    speeds = sorted(forces)
    apart = list(pairwise(speeds))
    off = 0.0
    while apart:
        low, high = apart.pop(0)
        v = low + BETWEEN * (high - low)
        forces[v] = direction * steady_force(model, direction * max(v, SLOWEST * fastest))
        deviation = abs(forces[v] - forces[low] - BETWEEN * (forces[high] - forces[low]))
        if deviation > allowed and len(forces) < FINEST:
            apart += [(low, v), (v, high)]
        else:
            off = max(off, deviation)
    curve = np.array(sorted(forces.items()))
    curve.setflags(write=False)
    return curve, off


def placed(curve: np.ndarray, count: int) -> list[int]:
    """Return the points of a curve between which straight lines deviate least, at most `count`, both ends among them.

    Bisects on the deviation: for one that is allowed, each line reaches as far as it can.
    """
    low, high = STRAIGHT * float(np.max(np.abs(curve[:, 1]))), float(np.ptp(curve[:, 1]))
    without = _reached(curve, low, count)
    if without is not None:
        return without
    best = [0, len(curve) - 1]
    for _ in range(HALVINGS):
        allowed = 0.5 * (low + high)
        corners = _reached(curve, allowed, count)
        if corners is None:
            low = allowed
        else:
            best, high = corners, allowed
    return best


def _reached(curve: np.ndarray, allowed: float, count: int) -> list[int] | None:
    """Return the points, each the last that a straight line reaches within a deviation; None if it takes more."""
    corners = [0]
    while corners[-1] < len(curve) - 1:
        if len(corners) == count:
            return None
        corners.append(_furthest(curve, corners[-1], allowed))
    return corners


def _furthest(curve: np.ndarray, first: int, allowed: float) -> int:
    """Return the last point that a straight line from the first one reaches, all between within a deviation."""
    run, rise = (curve[first + 1 :] - curve[first]).T
    # Each point leaves a cone of slopes for all lines that go beyond it.
    upper = np.minimum.accumulate((rise + allowed) / run)
    lower = np.maximum.accumulate((rise - allowed) / run)
    slope = rise / run
    fits = np.flatnonzero((slope <= upper) & (slope >= lower))
    return first + 1 + int(fits[-1])
