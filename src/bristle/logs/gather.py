"""Convert the columns of a file to the channels of an axis, in SI."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from bristle.core import units
from bristle.core.axis import COLUMNS, OF_COUPLING, Axis, Column
from bristle.core.diagnostic import Diagnostic, Number
from bristle.core.errors import InputError, close_names
from bristle.core.variable import KINDS, Kind, unit_of
from bristle.logs.channel import CHANNELS, Channel
from bristle.logs.clock import UNIFORM, median_step
from bristle.logs.nameless import is_nameless
from bristle.logs.table import USUAL_NAMES, Table, some_of, split_unit
from bristle.logs.words import converts, other_unit_in, unit_of_time


@dataclass
class Gathered:
    """Channels as recorded, not yet checked, and the reasons why other channels are missing."""

    channels: dict[str, Channel] = field(default_factory=dict)
    injected: list[Channel] = field(default_factory=list)
    regressors: list[Channel] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    problems: list[InputError] = field(default_factory=list)
    findings: list[Diagnostic] = field(default_factory=list)

    @property
    def motion(self) -> Channel | None:
        """Recorded motion of the axis: its position, or without it its velocity."""
        return self.channels.get("position", self.channels.get("velocity"))

    def change(self, changed: Callable[[Channel], Channel]) -> None:
        """Replace each channel."""
        self.channels = {name: changed(channel) for name, channel in self.channels.items()}
        self.injected = list(map(changed, self.injected))
        self.regressors = list(map(changed, self.regressors))

    def named(self) -> Iterator[tuple[str, Channel]]:
        """Yield name and channel of all that were found."""
        yield from self.channels.items()
        yield from ((f"injected.{channel.column}", channel) for channel in self.injected)
        yield from ((f"known.{channel.column}", channel) for channel in self.regressors)


def gather(table: Table, axis: Axis) -> Gathered:
    """Return the channels that `axis` names, in SI units of the axis, sign and transmission applied."""
    gathered = Gathered(notes=list(table.notes))
    motion, time = (
        axis.columns.get("position", axis.columns.get("velocity")),
        axis.columns.get("time"),
    )
    # Columns with their own times need no column of time.
    implied = motion is not None and (table.name_of(motion.name) or "") in table.stamps
    if implied and time is not None:
        implied = (table.name_of(time.name) or "") in ("", *table.stamps.values())
        if implied:
            gathered.notes.append(
                f"bristle ignores columns.time, because each column of this {table.format} file has its own time"
            )
    for name, column in axis.columns.items():
        if name in ("reference", "following_error"):  # they share the unit and sign of the position
            column = _in_the_unit_of(axis.columns.get("position"), column, table, gathered)
        if (
            not (name == "time" and implied)
            and (channel := _channel(table, column, name, axis.kind, gathered)) is not None
        ):
            gathered.channels[name] = channel
    stamps = gathered.channels.get("time")
    if (
        axis.sample_time
        and stamps is not None
        and stamps.values.size > 1
        and not axis.columns["time"].unit
    ):
        gathered.channels["time"] = _in_step(stamps, axis.sample_time, gathered)
    effort = axis.columns.get("effort")
    if (
        effort is not None
        and effort.base in OF_DRIVES[:5]
        and axis.kind == KINDS[1]
        and axis.arm is not None
        and axis.gear is None
    ):
        assumed = f"bristle takes the effort in column {effort.name} as that of a direct drive (gear_ratio = 1)"
        gathered.notes.append(f"the axis file states no gear_ratio: {assumed}")
    for index, injected in enumerate(axis.injected):
        column = Column(injected.column, "", "", injected.gain, injected.optional)
        if (
            channel := _channel(table, column, f"injected[{index}]", axis.kind, gathered)
        ) is not None:
            gathered.injected.append(channel)
    for index, known in enumerate(axis.regressors):
        column = Column(known.place, "", known.unit, optional=known.optional)
        channel = _channel(table, column, f"known[{index}]", axis.kind, gathered)
        if channel is None and known.optional and gathered.channels:
            channel = Channel(
                np.zeros(len(next(iter(gathered.channels.values())))), "1", known.place
            )
        if channel is not None:
            gathered.regressors.append(replace(channel, unit="1"))
    if motion is None:
        gathered.problems.append(
            InputError(
                "names no column of the position",
                path=f"axis {axis.name}",
                mend="Name this column in [columns]",
            )
        )
    if implied:
        _onto_one_time(table, gathered, time.unit if time else "")
    _compare_columns(table, gathered)
    _without_open_ends(gathered)
    return gathered


def _without_open_ends(gathered: Gathered) -> None:
    """Leave out the rows before the first value, and after the last one, of any channel: loggers start them one by one."""
    missing = {channel.column: np.isnan(channel.values) for _, channel in gathered.named()}
    is_whole = len({gaps.size for gaps in missing.values()}) == 1
    complete = np.flatnonzero(~np.any(list(missing.values()), axis=0)) if is_whole else np.empty(0)
    late = [column for column, gaps in missing.items() if gaps.size and (gaps[0] or gaps[-1])]
    if not complete.size or not late:
        return
    inner = slice(int(complete[0]), int(complete[-1]) + 1)
    left = len(missing[late[0]]) - (inner.stop - inner.start)
    noun = "sample" if left == 1 else "samples"
    gathered.notes.append(
        f"bristle ignores {left} {noun} at the ends, where column {' and column '.join(late)} has no values"
    )
    gathered.change(lambda channel: replace(channel, values=channel.values[inner]))


def _in_step(time: Channel, sample_time: float, gathered: Gathered) -> Channel:
    """Return the stamps in the unit of time in which they are a sample time [s] apart; unchanged if there is no such unit."""
    usual = median_step(time.values)
    scale = next(
        (scale for scale in UNITS_OF_TIME if abs(usual * scale / sample_time - 1.0) < UNIFORM), 1.0
    )
    if scale == 1.0:
        return time
    states = f"column {time.column} rises by {usual:.6g} s per sample by its unit in the log, but sample_time in the axis file is"
    gathered.notes.append(f"{states} {sample_time:g} s: bristle multiplies the column by {scale:g}")
    return replace(time, values=time.values * scale)


UNITS_OF_TIME = [1000.0**power for power in range(-3, 4)]  # ratios of two units, from ns to s


def _compare_columns(table: Table, gathered: Gathered) -> None:
    """Report columns used twice, refuse columns of different lengths, and derive the reference from a following error."""
    used: dict[str, list[str]] = {}
    for name, channel in gathered.named():
        used.setdefault(channel.column, []).append(name.partition(".")[0])
    for column, names in used.items():
        if len(names) > 1:
            gathered.notes.append(
                f"column {column} is used twice, as {' and as '.join(names)}. Check [columns]"
            )
    sizes = {channel.column: channel.values.size for _, channel in gathered.named()}
    if len(set(sizes.values())) > 1:
        message = f"has columns with different numbers of samples ({', '.join(f'{column}: {size}' for column, size in sizes.items())})"
        gathered.problems.append(
            InputError(
                message,
                path=str(table.source),
                mend="Export all channels with the same sample rate and duration. A shorter column may be truncated",
            )
        )
    error, position = (
        gathered.channels.pop("following_error", None),
        gathered.channels.get("position"),
    )
    if error is None:
        return
    if position is None:
        gathered.notes.append(
            f"bristle ignores the following error in column {error.column}, because the log has no position"
        )
    elif error.values.size == position.values.size and "reference" in gathered.channels:
        gathered.notes.append(
            f"bristle ignores the following error in column {error.column}, because the log has a reference"
        )
    elif error.values.size == position.values.size:
        gathered.channels["reference"] = Channel(
            position.values + error.values, position.unit, error.column
        )
        gathered.notes.append(
            f"bristle computes the reference as position plus following error, which column {error.column} contains"
        )


def _in_the_unit_of(
    position: Column | None, column: Column, table: Table, gathered: Gathered
) -> Column:
    """Return the column of a reference; if only its header states its unit, and that of the position too, with the unit of the position."""
    name = table.name_of(column.name)
    if position is None or column.unit or name is None or column.base not in ("m", "rad"):
        return column
    leading = table.name_of(position.name) or ""
    stated, own = table.units.get(leading, ""), table.units.get(name, "")
    unit = position.unit or ("" if table.unknown_unit(leading) else stated)
    if not unit or own not in ("", stated):
        return column
    if not own:
        gathered.notes.append(
            f"column {name} has no unit: bristle assumes the unit of the position, {unit}"
        )
    return replace(
        column, unit=unit, base=position.base, scale=math.copysign(position.scale, column.scale)
    )


def kind_of(unit: str) -> Kind:
    """Return the kind of the axis whose position or velocity has a unit."""
    return KINDS[any(converts(unit, base) for base in ("rad", "rad/s"))]


def axis_of(table: Table) -> Axis:
    """Return the axis that names and units of a table suggest, for logs without an axis file."""
    names = {
        channel: next((name for name in table.names if name.lower() in usual), None)
        for channel, usual in USUAL_NAMES.items()
    }
    moved = names["position"] or names["velocity"]
    if moved is None:
        for text in table.texts:
            if split_unit(text)[0].lower() in USUAL_NAMES["position"]:
                raise table.missing(text, "position")
        message, mend = (
            "has no column with a usual name of a position",
            "Give an axis file that names the columns (--axis AXIS.toml)",
        )
        if is_nameless(table):
            mend = "Propose a role for each column with `bristle log LOG --write AXIS.toml`, and add --axis AXIS.toml"
        raise InputError(
            f"{message}, only {some_of(table.names, 40)}", path=str(table.source), mend=mend
        )
    kind = kind_of(table.units.get(moved, ""))
    columns = {
        channel: Column(name, "", unit_of(CHANNELS[channel], kind))
        for channel, name in names.items()
        if name
    }
    return Axis(name=table.source.stem, kind=kind, columns=columns)


def _channel(
    table: Table, column: Column, key: str, kind: Kind, gathered: Gathered
) -> Channel | None:
    name = table.name_of(column.name)
    if name is None:
        if column.optional:
            close = close_names(column.name, table.names)
            hint = (
                f". If its name is {close[0]!r}, write this name in the axis file" if close else ""
            )
            gathered.notes.append(f"optional column {column.name} is not in this log{hint}")
        else:
            gathered.problems.append(table.missing(column.name, key))
        return None
    try:
        scale = column.scale * _factor(table, name, column, gathered)
    except InputError as error:
        gathered.problems.append(error)
        return None
    declared = column.unit or table.units.get(name, "")
    # If the axis file declares the unit of time and position, the check of the log compares them.
    # A unit at the end of a name has 2 letters or more: a single letter can be a motor or a phase.
    if (
        not (column.unit and key in ("time", "position"))
        and len(called := other_unit_in(name, declared)) >= 2
    ):
        numbers: dict[str, Number] = {"column": name, "called": called, "declared": declared}
        gathered.findings.append(Diagnostic("unit_contradicts", "", "warning", numbers))
    quantities = COLUMNS | OF_COUPLING
    is_further = key.isidentifier() and key not in quantities
    unit = (
        column.base or "K" if is_further else unit_of(quantities.get(key, COLUMNS["effort"]), kind)
    )
    with np.errstate(over="ignore"):  # too large values are refused with their sample
        values = table.columns[name] * scale + column.shift
    return Channel(values, unit, name)


# Base unit -> another usual unit of the numbers in a log.
USUAL_UNITS = {
    "s": "ms",
    "m": "mm",
    "rad": "deg",
    "m/s": "mm/s",
    "rad/s": "rev/s",
    "N": "%",
    "N*m": "%",
    "rated": "%",
}
# The axis file converts them by constants, gear and lead.
OF_DRIVES = ("count", "count/s", "A", "V", "rated", "rad", "rad/s", "N*m")


def _factor(table: Table, name: str, column: Column, gathered: Gathered) -> float:
    """Return the factor from the recorded numbers to the base unit of the column; a unit in the axis file outranks the log."""
    stated, place = table.units.get(name, ""), f"{table.source}: column {name!r}"
    if not column.base:
        return 1.0
    if column.unit:
        factor = units.factor(column.unit, column.base, path=place)
        if stated and not (
            converts(stated, column.base)
            and np.isclose(factor, units.factor(stated, column.base), rtol=1e-9)
        ):
            states = f"column {name} has the unit {stated!r} in the log, but {column.unit} in the axis file"
            gathered.notes.append(f"{states}: bristle uses {column.unit}")
        return factor
    if converts(stated, column.base):
        return units.factor(stated, column.base, path=place)
    if not stated and column.base != "rated":
        gathered.notes.append(f"column {name} has no unit: bristle assumes {column.base}")
        return 1.0
    usual = next(
        (stated for base in OF_DRIVES if converts(stated, base)),
        USUAL_UNITS.get(column.base, column.base),
    )
    raise InputError(
        "has the wrong unit",
        path=place,
        value=stated,
        allowed=f"{column.base}, or a unit that converts to it",
        mend=f'Write the unit of the numbers in the axis file, such as unit = "{usual}"',
    )


COINCIDES = 1e-6  # of the sample time: closer stamps are the same


def _onto_one_time(table: Table, gathered: Gathered, unit: str) -> None:
    """Interpolate all channels to the times of the position, or without it of the velocity; `unit` counts if the file states none."""
    # Keep samples recorded at such a time and interpolate the others.
    motion = gathered.motion
    if motion is None:
        return
    own, place = table.stamps[motion.column], str(table.source)
    stated = {
        name: table.units.get(name) or unit or unit_of_time(name, table.columns[name])
        for name in set(table.stamps.values())
    }
    clocks = {
        name: table.columns[name] * units.factor(stated[name], "s", path=place) for name in stated
    }
    base = clocks[own]
    step = median_step(base) if base.size > 1 else 0.0
    elsewhere = {
        id(channel): clocks[stamps]
        for _, channel in gathered.named()
        if (stamps := table.stamps.get(channel.column, own)) != own
    }
    gathered.change(
        lambda channel: (
            _on(base, elsewhere[id(channel)], channel, gathered, step)
            if id(channel) in elsewhere
            else channel
        )
    )
    gathered.channels = {"time": Channel(base, "s", own), **gathered.channels}


def _on(
    times: np.ndarray, stamps: np.ndarray, channel: Channel, gathered: Gathered, step: float
) -> Channel:
    """Return a channel at other times, without values outside of its own times."""
    stamps, first = np.unique(stamps, return_index=True)
    values = channel.values[first]
    outside = (times < stamps[0] - COINCIDES * step) | (times > stamps[-1] + COINCIDES * step)
    near = np.clip(np.searchsorted(stamps, times - COINCIDES * step), 0, stamps.size - 1)
    coincides = outside | (np.abs(stamps[near] - times) <= COINCIDES * step)
    if coincides.all() or stamps.size < 4:
        return replace(channel, values=np.where(outside, np.nan, values[near]))
    from scipy.interpolate import CubicSpline

    between = np.where(coincides, values[near], CubicSpline(stamps, values)(times))
    half = (
        CubicSpline(stamps[::2], values[::2])(stamps[1:-1:2]) if stamps.size > 8 else values[1:-1:2]
    )
    error = float(np.sqrt(np.mean((half - values[1:-1:2]) ** 2)))
    numbers: dict[str, Number] = {
        "column": channel.column,
        "sample_time": step,
        "own_sample_time": median_step(stamps),
        "percent": 100.0 * float(np.mean(~coincides[~outside])),
        "error_percent": 100.0 * error / max(float(np.std(values)), 1e-300),
    }
    gathered.findings.append(Diagnostic("resampled", "", "warning", numbers))
    return replace(channel, values=np.where(outside, np.nan, between))
