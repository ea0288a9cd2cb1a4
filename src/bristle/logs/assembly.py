"""Build a log from the columns of a table: check them, resample them onto a uniform grid of time, and report findings."""

from collections.abc import Iterator
from dataclasses import replace
from typing import TypeVar

import numpy as np

from bristle.core import InputError, unit_of, with_unit
from bristle.core.axis import COLUMNS, Axis
from bristle.core.diagnostic import Diagnostic, Number
from bristle.logs.channel import CHANNELS, Channel, LogData
from bristle.logs.clock import UNIFORM, Clock, clock_of
from bristle.logs.gather import Gathered, gather
from bristle.logs.problems import limits_exceeded, problems_of
from bristle.logs.stamped_text import stated_periods
from bristle.logs.table import Table
from bristle.logs.words import is_time


def record_of(table: Table, axis: Axis) -> LogData:
    """Return the log in a table, in SI units of the axis, on a uniform grid of time."""
    gathered = gather(table, axis)
    for problem in (*gathered.problems, *problems_of(gathered, str(table.source))):
        raise problem
    record = assembled(table, axis, gathered, clock_for(table, axis, gathered))
    return within(record, axis.span) if axis.span else record


def clock_for(table: Table, axis: Axis, gathered: Gathered) -> Clock:
    """Return the time base of a log: its column of time, or the sample time of the axis file, or that of the log."""
    time, place, source = gathered.channels.get("time"), str(table.source), "the axis file"
    if time is None:
        clock = clock_of(
            _period(table, axis, gathered) * np.arange(len(gathered.motion or ())),
            place,
            delay=axis.delay,
        )
    else:
        # Rows that repeat the previous row in all channels.
        values = [channel.values for name, channel in gathered.named() if name != "time"]
        repeats = np.append(False, np.all([np.diff(column) == 0.0 for column in values], axis=0))
        position, source = (
            gathered.motion.values if gathered.motion else None,
            f"column {time.column}",
        )
        place = f"{place}: column {time.column!r}"
        clock = clock_of(
            time.values,
            place,
            delay=axis.delay,
            sample_time=axis.sample_time,
            position=position,
            repeats=repeats,
        )
    if table.sample_time and abs(clock.sample_time / table.sample_time - 1.0) > UNIFORM:
        states = f"the log states a sample time of {table.sample_time:g} s, but {source} gives {clock.sample_time:.6g} s"
        gathered.notes.append(f"{states}: bristle uses {source}")
    return clock


USUAL = "the column of time in [columns]", 'sample_time = "1 ms" under [timing]'


def _period(table: Table, axis: Axis, gathered: Gathered) -> float:
    """Return the sample time of the axis file, or that of a log without a column of time [s]; refuse a log that leaves it open."""
    if axis.sample_time:
        return axis.sample_time
    used = [channel.column for _, channel in gathered.named()]
    columns = [name for name in table.names if is_time(name) and name not in used]
    if table.sample_time and not columns:
        return table.sample_time
    ways = [
        f'time = {{ column = "{name}", unit = "{table.units.get(name, "s")}" }} in [columns]'
        for name in columns
    ]
    stated = stated_periods(table.facts, named=False).items()
    ways += [
        f'sample_time = "{period:g} s" under [timing], which the line {line!r} states'
        for line, period in stated
    ]
    mend = f"Write in the axis file {', or '.join(ways or USUAL)}"
    raise InputError("has no column of time and no sample time", path=str(table.source), mend=mend)


def _of_clock(clock: Clock, gathered: Gathered, axis: Axis) -> Iterator[Diagnostic]:
    """Yield the effects of resampling on the channels."""
    # Jitter below 0.1 of the sample time is a note, not a warning.
    if clock.jitter is None or clock.jitter.usual <= 0.1 >= clock.jitter.largest:
        return
    motion, per = gathered.motion, 1.0 if "position" in gathered.channels else clock.sample_time
    numbers: dict[str, Number] = {
        "percent": 100.0 * clock.jitter.usual,
        "largest": 100.0 * clock.jitter.largest,
        "sample_time": clock.sample_time,
        "position_error": per * clock.error_of(motion.values) if motion else 0.0,
    }
    if axis.sample_time is not None:
        numbers["sample_time_stated"] = 1
    if "effort" in gathered.channels:
        numbers["effort_error"] = clock.error_of(gathered.channels["effort"].values)
    yield Diagnostic("resampled", "", "warning", numbers, axis.kind)


def assembled(table: Table, axis: Axis, gathered: Gathered, clock: Clock) -> LogData:
    """Return the log of examined channels, on the grid of `clock`."""

    def on_grid(name: str, lag: float = 0.0) -> Channel | None:
        channel = gathered.channels.get(name)
        if channel is None:
            return None
        step = None if clock.uniform and not lag else channel.step
        return replace(channel, values=clock.sampled(channel.values, lag), recorded_step=step)

    position, velocity, reference = on_grid("position"), on_grid("velocity"), on_grid("reference")
    time = gathered.channels.get("time")
    notes = [*gathered.notes, *clock.notes]
    if position is None:
        if velocity is None:
            raise InputError("has no column of the position or velocity", path=str(table.source))
        # The integral by trapezoids; each segment continues from the end of the previous segment.
        steps = 0.5 * clock.sample_time * (velocity.values[1:] + velocity.values[:-1])
        for segment in clock.segments[1:]:
            steps[segment.start - 1] = 0.0
        way = (float(reference.values[0]) if reference else 0.0) + np.concatenate(
            [[0.0], np.cumsum(steps)]
        )
        position = Channel(
            way,
            unit_of(CHANNELS["position"], axis.kind),
            velocity.column,
            velocity.step * clock.sample_time,
        )
        notes.append(_remark_on(velocity.column, axis, follows=reference is not None))
    if axis.delay:
        notes.append(f"bristle shifts the effort by {axis.delay:g} s, its delay in the axis file")
    return LogData(
        time=Channel(clock.time, "s", time.column if time else ""),
        position=position,
        velocity=velocity,
        effort=on_grid("effort", axis.delay),
        reference=reference,
        load=on_grid("load"),
        temperature=on_grid("temperature"),
        further={
            name: channel
            for name in gathered.channels
            if name not in COLUMNS and (channel := on_grid(name)) is not None
        },
        injected=tuple(
            Channel(
                clock.sampled(injected.values, axis.delay, smooth=False),
                injected.unit,
                injected.column,
            )
            for injected in gathered.injected
        ),
        regressors=tuple(
            replace(column, values=clock.sampled(column.values, 0.0))
            for column in gathered.regressors
        ),
        sample_time=clock.sample_time,
        segments=clock.segments,
        source=table.source,
        origin=table.origin,
        notes=(*notes, *_doubts_about_velocity(position, clock, axis)),
        kind=axis.kind,
        findings=(
            *gathered.findings,
            *_of_clock(clock, gathered, axis),
            *limits_exceeded(gathered, axis),
        ),
    )


def _remark_on(column: str, axis: Axis, *, follows: bool) -> str:
    """Return the note on a position that bristle integrated from a velocity column."""
    begin = "the first value of the reference" if follows else "position 0"
    terms = [
        name
        for name, stated in (
            ("gravity", axis.gravity),
            ("cogging", axis.cogging),
            ("a spring", axis.spring),
        )
        if stated
    ]
    named = f" ({' and '.join(terms)})" if terms else ""
    return (
        f"the log has no position: bristle integrates the velocity in column {column} from {begin}. The true start is unknown, "
        f"and an offset of the velocity makes the position drift. Results that depend on position{named} are meaningless"
    )


def _doubts_about_velocity(position: Channel, clock: Clock, axis: Axis) -> Iterator[str]:
    """Yield a sentence if the axis exceeds its velocity limit."""
    steps = [np.abs(np.diff(position.values[segment][::STRIDE])) for segment in clock.segments]
    fastest = max((float(step.max()) for step in steps if step.size), default=0.0) / (
        STRIDE * clock.sample_time
    )
    # Of the limit, allowed for noise of the velocity.
    if axis.velocity_limit is not None and fastest > (1.0 + 0.02) * axis.velocity_limit:
        speed, limit = (
            with_unit(value, unit_of("length/time", axis.kind))
            for value in (fastest, axis.velocity_limit)
        )
        yield f"the axis moves at up to {speed}, faster than its limit of {limit} in the axis file. Check the unit of the position"


STRIDE = 20  # samples over which the position is differentiated, against quantisation


R = TypeVar("R", bound=LogData)


def within(log: R, span: tuple[float, float]) -> R:
    """Return the part of a log between two times [s] of its own clock."""
    time = log.time.values
    first, last = (int(index) for index in np.searchsorted(time, span))
    extent = f"{span[0]:g} to {span[1]:g} s"
    if last - first < 10:
        raise InputError(
            "contains fewer than 10 samples of the log",
            path="log.span",
            value=extent,
            allowed=f"within {time[0]:g} to {time[-1]:g} s",
        )

    def part(channel: Channel) -> Channel:
        return replace(channel, values=channel.values[first:last])

    segments = [
        (max(segment.start, first) - first, min(segment.stop, last) - first)
        for segment in log.segments
    ]
    return replace(
        log,
        **{name: part(channel) for name in CHANNELS if (channel := getattr(log, name)) is not None},
        further={name: part(channel) for name, channel in log.further.items()},
        injected=tuple(map(part, log.injected)),
        regressors=tuple(map(part, log.regressors)),
        segments=tuple(slice(start, stop) for start, stop in segments if stop > start),
        notes=(*log.notes, f"bristle uses only the samples from {span[0]:g} to {span[1]:g} s"),
    )
