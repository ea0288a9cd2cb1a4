"""Numbers, lengths and shares as text, and tables with one unit and the same decimals in each column."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from bristle.core import Kind, Scale, number, scale_of, unit_of, with_unit

MICROMETRE = 1e-6  # the smallest unit for errors of servos
_NUMBER = re.compile(r"[−+±]? ?[\d.]+(e[−+]?\d+)?( ± [\d.]+)?|–|[−+]?∞")


class Table(NamedTuple):
    """A table: caption, column heads and rows; the first cell of a row is its head."""

    caption: str
    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    macro = "table"

    @classmethod
    def of(cls, caption: str, rows: Sequence[Mapping[str, str]]) -> Table:
        """Return the table of rows that map column heads to cells."""
        return cls(caption, list(rows[0]) if rows else [], [list(row.values()) for row in rows])

    def is_number(self, column: int) -> bool:
        """Return whether a column has numbers, which are aligned to the right."""
        return bool(self.rows) and all(_NUMBER.fullmatch(row[column]) for row in self.rows)

    def without_empty_columns(self) -> Table:
        """Return the table without empty columns."""
        # Empty cells have no text or a dash.
        filled = [
            column
            for column in range(len(self.heads))
            if any(row[column] not in ("", "–") for row in self.rows)
        ]
        return Table(
            self.caption,
            [self.heads[column] for column in filled],
            [[row[column] for column in filled] for row in self.rows],
        )


class Quantity(NamedTuple):
    """A column of one quantity, with its scaled unit and step."""

    scale: Scale
    step: float

    @classmethod
    def of(cls, unit: str, values: Iterable[float], digits: int = 3) -> Quantity:
        """Return the column for values in an SI unit, with `digits` for the largest."""
        top = max((abs(value) for value in values if math.isfinite(value)), default=0.0)
        scale = scale_of(unit, top)
        return cls(scale, top * scale.factor * 10.0 ** (2 - digits))

    def head(self, word: str) -> str:
        """Return the head of the column."""
        return self.scale.label(word)

    def cell(self, value: float) -> str:
        """Return the cell for a number in SI."""
        return number(value * self.scale.factor, self.step)


def fixed(value: float, unit: str) -> str:
    """Return a number with its unit, joined by a no-break space."""
    return with_unit(value, unit).replace(" ", "\u00a0")


def length_text(value: float, kind: Kind) -> str:
    r"""Return a length in micrometres or a larger unit.

    Examples
    --------
    >>> length_text(4.19e-7, "translational"), length_text(2.5e-3, "rotational")
    ('0.419\xa0µm', '2.5\xa0mrad')
    """
    unit = unit_of("length", kind)
    return (
        f"{short_text(value / MICROMETRE)}\u00a0µ{unit}"
        if 0.0 < abs(value) < MICROMETRE
        else fixed(value, unit)
    )


def capital(text: str) -> str:
    """Return a text with a capital at its beginning; the name of the program keeps its small letter."""
    return text if re.match(r"bristle\b", text) else f"{text[:1].upper()}{text[1:]}"


def short_text(value: float) -> str:
    """Return a number to three digits."""
    return number(value, digits=3)


def percent_text(value: float) -> str:
    """Return a share to three digits."""
    return f"{short_text(value)}\u00a0%"


def span_text(values: Sequence[float], unit: str) -> str:
    """Return the range of values with their unit; a single value if both ends have the same text."""
    low, high = (with_unit(end, unit) for end in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"


def interval_text(low: str, high: str) -> str:
    """Return an interval by its ends; ends with the same text give that number, exact to its last digit."""
    return f"{low} to {high}" if low != high else f"{low}, to the last digit"


def stiffness_text(stiffness: float, kind: str) -> str:
    """Return a stiffness [N/m or N*m/rad] of an axis in N/µm or N·m/rad."""
    factor, unit = (1e-6, "N/µm") if kind == "translational" else (1.0, "N·m/rad")
    return f"{number(factor * stiffness, digits=3)} {unit}"
