"""`Table`: contents of a file, before the axis is known."""

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple
from unicodedata import normalize

import numpy as np

from bristle.core import (
    Axis,
    InputError,
    did_you_mean,
    error_text,
    place_in_own_code,
    said_by_library,
    shortened,
    units,
)
from bristle.core.content import NOWHERE, Origin

NUMBER_BYTES = 8
# An axis of a SINUMERIK (its unit, its number), or one of several signals of the same name; not a unit.
_INDEX = re.compile(
    r"(?P<name>.*\S)\s*\[u(?P<unit>\d+)(?:[\s,;]+(?P<axis>\d+))?\]|(?P<plain>.*\w)\[\d+\]"
)


@dataclass(frozen=True)
class Table:
    """Named columns of numbers, as in a file.

    Parameters
    ----------
    columns : mapping of str to ndarray
        Samples of each column, a 1-D array; lengths may differ in formats that allow it.
    units : mapping of str to str
        Unit of a column, if the file states it.
    constants : mapping of str to float
        Named single numbers.
    texts : mapping of str to InputError
        Columns left out because they hold no numbers, and why.
    sample_time : float or None
        Sample time, if the file states it [s].
    notes : tuple of str
        Notes on left-out data and assumptions of the reader.
    format : str
        Kind of file.
    source : Path
        The file.
    tables : tuple of str
        Names of the tables of the columns, if there are several and none was chosen.
    names : tuple of str
        Names of all columns of numbers, read or not.
    origin : Origin
        Name and checksum of the file.
    stamps : mapping of str to str
        Map from column to its time column, in files whose channels have separate times.
    facts : mapping of str to str
        Facts in addition to the columns: the device, its rated torque, a date.
    numbers : mapping of str to str
        Map from ``column_2`` and similar numbers to the name of the column.
    about : mapping of str to str
        Description of a column in the file: a comment, the full name of a symbol, its data type.
    joints : mapping of str to tuple of str
        Joint of a column, in files that name the joint of each row, and an empty text.
    """

    columns: Mapping[str, np.ndarray]
    units: Mapping[str, str] = field(default_factory=dict)
    constants: Mapping[str, float] = field(default_factory=dict)
    texts: Mapping[str, InputError] = field(default_factory=dict)
    sample_time: float | None = None
    notes: tuple[str, ...] = ()
    format: str = ""
    source: Path = Path()
    tables: tuple[str, ...] = ()
    names: tuple[str, ...] = ()
    origin: Origin = NOWHERE
    stamps: Mapping[str, str] = field(default_factory=dict)
    facts: Mapping[str, str] = field(default_factory=dict)
    about: Mapping[str, str] = field(default_factory=dict)
    numbers: Mapping[str, str] = field(default_factory=dict)
    joints: Mapping[str, tuple[str, str]] = field(default_factory=dict)

    def name_of(self, name: str) -> str | None:
        """Return the column called `name`, with or without a unit in brackets; None if it does not exist."""
        for spelling in (*spellings(name), self.numbers.get(name, "")):
            if spelling in self.columns:
                return spelling
        alike = [column for column in self.columns if without_index(column) == name]
        return alike[0] if len(alike) == 1 else None

    def unknown_unit(self, name: str) -> str:
        """Return the unit of a column in the file if bristle does not know it; else an empty text."""
        unit = self.units.get(name, "")
        return "" if not unit or units.is_unit(unit) else unit

    def has(self, name: str) -> bool:
        """Return whether a column called `name` exists, with or without a unit in brackets, read or not."""
        return any(spelling in self.names for spelling in spellings(name))

    def missing(self, name: str, key: str) -> InputError:
        """Return the error that lists the columns of the file in place of `name`, needed under `key`."""
        role = key if "[" in key else f"the {key}"
        for text, reason in self.texts.items():
            if name in (text, split_unit(text)[0]):
                mend = reason.mend or f"Name a column of numbers as {role} in the axis file"
                return InputError(
                    f"{reason.message}, but the axis needs the column as {role}",
                    path=reason.path,
                    value=reason.value,
                    mend=mend,
                )
        if self.tables:
            message = f"holds {len(self.tables)} tables, but no column {name!r} outside these tables for {role}"
            mend = 'Name the table: table = "..." under [log] of the axis file, or write FILE::TABLE instead of FILE'
            return InputError(
                message, path=str(self.source), allowed=f"tables: {some_of(self.tables)}", mend=mend
            )
        mend = f"{name!r} is a single number in the file. " if name in self.constants else ""
        mend += did_you_mean(name, self.names, 0.5) or f"Name the column of {role} in the axis file"
        message, allowed = (
            f"has no column {name!r} for {role}",
            f"columns: {some_of(self.names, 40)}",
        )
        return InputError(message, path=str(self.source), allowed=allowed, mend=mend)


def some_of(names: Iterable[str], most: int = 8) -> str:
    """Return the first names, and the count of the others."""
    listed = list(names)
    left = len(listed) - most
    return ", ".join(shortened(text, 60) for text in listed[:most]) + (
        f" and {left} more" if left > 0 else ""
    )


def spellings(name: str) -> tuple[str, ...]:
    """Return possible spellings of the name of a column: without its unit, with letters in one Unicode form each."""
    composed = normalize("NFC", name)
    return tuple(dict.fromkeys((name, split_unit(name)[0], composed, split_unit(composed)[0])))


def split_unit(header: str) -> tuple[str, str]:
    """Return name and unit of a header such as ``position [um]``, ``position (um)`` or ``position / um``."""
    text = header.strip()
    if _INDEX.fullmatch(text):
        return text, ""
    if text.endswith(("]", ")")):
        name, opened, unit = text[:-1].rpartition("[" if text.rfind("[") > text.rfind("(") else "(")
        if opened and name.strip() and not set(unit) & set("])"):
            return name.strip(), unit.strip()
    words = text.rsplit(None, 2)
    if len(words) == 3 and words[1] == "/":
        return words[0], words[2]
    return text, ""


def without_index(name: str) -> str:
    """Return a name without the index that distinguishes axes, or signals of one name."""
    match = _INDEX.fullmatch(name.strip())
    return name if match is None else match["name"] or match["plain"]


def axis_in(address: str) -> tuple[str, str] | None:
    """Return unit and number of the axis in an address of a SINUMERIK; None if it names no axis."""
    match = _INDEX.fullmatch(address.strip())
    return (match["unit"], match["axis"]) if match and match["axis"] else None


# Usual names of columns, for files without an axis file.
USUAL_NAMES = {
    "time": ("time", "t"),
    "position": ("position", "pos", "q", "x"),
    "velocity": ("velocity", "vel", "v"),
    "effort": ("effort", "force", "torque"),
    "reference": ("reference", "position_ref", "setpoint"),
}


@dataclass(frozen=True)
class Choice:
    """Names of columns; None for all. For `usual` names, case does not matter."""

    names: frozenset[str] | None = None
    usual: bool = False

    def __call__(self, name: str, number: int = 0) -> bool:
        """Return whether this column is chosen, by its name or its number in the file."""
        if self.names is None or f"column_{number}" in self.names:
            return True
        return (
            name.lower() in self.names
            if self.usual
            else name in self.names or without_index(name) in self.names
        )


ALL, NONE = Choice(), Choice(frozenset())


def columns_named(names: Iterable[str]) -> Choice:
    """Return the choice of columns with these names, each with or without a unit."""
    return Choice(frozenset(spelt for name in names for spelt in spellings(name)))


def columns_of(axis: Axis | None) -> Choice:
    """Return the choice of columns named by an axis; without an axis, of columns with usual names."""
    if axis is None:
        return Choice(
            frozenset(name for names in USUAL_NAMES.values() for name in names), usual=True
        )
    return columns_named(
        [
            *(column.name for column in axis.columns.values()),
            *(channel.column for channel in axis.injected),
            *(term.column for term in axis.regressors if not term.file),
        ]
    )


@contextmanager
def damage_refused(source: Path) -> Iterator[None]:
    """Refuse a file whose reader raises an unforeseen error: the file is damaged, or your own reader is wrong."""
    try:
        yield
    except (InputError, MemoryError):
        raise
    except Exception as error:  # noqa: BLE001  (a damaged file makes a reader raise anything)
        message, mend = (
            f"is truncated or damaged, or in an unsupported format{said_by_library(error)}",
            "Copy or save it again",
        )
        if place := place_in_own_code(error):
            message = f"the reader of this file stopped with {type(error).__name__}: {error_text(error)} ({place})"
            mend = "Correct the reader. If the file is damaged, copy or save it again"
        raise InputError(message, path=str(source), mend=mend) from None


class Request(NamedTuple):
    """Options for reading a file; a reader receives them with the bytes: ``read(data, request)``."""

    source: Path
    table: str | None  # name of a table; formats with a single table ignore it
    choice: Choice  # of columns
    limit: int  # of the unpacked data [byte]
