"""Check logs before a fit: contradictions within a log, and motions that the fit needs but all logs together lack."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TypeVar

import numpy as np

from bristle.core import Axis, guarded, instance, units
from bristle.core.diagnostic import Diagnostic, Number, Severity
from bristle.core.variable import Kind
from bristle.logs.channel import LogData, clear_step
from bristle.logs.lines import Line, lost_in
from bristle.logs.look import DEFAULT, SAME_SCALE, SAME_SIGNAL, CheckThresholds, Look, likeness_of
from bristle.logs.turns import CHUNKS, CRUISING, FAST, graininess, period_of, rests_of
from bristle.logs.words import other_unit_in, plain_unit

Numbers = Mapping[str, Number]
AnyLog = TypeVar("AnyLog", bound=LogData)

COPIED_WITHIN = 1e-6  # of the range, within which a position is a copy of its reference
OTHER_STEP = 5.0  # times the resolution: counts of a quadrature encoder differ by 2 and 4
SAMPLED = 1e-5, 0.5  # s from sample to sample of a servo axis
# Of a spring: share of the work that stays in the axis, correlation of effort and position.
SPRING_WORK, SPRING_LIKENESS = (0.3, 0.6)
# [m, rad], more than the deflection of any contact
FARTHEST = {"translational": 0.05, "rotational": 0.5}
RATIOS = {
    "2": 2.0,
    "pi": np.pi,
    "2 pi": 2.0 * np.pi,
    "60": 60.0,
    "30/pi": 30.0 / np.pi,
    "180/pi": 180.0 / np.pi,
    "1000": 1000.0,
}
INVERSES = ("1/2", "1/pi", "1/(2 pi)", "1/60", "pi/30", "pi/180", "1/1000")
GEARS = RATIOS | {name: 1.0 / ratio for name, ratio in zip(INVERSES, RATIOS.values(), strict=True)}
"""Ratios of gears, leads and units, by which two equal quantities can differ."""


def _measured(look: Look) -> Iterator[tuple[str, Numbers | None]]:
    """Yield the code of each check of a log, in the order of the report, with the measured numbers; None if the check passes."""
    # `bristle.report.sentences.checks` has the sentence and the mend of each.
    effort, lost, x = look.log.effort, look.lost, look.log.position.values
    if lost.size:
        step = float(np.max(np.abs(x[lost + 1] - x[lost])))
        yield (
            "rows_lost",
            {"places": int(lost.size), "time": float(look.log.time.values[lost[0]]), "step": step},
        )
    if look.high_pass is not None:
        yield "high_passed", {"cutoff": look.high_pass}
    elif look.is_reversed:
        yield "sign_reversed", {"percent": -100.0 * look.share}
    suspect = dict(_suspect_units(look))
    yield "unit_suspect", suspect.get("time")
    yield "resolution_contradicts", _resolution_contradicts(look)
    yield "unit_suspect", suspect.get("position")
    if look.velocity is not None:
        scale, likeness, delay = look.velocity
        yield "velocity_contradicts", {"ratio": scale, "correlation": likeness, "delay": delay}
        if likeness >= SAME_SIGNAL and abs(scale - 1.0) > SAME_SCALE:
            yield "gear_suspect", _gear(look, "velocity", scale)
    if effort is not None and look.is_unsigned:
        yield "effort_unsigned", {"largest": float(np.max(np.abs(effort.values)))}
    if cut := look.cut:
        time = float(look.log.time.values[cut.first])
        yield (
            "clipped",
            {"level": cut.level, "samples": cut.longest, "all": cut.samples, "time": time},
        )
    reference = look.log.reference
    if reference is not None and np.ptp(reference.values - x) < COPIED_WITHIN * np.ptp(x):
        yield "reference_recorded", {}
    if look.bend is not None:
        yield "saturates", {"percent": 100.0 * look.bend}
    if look.mass is not None:
        mass, ratio = look.mass
        yield "mass_contradicts", {"known": look.axis.mass or 0.0, "found": mass, "ratio": ratio}
        yield "gear_suspect", _gear(look, "mass", ratio)
    level, shares = look.changes
    if look.step is not None:
        time, share = look.step
        shares = {place: value for place, value in shares.items() if place != -2}
        yield "scale_steps", {"time": time, "percent": 100.0 * share}
    for place, code in ((-2, "level_drifts"), (-1, "level_over_position")):
        if place in shares:
            yield code, {"percent": 100.0 * shares[place], "level": level}


def _of_motion(looks: Sequence[Look]) -> Iterator[tuple[str, Numbers | None]]:
    """Yield the same for the checks of the motion: a motion that one log lacks may be in another."""
    stuck = [_never_slides(look) for look in looks]
    if all(stuck):
        yield "never_slides", stuck[0]
    moving = [look for look in looks if look.way >= 10.0 * look.resolution]
    if not moving:  # the encoder does not resolve the motion
        yield "below_resolution", {"way": looks[0].way, "resolution": looks[0].resolution}
        return
    ways = np.concatenate([way for look in moving for way in look.ways])
    ahead, back = float(ways[ways > 0.0].sum()), -float(ways[ways < 0.0].sum())
    share = min(ahead, back) / max(ahead + back, np.finfo(float).tiny)
    if share < 0.03:  # of the travel is in the rarer direction
        yield (
            "one_direction",
            {
                "percent": max(100.0 * share, 0.0),
                "direction": "forward" if ahead >= back else "backward",
            },
        )
    yield "one_speed", _one_speed(moving)
    periods = list(map(_period, moving))
    if all(periods):
        yield "motion_repeats", {"every": max(filter(None, periods))}


def _period(look: Look) -> float | None:
    """Return the period of the longest segment [s]; None if its motion is not periodic."""
    position = max(look.segments, key=len)
    step = max(position.size // 4000, 1)  # of a possibly periodic position
    return period_of(position[::step], step * look.log.sample_time)


def _suspect_units(look: Look) -> Iterator[tuple[str, Numbers]]:
    """Yield times or speeds that no axis has, and units in names that contradict the axis file."""
    settings, dt, turns = look.settings, look.log.sample_time, look.log.kind != "translational"
    speeds = np.abs(look.rows.velocity)
    # Of the rows: faster rows can be noise.
    speed = float(np.quantile(speeds, 0.999)) if speeds.size else 0.0
    is_odd = not SAMPLED[0] <= dt <= SAMPLED[1]
    is_fast = speed > (settings.fastest_turning if turns else settings.fastest) and dt >= SAMPLED[0]
    for channel, bases, odd, numbers in (
        ("time", ("s",), is_odd, {"sample_time": dt}),
        ("position", ("m", "rad"), is_fast, {"speed": speed}),
    ):
        column, recorded = look.axis.columns.get(channel), getattr(look.log, channel).column
        called = other_unit_in(column.name, plain_unit(column.unit)) if column is not None else ""
        if column is not None and called and any(units.compatible(called, base) for base in bases):
            yield (
                channel,
                numbers | {"column": column.name, "declared": column.unit, "called": called},
            )
        elif odd:
            yield channel, numbers | {"column": recorded, "declared": "", "called": ""}


def _resolution_contradicts(look: Look) -> Numbers | None:
    position, resolution = look.log.position, look.axis.resolution
    if not resolution:
        return None
    step = position.recorded_step
    if step is None:
        step = clear_step(position.values, most=math.inf)
        if step < resolution:  # a text can have more digits than any encoder resolves
            step = clear_step(position.values)
    times = step / resolution
    if not step or 1.0 / OTHER_STEP < times < OTHER_STEP:
        return None
    degrees = any(abs(ratio / GEARS["180/pi"] - 1.0) < 0.02 for ratio in (times, 1.0 / times))
    return {"step": step, "resolution": resolution, "times": times, "degrees": float(degrees)}


def _gear(look: Look, of: str, ratio: float) -> Numbers | None:
    """Return a ratio if it is typical of gears or units."""
    name, value = min(GEARS.items(), key=lambda gear: abs(np.log(abs(ratio) / gear[1])))
    return (
        {"of": of, "ratio": ratio, "gear": name} if abs(abs(ratio) / value - 1.0) < 0.06 else None
    )


def _never_slides(look: Look) -> Numbers | None:
    """Return measures of a log whose effort follows the position as a spring does, and returns its work."""
    log, share = look.log, look.share
    # Limits of work and correlation (0.5 and 0.9) that a wide, inclined loop also exceeds.
    if log.effort is None or look.axis.plant != "inertia" or not 0.0 < abs(share) < 0.5:
        return None
    likeness = likeness_of(
        *(channel.values - np.mean(channel.values) for channel in (log.position, log.effort))
    )
    reach = 0.5 * float(np.ptp(log.position.values))
    # No contact sticks over such strokes: gravity, a spring or a cable outweighs the friction of an axis that slides.
    narrow = abs(share) < SPRING_WORK and likeness > SPRING_LIKENESS and reach < FARTHEST[log.kind]
    if not narrow and not (
        likeness > (0.9 if reach < FARTHEST[log.kind] else SPRING_LIKENESS) and _builds_up(look)
    ):
        return None
    return {"correlation": likeness, "percent": 100.0 * share, "reach": reach}


def _builds_up(look: Look) -> bool:
    """Return whether friction builds up over the strokes of a log, instead of reversing at once in parallel to a spring."""
    # Loops before sliding can be as wide as those of an axis that slides against a spring. The spring force depends on the
    # position; the friction of such an axis is complete directly after each reversal.
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
    # Of the longest stroke: build-up distance of such a loop.
    lacking = -side * np.exp(-behind / (0.25 * longest))
    columns = (
        np.ones_like(x),
        place,
        place**2,
        place**3,
        rows.velocity,
        rows.acceleration,
        side,
        lacking,
    )
    line = Line.through(np.column_stack(columns), rows.effort)
    if line is None:
        return False
    level, (missing, error) = float(line.coefficients[-2]), line.last
    # The deficit must exceed 2.0 standard errors.
    # Of friction: a larger deficit: the contact has not slid.
    return level > 0.0 and missing - 2.0 * error > 0.5 * level


def _one_speed(looks: Sequence[Look]) -> Numbers | None:
    """Return the 10 % and 90 % quantiles of steady speeds over the strokes of all logs."""
    # A stroke is steady if most of its parts are as fast as the fastest part. Parts in which the axis waits do not count.
    every, steady = [np.zeros(1)], [np.empty((2, 0))]
    segments = [(look, x) for look in looks for x in look.segments]
    for look, x in segments:
        grain = graininess(x, look.resolution)
        ends = look.turns(x)
        for rest in rests_of(x, grain, look.log.sample_time):
            # After a rest within a stroke, the axis may go on at another speed.
            if np.searchsorted(ends, rest.start - 1) == np.searchsorted(
                ends, rest.stop, side="right"
            ):
                ends = np.sort([*ends, rest.start, rest.stop - 1])
        marks = np.linspace(ends[:-1], ends[1:], CHUNKS + 1).astype(int)[:, np.diff(ends) >= CHUNKS]
        times = look.log.sample_time * np.diff(marks, axis=0)
        speeds = np.abs(np.diff(x[marks], axis=0)) / times
        top = np.quantile(speeds, FAST, axis=0)
        goes = speeds > 0.05 * top  # of the speed of a cruise: below, the axis waits
        cruises = goes & (np.abs(speeds - top) <= CRUISING * top + 2.0 * grain / times)
        way = np.abs(np.diff(x[marks[[0, -1]]], axis=0))[0]
        every.append(way)
        # Of the parts of a stroke.
        steady.append(
            np.stack([way, top])[:, (cruises.sum(axis=0) >= 0.6 * goes.sum(axis=0)) & (top > 0.0)]
        )
    ways, tops = np.concatenate(steady, axis=1)
    if not ways.size or ways.sum() < 0.35 * np.concatenate(every).sum():
        return None
    order = np.argsort(tops)
    below = np.cumsum(ways[order]) / ways.sum()
    slow, fast = (float(tops[order][np.searchsorted(below, share)]) for share in (0.1, 0.9))
    return {"slowest": slow, "fastest": fast} if fast < looks[0].settings.one_speed * slow else None


SEVERITIES: dict[str, Severity] = {
    "sign_reversed": "error",
    "effort_unsigned": "error",
    "motion_repeats": "note",
}
"""Severities other than a warning."""

RECORDED = (
    *(
        "rows_lost",
        "sign_reversed",
        "resolution_contradicts",
        "unit_suspect",
        "velocity_contradicts",
    ),
    *(
        "gear_suspect",
        "effort_unsigned",
        "clipped",
        "saturates",
        "reference_recorded",
        "high_passed",
        "scale_steps",
    ),
    *("resampled", "unit_contradicts", "beyond_limit"),
)
"""Codes of faults of a recording, whatever its use; readers find the last ones."""


@guarded(
    log=instance(LogData, "a log", "Write read_log(...)"),
    settings=instance(CheckThresholds, "thresholds"),
)
def checked(
    log: LogData, axis: Axis | None = None, settings: CheckThresholds = DEFAULT
) -> tuple[Diagnostic, ...]:
    """Return contradictions within a log, and between the log and its axis; call it before a fit.

    Parameters
    ----------
    log : Log
        The log, in SI.
    axis : Axis, optional
        The axis, with its mass, resolution, limits and units, where known.
    settings : CheckThresholds
        Thresholds of the findings.

    Returns
    -------
    tuple of Diagnostic
        Findings of the reader first, then those of the checks. Each has a code, a severity and numbers.
    """
    return checked_together([(log, axis)], settings)


def checked_together(
    pairs: Sequence[tuple[LogData, Axis | None]], settings: CheckThresholds = DEFAULT
) -> tuple[Diagnostic, ...]:
    """Return the same for several logs of one axis, which are one experiment: the checks of the motion look at all logs."""
    looks, diagnostics = list[Look](), list[Diagnostic]()
    for log, axis in pairs:
        described = axis or Axis(kind=log.kind)
        resolution = described.resolution or log.position.step
        lost = lost_in(log, resolution)
        looks.append(Look(_parted(log, lost), described, settings, resolution, lost))
        diagnostics += (*log.findings, *_diagnostics(_measured(looks[-1]), log.kind))
    return (*diagnostics, *_diagnostics(_of_motion(looks), looks[0].log.kind))


def _diagnostics(
    measured: Iterator[tuple[str, Numbers | None]], kind: Kind
) -> Iterator[Diagnostic]:
    """Yield the diagnostics of the checks that did not pass."""
    return (
        Diagnostic(code, "", SEVERITIES.get(code, "warning"), numbers, kind)
        for code, numbers in measured
        if numbers is not None
    )


def parted(log: AnyLog, axis: Axis | None = None) -> AnyLog:
    """Return a log split into segments at missing rows, so that no filter or derivative crosses them."""
    return _parted(log, lost_in(log, (axis and axis.resolution) or log.position.step))


def _parted(log: AnyLog, starts: np.ndarray) -> AnyLog:
    """Return a log whose segments end before the samples `starts`."""
    segments = []
    for segment in log.segments if starts.size else ():
        first, last, _ = segment.indices(len(log))
        inside = starts[(starts >= first) & (starts < last - 1)] + 1
        # A stretch between lost rows has at least 10 samples.
        segments += [
            slice(a, b) for a, b in pairwise([first, *inside.tolist(), last]) if b - a >= 10
        ]
    return replace(log, segments=tuple(segments)) if segments else log
