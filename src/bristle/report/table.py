"""Tables of text, and columns of one quantity in which all numbers have the same unit and the same decimals."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from bristle.core.typography import Scale, number, scale_of

__all__ = ["Quantity", "Table"]

_NUMBER = re.compile(r"[−+±]? ?[\d.]+(e[−+]?\d+)?( ± [\d.]+)?|–|[−+]?∞")


EMPTY = ("", "–")  # cells that say nothing


class Table(NamedTuple):
    """A table: its caption, the heads of its columns, its rows; the first cell of a row is its head."""

    caption: str
    heads: Sequence[str]
    rows: Sequence[Sequence[str]]

    def is_number(self, column: int) -> bool:
        """Return whether a column holds numbers, which stand to the right."""
        cells = [row[column] for row in self.rows]
        return bool(cells) and all(_NUMBER.fullmatch(cell) for cell in cells)

    def without_empty_columns(self) -> Table:
        """Return the table without the columns in which no row has anything to say."""
        filled = [column for column in range(len(self.heads)) if any(row[column] not in EMPTY for row in self.rows)]
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

    @classmethod
    def at_least(cls, least: float, unit: str, value: float) -> Quantity:
        """Return the column for values of which one is told to three digits, in a unit no smaller than `least`."""
        scale = scale_of(unit, max(value, least))
        return cls(scale, value * scale.factor * 0.1)

    def head(self, word: str) -> str:
        """Return the head of the column."""
        return self.scale.label(word)

    def cell(self, value: float) -> str:
        """Return a number in SI as it stands in the column."""
        return number(value * self.scale.factor, self.step)
