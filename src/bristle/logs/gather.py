"""From the columns of a file to the channels of an axis, in SI."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from bristle.core import units
from bristle.core.axis import Axis, Column
from bristle.core.errors import InputError, close_names
from bristle.core.variable import KINDS, Kind, unit_of
from bristle.logs.choice import USUAL_NAMES
from bristle.logs.log import CHANNELS, Channel
from bristle.logs.table import Table, some_of, split_unit

__all__ = ["Gathered", "axis_of", "gather"]


@dataclass
class Gathered:
    """Channels as recorded, not yet examined, and what kept others from being gathered."""

    channels: dict[str, Channel] = field(default_factory=dict)
    injected: list[Channel] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    problems: list[InputError] = field(default_factory=list)

    def named(self) -> Iterator[tuple[str, Channel]]:
        """Yield the name and the channel of all that was found."""
        yield from self.channels.items()
        yield from ((f"injected.{channel.column}", channel) for channel in self.injected)


def gather(table: Table, axis: Axis) -> Gathered:
    """Return the channels that `axis` names, in SI of its kind, sign and transmission applied."""
    found = Gathered(notes=list(table.notes))
    for name, column in axis.columns.items():
        if (channel := _channel(table, column, name, axis.kind, found)) is not None:
            found.channels[name] = channel
    for index, known in enumerate(axis.injected):
        column = Column(known.column, "", "", known.gain, known.optional)
        if (channel := _channel(table, column, f"injected[{index}]", axis.kind, found)) is not None:
            found.injected.append(channel)
    if "position" not in axis.columns:
        found.problems.append(
            InputError("no column is named as the position", path=f"axis {axis.name}", mend="Name it in [columns]")
        )
    _tell_of_shared_columns(found)
    _refuse_unequal_lengths(table, found)
    return found


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


def _channel(table: Table, column: Column, key: str, kind: Kind, found: Gathered) -> Channel | None:
    name = table.name_of(column.name)
    if name is None:
        if column.optional:
            close = close_names(column.name, table.names)
            meant = f"; is it {close[0]!r}? Then name it so in the axis file" if close else ""
            found.notes.append(f"optional column {column.name} is not in this log{meant}")
        else:
            found.problems.append(table.missing(column.name, key))
        return None
    try:
        scale = column.scale * _factor(table, name, column, found)
    except InputError as error:
        found.problems.append(error)
        return None
    quantity = CHANNELS.get(key, CHANNELS["effort"])
    with np.errstate(over="ignore"):  # what is too large is refused with its sample
        values = table.columns[name] * scale + column.shift
    return Channel(values, unit_of(quantity, kind), name)


def _factor(table: Table, name: str, column: Column, found: Gathered) -> float:
    """Return the factor from the numbers in the log to the base unit of the column."""
    said, place = table.units.get(name, ""), f"{table.source}: column {name!r}"
    if not column.base:
        return 1.0
    if not said and not column.unit:
        found.notes.append(f"column {name} has no unit: taken as {column.base}")
        return 1.0
    if not said or not units.is_unit(said):
        return units.factor(column.unit or said, column.base, path=place)
    there = units.factor(said, column.base, path=place)
    if column.unit and not np.isclose(there, units.factor(column.unit, column.base), rtol=1e-9):
        raise InputError(
            "has another unit in the log than in the axis file", path=place, value=said, allowed=column.unit,
            mend=f"If the log is right, write unit = {said!r} in the axis file, or leave the unit out there",
        )  # fmt: skip
    return there


def _tell_of_shared_columns(found: Gathered) -> None:
    used: dict[str, list[str]] = {}
    for name, channel in found.named():
        used.setdefault(channel.column, []).append(name.partition(".")[0])
    for column, names in used.items():
        if len(names) > 1:
            found.notes.append(f"column {column} is used twice, as {' and as '.join(names)}: is that meant?")


def _refuse_unequal_lengths(table: Table, found: Gathered) -> None:
    sizes = {channel.column: channel.values.size for _, channel in found.named()}
    if len(set(sizes.values())) > 1:
        said = ", ".join(f"{column}: {size}" for column, size in sizes.items())
        found.problems.append(
            InputError(
                f"has columns of different lengths ({said})",
                path=str(table.source),
                mend="Export all channels at one rate and of one length; a shorter one may be truncated",
            )
        )
