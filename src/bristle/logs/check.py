"""A look at a log before anything is fitted to it: what it contradicts, and what it cannot tell. One table of rules."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple, TypeVar

import numpy as np

from bristle.core import units
from bristle.core.axis import Axis
from bristle.core.diagnostic import Diagnostic, Number, Severity
from bristle.core.edge import guarded, instance, optional
from bristle.logs.channel import LogData, clear_step
from bristle.logs.legs import CHUNKS, CRUISING, FAST, graininess
from bristle.logs.lines import Line, lost_in
from bristle.logs.look import DEFAULT, CheckThresholds, Look, likeness_of
from bristle.logs.names import plain_unit
from bristle.logs.turns import period_of
from bristle.logs.words import other_unit_in

__all__ = ["RECORDED", "CheckThresholds", "checked", "parted"]

Numbers = dict[str, Number]
AnyLog = TypeVar("AnyLog", bound=LogData)

SHORTEST_PART = 10  # samples of a stretch between lost rows
ALMOST_ALL = 0.999  # of the rows: faster ones may be noise
OTHER_STEP = 5.0  # times the resolution: counts of a quadrature encoder differ by 2 and 4
MOST_KEPT, PULLED = 0.5, 0.9  # of work and of likeness: a wide loop that leans as a spring does
WITHIN = 0.25  # of the longest way, over which the friction of such a loop builds up
AT_ONCE = 0.5  # of friction: less right behind a reversal is a contact that has not slid
CLEAR = 2.0  # standard errors by which it must be less
WAITS = 0.05  # of the speed of a cruise: that of an axis that waits
STEADY = 0.6  # of the parts of a way
POINTS = 4000  # of a position that may repeat itself
PAIRS = (
    ("2", "1/2", 2.0),
    ("pi", "1/pi", np.pi),
    ("2 pi", "1/(2 pi)", 2.0 * np.pi),
    ("60", "1/60", 60.0),
    ("30/pi", "pi/30", 30.0 / np.pi),
    ("180/pi", "pi/180", 180.0 / np.pi),
    ("1000", "1/1000", 1000.0),
)
GEARS = {name: value for ahead, back, ratio in PAIRS for name, value in ((ahead, ratio), (back, 1.0 / ratio))}
"""Ratios that gears, leads and units have, when two numbers that should be one differ by such a factor."""


def _rows_lost(look: Look) -> Numbers | None:
    lost, x = look.lost, look.log.position.values
    if not lost.size:
        return None
    step = float(np.max(np.abs(x[lost + 1] - x[lost])))
    return {"places": int(lost.size), "time": float(look.log.time.values[lost[0]]), "step": step}


def _sign_reversed(look: Look) -> Numbers | None:
    return {"percent": -100.0 * look.share} if look.share < -look.settings.reversed_work else None


def _clock_suspect(look: Look) -> Numbers | None:
    named, dt, settings = _named_otherwise("time", ("s",), look.axis), look.log.sample_time, look.settings
    if named is None and settings.shortest_sample <= dt <= settings.longest_sample:
        return None
    return {"sample_time": dt} | (named or {"column": look.log.time.column, "declared": "", "called": ""})


def _unit_suspect(look: Look) -> Numbers | None:
    named, settings, speeds = _named_otherwise("position", ("m", "rad"), look.axis), look.settings, np.abs(look.rows.velocity)
    speed = float(np.quantile(speeds, ALMOST_ALL)) if speeds.size else 0.0
    most = settings.fastest if look.log.kind == "translational" else settings.fastest_turning
    if named is None and (speed <= most or look.log.sample_time < settings.shortest_sample):
        return None
    return {"speed": speed} | (named or {"column": look.log.position.column, "declared": "", "called": ""})


def _named_otherwise(channel: str, bases: tuple[str, ...], axis: Axis) -> Numbers | None:
    """Return a column, its declared unit and the one in its name, where these differ."""
    column = axis.columns.get(channel)
    called = other_unit_in(column.name, plain_unit(column.unit)) if column is not None else ""
    if column is None or not called or not any(units.compatible(called, base) for base in bases):
        return None
    return {"column": column.name, "declared": column.unit, "called": called}


def _resolution_contradicts(look: Look) -> Numbers | None:
    position, resolution = look.log.position, look.axis.resolution
    if not resolution:
        return None
    step = position.recorded_step
    if step is None:
        step = clear_step(position.values, most=math.inf)
        if step < resolution:  # digits of a text are a finer step than any encoder has
            step = clear_step(position.values)
    times = step / resolution
    if not step or 1.0 / OTHER_STEP < times < OTHER_STEP:
        return None
    degrees = any(abs(ratio / GEARS["180/pi"] - 1.0) < 0.02 for ratio in (times, 1.0 / times))
    return {"step": step, "resolution": resolution, "times": times, "degrees": float(degrees)}


def _velocity_contradicts(look: Look) -> Numbers | None:
    return None if look.velocity is None else dict(zip(("ratio", "correlation", "delay"), look.velocity, strict=True))


def _gear(look: Look, of: str, ratio: float) -> Numbers | None:
    """Return a ratio that is one of those that gears and units have."""
    name, value = min(GEARS.items(), key=lambda gear: abs(np.log(abs(ratio) / gear[1])))
    return {"of": of, "ratio": ratio, "gear": name} if abs(abs(ratio) / value - 1.0) < look.settings.gear_near else None


def _gear_of_velocity(look: Look) -> Numbers | None:
    scale, likeness, _ = look.velocity or (1.0, 0.0, 0.0)
    of_other_size = likeness >= look.settings.velocity_likeness and abs(scale - 1.0) > look.settings.velocity_scale
    return _gear(look, "velocity", scale) if of_other_size else None


def _effort_unsigned(look: Look) -> Numbers | None:
    effort = look.log.effort
    return {"largest": float(np.max(np.abs(effort.values)))} if effort is not None and look.is_unsigned else None


def _clipped(look: Look) -> Numbers | None:
    cut = look.cut
    return cut and {"level": cut.level, "samples": cut.longest, "all": cut.samples, "time": float(look.log.time.values[cut.first])}


def _never_slides(look: Look) -> Numbers | None:
    """Measure where the effort follows the position as that of a spring, and gives back the work that it did."""
    log, share, settings = look.log, look.share, look.settings
    if log.effort is None or look.axis.plant != "inertia" or not 0.0 < abs(share) < max(settings.kept_work, MOST_KEPT):
        return None
    likeness = likeness_of(*(channel.values - np.mean(channel.values) for channel in (log.position, log.effort)))
    narrow = abs(share) < settings.kept_work and likeness > settings.spring_likeness
    if not narrow and not (likeness > max(settings.spring_likeness, PULLED) and _builds_up(look)):
        return None
    return {"correlation": likeness, "percent": 100.0 * share, "reach": 0.5 * float(np.ptp(log.position.values))}


def _builds_up(look: Look) -> bool:
    """Return whether friction builds up over the ways of a log, rather than to turn at once beside a spring.

    Loops before sliding may be as wide as those of an axis that slides and is pulled back. What such an axis is pulled
    by depends on the place; its friction is there right behind each reversal.
    """
    rows, x = look.rows, look.rows.position
    if x.size < CHUNKS:
        return False
    turns = look.turns(x)
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
    level, (missing, error) = float(line.coefficients[-2]), line.last
    return level > 0.0 and missing - CLEAR * error > AT_ONCE * level


def _saturates(look: Look) -> Numbers | None:
    return None if look.bend is None else {"percent": 100.0 * look.bend}


def _mass_contradicts(look: Look) -> Numbers | None:
    return look.mass and {"known": look.axis.mass or 0.0, "found": look.mass[0], "ratio": look.mass[1]}


def _gear_of_mass(look: Look) -> Numbers | None:
    return look.mass and _gear(look, "mass", look.mass[1])


def _level_drifts(look: Look) -> Numbers | None:
    level, shares = look.changes
    return {"percent": 100.0 * shares[-2], "level": level} if -2 in shares else None


def _level_over_position(look: Look) -> Numbers | None:
    level, shares = look.changes
    return {"percent": 100.0 * shares[-1], "level": level} if -1 in shares else None


def _below_resolution(look: Look) -> Numbers | None:
    return None if look.is_fine else {"way": look.way, "resolution": look.resolution}


def _one_direction(look: Look) -> Numbers | None:
    ways = np.concatenate(look.ways)
    ahead, back = float(ways[ways > 0.0].sum()), -float(ways[ways < 0.0].sum())
    share = min(ahead, back) / max(ahead + back, np.finfo(float).tiny)
    if not look.is_fine or share >= look.settings.one_way:
        return None
    return {"percent": max(100.0 * share, 0.0), "direction": "forward" if ahead >= back else "backward"}


def _one_speed(look: Look) -> Numbers | None:
    """Measure the 10 % and 90 % quantiles of steady speeds over the way.

    A way is steady where most of its parts are as fast as the fastest of them; those in which the axis waits tell
    nothing.
    """
    every, steady = [np.zeros(1)], [np.empty((2, 0))]
    for x in look.segments if look.is_fine else ():
        ends = look.turns(x)
        marks = np.linspace(ends[:-1], ends[1:], CHUNKS + 1).astype(int)[:, np.diff(ends) >= CHUNKS]
        times = look.log.sample_time * np.diff(marks, axis=0)
        speeds = np.abs(np.diff(x[marks], axis=0)) / times
        top = np.quantile(speeds, FAST, axis=0)
        goes = speeds > WAITS * top
        cruises = goes & (np.abs(speeds - top) <= CRUISING * top + 2.0 * graininess(x, look.resolution) / times)
        way = np.abs(np.diff(x[marks[[0, -1]]], axis=0))[0]
        every.append(way)
        steady.append(np.stack([way, top])[:, (cruises.sum(axis=0) >= STEADY * goes.sum(axis=0)) & (top > 0.0)])
    ways, tops = np.concatenate(steady, axis=1)
    if not ways.size or ways.sum() < look.settings.steady_share * np.concatenate(every).sum():
        return None
    order = np.argsort(tops)
    below = np.cumsum(ways[order]) / ways.sum()
    slow, fast = (float(tops[order][np.searchsorted(below, share)]) for share in (0.1, 0.9))
    return {"slowest": slow, "fastest": fast} if fast < look.settings.one_speed * slow else None


def _repeats(look: Look) -> Numbers | None:
    if not look.is_fine:
        return None
    position = max(look.segments, key=len)
    step = max(position.size // POINTS, 1)
    period = period_of(position[::step], step * look.log.sample_time, look.settings.repeated, look.settings.repeated_periods)
    return None if period is None else {"every": period}


class Rule(NamedTuple):
    """A code, what measures it in a log (None: nothing to say), how grave it is, and whether any use of the log suffers."""

    code: str
    measure: Callable[[Look], Numbers | None]
    severity: Severity = "warning"
    of_recording: bool = True


RULES = (
    Rule("rows_lost", _rows_lost),
    Rule("sign_reversed", _sign_reversed, "error"),
    Rule("unit_suspect", _clock_suspect),
    Rule("resolution_contradicts", _resolution_contradicts),
    Rule("unit_suspect", _unit_suspect),
    Rule("velocity_contradicts", _velocity_contradicts),
    Rule("gear_suspect", _gear_of_velocity),
    Rule("effort_unsigned", _effort_unsigned, "error"),
    Rule("clipped", _clipped),
    Rule("never_slides", _never_slides, of_recording=False),
    Rule("saturates", _saturates),
    Rule("mass_contradicts", _mass_contradicts, of_recording=False),
    Rule("gear_suspect", _gear_of_mass),
    Rule("level_drifts", _level_drifts, of_recording=False),
    Rule("level_over_position", _level_over_position, of_recording=False),
    Rule("below_resolution", _below_resolution, of_recording=False),
    Rule("one_direction", _one_direction, of_recording=False),
    Rule("one_speed", _one_speed, of_recording=False),
    Rule("motion_repeats", _repeats, "note", of_recording=False),
)
"""What a log is asked, in the order in which it is said; `bristle.report.sentences.checks` has the sentence and the mend of each."""

RECORDED = (*dict.fromkeys(rule.code for rule in RULES if rule.of_recording), *("resampled", "unit_contradicts", "beyond_limit"))
"""Codes of what is wrong with a recording, whatever it is used for; the last ones are found while it is read."""


@guarded(
    log=instance(LogData, "a log", "Write read_log(...)"),
    axis=optional(instance(Axis, "an axis")),
    settings=instance(CheckThresholds, "thresholds"),
)
def checked(log: LogData, axis: Axis | None = None, settings: CheckThresholds = DEFAULT) -> tuple[Diagnostic, ...]:
    """Return what a log says against itself and against what is told of its axis, before anything is fitted.

    Parameters
    ----------
    log : Log
        Its channels, in SI.
    axis : Axis, optional
        Mass, resolution, limits and units, as far as they are known.
    settings : CheckThresholds
        From where on something is said.

    Returns
    -------
    tuple of Diagnostic
        Gravest first. Each has a code, numbers, and a sentence that says how to mend it.
    """
    return (*log.findings, *_told(log, axis or Axis(kind=log.kind), settings))


def _told(log: LogData, axis: Axis, settings: CheckThresholds) -> Iterator[Diagnostic]:
    resolution = _resolution(log, axis)
    lost = lost_in(log, resolution, settings.lost_step)
    look = Look(_parted(log, lost), axis, settings, resolution, lost)
    for rule in RULES:
        if (numbers := rule.measure(look)) is not None:
            yield Diagnostic(rule.code, "", rule.severity, numbers, log.kind)


def parted(log: AnyLog, axis: Axis | None = None, settings: CheckThresholds = DEFAULT) -> AnyLog:
    """Return a log with the places where rows are missing between its segments, so that nothing goes across them."""
    return _parted(log, lost_in(log, _resolution(log, axis), settings.lost_step))


def _resolution(log: LogData, axis: Axis | None) -> float:
    return (axis and axis.resolution) or log.position.step


def _parted(log: AnyLog, starts: np.ndarray) -> AnyLog:
    """Return a log whose segments end at the samples `starts`, before missing rows."""
    segments = []
    for segment in log.segments if starts.size else ():
        first, last, _ = segment.indices(len(log))
        inside = starts[(starts >= first) & (starts < last - 1)] + 1
        segments += [slice(a, b) for a, b in pairwise([first, *inside.tolist(), last]) if b - a >= SHORTEST_PART]
    return replace(log, segments=tuple(segments)) if segments else log
