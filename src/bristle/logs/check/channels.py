"""What a recording did to its channels: an effort cut off or bent, lost rows, a velocity of another motion."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.diagnostic import Diagnostic
from bristle.core.least_squares import unbounded
from bristle.logs.channel import LogData
from bristle.logs.check.gears import gears_near
from bristle.logs.check.pile import piled_up
from bristle.logs.check.rows import Rows
from bristle.logs.check.thresholds import CheckThresholds
from bristle.logs.checks import clipped

__all__ = ["about_effort", "about_rows", "about_velocity", "lost_in"]

SHORTEST = 120  # steps of a segment that is looked at
SPEEDS = 0.05  # of the largest: what a recorded velocity must tell apart to be compared
A_ROW = 1.8  # times the steps around it that a step over a missing row is; less is a sample that was late
NEAR_ZERO = 0.02  # of the largest effort
VISITS = 8  # of an effort to zero
SHORT_VISITS = 0.2  # of the log
FEWEST = 50  # rows to compare
MOVED = 100.0  # encoder steps of the range from which the position tells a velocity
USUAL = 0.95  # quantile of how steps differ from those around them
SELDOM = 0.001  # of the steps: what stands out more often is how this axis moves, unless it is always the same
ALIKE = 0.1  # relative, by which the jumps of one counter differ


def about_effort(log: LogData, rows: Rows, axis: Axis, resolution: float, settings: CheckThresholds) -> Iterator[Diagnostic]:
    """Yield where an effort is cut off, or has lost its sign."""
    assert log.effort is not None
    law = axis.controller.values if isinstance(axis.controller, Model) else {}
    run = int(settings.clipped_samples)
    # The controller bounds its own part: known inputs are added behind its limit.
    own = clipped(log.effort.values - log.injected_effort, law.get("limit"), run) if log.injected else None
    cut = own or clipped(log.effort.values, axis.effort_limit or law.get("limit"), run)
    cut = cut or piled_up(log, rows, resolution, settings)
    if _unsigned(log):
        numbers = {"largest": float(np.max(np.abs(log.effort.values)))}
        yield Diagnostic("effort_unsigned", "", "error", numbers, log.kind)
    if cut is not None:
        numbers = {"level": cut.level, "samples": cut.longest, "all": cut.samples, "time": float(log.time.values[cut.first])}
        yield Diagnostic("clipped", "", "warning", numbers, log.kind)


def about_velocity(log: LogData, rows: Rows, axis: Axis, resolution: float, settings: CheckThresholds) -> Iterator[Diagnostic]:
    """Yield where a recorded velocity is not that of the position: its size, its shape, its delay."""
    speed = np.abs(rows.velocity)
    moved = rows.of(speed > SPEEDS * speed.max(initial=0.0))
    moves = float(np.ptp(log.position.values)) > MOVED * resolution
    if not rows.recorded.size or not moves or moved.velocity.size < FEWEST:
        return
    v, recorded = moved.velocity, moved.recorded
    size = float(np.linalg.norm(v) * np.linalg.norm(recorded))
    likeness = float(v @ recorded) / size if size > 0.0 else 0.0
    # A velocity that is late by a time is less by that time of the acceleration.
    scale, late = unbounded(np.column_stack([v, -moved.acceleration]), recorded).tolist()
    alike = likeness >= settings.velocity_likeness
    of_size = alike and abs(scale - 1.0) <= settings.velocity_scale
    delay = late / scale if of_size else 0.0
    if of_size and abs(delay) <= settings.velocity_delay:
        return
    numbers = {"ratio": scale, "correlation": likeness, "delay": delay}
    yield Diagnostic("velocity_contradicts", "", "warning", numbers, log.kind)
    if alike and abs(scale - 1.0) > settings.velocity_scale:
        yield from gears_near(scale, "velocity", axis, settings)


def about_rows(log: LogData, starts: np.ndarray) -> Iterator[Diagnostic]:
    """Yield where rows are missing, behind the samples `starts`, though the stamps go on."""
    if starts.size:
        numbers = {
            "places": int(starts.size),
            "time": float(log.time.values[starts[0]]),
            "step": float(np.max(np.abs(log.position.values[starts + 1] - log.position.values[starts]))),
        }
        yield Diagnostic("rows_lost", "", "warning", numbers, log.kind)


def lost_in(log: LogData, resolution: float, factor: float) -> np.ndarray:
    """Return the samples before steps of the position that the velocity around does not explain, shape (place,).

    A step stands out where it differs from the steps next to it by far more than those do among themselves, and by
    more than the whole log does elsewhere.
    """
    places = []
    for segment in log.segments:
        x = log.position.values[segment]
        steps = np.diff(x)
        if steps.size < SHORTEST:
            continue
        beside = np.stack([steps[:-4], steps[1:-3], steps[3:-1], steps[4:]])
        inner, around, spread = steps[2:-2], beside.mean(axis=0), np.ptp(beside, axis=0)
        out = np.abs(inner - around)
        usual = float(np.quantile(out, USUAL))
        far = (out > factor * np.maximum(spread, max(usual, resolution))) & (np.abs(inner) > A_ROW * np.abs(around))
        at = np.flatnonzero(far)
        if at.size and (at.size < SELDOM * steps.size + 3 or _alike(out[at])):
            places.append(at + 2 + (segment.start or 0))
    return np.concatenate(places) if places else np.empty(0, dtype=int)


def _unsigned(log: LogData) -> bool:
    """Return whether an effort turns back at zero again and again, as a magnitude does, and never crosses it."""
    assert log.effort is not None
    values = log.effort.values
    size = np.abs(values)
    if values.min() < 0.0 < values.max() or not size.any():
        return False
    # An effort that stays at zero is that of a drive that is off.
    near = size < NEAR_ZERO * float(np.quantile(size, USUAL))
    return int(np.sum(np.diff(near.astype(np.int8)) == 1)) >= VISITS and float(np.mean(near)) < SHORT_VISITS


def _alike(jumps: np.ndarray) -> bool:
    """Return whether jumps are of one size, as those of a counter that starts anew."""
    return bool(np.ptp(jumps) < ALIKE * np.median(jumps))
