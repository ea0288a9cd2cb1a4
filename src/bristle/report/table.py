"""Numbers, lengths and shares as text, and tables whose columns have one unit and the same decimals."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from bristle.core import Kind, Scale, number, scale_of, unit_of, with_unit

MICROMETRE = 1e-6  # the errors of servos are told in no smaller unit
_NUMBER = re.compile(r"[−+±]? ?[\d.]+(e[−+]?\d+)?( ± [\d.]+)?|–|[−+]?∞")


class Table(NamedTuple):
    """A table: its caption, the heads of its columns, its rows; the first cell of a row is its head."""

    caption: str
    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    macro = "table"

    @classmethod
    def of(cls, caption: str, rows: Sequence[Mapping[str, str]]) -> Table:
        """Return the table of rows that hold their cells by the heads of the columns."""
        return cls(caption, list(rows[0]) if rows else [], [list(row.values()) for row in rows])

    def is_number(self, column: int) -> bool:
        """Return whether a column holds numbers, which stand to the right."""
        return bool(self.rows) and all(_NUMBER.fullmatch(row[column]) for row in self.rows)

    def without_empty_columns(self) -> Table:
        """Return the table without the columns in which no row has anything to say."""
        # Empty cells have no text or a dash.
        filled = [column for column in range(len(self.heads)) if any(row[column] not in ("", "–") for row in self.rows)]
        return Table(self.caption, [self.heads[column] for column in filled], [[row[column] for column in filled] for row in self.rows])


class Quantity(NamedTuple):
    """A column of one quantity: in which multiple of its unit, and to which step."""

    scale: Scale
    step: float

    @classmethod
    def of(cls, unit: str, values: Iterable[float], digits: int = 3) -> Quantity:
        """Return the column for values in an SI unit, the largest of which is told to `digits`."""
        top = max((abs(value) for value in values if math.isfinite(value)), default=0.0)
        scale = scale_of(unit, top)
        return cls(scale, top * scale.factor * 10.0 ** (2 - digits))

    def head(self, word: str) -> str:
        """Return the head of the column."""
        return self.scale.label(word)

    def cell(self, value: float) -> str:
        """Return a number in SI as it stands in the column."""
        return number(value * self.scale.factor, self.step)


def fixed(value: float, unit: str) -> str:
    """Return a number with its unit, between which no line ends."""
    return with_unit(value, unit).replace(" ", "\u00a0")


def length_text(value: float, kind: Kind) -> str:
    r"""Return a length in no smaller unit than the micrometre, in which the errors of servos are told.

    Examples
    --------
    >>> length_text(4.19e-7, "translational"), length_text(2.5e-3, "rotational")
    ('0.419\xa0µm', '2.5\xa0mrad')
    """
    unit = unit_of("length", kind)
    return f"{short_text(value / MICROMETRE)}\u00a0µ{unit}" if 0.0 < abs(value) < MICROMETRE else fixed(value, unit)


def short_text(value: float) -> str:
    """Return a number to three digits."""
    return number(value, digits=3)


def percent_text(value: float) -> str:
    """Return a share to three digits."""
    return f"{short_text(value)}\u00a0%"


def span_text(values: Sequence[float], unit: str) -> str:
    """Return the least and the largest of values with their unit, once where they read alike."""
    low, high = (with_unit(end, unit) for end in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"


def interval_text(low: str, high: str) -> str:
    """Return an interval whose ends are written out; of two that are written alike, the digit that it is known to."""
    return f"{low} to {high}" if low != high else f"{low}, to the last digit"


def stiffness_text(stiffness: float, kind: str) -> str:
    """Return a stiffness [N/m or N*m/rad] as it is told of an axis: in N/µm or N·m/rad."""
    factor, unit = (1e-6, "N/µm") if kind == "translational" else (1.0, "N·m/rad")
    return f"{number(factor * stiffness, digits=3)} {unit}"
