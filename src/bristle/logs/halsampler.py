"""Text of halsampler, the recorder of LinuxCNC: rows of numbers without a header and without time.

The sample time is that of the thread, which only the axis file states. Each lost sample would shift the clock. Therefore
the reader looks for lost samples in the tags of ``-t``, in columns that count the rows, and in lines ``overrun``.
"""

import io
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from bristle.core.content import content_of, refuse_larger
from bristle.core.errors import InputError
from bristle.logs.formats import LogFormat
from bristle.logs.table import NUMBER_BYTES, Request, Table
from bristle.logs.words import names_and_units

OVERRUN = b"overrun"
GRID = 1e-6  # halsampler prints numbers with six decimals
COARSE = 1000  # steps of the grid from row to row, in a column of less than 1 unit, below which the grid is reported
COUNTS = 0.5  # of the rows: share of steps of 1 in a column that counts the rows
WRAP = 2.0**32  # of a counter
MOST_FILES, FILE_BYTES = 50, 2**20  # HAL files beside the log
_ROW = re.compile(rb"(?:(?:-?\d+(?:\.\d{6})?|-?nan|-?inf) )+")
_COMMENT = re.compile(r"#.*")
_PIN = re.compile(r"sampler\.(\d+)\.pin\.(\d+)")
MEND_LOST = "Record again with a larger depth of the sampler: `loadrt sampler depth=...`; its pin overruns must stay 0"


def recognises(head: bytes, suffix: str) -> bool:
    """Return whether text has only rows of halsampler: single blanks, one more at the end, integers or six decimals."""
    lines = head.replace(b"\r\n", b"\n").split(b"\n")[:-1]
    rows = lines[1:] if lines[:1] == [OVERRUN] else lines
    return (
        len(rows) > 1
        and all(line == OVERRUN or _ROW.fullmatch(line) for line in rows)
        and _ROW.fullmatch(rows[0]) is not None
    )


def read(data: bytes, request: Request) -> Table:
    """Return the columns, named by the signals of a HAL file beside the log, or by number; without columns that count the rows."""
    place, notes = str(request.source), []
    lines = data.replace(b"\r\n", b"\n").split(b"\n")
    if lines[0] == OVERRUN:  # each new halsampler prints it
        lines[0] = b""
    if last := lines.pop():
        notes.append(
            f"the file ends within a row: bristle ignores this row, {last[:60].decode('ascii', 'replace')!r}"
        )
    rows, at = (
        [line for line in lines if line and line != OVERRUN],
        [i for i, line in enumerate(lines) if line and line != OVERRUN],
    )
    width = len(rows[0].split())
    refuse_larger(len(rows) * width * NUMBER_BYTES, request.limit, request.source)
    try:
        values = np.loadtxt(io.BytesIO(b"\n".join(rows)), ndmin=2)
    except ValueError:
        i, row = next(
            (i, row)
            for i, row in zip(at, rows, strict=True)
            if _ROW.fullmatch(row) is None or row.count(b" ") != width
        )
        raise InputError(
            "is not a row of halsampler",
            path=f"{place}: line {i + 1}",
            value=row[:60].decode("ascii", "replace"),
            mend="Record again, or delete the lines from here on",
        ) from None
    counters = [k for k in range(width) if counts_rows(values[:, k])]
    # After its buffer was full once, HAL leaves one old row, which is the first of the next record.
    jumps = np.array([_steps(values[:, k]) != 1.0 for k in counters])
    if jumps.size and np.any(jumps[:, 0]) and not np.any(jumps[:, 1:]):
        values, at = values[1:], at[1:]
        notes.append("the first row is an old one of the buffer of HAL: bristle ignores it")
    _refuse_losses(
        values, counters, [i for i, line in enumerate(lines) if line == OVERRUN], at, place
    )
    signals, remarks = signals_beside(
        request.source, len(data), width, tagged=0 in counters and b"." not in rows[0].split()[0]
    )
    names = [signals.get(k, f"column_{k + 1}") for k in range(width)]
    called, _, renamed = names_and_units(names, {})
    columns = {
        name: np.ascontiguousarray(values[:, k])
        for k, name in enumerate(called)
        if k not in counters
    }
    notes += [
        *remarks,
        *renamed,
        *(note for name, column in columns.items() for note in _grid(name, column)),
    ]
    if counters:
        notes.append(
            f"no sample is lost, as {' and '.join(f'column_{k + 1}' for k in counters)} shows, which counts the rows"
        )
    mend = 'Write sample_time = "1 ms", the period of the thread, under [timing] of the axis file'
    counting = {
        called[k]: InputError(
            "counts the rows and is no time", path=f"{place}: {called[k]}", mend=mend
        )
        for k in counters
    }
    numbers = {f"column_{k + 1}": name for k, name in enumerate(called)}
    return Table(
        columns,
        texts=counting,
        notes=tuple(notes),
        format="halsampler",
        names=tuple(columns),
        numbers=numbers,
    )


def _steps(values: np.ndarray) -> np.ndarray:
    """Return the steps of a counter; it continues from 0 at `WRAP`."""
    steps = np.diff(values)
    return np.where(steps < -0.5 * WRAP, steps + WRAP, steps)


def counts_rows(values: np.ndarray) -> bool:
    """Return whether a column counts the rows: whole numbers that rise, most often by 1."""
    if values.size < 3 or not np.all(np.isfinite(values)) or np.any(values % 1.0):
        return False
    steps = _steps(values)
    return bool(
        np.mean(steps == 1.0) >= COUNTS and (np.all(steps >= 1.0) or np.mean(steps == 1.0) > 0.9)
    )


def _refuse_losses(
    values: np.ndarray, counters: list[int], overruns: list[int], at: list[int], place: str
) -> None:
    """Refuse a log with lost samples, by a jump of a counter or by a line of halsampler, which does not state their number."""
    for k in counters:
        lost = _steps(values[:, k]) - 1.0  # samples that the counter lacks between rows
        if jumps := np.flatnonzero(lost).tolist():
            cell = f"{place}: line {at[jumps[0] + 1] + 1}, column_{k + 1}"
            count = f"{lost[jumps].sum():.0f} samples in {len(jumps)} {'place' if len(jumps) == 1 else 'places'}"
            if np.any(lost < 0.0):
                raise InputError(
                    "jumps back: the recording restarted, or the column counts something else",
                    path=cell,
                    mend=MEND_LOST,
                )
            raise InputError(f"lost {count}", path=cell, mend=MEND_LOST)
    if overruns:
        message = "lost samples before this line, an unknown number" + (
            "" if not counters else ", although the counter continues"
        )
        raise InputError(
            message, path=f"{place}: line {overruns[0] + 1}", value="overrun", mend=MEND_LOST
        )


def _grid(name: str, values: np.ndarray) -> Iterator[str]:
    """Yield a note on a column whose grid of six decimals is visible from row to row."""
    finite = values[np.isfinite(values)]
    moved = np.abs(np.diff(finite))
    moved = moved[moved > 0.0]
    if (
        moved.size
        and np.any(finite % 1.0)
        and np.ptp(finite) < 1.0
        and float(np.median(moved)) < COARSE * GRID
    ):
        usual = max(round(float(np.median(moved)) / GRID), 1)
        yield (
            f"{name} has a grid of {GRID:g}, and the usual step from row to row is {usual} of the grid. If it is in m, the grid is "
            "1 um, too coarse for pre-sliding: record a smaller unit, such as mm or um"
        )


def signals_beside(
    source: Path, size: int, width: int, *, tagged: bool
) -> tuple[dict[int, str], list[str]]:
    """Return signals by column from the HAL file beside a log, preferably that of the same name, and remarks."""
    # Not an upload, which has only a name.
    is_here = source.is_file() and source.stat().st_size == size
    files = sorted(source.parent.glob("*.hal"))[:MOST_FILES] if is_here else []
    files = [file for file in files if file.stem == source.stem] or files
    mappings: dict[tuple[tuple[int, str], ...], str] = {}
    for file in files:
        for count, signals in signals_of(
            content_of(file, limit=FILE_BYTES).data.decode("utf-8", "replace")
        ).values():
            before = width - (count or max(signals) + 1)  # a tag stands before the pins
            if not count and not tagged and before > 0:
                before = 0  # the last pins have no signal
            if before == 0 or (before == 1 and tagged):
                mappings.setdefault(
                    tuple(sorted((pin + before, name) for pin, name in signals.items())), file.name
                )
    if len(mappings) == 1:
        signals_by_column, name = next(iter(mappings.items()))
        return dict(signals_by_column), [f"bristle names the columns by the signals in {name}"]
    hal_files = ", ".join(dict.fromkeys(mappings.values()))
    return {}, [
        f"samplers in {hal_files} have different signals: bristle numbers the columns"
    ] if mappings else []


def signals_of(text: str) -> dict[int, tuple[int, dict[int, str]]]:
    """Return the number of pins of each sampler with signals in a HAL file, 0 if it is not stated, and the signal at each pin."""
    signals: dict[int, dict[int, str]] = {}
    counts: list[int] = []
    for line in text.replace("\\\n", " ").splitlines():
        words = [
            word
            for word in _COMMENT.sub("", line).split()
            if word not in ("=>", "<=", "<=>", "==>", "<==")
        ]
        if words[:2] == ["loadrt", "sampler"]:
            counts = [
                len(letters)
                for word in words
                if word.startswith("cfg=")
                for letters in word[4:].split(",")
            ]
        if len(words) < 3 or words[0] not in ("net", "linkps", "linksp"):
            continue
        signal, pins = (words[2], words[1:2]) if words[0] == "linkps" else (words[1], words[2:])
        for match in filter(None, map(_PIN.fullmatch, pins)):
            signals.setdefault(int(match[1]), {})[int(match[2])] = signal
    return {k: (counts[k] if k < len(counts) else 0, signals[k]) for k in signals}


EXAMPLE = b"overrun\n" + b"".join(
    b"%d %.6f %.6f 1 \n" % (k, 0.25 * k, 3.5 - 0.125 * k) for k in range(40)
)
FORMAT = halsampler = LogFormat(
    "halsampler", "halsampler of LinuxCNC", recognises, read=read, example=EXAMPLE
)
