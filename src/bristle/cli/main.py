"""The entry point of ``bristle``. It imports nothing that takes time before it can be interrupted in good order."""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from bristle.cli.signals import ended_by_signals

__all__ = ["main"]


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return the exit code.

    Parameters
    ----------
    arguments : list of str, optional
        What follows the name of the program; taken from the process where not given.
    """
    if arguments is None:
        # Nearly all that a command makes lives until its end: looking for garbage as often as by default costs a tenth.
        gc.set_threshold(20_000, 100)
        try:
            return _ended_well(list(sys.argv[1:]))
        finally:
            # The interpreter would look for garbage in all of it once more as it ends: a seventh of the time.
            gc.freeze()
    return _ended_well(list(arguments))


def _ended_well(given: list[str]) -> int:
    """Run a command line; return the exit code, whatever happens."""
    with ended_by_signals() as signals, errors_let_go():
        try:
            from bristle.cli.application import run
            from bristle.cli.terminal import streams_that_take_all, warnings_as_lines

            signals.check()
            streams_that_take_all()
            with warnings_as_lines():
                return _flushed(run(given))
        except BaseException as error:  # noqa: BLE001  (a fault of ours is told as one message)
            from bristle.cli.failure import report

            return report(error, results=_asks_for_results(given))


@contextmanager
def errors_let_go() -> Iterator[None]:
    """Leave nothing for the standard error stream that cannot be written: the interpreter would fail on it later."""
    try:
        yield
    finally:
        try:
            sys.stderr.flush()
        except OSError:
            from bristle.cli.failure import let_go

            let_go(sys.stderr)


def _asks_for_results(arguments: list[str]) -> bool:
    return arguments[:1] in (["demo"], ["paper"]) or any(one.partition("=")[0] == "--out" for one in arguments)


def _flushed(code: int) -> int:
    """Return the exit code once all that was written has left; a reader that has gone does not change it."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        from bristle.cli.failure import let_go

        let_go(sys.stdout)
    return code
