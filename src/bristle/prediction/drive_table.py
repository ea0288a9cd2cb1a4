"""The friction as a drive takes it: a table of velocity and effort."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bristle.core.edge import guarded, instance, whole
from bristle.engine.steady import steady_force
from bristle.identification.result import Fit
from bristle.identification.roles import Role, name_of, offset_of

__all__ = ["LevelValues", "drive_table", "largest_deviation", "level_values", "placed", "steady_curve"]

FINE = 300  # points of the steady curve on each side
NEAREST = 1e-6  # of the largest speed: the first of these points
HALVINGS = 40
STRAIGHT = 1e-6  # of the largest force: a deviation that is none


@guarded(fit=instance(Fit, "a model that was identified"), entries=whole(4, 1000))
def drive_table(fit: Fit, entries: int = 20) -> list[tuple[float, float]]:
    """Return the steady friction force over velocity, for the friction compensation of a drive.

    Parameters
    ----------
    fit : Fit
        An identified model.
    entries : int
        Number of entries at most, 4 to 1000.

    Returns
    -------
    list of (float, float)
        Velocity [m/s or rad/s], ascending, and the force to be fed forward [N or N*m], offset included, inertia not.
        The table covers the velocities of the log, in both directions if the log has both. The entries lie where
        straight lines between them stay closest to the steady friction; where fewer do that as well, there are fewer.
        At standstill it has two entries, -0.0 and +0.0: the limits from either side. Empty for a plant on a spring,
        which does not move on steadily.

    Raises
    ------
    InputError
        If `entries` is out of range.
    """
    sides = _sides(fit)
    return [point for side in sides for point in side[placed(side, entries // len(sides))].tolist()]


class LevelValues(NamedTuple):
    r"""The friction of a drive that takes one level for each direction and a constant force.

    .. math:: u = M a + F_\text{constant} + \begin{cases} F_+ & v > 0 \\ -F_- & v < 0 \end{cases}

    Parameters
    ----------
    inertia : float
        Moving mass [kg or kg*m^2].
    constant : float
        Gravity or bias [N or N*m].
    forward, backward : float or None
        Levels F+ and F- [N or N*m]; None for a direction that the log does not have.
    deviation : float
        How far these levels are from the steady friction at most, over the speeds of the log [N or N*m].
    """

    inertia: float
    constant: float
    forward: float | None
    backward: float | None
    deviation: float


@guarded(fit=instance(Fit, "a model that was identified"))
def level_values(fit: Fit) -> LevelValues | None:
    """Return the friction as one level for each direction: the middle of the steady friction at the speeds of a log.

    Parameters
    ----------
    fit : Fit
        An identified model.

    Returns
    -------
    LevelValues or None
        None for a plant on a spring, which does not move on steadily.
    """
    sides = {bool(np.signbit(side[0, 0])): side[:, 1] for side in _sides(fit)}
    if not sides:
        return None
    variables, values = fit.friction.component.variables, fit.friction.values
    constant = offset_of(variables, values)
    middle = {back: 0.5 * float(force.min() + force.max()) for back, force in sides.items()}
    deviation = max(0.5 * float(np.ptp(force)) for force in sides.values())
    inertia = name_of(Role.INERTIA, fit.plant.component.variables)
    return LevelValues(
        fit.plant.values[inertia] if inertia else 0.0, constant,
        middle[False] - constant if False in middle else None, constant - middle[True] if True in middle else None,
        deviation,
    )  # fmt: skip


def steady_curve(fit: Fit) -> list[tuple[float, float]]:
    """Return the steady friction force over velocity, as `drive_table` does, with many points and dense near zero."""
    return [(velocity, force) for side in _sides(fit) for velocity, force in side.tolist()]


def largest_deviation(fit: Fit, table: Sequence[tuple[float, float]]) -> float:
    """Return how far a table, joined by straight lines, is from the steady friction at most [N or N*m].

    Parameters
    ----------
    fit : Fit
        An identified model.
    table : sequence of (velocity, force)
        Ascending, with -0.0 before +0.0 where it has both.
    """
    entries = np.array(list(table), dtype=float)
    deviations = [0.0]
    for side in _sides(fit):
        own = entries[np.signbit(entries[:, 0]) == np.signbit(side[0, 0])]
        if own.size:
            deviations.append(float(np.max(np.abs(np.interp(side[:, 0], own[:, 0], own[:, 1]) - side[:, 1]))))
    return max(deviations)


def _sides(fit: Fit) -> list[np.ndarray]:
    """Return the steady friction on each side of standstill, shape (point, 2), velocity ascending."""
    if fit.plant.values.get("k"):
        return []
    lowest, highest = float(np.min(fit.traces.velocity)), float(np.max(fit.traces.velocity))
    sides = [(-1.0, -lowest)] * (lowest < 0.0) + [(1.0, highest)] * (highest > 0.0)
    branches = []
    for side, top in sides:
        speeds = np.union1d(top * np.geomspace(NEAREST, 1.0, FINE // 2), np.linspace(0.0, top, FINE // 2))
        curve = [
            (math.copysign(speed, side), steady_force(fit.friction, math.copysign(max(speed, 1e-9 * top), side)))
            for speed in speeds.tolist()
        ]
        branches.append(np.array(curve if side > 0.0 else curve[::-1]))
    return branches


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
