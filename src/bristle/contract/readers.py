"""The contract of a log reader, built-in or a user's: reading its example, truncated parts of it, and other files."""

import io
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np

from bristle.contract.check import Check, Fact, UnmetError, outcomes
from bristle.core import Content, InputError, cached_property, error_text, units
from bristle.logs.catalogue import FORMATS, format_of
from bristle.logs.formats import START, LogFormat, reading
from bristle.logs.readers import read_table
from bristle.logs.table import Table
from bristle.logs.words import is_time

SEED = 20260
FILE = "example.log"
ENDINGS = ("", ".log", ".csv", ".dat")
CUTS = (0.1, 0.4, 0.7, 0.9)  # of the bytes of a file
LAST = (1, 2, 4)  # bytes before the end of a file
FEWEST_COLUMNS = 2
FEWEST_ROWS = 4
RAISE = f"Raise InputError(message, path=str(request.source)) from bristle.core, or any error: the message names {FILE}"


def check_reader(log_format: LogFormat, example: bytes = b"") -> list[Check]:
    """Run the contract suite on a log reader.

    Parameters
    ----------
    log_format : LogFormat
        A built-in format, or your own.
    example : bytes
        The contents of a small file of this format; by default the `example` of the format.

    Returns
    -------
    list of Check
        One for each demand, in order; if a demand of the form is not met, the others are skipped.
    """
    trial = _Trial(log_format, example or log_format.example)
    return outcomes(READER_CHECKS, trial, FORM, "Make read accept the bytes of its example")


class _Trial:
    """A format, and the result of reading its example."""

    def __init__(self, log_format: LogFormat, example: bytes) -> None:
        self.format = log_format
        self.example = example

    @cached_property
    def table(self) -> Table:
        """The contents of the example, as every command receives them."""
        return self.read(self.example)

    def read(self, data: bytes) -> Table:
        """Return the contents of bytes in this format."""
        content = Content(Path(FILE), data)
        if self.format.read is None:
            return read_table(content)
        # A part of a file may start differently from the whole: only the result of the reader counts.
        with reading(self.format._replace(recognises=lambda head, ending: True)):
            return read_table(content)

    @property
    def times(self) -> dict[str, np.ndarray]:
        """The columns of time, by name."""
        table = self.table
        named = (
            dict.fromkeys(table.stamps.values())
            or [name for name in table.columns if is_time(name)][:1]
        )
        return {name: table.columns[name] for name in named}


def described_reader(trial: _Trial) -> Fact:
    """State the usual name of the format, and give an example: the bytes of a small file of this format."""
    title = str(trial.format.title)
    if not title.strip() or not title.isprintable():
        raise UnmetError(
            f"the title is {title!r:.60}", "Give the usual name of such files in a few words"
        )
    if not isinstance(trial.example, bytes) or not trial.example.strip():
        raise UnmetError(
            "there is no example",
            f'Write LogFormat(..., example=b"...") with the bytes of {FEWEST_ROWS} rows or more',
        )
    return Fact(f"{title}: {len(trial.example)} bytes")


def recognises_its_example(trial: _Trial) -> Fact:
    """Recognize a file by its first bytes, whatever its file extension."""
    for ending in ENDINGS:
        if not trial.format.recognises(trial.example[:START], ending):
            raise UnmetError(
                f"its example is not recognized as {trial.format.title} in a file named log{ending}",
                f"Use head, the first {START} bytes, in recognises",
            )
    return Fact(f"with {len(ENDINGS)} endings")


def columns_of_numbers(trial: _Trial) -> Fact:
    """Give columns of numbers by name, of equal length or with separate times."""
    table = trial.table
    if len(table.columns) < FEWEST_COLUMNS:
        raise UnmetError(
            f"it gives {len(table.columns)} columns of numbers",
            "Return arrays of numbers by their names",
        )
    for name, values in table.columns.items():
        if values.ndim != 1 or values.dtype.kind != "f" or values.size < FEWEST_ROWS:
            raise UnmetError(
                f"column {name!r} has the type {values.dtype} and the shape {values.shape}",
                f"Return one array of numbers for each column; the example has {FEWEST_ROWS} rows or more",
            )
    if not {*table.columns, *table.stamps.values()} <= set(table.names):
        raise UnmetError(
            "the list names lacks existing columns", "Omit names, or list every column in it"
        )
    plain = [name for name in table.columns if name not in {*table.stamps, *table.stamps.values()}]
    pairs = []
    if not table.tables:
        # Each column is as long as its time column, or as the first other column; tables of one file may differ.
        pairs = [*table.stamps.items(), *((name, plain[0]) for name in plain)]
    for name, beside in pairs:
        rows = table.columns[name].size
        expected = table.columns[beside].size
        if rows != expected:
            raise UnmetError(
                f"column {name!r} has {rows} rows, and {beside!r} has {expected}",
                "Return columns of equal length, or a Table with stamps: the time column of each column",
            )
    return Fact(f"{len(table.columns)} columns, {next(iter(table.columns.values())).size} rows")


def units_that_exist(trial: _Trial) -> Fact:
    """Give existing units to existing columns."""
    for name, unit in trial.table.units.items():
        if name not in trial.table.names:
            raise UnmetError(
                f"there is a unit for {name!r}, but no such column",
                "Give units by the names of columns",
            )
        try:
            units.si_of(unit)
        except InputError as error:
            raise UnmetError(
                f"column {name!r} has the unit {unit!r}, which does not exist",
                error.mend or "Write mm, N, A, %, or omit the unit: the axis file then states it",
            ) from None
    return Fact(
        ", ".join(f"{name} [{unit}]" for name, unit in trial.table.units.items()) or "no units"
    )


def time_in_order(trial: _Trial) -> Fact:
    """Give times that are numbers and increase, or the time between samples."""
    for name, values in trial.times.items():
        if not np.all(np.isfinite(values)):
            raise UnmetError(
                f"column {name!r} has times that are not numbers", "Omit rows without a time"
            )
        falls = np.flatnonzero(np.diff(values) < 0.0)
        if falls.size:
            raise UnmetError(
                f"column {name!r} decreases after row {falls[0] + 1}",
                "Return rows in the order of their times, and unwrap a counter",
            )
    period = trial.table.sample_time
    if period is not None and not (np.isfinite(period) and period > 0.0):
        raise UnmetError(
            f"the time between samples is {period!r}", "Give sample_time in seconds, or omit it"
        )
    if not trial.times and period is None:
        return Fact("no time: the axis file states the time between samples", applies=False)
    return Fact(", ".join(trial.times) or f"every {period:g} s")


def same_log_twice(trial: _Trial) -> Fact:
    """Give the same numbers, units and notes for the same bytes."""
    first = trial.table
    again = trial.read(trial.example)
    facts = [
        (table.units, table.notes, table.stamps, table.sample_time, list(table.columns))
        for table in (first, again)
    ]
    if facts[0] != facts[1] or any(
        again.columns[name].tobytes() != values.tobytes() for name, values in first.columns.items()
    ):
        raise UnmetError(
            "the second reading differs",
            "Use only the bytes: no clock, no counter, no unordered set",
        )
    return Fact(f"{sum(values.size for values in first.columns.values())} numbers")


def leaves_other_files(trial: _Trial) -> Fact:
    """Claim no file of another format, and never fail: recognises is called for every file, even an empty one."""
    if trial.format is FORMATS[-1]:
        return Fact("it is called last, for files that no other format claims", applies=False)
    foreign = {
        title: data
        for title, data in other_files().items()
        if format_of(data, "") is not trial.format
    }
    for title, data in foreign.items():
        for ending in ENDINGS:
            try:
                claimed = trial.format.recognises(data[:START], ending)
            except Exception as error:  # noqa: BLE001  (user code may raise any error)
                raise UnmetError(
                    f"recognises stops with {type(error).__name__}: {error_text(error)} ({title})",
                    "Return False for unknown files",
                ) from None
            if claimed:
                raise UnmetError(
                    f"it recognizes a file of another format as its own: {title}",
                    "Check more of the first bytes in recognises",
                )
    return Fact(f"{len(foreign)} files of other formats")


def tells_where_a_file_ends_early(trial: _Trial) -> Fact:
    """Refuse a truncated file with its name, or give its whole rows and note that the last row may be cut."""
    refused = 0
    short = 0
    ends = {
        *(round(share * len(trial.example)) for share in CUTS),
        *(len(trial.example) - last for last in LAST),
    }
    for part in [trial.example[:end] for end in sorted(ends) if trial.example[:end].strip()]:
        try:
            table = trial.read(part)
        except InputError as error:
            if FILE not in str(error.path):
                raise UnmetError(
                    f"truncated to {len(part)} bytes, it is refused without its name: {error}",
                    RAISE,
                ) from None
            refused += 1
        else:
            _refuse_other_rows(trial.table, table, len(part))
            short += 1
    return Fact(f"{refused} parts refused, {short} read up to their end")


def _refuse_other_rows(complete: Table, part: Table, size: int) -> None:
    """Refuse rows that differ from the whole file; a note may declare the last row as cut."""
    for name, values in complete.columns.items():
        read = part.columns.get(name, np.empty(0))
        if not 0 < read.size <= values.size:
            raise UnmetError(
                f"truncated to {size} bytes, column {name!r} has {read.size} rows, without a note",
                RAISE,
            )
        differs = np.flatnonzero(
            ~((read == values[: read.size]) | (np.isnan(read) & np.isnan(values[: read.size])))
        )
        may_be_cut = part.notes != complete.notes
        if differs.size and not (may_be_cut and differs[0] == read.size - 1):
            raise UnmetError(
                f"truncated to {size} bytes, row {differs[0] + 1} of {name!r} is {read[differs[0]]:g} instead of "
                f"{values[differs[0]]:g} in the whole file",
                "Omit an incomplete last row, or refuse the file",
            )


FORM = (described_reader, recognises_its_example, columns_of_numbers)
READER_CHECKS = (
    *FORM,
    units_that_exist,
    time_in_order,
    same_log_twice,
    leaves_other_files,
    tells_where_a_file_ends_early,
)


@cache
def other_files() -> Mapping[str, bytes]:
    """Return files of many kinds, by their usual names, each long enough to be recognized."""
    rows = [(0.001 * k, 1.5 * k, -3.25) for k in range(40)]
    archive = io.BytesIO()
    array = io.BytesIO()
    np.savez(archive, t=np.arange(40.0), q=np.arange(40.0))
    np.save(array, np.arange(80.0).reshape(40, 2))
    return {
        "text with commas": "\n".join(
            ["t,q [mm],force [N]", *(f"{t:.3f},{x},{f}" for t, x, f in rows)]
        ).encode(),
        "text with decimal commas": "\r\n".join(
            ["Zeit;Weg [mm];Kraft [N]", *(f"{t:.3f};{x};{f}".replace(".", ",") for t, x, f in rows)]
        ).encode("utf-16"),
        "text with tabs and a preamble": b"Name\tScope\nStart\t2025-03-14\n\nTime [ms]\tActPos\n0\t1.5\n1\t1.6\n",
        "numbers alone": "\n".join(f"{t} {x} {f}" for t, x, f in rows).encode(),
        "JSON": b'[{"t": 0.0, "position": 1.5}, {"t": 0.001, "position": 1.6}]',
        "objects of JSON, line by line": b'{"t": 0.0, "x": 1.5}\n{"t": 0.001, "x": 1.6}\n',
        "XML": b'<?xml version="1.0" encoding="UTF-8"?>\n<trace><signal name="x">1 2 3</signal></trace>\n',
        "settings": b"[axis]\nname = bench\nkind=translational\n# a remark\n",
        "NPZ": archive.getvalue(),
        "NPY": array.getvalue(),
        "HDF5": b"\x89HDF\r\n\x1a\n" + bytes(64),
        "MAT": b"MATLAB 5.0 MAT-file, Platform: GLNXA64".ljust(128),
        "MAT v7.3": b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512),
        "Parquet": b"PAR1\x15\x04\x15" + bytes(64),
        "MF4": b"MDF     4.10    ".ljust(64, b"\0"),
        "MCAP": b"\x89MCAP0\r\n" + bytes(64),
        "TDMS": b"TDSm" + bytes(64),
        "a spreadsheet": b"PK\x03\x04" + bytes(22) + b"xl/workbook.xml",
        "a document": b"%PDF-1.7\n1 0 obj\n",
        "compressed data": b"\x1f\x8b\x08" + bytes(64),
        "nothing": b"",
        "blanks": b" \r\n\n",
        "noise": np.random.default_rng(SEED).bytes(START),
    }
