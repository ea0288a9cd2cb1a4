"""The entry point of ``bristle``. It imports slow modules only after signals are handled."""

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
        # Nearly all objects live until the end: garbage collection at the default rate costs a tenth of the time.
        gc.set_threshold(20_000, 100)
        _own_the_compiler()
        try:
            code = _ended_well(list(sys.argv[1:]))
            if any(
                not thread.daemon and thread is not threading.main_thread()
                for thread in threading.enumerate()
            ):
                # Threads of a user's model still run, and the interpreter would wait for them forever.
                os._exit(code)  # the streams are already flushed
            return code
        finally:
            # A last garbage collection at exit would take a seventh of the time.
            gc.freeze()
    return _ended_well(list(arguments))


def _ended_well(arguments: list[str]) -> int:
    """Run a command line and return the exit code. Turn every error into a message."""
    with ended_by_signals() as signals, errors_let_go():
        try:
            refuse_little_memory()
            from bristle.cli.application import run
            from bristle.cli.terminal import (
                let_go,
                report,
                streams_that_take_all,
                warnings_as_lines,
            )

            signals.check()
            streams_that_take_all()
            with warnings_as_lines() as faults:
                code = run(arguments)
                if faults:  # a library may have replaced a signal by another error
                    code = INTERRUPTED
                    if signals.exit_code is None:
                        code = report(faults[0])
                try:
                    sys.stdout.flush()
                except BrokenPipeError:  # a closed pipe does not change the exit code
                    let_go(sys.stdout)
        except BaseException as error:  # noqa: BLE001  (a fault of bristle becomes one message)
            from bristle.cli.terminal import report

            has_results = arguments[:1] in (["demo"], ["paper"]) or any(
                argument.partition("=")[0] == "--out" for argument in arguments
            )
            code = report(error, results=has_results)
        # An interrupted identification does not know the number of the signal.
        if code == INTERRUPTED:
            return signals.exit_code or code
        return code


def _own_the_compiler() -> None:
    """Drop compiler settings made for other programs: they change numbers here, or end the process."""
    for name in [
        name for name in os.environ if name.startswith("NUMBA_") and name != "NUMBA_DISABLE_JIT"
    ]:
        del os.environ[name]
    dated = os.environ.get("SOURCE_DATE_EPOCH", "0")
    # Libraries that read it fail beyond the year 2286
    if not (dated.isdecimal() and len(dated) <= 10):
        del os.environ["SOURCE_DATE_EPOCH"]


def refuse_little_memory() -> None:
    """Refuse to start with too little memory for linear algebra: a library would wait for memory forever."""
    try:
        import resource
    except ImportError:  # no such limits on this system
        return
    for name, option in (("RLIMIT_AS", "-v"), ("RLIMIT_DATA", "-d")):
        limit = resource.getrlimit(getattr(resource, name))[0]
        if limit != resource.RLIM_INFINITY and limit < LEAST_MEMORY:
            from bristle.core import InputError

            raise InputError(
                "is too little memory for the required libraries",
                path=f"ulimit {option} {limit // 1024}",
                allowed=f"{LEAST_MEMORY // 1024} or more",
                mend=f"Run ulimit {option} unlimited",
            )


@contextmanager
def errors_let_go() -> Iterator[None]:
    """Discard unwritable text for the standard error stream: the interpreter would fail on it at exit."""
    try:
        yield
    finally:
        try:
            sys.stderr.flush()
        except OSError:
            from bristle.cli.terminal import let_go

            let_go(sys.stderr)
