"""Every way to fail, as one readable message and an exit code."""

from __future__ import annotations

import errno
import os
import sys
import tempfile
import traceback
from typing import TextIO

from bristle.cli.terminal import complain

__all__ = ["BAD_INPUT", "INTERRUPTED", "NO", "OUR_BUG", "let_go", "report"]

NO = 1
BAD_INPUT = 2
OUR_BUG = 70
INTERRUPTED = 130
LONGEST = 500
NO_OUTPUT = {errno.ENOSPC, errno.EFBIG, errno.EDQUOT, errno.EIO, errno.EBADF, errno.EROFS}

NO_MORE_FILES = {errno.EMFILE, errno.ENFILE}


def report(error: BaseException, *, results: bool = False) -> int:
    """Tell a person what went wrong and return the exit code."""
    from bristle.core.errors import BristleError, told_by

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
        complain("there is not enough memory for this. Take a shorter log or experiment")
        return BAD_INPUT
    if isinstance(error, OSError) and error.errno in NO_MORE_FILES:
        complain("no more files can be opened: the limit of this process or of the system is reached (ulimit -n)")
        return BAD_INPUT
    if isinstance(error, OSError) and error.filename is None and error.errno in NO_OUTPUT:
        remark = ". The folder of results is whole and stays" if results else ""
        complain(f"the standard output cannot be written: {error.strerror}. Make room or write it elsewhere{remark}")
        let_go(sys.stdout)
        return BAD_INPUT
    own = _place_in_own_file(error)
    if own:
        message = f"stops with {type(error).__name__}: {told_by(error)[:LONGEST]}".rstrip(": ")
        complain(f"{own[0]}, line {own[1]}: {message}. Try: bristle check {own[0]}")
        return BAD_INPUT
    if isinstance(error, ImportError) and not (error.name or "").startswith("bristle"):
        complain(
            f"a library that is needed cannot be loaded: {told_by(error)[:LONGEST]}. Install it again; where "
            "memory is limited (ulimit -v), allow more"
        )
        return BAD_INPUT
    complain(f"this is a fault of bristle, not yours: {type(error).__name__}: {told_by(error)[:LONGEST]}. {_saved(error)}")
    return OUR_BUG


def _place_in_own_file(error: BaseException) -> tuple[str, int] | None:
    """Return file and line where a model of a person's own raised, or called what did; None where bristle did."""
    for frame, line in reversed(list(traceback.walk_tb(error.__traceback__))):
        module = str(frame.f_globals.get("__name__", ""))
        if module.startswith("bristle_user_"):
            return frame.f_code.co_filename, line
        if module.partition(".")[0] == "bristle":
            return None
    return None


def let_go(stream: TextIO) -> None:
    """Leave nothing in a stream for the interpreter to write at its end, where it would fail again."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


def _saved(error: BaseException) -> str:
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="bristle-", suffix=".txt", delete=False, encoding="utf-8", errors="backslashreplace"
        ) as file:
            file.write(f"command: {sys.argv}\n")
            file.writelines(traceback.format_exception(error))
    except OSError:
        return "Its details could not be saved: there is no room for temporary files"
    return f"Please report it with the details in {file.name}"
