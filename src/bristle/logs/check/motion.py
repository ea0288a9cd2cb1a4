"""What the motion of a log cannot tell: one direction, one speed, the same motion again, less than the encoder sees."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bristle.core.axis import Axis
from bristle.core.diagnostic import Diagnostic
from bristle.logs.channel import LogData
from bristle.logs.check.rows import Line, Rows
from bristle.logs.check.thresholds import CheckThresholds
from bristle.logs.legs import graininess
from bristle.logs.turns import period_of, turning_points

__all__ = ["about_motion", "about_sliding", "lesser_way", "speeds_of", "ways_of"]

PARTS = 20  # of a way, in which its speed is looked at
FAST, WAITS = 0.8, 0.05  # quantile of them that a cruise has; of that, the speed of an axis that waits
CRUISING = 0.08  # of the speed: what counts as constant; a sine keeps to it for a third of its way
MOST_PARTS = 0.6  # of a way that is steady
POINTS = 4000  # of a position that may repeat itself
MOST_KEPT, PULLED = 0.5, 0.9  # of work and of likeness: a wide loop that leans as a spring does
WITHIN = 0.25  # of the longest way, over which the friction of such a loop builds up
AT_ONCE = 0.5  # of friction: less right behind a reversal is a contact that has not slid
CLEAR = 2.0  # standard errors by which it must be less


def about_motion(log: LogData, resolution: float, settings: CheckThresholds) -> Iterator[Diagnostic]:
    """Yield what a motion does not tell, whatever is fitted."""
    ways = ways_of(log, resolution)
    between = np.abs(np.concatenate([part[1:-1] for part in ways]))
    way = float(np.median(between)) if between.size else float(np.ptp(log.position.values))
    if way < settings.steps_of_motion * resolution:
        yield Diagnostic("below_resolution", "", "warning", {"way": way, "resolution": resolution}, log.kind)
        return
    share, forward = lesser_way(np.concatenate(ways))
    if share < settings.one_way:
        numbers = {"percent": max(100.0 * share, 0.0), "direction": "forward" if forward else "backward"}
        yield Diagnostic("one_direction", "", "warning", numbers, log.kind)
    steady, slow, fast = speeds_of(log, resolution)
    if steady >= settings.steady_share and fast < settings.one_speed * slow:
        yield Diagnostic("one_speed", "", "warning", {"slowest": slow, "fastest": fast}, log.kind)
    position = max((log.position.values[segment] for segment in log.segments), key=len)
    step = max(position.size // POINTS, 1)
    period = period_of(position[::step], step * log.sample_time, settings.repeated, settings.repeated_periods)
    if period is not None:
        yield Diagnostic("repeats_one_motion", "", "note", {"period": period}, log.kind)


def about_sliding(log: LogData, rows: Rows, axis: Axis, share: float, resolution: float, settings: CheckThresholds) -> Iterator[Diagnostic]:
    """Yield where the effort follows the position as that of a spring, and gives back the work that it did.

    `share` is the work that stays in the axis over closed motion, as a share of what friction would keep.
    """
    if log.effort is None or axis.plant != "inertia" or not 0.0 < abs(share) < max(settings.kept_work, MOST_KEPT):
        return
    x, u = (one.values - np.mean(one.values) for one in (log.position, log.effort))
    size = float(np.linalg.norm(x) * np.linalg.norm(u))
    likeness = float(x @ u) / size if size > 0.0 else 0.0
    narrow = abs(share) < settings.kept_work and likeness > settings.spring_likeness
    if narrow or (likeness > max(settings.spring_likeness, PULLED) and _builds_up(rows, resolution)):
        numbers = {"correlation": likeness, "percent": 100.0 * share, "reach": 0.5 * float(np.ptp(log.position.values))}
        yield Diagnostic("never_slides", "", "warning", numbers, log.kind)


def _builds_up(rows: Rows, resolution: float) -> bool:
    """Return whether friction builds up over the ways of a log, rather than to turn at once beside a spring.

    Loops before sliding may be as wide as those of an axis that slides and is pulled back. What such an axis is pulled
    by depends on the place; its friction is there right behind each reversal.
    """
    x = rows.position
    if x.size < PARTS:
        return False
    turns = _turns(x, resolution)
    way = np.minimum(np.searchsorted(turns, np.arange(x.size), side="right"), turns.size - 1)
    ways = x[turns[way]] - x[turns[way - 1]]
    longest = float(np.abs(ways).max())
    if longest == 0.0:
        return False
    side, place, behind = np.sign(ways), (x - x.mean()) / np.ptp(x), np.abs(x - x[turns[way - 1]])
    lacking = -side * np.exp(-behind / (WITHIN * longest))
    columns = (np.ones_like(x), place, place**2, place**3, rows.velocity, rows.acceleration, side, lacking)
    line = Line.through(np.column_stack(columns), rows.effort)
    if line is None:
        return False
    level, missing, error = float(line.coefficients[-2]), float(line.coefficients[-1]), float(line.deviations[-1])
    return level > 0.0 and missing - CLEAR * error > AT_ONCE * level


def lesser_way(ways: np.ndarray) -> tuple[float, bool]:
    """Return the share of all ways that goes in the lesser direction, and whether the other one is forward."""
    ahead, back = float(ways[ways > 0.0].sum()), -float(ways[ways < 0.0].sum())
    return min(ahead, back) / max(ahead + back, np.finfo(float).tiny), ahead >= back


def speeds_of(log: LogData, resolution: float) -> tuple[float, float, float]:
    """Return the share of the way at a steady speed, and the 10 % and 90 % quantiles of those speeds over the way.

    A way is steady where most of its parts are as fast as the fastest of them; those in which the axis waits tell
    nothing.
    """
    every, steady = [np.zeros(1)], [np.empty((2, 0))]
    for segment in log.segments:
        x = log.position.values[segment]
        ends = _turns(x, resolution)
        marks = np.linspace(ends[:-1], ends[1:], PARTS + 1).astype(int)
        marks = marks[:, np.diff(ends) >= PARTS]
        times = log.sample_time * np.diff(marks, axis=0)
        speeds = np.abs(np.diff(x[marks], axis=0)) / times
        top = np.quantile(speeds, FAST, axis=0)
        goes = speeds > WAITS * top
        cruises = goes & (np.abs(speeds - top) <= CRUISING * top + 2.0 * graininess(x, resolution) / times)
        way = np.abs(np.diff(x[marks[[0, -1]]], axis=0))[0]
        chosen = cruises.sum(axis=0) >= MOST_PARTS * goes.sum(axis=0)
        every.append(way)
        steady.append(np.stack([way, top])[:, chosen & (top > 0.0)])
    ways, tops = np.concatenate(steady, axis=1)
    if not ways.size:
        return 0.0, 0.0, 0.0
    order = np.argsort(tops)
    below = np.cumsum(ways[order]) / ways.sum()
    slow, fast = (float(tops[order][np.searchsorted(below, share)]) for share in (0.1, 0.9))
    return float(ways.sum() / np.concatenate(every).sum()), slow, fast


def _turns(position: np.ndarray, resolution: float) -> np.ndarray:
    """Return the first sample, those at which the motion turns, and the last, shape (turn,)."""
    turns = turning_points(position, max(graininess(position, resolution), 1e-3 * float(np.ptp(position))))
    return np.array([0, *turns, position.size - 1])


def ways_of(log: LogData, resolution: float) -> list[np.ndarray]:
    """Return of each segment how far the axis goes [m or rad], shape (way,): to its first turn, and from turn to turn.

    The last one goes from the last turn to the end.
    """
    ways = []
    for segment in log.segments:
        x = log.position.values[segment]
        ways.append(np.diff(x[_turns(x, resolution)]))
    return ways
