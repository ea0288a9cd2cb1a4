"""`Table`: what a reader finds in a file, before anything is known of the axis."""

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple
from unicodedata import normalize

import numpy as np

from bristle.core import units
from bristle.core.axis import Axis
from bristle.core.content import NOWHERE, Origin
from bristle.core.errors import InputError, did_you_mean, place_in_own_code, said_by_library, shortened, told_by

NUMBER_BYTES = 8
# Of an axis in a SINUMERIK (its unit, its number), or of one of several signals of a name: no unit.
_INDEX = re.compile(r"(?P<name>.*\S)\s*\[u(?P<unit>\d+)(?:[\s,;]+(?P<axis>\d+))?\]|(?P<plain>.*\w)\[\d+\]")


@dataclass(frozen=True)
class Table:
    """Named columns of numbers, as a file holds them.

    Parameters
    ----------
    columns : mapping of str to ndarray
        Each column, 1-D; lengths may differ in formats that allow it.
    units : mapping of str to str
        Unit of a column, where the file says it.
    constants : mapping of str to float
        Named single numbers.
    texts : mapping of str to InputError
        Columns left out because they hold no numbers, and why.
    sample_time : float or None
        Sample time, where the file knows it [s].
    notes : tuple of str
        What the reader left out or assumed.
    format : str
        Kind of file.
    source : Path
        The file.
    tables : tuple of str
        Names of the tables that the columns are from, where there are several and none was chosen.
    names : tuple of str
        All columns of numbers, those that were not read among them.
    origin : Origin
        Name and checksum of what was read.
    stamps : mapping of str to str
        Column -> the column of its time, in files whose channels bring their own: nobody has to name it.
    facts : mapping of str to str
        What stands beside the columns: the device, its rated torque, a date.
    numbers : mapping of str to str
        ``column_2`` and the like -> the name of that column.
    about : mapping of str to str
        What a file says of a column beside its name: a comment, the full name of a symbol, its data type.
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

    def name_of(self, name: str) -> str | None:
        """Return the column called `name`, with or without a unit in brackets; None if there is none."""
        for spelling in (*spellings(name), self.numbers.get(name, "")):
            if spelling in self.columns:
                return spelling
        alike = [column for column in self.columns if without_index(column) == name]
        return alike[0] if len(alike) == 1 else None

    def unknown_unit(self, name: str) -> str:
        """Return what the file says for the unit of a column, where that is no unit that is known; else nothing."""
        unit = self.units.get(name, "")
        return "" if not unit or units.is_unit(unit) else unit

    def has(self, name: str) -> bool:
        """Return whether there is a column called `name`, with or without a unit in brackets, read or not."""
        return any(spelling in self.names for spelling in spellings(name))

    def missing(self, name: str, key: str) -> InputError:
        """Return the error that says which columns there are instead of `name`, asked for under `key`."""
        for text, reason in self.texts.items():
            if name in (text, split_unit(text)[0]):
                mend = reason.mend or f"Name a column of numbers as the {key} in the axis file"
                return InputError(f"{reason.message}, and the column is to be the {key}", path=reason.path, value=reason.value, mend=mend)
        if self.tables:
            message = f"holds {len(self.tables)} tables, and no column {name!r} beside them, which is to be the {key}"
            mend = 'Name the table: table = "..." under [log] of the axis file, or FILE::TABLE in place of the file'
            return InputError(message, path=str(self.source), allowed=some_of(self.tables), mend=mend)
        mend = f"{name!r} is a single number there. " if name in self.constants else ""
        mend += did_you_mean(name, self.names, 0.5) or f"Name the {key} in the axis file"
        message = f"has no column {name!r}, which is to be the {key}"
        return InputError(message, path=str(self.source), allowed=some_of(self.names, 40), mend=mend)


def some_of(names: Iterable[str], most: int = 8) -> str:
    """Return the first of several names, and how many more there are."""
    listed = list(names)
    left = len(listed) - most
    return ", ".join(shortened(text, 60) for text in listed[:most]) + (f" and {left} more" if left > 0 else "")


def spellings(name: str) -> tuple[str, ...]:
    """Return what a column may be called that a person calls so: without its unit, its letters in one piece each."""
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
    """Return a name without the index behind it that tells axes, or signals of one name, apart."""
    match = _INDEX.fullmatch(name.strip())
    return name if match is None else match["name"] or match["plain"]


def axis_in(address: str) -> tuple[str, str] | None:
    """Return the unit and the number of the axis in an address of a SINUMERIK; None where it names no axis."""
    match = _INDEX.fullmatch(address.strip())
    return (match["unit"], match["axis"]) if match and match["axis"] else None


# What a column may be called where no axis file says which channel it is.
USUAL_NAMES = {
    "time": ("time", "t"),
    "position": ("position", "pos", "q", "x"),
    "velocity": ("velocity", "vel", "v"),
    "effort": ("effort", "force", "torque"),
    "reference": ("reference", "position_ref", "setpoint"),
}


@dataclass(frozen=True)
class Choice:
    """Names of columns; None for all. Where they are `usual` ones, their case does not matter."""

    names: frozenset[str] | None = None
    usual: bool = False

    def __call__(self, name: str, number: int = 0) -> bool:
        """Return whether this column is chosen, by its name or its number in the file."""
        if self.names is None or f"column_{number}" in self.names:
            return True
        return name.lower() in self.names if self.usual else name in self.names or without_index(name) in self.names


ALL, NONE = Choice(), Choice(frozenset())


def columns_named(names: Iterable[str]) -> Choice:
    """Return the choice of columns of these names, each with or without the unit behind it."""
    return Choice(frozenset(spelt for name in names for spelt in spellings(name)))


def columns_of(axis: Axis | None) -> Choice:
    """Return the choice of the columns that an axis names; without one, of those that are called as usual."""
    if axis is None:
        return Choice(frozenset(name for names in USUAL_NAMES.values() for name in names), usual=True)
    return columns_named(
        [*(column.name for column in axis.columns.values()), *(channel.column for channel in (*axis.injected, *axis.regressors))]
    )


@contextmanager
def damage_refused(source: Path) -> Iterator[None]:
    """Refuse a file whose reader raises an error that it does not foresee: the file is damaged, or a reader of one's own wrong."""
    try:
        yield
    except (InputError, MemoryError):
        raise
    except Exception as error:  # noqa: BLE001  (a damaged file makes a reader raise anything)
        message, mend = f"is truncated or damaged, or of a kind that is not read{said_by_library(error)}", "Copy or save it again"
        if place := place_in_own_code(error):
            message = f"stops its reader with {type(error).__name__}: {told_by(error)} ({place})"
            mend = "Correct the reader; if the file is damaged, copy or save it again"
        raise InputError(message, path=str(source), mend=mend) from None


class Request(NamedTuple):
    """What is read of a file; its reader takes it beside the bytes, ``read(data, request)``."""

    source: Path
    table: str | None  # in it; files of most kinds are one table, and do not use it
    choice: Choice  # of columns
    limit: int  # of what is read, unpacked [byte]
