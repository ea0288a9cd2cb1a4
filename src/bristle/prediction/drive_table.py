"""The friction of a fit in the form of a drive: a table of velocity and effort, or levels."""

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bristle.core import (
    DEVIATION_OVER_MEDIAN,
    NORMAL_95,
    Axis,
    InputError,
    Model,
    Motion,
    guarded,
    instance,
    whole,
)
from bristle.engine.checks import finite
from bristle.engine.contact import steady_force
from bristle.identification.dataset import transmitted_by
from bristle.identification.parameters import Role, name_of, offset_of
from bristle.identification.result import Fit
from bristle.logs.check import parted
from bristle.logs.log import Log
from bristle.models.friction import unvaried
from bristle.prediction.predict import rows_as_fitted

FINE = 300  # points of the steady curve on each side, for figures
COARSE = 48  # points on each side before refinement
FINEST = 800  # points on each side at most
SLOWEST = 1e-9  # of the largest speed: treated as rest
DRAWS = 32  # for the band of the steady curve
REMEMBERED = 16  # cached curves and distances: a report uses each several times
BETWEEN = 0.4  # of the interval: not the middle, because that of an S lies on its chord
SETTLED_SHARE = 0.95  # of the change after a reversal
WAY = np.geomspace(1e-9, 1e-1, 160)  # after a reversal [m or rad]


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
        Velocity [m/s or rad/s], ascending, and the force to feed forward [N or N*m], including the offset, without inertia.
        The table covers the velocities of the log, in both directions if the log has both. Straight lines between the
        entries follow the steady friction as closely as possible, except where it falls with speed: there the table has the
        least later friction (`without_fall`). The table is shorter if fewer entries suffice.
        Zero speed has two entries, -0.0 and +0.0, one per direction. The table is empty for a plant on a spring and for a
        force that hardens without bound, which have no steady motion, and for a log without sliding (`Fit.never_slid`).

    Raises
    ------
    InputError
        If `entries` is out of range.
    """
    sides = [(way, without_fall(side)) for way, side, _ in _branches(fit)]
    rows = [(way, side[placed(side, entries // len(sides))]) for way, side in sides]
    return [point for way, side in rows for point in _ascending(way, side).tolist()]


class LevelValues(NamedTuple):
    r"""The friction of a drive with one level for each direction, viscous friction and a constant force.

    .. math:: u = M a + F_\text{constant} + \begin{cases} F_+ + D_+ v & v > 0 \\ -F_- + D_- v & v < 0 \end{cases}

    At every speed of the log, a level with its viscous part is at most the steady friction: it never overcompensates.
    """

    inertia: float
    constant: float
    forward: float | None
    backward: float | None
    viscous_forward: float | None
    viscous_backward: float | None
    deviation: float
    deviation_of_levels: float


@guarded(fit=instance(Fit, "a model that was identified"))
def level_values(fit: Fit) -> LevelValues | None:
    """Return the friction of a fit as one level and one viscous coefficient for each direction."""
    sides = {direction: along for direction, along, _ in _branches(fit)}
    if sides:
        return levels_of(fit.plant, fit.friction, sides)
    return None


def levels_of(
    plant: Model | None, friction: Model, sides: Mapping[float, np.ndarray]
) -> LevelValues:
    """Return the friction as a level and a viscous coefficient for each direction, never above the steady friction."""
    constant = offset_of(friction.component.variables, friction.values)
    lines = {way: _line_below(side) for way, side in sides.items()}
    level = {way: line.level - way * constant for way, line in lines.items()}
    viscous = {way: line.slope for way, line in lines.items()}
    mass = 0.0
    if plant is not None:
        inertia = name_of(Role.INERTIA, plant.component.variables)
        if inertia:
            mass = plant.values[inertia]
    return LevelValues(
        mass,
        constant,
        level.get(1.0),
        level.get(-1.0),
        viscous.get(1.0),
        viscous.get(-1.0),
        max(line.deviation for line in lines.values()),
        max(line.deviation_of_level for line in lines.values()),
    )


class _Line(NamedTuple):
    """A straight line below a curve of steady friction: its start, its slope, and its largest deviation."""

    level: float
    slope: float
    deviation: float
    deviation_of_level: float


def _line_below(side: np.ndarray) -> _Line:
    """Return the line with the least-squares slope over the speeds, at least 0, that touches a curve from below."""
    speed, force = side.T
    weight = np.gradient(speed)  # points are dense near rest
    apart = speed - np.average(speed, weights=weight)
    slope = max(0.0, float((weight * apart) @ force / ((weight * apart) @ apart)))
    level = float(np.min(force - slope * speed))
    return _Line(
        level, slope, float(np.max(force - slope * speed)) - level, float(np.max(force)) - level
    )


def without_fall(curve: np.ndarray) -> np.ndarray:
    """Return the largest curve that is nowhere above a curve of steady friction and never falls with speed.

    A table without memory that feeds forward a peak near rest pushes an axis that has not broken away, or stands, with more
    force than its friction: the controller alone then limits the motion.
    """
    return np.column_stack([curve[:, 0], np.minimum.accumulate(curve[::-1, 1])[::-1]])


def steady_curve(fit: Fit, *, band: bool = False) -> list[tuple[float, float]]:
    """Return the steady friction force over velocity, as `drive_table`, with many points, dense near zero.

    With `band`, the half-width of its 95 % band over velocity; empty without draws.
    """
    if not band:
        return [(velocity, force) for side in _sides(fit) for velocity, force in side.tolist()]
    if fit.resampling is None:
        return []
    models = fit.resampling.bands.models(fit.friction, DRAWS)
    if len(models) < 2:
        return []
    halves: list[tuple[float, float]] = []
    for direction, side, ascending in _branches(fit):
        speeds = side[-1, 0] * np.geomspace(1e-6, 1.0, COARSE // 2)
        own, *drawn = (
            [_or_infinite(model, direction * v) for v in speeds.tolist()]
            for model in (fit.friction, *models)
        )
        spread = (
            NORMAL_95 * DEVIATION_OVER_MEDIAN * np.median(np.abs(np.subtract(drawn, own)), axis=0)
        )
        if not np.all(np.isfinite(spread)):  # half of the draws harden without bound
            return []
        velocities = ascending[:, 0]
        halves += zip(
            velocities.tolist(), np.interp(np.abs(velocities), speeds, spread).tolist(), strict=True
        )
    return halves


def _or_infinite(model: Model, v: float) -> float:
    """Return the steady friction force [N or N*m], infinite if it grows without bound."""
    try:
        return steady_force(model, v)
    except InputError:
        return math.inf


def largest_deviation(fit: Fit, table: Sequence[tuple[float, float]]) -> float:
    """Return the largest deviation of a table, joined by straight lines, from the steady friction [N or N*m]."""
    entries = np.array(list(table), dtype=float)
    deviation = 0.0
    for side in _sides(fit):
        own = entries[np.signbit(entries[:, 0]) == np.signbit(side[0, 0])]
        if own.size:
            deviation = max(
                deviation,
                float(np.max(np.abs(np.interp(side[:, 0], own[:, 0], own[:, 1]) - side[:, 1]))),
            )
    return deviation


def _sides(fit: Fit) -> list[np.ndarray]:
    """Return the steady friction in each direction, shape (point, 2), velocity ascending."""
    return [side for _, _, side in _branches(fit)]


def _branches(fit: Fit) -> list[tuple[float, np.ndarray, np.ndarray]]:
    """Return each direction of the log, the steady friction along it, and the same over ascending velocity."""
    if fit.plant.values.get("k") or fit.never_slid:
        return []
    lowest = float(np.min(fit.traces.velocity))
    highest = float(np.max(fit.traces.velocity))
    tops = []
    if lowest < 0.0:
        tops.append((-1.0, -lowest))
    if highest > 0.0:
        tops.append((1.0, highest))
    try:
        sides = [
            (direction, steady_side(fit.friction, direction, top, FINE)) for direction, top in tops
        ]
    except InputError:  # the force hardens without bound
        return []
    return [(direction, side, _ascending(direction, side)) for direction, side in sides]


def _ascending(direction: float, side: np.ndarray) -> np.ndarray:
    """Return speeds and forces along a direction as velocities, ascending, and forces."""
    if direction > 0.0:
        return side
    return -side[::-1]


@lru_cache(maxsize=REMEMBERED)
def steady_side(model: Model, direction: float, fastest: float, fine: int) -> np.ndarray:
    """Return speed, ascending from 0, and the force along the motion, dense near rest; shape (point, 2)."""
    speeds = np.union1d(
        fastest * np.geomspace(1e-6, 1.0, fine // 2), np.linspace(0.0, fastest, fine // 2)
    )
    forces = [
        direction * steady_force(model, direction * max(v, SLOWEST * fastest))
        for v in speeds.tolist()
    ]
    curve = np.column_stack([speeds, forces])
    curve.setflags(write=False)
    return curve


@lru_cache(maxsize=REMEMBERED)
def resolved_side(model: Model, direction: float, fastest: float) -> tuple[np.ndarray, float]:
    """Return `steady_side`, refined until straight lines follow it, and their largest deviation."""
    forces = dict(steady_side(model, direction, fastest, COARSE).tolist())
    # Allowed deviation of a point from the line between its neighbours, over the largest force.
    allowed = 2e-5 * max(map(abs, forces.values()))
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
    """Return at most `count` points of a curve, both ends included, between which straight lines deviate least, by bisection."""
    low = 1e-6 * float(np.max(np.abs(curve[:, 1])))  # a smaller deviation counts as zero
    high = float(np.ptp(curve[:, 1]))
    best = _reached(curve, low, count)
    if best is not None:
        return best
    best = [0, len(curve) - 1]
    for _ in range(40):
        allowed = 0.5 * (low + high)
        corners = _reached(curve, allowed, count)
        if corners is None:
            low = allowed
        else:
            high = allowed
            best = corners
    return best


def _reached(curve: np.ndarray, allowed: float, count: int) -> list[int] | None:
    """Return the points, each the last within the allowed deviation of a straight line; None if there are too many."""
    corners = [0]
    while corners[-1] < len(curve) - 1:
        if len(corners) == count:
            return None
        run, rise = (curve[corners[-1] + 1 :] - curve[corners[-1]]).T
        # Each point limits the slopes of all lines that go beyond it.
        upper = np.minimum.accumulate((rise + allowed) / run)
        lower = np.maximum.accumulate((rise - allowed) / run)
        slope = rise / run
        corners.append(
            corners[-1] + 1 + int(np.flatnonzero((slope <= upper) & (slope >= lower))[-1])
        )
    return corners


@lru_cache(maxsize=REMEMBERED)
def reversal_distance(model: Model, fastest: float) -> float:
    """Return the distance after a reversal over which the force makes 95 % of its change [m or rad]."""
    component = model.component
    p = unvaried(model).parameters
    speed = 1e-3 * fastest
    state = component.initial_state(p)
    memory = component.new_memory(p)
    way = np.diff(WAY, prepend=0.0).tolist()
    x = 0.0
    before = 0.0
    forces: list[float] = []
    # A force that grows without bound has no such distance.
    with np.errstate(over="ignore", invalid="ignore"):
        for direction in (-1.0, 1.0):
            if forces:
                before = forces[-1]
            forces = []
            for pace in way:
                x += direction * pace
                force, move = component.trial(
                    state, memory, Motion(direction * speed, x), pace / speed, p
                )
                state = component.commit(state, memory, move, p)
                forces.append(force)
        change = np.array(forces) - before
    enough = SETTLED_SHARE * change[-1]
    first = int(np.argmax(change >= enough))
    if first > 0:
        return float(np.interp(enough, change[first - 1 : first + 1], WAY[first - 1 : first + 1]))
    return 0.0


def table_error(
    friction: Model,
    plant: Model | None,
    log: Log,
    axis: Axis | None,
    sides: Mapping[float, np.ndarray],
    treatment: Mapping[str, float],
) -> tuple[float, float]:
    """Return the largest and the rms error of a table along the motion of a log, treated as in identification [N or N*m]."""
    if friction.kind != log.kind:
        raise InputError(
            "is not of the same kind of axis as the table",
            path="log",
            value=log.kind,
            allowed=friction.kind,
            mend="Give the axis file of this log",
        )
    if log.effort is None:
        raise InputError(
            "has no effort", path="log", mend="Name the column of the effort in the axis file"
        )
    rows = rows_as_fitted(parted(log, axis), axis, treatment)
    gaps = []
    for segment, contact in zip(rows.segments, rows.contacts(friction, plant), strict=True):
        force = segment.friction(
            friction, rows.sample_time, contact, transmitted_by(friction, plant, segment)
        )
        speed = np.abs(segment.velocity)
        forward, backward = (
            np.interp(speed, sides[way][:, 0], sides[way][:, 1]) for way in (1.0, -1.0)
        )
        # At rest, the table gives the force of the last direction of motion.
        gaps.append(
            rows.without_edges(force - np.where(np.signbit(segment.velocity), -backward, forward))
        )
    gap = finite(np.concatenate(gaps), friction, "friction")
    return float(np.max(np.abs(gap))), float(np.sqrt(np.mean(gap**2)))
