"""Handling of signals that end the program: unfinished files are removed, and one line names the signal.

The interpreter handles a signal between two of its own steps. Native code may delay it, even forever, so a thread
watches and ends a process that does not react in time.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from types import FrameType
from typing import Any, NoReturn

SENTENCES = {
    "SIGINT": "interrupted",
    "SIGTERM": "terminated",
    "SIGHUP": "hung up",
    "SIGBREAK": "interrupted",
}
INTERRUPTED = 130  # the exit code
PATIENCE = 60.0  # [s] until the end after a request to terminate, within which results are written; Ctrl-C can be pressed again
_MARK = b"\xff"


class SignalledError(KeyboardInterrupt):
    """A signal that ends the program; `exit_code` is 128 plus its number."""

    def __init__(self, number: int) -> None:
        self.exit_code = 128 + number
        super().__init__(SENTENCES[signal.Signals(number).name])


class ended_by_signals:  # noqa: N801  (used as a context)
    """Context in which the signals that end a program raise `SignalledError`.

    Ignored signals (``nohup``, background jobs) stay ignored. Signals repeated within a second, as from a closing
    terminal, count once, so that they do not end the cleanup. If native code blocks the interpreter, the process ends
    after two seconds, or for Ctrl-C at the second press. A process that is still alive `PATIENCE` after a request to
    terminate also ends: a thread or a lock may block it.
    """

    def __init__(self) -> None:
        self._before: dict[int, Any] = {}
        self._first: tuple[int, float] | None = None
        self._waiting: int | None = None
        self._unraisable = sys.unraisablehook
        self._watch = _Watch()
        self._again: threading.Timer | None = None
        self._is_over = False

    def __enter__(self) -> ended_by_signals:
        for name in SENTENCES:
            number = getattr(signal, name, None)
            if number is None or signal.getsignal(number) not in (
                signal.SIG_DFL,
                signal.default_int_handler,
            ):
                continue
            try:
                self._before[number] = signal.signal(number, self._raise)
            except ValueError:  # only the main thread receives signals
                return self
        self._unraisable = sys.unraisablehook
        sys.unraisablehook = self._lost
        self._watch.begin(set(self._before))
        return self

    def __exit__(self, *_: object) -> None:
        self._is_over = True
        if self._again is not None:  # else it would end a later command in this process
            self._again.cancel()
            self._again.join()
        self._watch.end()
        for number, handler in self._before.items():
            signal.signal(number, handler)
        sys.unraisablehook = self._unraisable

    @property
    def exit_code(self) -> int | None:
        """128 plus the number of the signal that ended the program; None without a signal."""
        if self._first is None:
            return None
        return 128 + self._first[0]

    def check(self) -> None:
        """Raise the signal received during the import of modules; call outside any import."""
        if self._first is None:
            number = self._waiting
        else:
            number = self._first[0]
        if number is not None:
            self._end(number)

    def _raise(self, number: int, frame: FrameType | None) -> None:
        self._watch.observed.set()
        now = time.monotonic()
        if self._is_over or (self._first is not None and now - self._first[1] < 1.0):
            return
        if is_importing(frame):
            # A module that is being imported may drop the exception, or turn it into its own error.
            self._waiting = number
            self._send_again(number)
            return
        self._end(number)

    def _end(self, number: int) -> NoReturn:
        self._first = (number, time.monotonic())
        raise SignalledError(number)

    def _lost(self, unraisable: Any) -> None:
        """Send the signal again if the interpreter dropped its exception, as in a finalizer."""
        if not isinstance(unraisable.exc_value, SignalledError) or self._first is None:
            self._unraisable(unraisable)
            return
        number = self._first[0]
        self._first = None
        self._send_again(number)

    def _send_again(self, number: int) -> None:
        self._again = threading.Timer(0.01, _interrupt_main, (number,))
        self._again.daemon = True
        self._again.start()


class _Watch:
    """A thread that receives each signal on arrival and ends the process if the interpreter does not react."""

    def __init__(self) -> None:
        self.observed = threading.Event()
        self._numbers: set[int] = set()
        self._pipe: _Pipe | None = None
        self._before = -1
        self._thread: threading.Thread | None = None
        self._last: threading.Timer | None = None

    def begin(self, numbers: set[int]) -> None:
        """Watch for these signals."""
        if not numbers:
            return
        self._pipe = _Pipe()
        self._numbers = numbers
        self._before = signal.set_wakeup_fd(self._pipe.write_to, warn_on_full_buffer=False)
        self._thread = threading.Thread(target=self._watch, args=(self._pipe,), daemon=True)
        self._thread.start()

    def end(self) -> None:
        """Stop watching."""
        if self._pipe is None or self._thread is None:
            return
        signal.set_wakeup_fd(self._before)
        self._pipe.end()
        self._thread.join()
        self._pipe.close()
        if self._last is not None:
            self._last.cancel()

    def _watch(self, pipe: _Pipe) -> None:
        interrupts = 0
        while number := pipe.next():
            if number not in self._numbers:
                continue
            # Native code that takes longer [s] is treated as code that never returns.
            if self.observed.wait(2.0):
                # Signals of one number that arrive together count as one: those received so far were seen.
                self.observed.clear()
                pipe.drain()
                if number != signal.SIGINT and self._last is None:
                    self._last = threading.Timer(PATIENCE, _end_at_once, (number,))
                    self._last.daemon = True
                    self._last.start()
                continue
            interrupts += number == signal.SIGINT
            if interrupts == 1:
                _say(
                    "interrupted: waiting for a library to return. Press Ctrl-C again to end at once"
                )
            else:
                _end_at_once(number)


class _Pipe:
    """A pipe to which the interpreter immediately writes the number of each signal."""

    def __init__(self) -> None:
        self._read, self.write_to = os.pipe()
        if os.name != "nt":
            os.set_blocking(self.write_to, False)

    def next(self) -> int:
        """Wait for the next number; 0 at the end."""
        return (os.read(self._read, 1) or b"\0")[0]

    def drain(self) -> None:
        """Discard the numbers in the pipe."""
        os.write(self.write_to, _MARK)
        while (byte := os.read(self._read, 1)) not in (_MARK, b""):
            if byte == b"\0":
                self.end()

    def end(self) -> None:
        """Let the reader finish."""
        os.write(self.write_to, b"\0")

    def close(self) -> None:
        """Close both ends."""
        os.close(self._read)
        os.close(self.write_to)


def _say(text: str) -> None:
    """Write to the standard error stream without the locks of Python's streams."""
    try:
        os.write(2, f"bristle: {text}\n".encode())
    except OSError:
        return


def _end_at_once(number: int) -> NoReturn:
    results = sys.modules.get("bristle.files.results")
    if results is not None:
        results.remove_unfinished()
    _say(SENTENCES[signal.Signals(number).name])
    os._exit(128 + number)


def is_importing(frame: FrameType | None) -> bool:
    """Return whether a frame is inside an import, which an interruption would leave incomplete."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


def _interrupt_main(number: int) -> None:
    if hasattr(signal, "pthread_kill"):
        # Wakes a sleeping main thread.
        signal.pthread_kill(threading.main_thread().ident or 0, number)
    else:
        import _thread

        _thread.interrupt_main(signal.Signals(number))
