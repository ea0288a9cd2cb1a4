"""What the motion of a log cannot tell: one direction, one speed, the same motion again, less than the encoder sees."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bristle.core.axis import Axis
from bristle.core.diagnostic import Diagnostic
from bristle.logs.check.rows import Rows
from bristle.logs.check.thresholds import CheckThresholds
from bristle.logs.log_data import LogData
from bristle.logs.repetition import repeats_after
from bristle.logs.segmentation import turning_points

__all__ = ["about_motion", "about_sliding", "lesser_way", "speeds_of", "ways_of"]

SLOW = 0.01  # of the largest speed: below, the axis creeps into its place
STEADY = 0.1  # of the largest acceleration but for one row in a hundred
POINTS = 4000  # of a position that may repeat itself
TREMBLE = 2.5  # encoder steps that are no way


def about_motion(
    log: LogData, rows: Rows, resolution: float, settings: CheckThresholds
) -> Iterator[Diagnostic]:  # fmt: skip
    """Yield what a motion does not tell, whatever is fitted."""
    ways = ways_of(log, resolution)
    between = np.abs(np.concatenate([part[1:-1] for part in ways]))
    way = float(np.median(between)) if between.size else float(np.ptp(log.position.values))
    if way < settings.steps_of_motion * resolution:
        yield Diagnostic("below_resolution", "", "warning", {"way": way, "resolution": resolution}, log.kind)
        return
    share, forward = lesser_way(np.concatenate(ways))
    if share < settings.one_way:
        numbers = {"percent": 100.0 * share, "direction": "forward" if forward else "backward"}
        yield Diagnostic("one_direction", "", "warning", numbers, log.kind)
    steady, slow, fast = speeds_of(rows)
    if steady >= settings.steady_share and fast < settings.one_speed * slow:
        yield Diagnostic("one_speed", "", "warning", {"slowest": slow, "fastest": fast}, log.kind)
    position = max((log.position.values[segment] for segment in log.segments), key=len)
    step = max(position.size // POINTS, 1)
    period = repeats_after(position[::step], step * log.sample_time, settings)
    if period is not None:
        yield Diagnostic("repeats_one_motion", "", "note", {"period": period}, log.kind)


def about_sliding(log: LogData, axis: Axis, share: float, settings: CheckThresholds) -> Iterator[Diagnostic]:
    """Yield where the effort follows the position as that of a spring, and gives back the work that it did.

    `share` is the work that stays in the axis over closed motion, as a share of what friction would keep.
    """
    if log.effort is None or axis.plant != "inertia" or not 0.0 < abs(share) < settings.kept_work:
        return
    x, u = (one.values - np.mean(one.values) for one in (log.position, log.effort))
    size = float(np.linalg.norm(x) * np.linalg.norm(u))
    likeness = float(x @ u) / size if size > 0.0 else 0.0
    if likeness > settings.spring_likeness:
        numbers = {"correlation": likeness, "percent": 100.0 * share, "reach": 0.5 * float(np.ptp(log.position.values))}
        yield Diagnostic("never_slides", "", "warning", numbers, log.kind)


def lesser_way(ways: np.ndarray) -> tuple[float, bool]:
    """Return the share of all ways that goes in the lesser direction, and whether the other one is forward."""
    ahead, back = float(ways[ways > 0.0].sum()), -float(ways[ways < 0.0].sum())
    return min(ahead, back) / max(ahead + back, np.finfo(float).tiny), ahead >= back


def speeds_of(rows: Rows) -> tuple[float, float, float]:
    """Return the share of sliding rows at a steady speed, and the 10 % and 90 % quantiles of those speeds."""
    speed = np.abs(rows.velocity)
    slid = rows.of(speed > SLOW * speed.max(initial=0.0))
    if not slid.velocity.size:
        return 0.0, 0.0, 0.0
    steady = np.abs(slid.acceleration) < STEADY * np.quantile(np.abs(rows.acceleration), 0.99)
    if not steady.any():
        return 0.0, 0.0, 0.0
    slow, fast = np.quantile(np.abs(slid.velocity[steady]), [0.1, 0.9]).tolist()
    return float(np.mean(steady)), slow, fast


def ways_of(log: LogData, resolution: float) -> list[np.ndarray]:
    """Return of each segment how far the axis goes [m or rad], shape (way,): to its first turn, and from turn to turn.

    The last one goes from the last turn to the end.
    """
    ways = []
    for segment in log.segments:
        x = log.position.values[segment]
        turns = turning_points(x, max(TREMBLE * resolution, 1e-3 * float(np.ptp(x))))
        ways.append(np.diff(x[[0, *turns, x.size - 1]]))
    return ways
