"""`Card`: a result in a few lines, as the prompt shows it and as a notebook does."""

from __future__ import annotations

from html import escape
from typing import NamedTuple

from bristle.core.errors import in_one_line, shortened

__all__ = ["Card", "WithCard"]

MOST_ROWS, MOST_REMARKS = 20, 6  # with title, heads and what is left out 30 lines: a screen
WIDEST = 100  # characters of a remark


class Card(NamedTuple):
    """A title, a table, and remarks; what is too much of it is counted."""

    title: str
    heads: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def _rest(self) -> list[str]:
        """The remarks, as many as there is room for, and how much is left out."""
        lines = [shortened(in_one_line(remark), WIDEST) for remark in self.remarks[:MOST_REMARKS]]
        for left, noun in ((len(self.rows) - MOST_ROWS, "rows"), (len(self.remarks) - MOST_REMARKS, "remarks")):
            lines += [f"and {left} more {noun}"] if left > 0 else []
        return lines

    def text(self) -> str:
        """Return it as lines of text, fewer than a screen has."""
        rows = [tuple(map(in_one_line, row)) for row in (self.heads, *self.rows[:MOST_ROWS]) if row]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
        return "\n".join([in_one_line(self.title), *(f"  {line}".rstrip() for line in (*lines, *self._rest))])

    def html(self) -> str:
        """Return it as HTML; what comes from files is escaped."""

        def row(cells: tuple[str, ...], tag: str) -> str:
            side = ' style="text-align: left; padding-right: 1em"'
            return "<tr>" + "".join(f"<{tag}{side}>{escape(in_one_line(cell))}</{tag}>" for cell in cells) + "</tr>"

        body = "".join(row(cells, "td") for cells in self.rows[:MOST_ROWS])
        table = f"<table><thead>{row(self.heads, 'th')}</thead><tbody>{body}</tbody></table>" if self.rows else ""
        remarks = "".join(f"<li>{escape(remark)}</li>" for remark in self._rest)
        listed = f"<ul>{remarks}</ul>" if remarks else ""
        return f"<div><strong>{escape(in_one_line(self.title))}</strong>{table}{listed}</div>"


class WithCard:
    """A result that is shown as a card rather than with all its numbers."""

    def __init_subclass__(cls, **arguments: object) -> None:
        super().__init_subclass__(**arguments)
        # A dataclass brings a representation of its own for each class that has none.
        cls.__repr__ = WithCard.__repr__  # type: ignore[method-assign]

    def _card(self) -> Card:
        """Return what is shown of it."""
        return Card(type(self).__name__)

    def __repr__(self) -> str:
        return self._card().text()

    def _repr_html_(self) -> str:
        return self._card().html()
