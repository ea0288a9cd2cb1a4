"""Signals that end a program end it in good order: what was half written is removed, and one line says why."""

from __future__ import annotations

import signal
import sys
import time
from types import FrameType
from typing import Any, NoReturn

__all__ = ["SignalledError", "ended_by_signals"]

SENTENCES = {"SIGINT": "interrupted", "SIGTERM": "terminated", "SIGHUP": "hung up"}
GRACE = 1.0  # [s]
AGAIN = 0.01  # [s]


class SignalledError(KeyboardInterrupt):
    """A signal asks the program to end; `exit_code` is 128 and its number."""

    def __init__(self, number: int) -> None:
        self.exit_code = 128 + number
        super().__init__(SENTENCES[signal.Signals(number).name])


class ended_by_signals:  # noqa: N801  (used as a context)
    """Inside this block the signals that ask a program to end raise `SignalledError`.

    Those that are ignored (``nohup``, jobs in the background) stay so. What repeats within a second, as a closing
    terminal does, is one signal: it must not end the cleaning up.
    """

    def __init__(self) -> None:
        self._before: dict[int, Any] = {}
        self._first: tuple[int, float] | None = None
        self._waiting: int | None = None
        self._unraisable = sys.unraisablehook

    def __enter__(self) -> ended_by_signals:
        for name in SENTENCES:
            number = getattr(signal, name, None)
            if number is None or signal.getsignal(number) not in (signal.SIG_DFL, signal.default_int_handler):
                continue
            try:
                self._before[number] = signal.signal(number, self._raise)
            except ValueError:  # only the main thread receives signals
                return self
        self._unraisable, sys.unraisablehook = sys.unraisablehook, self._lost
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        sys.unraisablehook = self._unraisable

    def check(self) -> None:
        """Raise what was received while modules were imported: called where none is."""
        number = self._waiting if self._first is None else self._first[0]
        if number is not None:
            self._end(number)

    def _raise(self, number: int, frame: FrameType | None) -> None:
        now = time.monotonic()
        if self._first is not None and now - self._first[1] < GRACE:
            return
        if _imports(frame):
            # A module that is being imported may drop what is raised in it, or call it an error of its own.
            self._waiting = number
            _send_again(number)
            return
        self._end(number)

    def _end(self, number: int) -> NoReturn:
        self._first = (number, time.monotonic())
        raise SignalledError(number)

    def _lost(self, unraisable: Any) -> None:
        """Send the signal again where the interpreter drops what is raised, as in a finalizer."""
        if not isinstance(unraisable.exc_value, SignalledError) or self._first is None:
            self._unraisable(unraisable)
            return
        number, self._first = self._first[0], None
        _send_again(number)


def _imports(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


def _send_again(number: int) -> None:
    import _thread
    from threading import Timer

    again = Timer(AGAIN, _thread.interrupt_main, (number,))
    again.daemon = True
    again.start()
