"""Reading logs: what many columns and long headers cost, against as many cells in few columns and a short header."""

from __future__ import annotations

import io
from collections.abc import Iterator

import numpy as np

from benchmarks.timing import Ratio, side_by_side
from bristle.core.content import content_of
from bristle.logs import summarize
from bristle.logs.readers import read_table

__all__ = ["readers"]

SHORT, LONG = 600, 60_000  # characters of a header


def readers() -> Iterator[Ratio]:
    """Time text files that only differ in shape: reading is linear in cells and in characters."""
    wide, tall = content_of(_export(2000, 30)), content_of(_export(20, 3000))
    for name, read in (("read", read_table), ("looked through", summarize)):
        ours, theirs, ratio = side_by_side(
            lambda read=read: read(wide), lambda read=read: read(tall), 15
        )
        yield Ratio(
            f"2 000 columns of 30 rows, {name}",
            ours,
            theirs,
            ratio,
            2.0 if name == "read" else None,
            "20 columns of 3 000 rows",
        )
    for name, middle in (
        ("blanks in a bracket", " "),
        ("opening brackets", "["),
        ("a name", "x"),
        ("names", "x,"),
    ):
        long, short = (content_of(_headed(middle, length)) for length in (LONG, SHORT))
        ours, theirs, ratio = side_by_side(
            lambda long=long: read_table(long), lambda short=short: read_table(short), 15
        )
        yield Ratio(
            f"a header of {LONG} characters, {name}",
            ours,
            theirs,
            ratio / (LONG / SHORT),
            3.0,
            f"a header of {SHORT} characters, per character",
        )


def _export(columns: int, rows: int) -> bytes:
    """Return a log as a scope exports it."""
    numbers = np.random.default_rng(columns).standard_normal((rows, columns))
    numbers[:, 0] = 1e-3 * np.arange(rows)
    head = ",".join(["t [s]", *(f"channel {i} [mm]" for i in range(1, columns))])
    text = io.StringIO()
    np.savetxt(text, numbers, fmt="%.6g", delimiter=",", header=head, comments="")
    return text.getvalue().encode()


def _headed(middle: str, length: int) -> bytes:
    """Return a log of few rows below a header of this length: one cell of it, or as many as its separators make."""
    cells = middle.count(",") * (length // len(middle))
    row = ",".join(["0.1"] * (2 + cells))
    return f"t [s],x [{middle * (length // len(middle))} mm]\n{f'{row}{chr(10)}' * 3}".encode()
