"""The entry point of ``bristle``. It imports nothing that takes time before it can be interrupted in good order."""

import gc
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from bristle.cli.signals import INTERRUPTED, ended_by_signals

LEAST_MEMORY = 512 * 2**20  # [byte]


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return the exit code."""
    if arguments is None:
        # Nearly all that a command makes lives until its end: looking for garbage as often as by default costs a tenth.
        gc.set_threshold(20_000, 100)
        _own_the_compiler()
        try:
            code = _ended_well(list(sys.argv[1:]))
            if any(not thread.daemon and thread is not threading.main_thread() for thread in threading.enumerate()):
                # Threads of a person's own model still run, and the interpreter would wait for them for ever.
                os._exit(code)  # all that was said has left the streams already
            return code
        finally:
            # The interpreter would look for garbage in all of it once more as it ends: a seventh of the time.
            gc.freeze()
    return _ended_well(list(arguments))


def _ended_well(arguments: list[str]) -> int:
    """Run a command line; return the exit code, whatever happens."""
    with ended_by_signals() as signals, errors_let_go():
        try:
            refuse_little_memory()
            from bristle.cli.application import run
            from bristle.cli.terminal import let_go, report, streams_that_take_all, warnings_as_lines

            signals.check()
            streams_that_take_all()
            with warnings_as_lines() as faults:
                code = run(arguments)
                if faults:  # of a signal a library may have made an error of its own
                    code = report(faults[0]) if signals.exit_code is None else INTERRUPTED
                try:
                    sys.stdout.flush()
                except BrokenPipeError:  # a reader that has gone does not change it
                    let_go(sys.stdout)
        except BaseException as error:  # noqa: BLE001  (a fault of ours is told as one message)
            from bristle.cli.terminal import report

            has_results = arguments[:1] in (["demo"], ["paper"]) or any(argument.partition("=")[0] == "--out" for argument in arguments)
            code = report(error, results=has_results)
        # An identification that was interrupted does not know which of the signals it was.
        return signals.exit_code or code if code == INTERRUPTED else code


def _own_the_compiler() -> None:
    """Drop settings of the compiler: made for other programs, they change numbers here, or end the process."""
    for name in [name for name in os.environ if name.startswith("NUMBA_") and name != "NUMBA_DISABLE_JIT"]:
        del os.environ[name]
    dated = os.environ.get("SOURCE_DATE_EPOCH", "0")
    if not (dated.isdecimal() and len(dated) <= 10):  # libraries that look at it end over one beyond the year 2286
        del os.environ["SOURCE_DATE_EPOCH"]


def refuse_little_memory() -> None:
    """Refuse to begin where the libraries of linear algebra would not find their memory, and one looks for it for ever."""
    try:
        import resource
    except ImportError:  # no such limits on this system
        return
    for name, option in (("RLIMIT_AS", "-v"), ("RLIMIT_DATA", "-d")):
        limit = resource.getrlimit(getattr(resource, name))[0]
        if limit != resource.RLIM_INFINITY and limit < LEAST_MEMORY:
            from bristle.core import InputError

            raise InputError(
                "is too little memory for the libraries that are needed",
                path=f"ulimit {option} {limit // 1024}",
                allowed=f"{LEAST_MEMORY // 1024} or more",
                mend=f"Run ulimit {option} unlimited",
            )


@contextmanager
def errors_let_go() -> Iterator[None]:
    """Leave nothing for the standard error stream that cannot be written: the interpreter would fail on it later."""
    try:
        yield
    finally:
        try:
            sys.stderr.flush()
        except OSError:
            from bristle.cli.terminal import let_go

            let_go(sys.stderr)
