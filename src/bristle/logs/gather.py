"""From the columns of a file to the channels of an axis, in SI."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from bristle.core import units
from bristle.core.axis import COLUMNS, Axis, Column
from bristle.core.errors import InputError, close_names
from bristle.core.variable import KINDS, Kind, unit_of
from bristle.logs.channel import CHANNELS, Channel
from bristle.logs.choice import USUAL_NAMES
from bristle.logs.table import Table, some_of, split_unit

__all__ = ["Gathered", "axis_of", "gather"]


@dataclass
class Gathered:
    """Channels as recorded, not yet examined, and what kept others from being gathered."""

    channels: dict[str, Channel] = field(default_factory=dict)
    injected: list[Channel] = field(default_factory=list)
    regressors: list[Channel] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    problems: list[InputError] = field(default_factory=list)

    def named(self) -> Iterator[tuple[str, Channel]]:
        """Yield the name and the channel of all that was found."""
        yield from self.channels.items()
        yield from ((f"injected.{channel.column}", channel) for channel in self.injected)
        yield from ((f"known.{channel.column}", channel) for channel in self.regressors)


def gather(table: Table, axis: Axis) -> Gathered:
    """Return the channels that `axis` names, in SI of its kind, sign and transmission applied."""
    gathered = Gathered(notes=list(table.notes))
    for name, column in axis.columns.items():
        if (channel := _channel(table, column, name, axis.kind, gathered)) is not None:
            gathered.channels[name] = channel
    for index, injected in enumerate(axis.injected):
        column = Column(injected.column, "", "", injected.gain, injected.optional)
        if (channel := _channel(table, column, f"injected[{index}]", axis.kind, gathered)) is not None:
            gathered.injected.append(channel)
    for index, told in enumerate(axis.regressors):
        column = Column(told.column, "", "", optional=told.optional)
        channel = _channel(table, column, f"known[{index}]", axis.kind, gathered)
        if channel is None and told.optional and gathered.channels:
            channel = Channel(np.zeros(len(next(iter(gathered.channels.values())))), "1", told.column)
        if channel is not None:
            gathered.regressors.append(replace(channel, unit="1"))
    if "position" not in axis.columns:
        gathered.problems.append(
            InputError("no column is named as the position", path=f"axis {axis.name}", mend="Name it in [columns]")
        )
    _tell_of_shared_columns(gathered)
    _refuse_unequal_lengths(table, gathered)
    _add_reference(gathered)
    return gathered


def axis_of(table: Table) -> Axis:
    """Return the axis that the names and units of a table speak of, for logs without an axis file.

    Raises
    ------
    InputError
        If no column is called as positions usually are.
    """
    names = {
        channel: next((name for name in table.names if name.lower() in usual), None)
        for channel, usual in USUAL_NAMES.items()
    }
    if names["position"] is None:
        text = next((name for name in table.texts if split_unit(name)[0].lower() in USUAL_NAMES["position"]), None)
        if text is not None:
            raise table.missing(text, "position")
        raise InputError(
            "does not say which column is the position",
            path=str(table.source),
            allowed=some_of(table.names, 40),
            mend="Give an axis file that names the columns (--axis AXIS.toml)",
        )
    position = table.units.get(names["position"], "m")
    kind: Kind = KINDS[1] if units.compatible(position, "rad", path=str(table.source)) else KINDS[0]
    columns = {channel: Column(name, "", unit_of(CHANNELS[channel], kind)) for channel, name in names.items() if name}
    return Axis(name=table.source.stem, kind=kind, columns=columns)


def _channel(table: Table, column: Column, key: str, kind: Kind, gathered: Gathered) -> Channel | None:
    name = table.name_of(column.name)
    if name is None:
        if column.optional:
            close = close_names(column.name, table.names)
            hint = f"; is it {close[0]!r}? Then name it so in the axis file" if close else ""
            gathered.notes.append(f"optional column {column.name} is not in this log{hint}")
        else:
            gathered.problems.append(table.missing(column.name, key))
        return None
    try:
        scale = column.scale * _factor(table, name, column, gathered)
    except InputError as error:
        gathered.problems.append(error)
        return None
    quantity = COLUMNS.get(key, COLUMNS["effort"])
    with np.errstate(over="ignore"):  # what is too large is refused with its sample
        values = table.columns[name] * scale + column.shift
    return Channel(values, unit_of(quantity, kind), name)


def _factor(table: Table, name: str, column: Column, gathered: Gathered) -> float:
    """Return the factor from the numbers in the log to the base unit of the column."""
    unit, place = table.units.get(name, ""), f"{table.source}: column {name!r}"
    if not column.base:
        return 1.0
    if not unit and not column.unit:
        gathered.notes.append(f"column {name} has no unit: taken as {column.base}")
        return 1.0
    if not unit or not units.is_unit(unit):
        return units.factor(column.unit or unit, column.base, path=place)
    factor = units.factor(unit, column.base, path=place)
    if column.unit and not np.isclose(factor, units.factor(column.unit, column.base), rtol=1e-9):
        raise InputError(
            "has another unit in the log than in the axis file", path=place, value=unit, allowed=column.unit,
            mend=f"If the log is right, write unit = {unit!r} in the axis file, or leave the unit out there",
        )  # fmt: skip
    return factor


def _add_reference(gathered: Gathered) -> None:
    """Add the reference where the log holds the following error in its place: position and error together."""
    error, position = gathered.channels.pop("following_error", None), gathered.channels.get("position")
    if error is None or position is None or error.values.size != position.values.size:
        return
    if "reference" in gathered.channels:
        gathered.notes.append(f"column {error.column} is not used: the reference is in the log itself")
        return
    reference = Channel(position.values + error.values, position.unit, error.column)
    gathered.channels["reference"] = reference
    gathered.notes.append(f"the reference is position and {error.column}, taken as reference less position")


def _tell_of_shared_columns(gathered: Gathered) -> None:
    used: dict[str, list[str]] = {}
    for name, channel in gathered.named():
        used.setdefault(channel.column, []).append(name.partition(".")[0])
    for column, names in used.items():
        if len(names) > 1:
            gathered.notes.append(f"column {column} is used twice, as {' and as '.join(names)}: is that meant?")


def _refuse_unequal_lengths(table: Table, gathered: Gathered) -> None:
    sizes = {channel.column: channel.values.size for _, channel in gathered.named()}
    if len(set(sizes.values())) > 1:
        lengths = ", ".join(f"{column}: {size}" for column, size in sizes.items())
        gathered.problems.append(
            InputError(
                f"has columns of different lengths ({lengths})",
                path=str(table.source),
                mend="Export all channels at one rate and of one length; a shorter one may be truncated",
            )
        )
