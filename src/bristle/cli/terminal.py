"""Text, tables, progress bars and one-line errors on any terminal, in a pipe, and without Unicode."""

from __future__ import annotations

import codecs
import errno
import io
import os
import sys
import tempfile
import textwrap
import threading
import traceback
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from datetime import timedelta
from time import monotonic
from typing import TYPE_CHECKING, Any, TextIO

from bristle.cli.signals import INTERRUPTED

if TYPE_CHECKING:
    from rich.console import Console

    from bristle.report.brief import Line
    from bristle.report.table import Table

NO = 1
BAD_INPUT = 2
OUR_BUG = 70
LONGEST = 500  # letters
NO_OUTPUT = {errno.ENOSPC, errno.EFBIG, errno.EDQUOT, errno.EIO, errno.EBADF, errno.EROFS}
PATIENCE = 1.0  # [s]
PIPE_WIDTH = 160
READ_WELL = 100
LABEL = 12  # letters of a label and its blanks


def streams_that_take_all() -> None:
    """Let the standard streams replace characters that their encoding lacks; a closed stream (``>&-``) discards its text."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115  (it lives as long as we do)
    codecs.register_error("plain", _plain)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="plain")


def _plain(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    from bristle.core import escaped, spelt_out

    return "".join(map(spelt_out, escaped(error.object[error.start : error.end]))), error.end


def one_line(text: str) -> str:
    """Return text in one line without control characters, such as those in a file name."""
    from bristle.core import printable

    return " ".join(printable(text).split())


def complain(text: str) -> None:
    """Write one line to the standard error stream. Ignore a closed or full stream."""
    with suppress(OSError):
        print(f"bristle: {one_line(text)}", file=sys.stderr)


def exit_code(failed: object, code: int = NO) -> int:
    """Return 0, or an exit code if something failed."""
    if failed:
        return code
    return 0


def _console(stream: TextIO) -> Console:
    from rich.console import Console

    width = PIPE_WIDTH
    if stream.isatty():
        width = None

    def ended() -> None:
        raise BrokenPipeError  # its own way is to end the program with the code that says no

    console = Console(file=stream, width=width, markup=False, emoji=False, highlight=False)
    console.on_broken_pipe = ended
    return console


def say(text: str) -> None:
    """Write a paragraph to the standard output; a line may break between number and unit, unlike in pages."""
    _console(sys.stdout).print(text.replace("\u00a0", " "))


def say_laid_out(lay_out: Callable[[int], str]) -> None:
    """Write text laid out for the width of the terminal, or for a readable width if the terminal is wider."""
    console = _console(sys.stdout)
    console.print(f"{lay_out(min(console.width, READ_WELL))}\n", soft_wrap=True)


def show_table(table: Table) -> None:
    """Write a table without its empty columns to the standard output, or row by row if the terminal is too narrow."""
    trimmed = table.without_empty_columns()
    console = _console(sys.stdout)
    cells = [
        [one_line(row[i]) for row in (trimmed.heads, *trimmed.rows)]
        for i in range(len(trimmed.heads))
    ]
    least = [
        max(len(word) for text in column for word in (text.split() or [""])) for column in cells
    ]
    # Beside the lines and the blanks between columns.
    available = console.width - 3 * len(least) - 1
    if sum(least) <= available:
        from rich import box
        from rich.table import Table as Drawing

        widths = [max(map(len, column)) for column in cells]
        while sum(widths) > available:  # the widest one is made narrower first
            spare = [width if width > low else 0 for width, low in zip(widths, least, strict=True)]
            widths[spare.index(max(spare))] -= 1
        drawing = Drawing(
            title=trimmed.caption, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD
        )
        for i, head in enumerate(trimmed.heads):
            justify = "left"
            if trimmed.is_number(i):
                justify = "right"
            drawing.add_column(head, justify=justify, width=widths[i])
        for row in trimmed.rows:
            drawing.add_row(*map(one_line, row))
        console.print(drawing)
        return
    console.print(trimmed.caption)
    for row in trimmed.rows:
        console.print(one_line(row[0]))
        for head, text in zip(trimmed.heads[1:], row[1:], strict=True):
            if text:
                console.print(f"  {head}: {one_line(text)}")


def show_lines(lines: Iterable[Line], stream: TextIO | None = None) -> None:
    """Write labelled lines to a stream, wrapped behind their labels, a verdict in its colour, commands unwrapped."""
    from rich.text import Text

    from bristle.core.palette import TERMINAL

    console = _console(stream or sys.stdout)
    width = min(console.width, READ_WELL) - LABEL
    for line in lines:
        style = TERMINAL.get(line.level, "")
        options: dict[str, Any] = {
            "break_on_hyphens": False,
            "break_long_words": False,
            "drop_whitespace": False,
        }
        parts = textwrap.wrap(line.text.replace("\u00a0", " "), width, **options) or [""]
        bold = ""
        if style or line.label:
            bold = "bold"
        label = line.label
        for part in [parts[0].rstrip(), *map(str.strip, parts[1:])]:
            head = Text(f"{label:<{LABEL}}", style=bold)
            console.print(head + Text(part, style=style), soft_wrap=True)
            label = ""
        if line.command:
            console.print(Text(f"  {line.command}"), soft_wrap=True)


def show(*parts: str | Table | None) -> None:
    """Write paragraphs and tables to the standard output. Skip None."""
    for part in parts:
        if isinstance(part, str):
            say(part)
        elif part is not None:
            show_table(part)


@contextmanager
def progress(text: str, *, quiet: bool = False) -> Iterator[Callable[[float, str], None]]:
    """Give the callback for progress. A terminal shows a bar if the work takes longer than a second."""
    if quiet or not sys.stderr.isatty():
        yield lambda share, text: None
        return
    from rich.progress import (
        BarColumn,
        Progress,
        ProgressColumn,
        Task,
        TextColumn,
        TimeElapsedColumn,
    )

    class Remaining(ProgressColumn):
        """The time until the end that the last report tells; empty for a share of 0, at which it is unknown."""

        def render(self, task: Task) -> str:
            left = round(task.fields["end"] - monotonic())
            return str(timedelta(seconds=left)) * (0 < left < 1e7)

    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TimeElapsedColumn(),
        Remaining(),
    )
    bar = Progress(*columns, console=_console(sys.stderr), transient=True)
    begun = monotonic()
    task = bar.add_task(text, total=None, end=begun)

    def report(share: float, text: str) -> None:
        end = begun + (monotonic() - begun) / max(share, 1e-9)
        bar.update(task, total=1.0, completed=share, description=one_line(text), end=end)

    starter = threading.Timer(PATIENCE, bar.start)
    starter.daemon = True
    starter.start()
    try:
        yield report
    finally:
        starter.cancel()
        starter.join()
        bar.stop()


@contextmanager
def warnings_as_lines() -> Iterator[list[BaseException]]:
    """Show each warning once, as one line without its place in the code. Collect the faults of bristle among them."""
    printed: set[str] = set()
    faults: list[BaseException] = []

    def show(message: Any, *_: Any, **__: Any) -> None:
        line = one_line(str(message))
        fault = getattr(message, "__cause__", None)
        if fault is not None:
            faults.append(fault)
        if line not in printed:
            printed.add(line)
            complain(f"warning: {line}")

    with warnings.catch_warnings():
        warnings.simplefilter("always", UserWarning)
        warnings.showwarning = show
        yield faults


def report(error: BaseException, *, results: bool = False) -> int:
    """Report an error and return the exit code."""
    from bristle.core import BristleError, error_text

    if isinstance(error, KeyboardInterrupt):
        complain(str(error) or "interrupted")
        return getattr(error, "exit_code", INTERRUPTED)
    if isinstance(error, BristleError):
        complain(str(error))
        return error.exit_code
    if isinstance(error, BrokenPipeError):
        let_go(sys.stdout)
        return 0
    if isinstance(error, MemoryError):
        complain("there is not enough memory for this command. Use a shorter log or experiment")
        return BAD_INPUT
    if isinstance(error, OSError) and error.errno in {errno.EMFILE, errno.ENFILE}:
        complain(
            "bristle cannot open more files: this process or the system has reached its limit. Raise it with ulimit -n"
        )
        return BAD_INPUT
    if isinstance(error, OSError) and error.filename is None and error.errno in NO_OUTPUT:
        remark = ""
        if results:
            remark = ". The folder of results is complete"
        complain(
            f"bristle cannot write to the standard output: {error.strerror}. Free disk space, or redirect the output{remark}"
        )
        let_go(sys.stdout)
        return BAD_INPUT
    own = _place_in_own_file(error)
    if own:
        message = f"stops with {type(error).__name__}: {error_text(error)[:LONGEST]}".rstrip(": ")
        complain(f"{own[0]}, line {own[1]}: {message}. Try: bristle check {own[0]}")
        return BAD_INPUT
    if isinstance(error, ImportError) and not (error.name or "").startswith("bristle"):
        complain(
            f"bristle cannot load a required library: {error_text(error)[:LONGEST]}. Install the library again. If the "
            "memory is limited (ulimit -v), raise the limit"
        )
        return BAD_INPUT
    try:
        options: Any = {"delete": False, "encoding": "utf-8", "errors": "backslashreplace"}
        with tempfile.NamedTemporaryFile("w", prefix="bristle-", suffix=".txt", **options) as file:
            file.writelines([f"command: {sys.argv}\n", *traceback.format_exception(error)])
        details = f"Please report it with the details in {file.name}"
    except OSError:
        details = "bristle could not save the details: there is no space for temporary files"
    complain(
        f"this is a fault of bristle, not yours: {type(error).__name__}: {error_text(error)[:LONGEST]}. {details}"
    )
    return OUR_BUG


def _place_in_own_file(error: BaseException) -> tuple[str, int] | None:
    """Return the file and line of user code at the origin of an error, or None for an error of bristle."""
    for frame, line in reversed(list(traceback.walk_tb(error.__traceback__))):
        module = str(frame.f_globals.get("__name__", ""))
        if module.startswith("bristle_user_"):
            return frame.f_code.co_filename, line
        if module.partition(".")[0] == "bristle":
            return None
    return None


def let_go(stream: TextIO) -> None:
    """Redirect a stream so that the interpreter does not fail on it at exit."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)
