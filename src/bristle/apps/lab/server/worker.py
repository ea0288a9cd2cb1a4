"""The process of a job: it does one piece of work, reports its progress, and ends."""

import json
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

from bristle.apps.lab.server.limits import RESTORING
from bristle.cli.signals import is_importing
from bristle.core import BristleError, error_text

REFUSED = {
    KeyboardInterrupt: "cancelled before the first result",
    MemoryError: "there is not enough memory for this job. Use a shorter log",
}


class Interruption:
    """Requests of the server during the work: end with the best result, or, if the server disconnects, at once.

    Work that restores a machine ends itself in both cases.
    """

    def __init__(self, *, restores: bool = False) -> None:
        self._lock, self._allowed, self.requested, self._restores = (
            threading.Lock(),
            False,
            False,
            restores,
        )
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        for line in sys.stdin:
            if line.strip() == "cancel":
                with self._lock:
                    self.requested = True
                self._interrupt()
        self.requested = True
        if not self._restores:
            os._exit(1)  # the server is gone, so that the result is useless

    def _interrupt(self) -> None:
        """Raise `KeyboardInterrupt` in the work, but never in an import, which would stay incomplete."""
        while True:
            with self._lock:
                if not self._allowed:
                    return
                if not _imports():
                    import _thread

                    self._allowed = False
                    _thread.interrupt_main()
                    return
            time.sleep(0.02)

    @contextmanager
    def allowed(self) -> Iterator[None]:
        """Allow interruption of the work in this block; an earlier request takes effect at once."""
        with self._lock:
            self._allowed, requested = True, self.requested
        if requested:
            self._interrupt()
        try:
            yield
        finally:
            with self._lock:
                self._allowed = False


def _imports() -> bool:
    return is_importing(sys._current_frames().get(threading.main_thread().ident or 0))


def main() -> None:
    """Do the piece of work in the first line of the standard input."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    request: dict[str, Any] = json.loads(sys.stdin.readline())
    stream = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # output of libraries must not mix with the events

    def tell(**event: Any) -> None:
        """Send an event to the server: one line of JSON."""
        stream.write(json.dumps(event) + "\n")
        stream.flush()

    with suppress(ImportError):  # on systems without such limits
        import resource

        for name, most in (("AS", request["memory"]), ("CORE", 0)):
            # Some systems have this limit but reject it, or have a smaller limit already.
            with suppress(AttributeError, ValueError, OSError):
                resource.setrlimit(getattr(resource, f"RLIMIT_{name}"), (most, most))
    os.chdir(request["folder"])  # results name files relative to their folder
    interruption = Interruption(restores=request["task"] in RESTORING)
    try:
        from bristle.apps.lab.server.errand import DATA, Errand
        from bristle.apps.lab.server.tasks import TASKS
        from bristle.files import plain

        errand = Errand.of(
            request,
            lambda share, text: tell(share=share, text=text),
            interruption.allowed,
            lambda: interruption.requested,
        )
        facts, data = TASKS[request["task"]](errand)
        (errand.folder / DATA).write_text(
            json.dumps(plain(data), allow_nan=False), encoding="utf-8"
        )
    except (KeyboardInterrupt, BristleError, MemoryError) as error:
        # numpy has a separate MemoryError.
        tell(
            refused=next(
                (text for kind, text in REFUSED.items() if isinstance(error, kind)), str(error)
            )
        )
        os._exit(2)
    except Exception as error:
        tell(
            refused=f"this is a fault of bristle, not yours: {type(error).__name__}: {error_text(error)}"
        )
        raise
    tell(facts=facts)
    os._exit(0)  # without waiting for threads of an interrupted search
