"""A worker of a study: a process that simulates the blocks that it is handed, and ends when nobody hands it any.

It is told what to do on its standard input and answers on its standard output, each message a length and its bytes. A
thread waits for the next message: where the input ends, the process that asked is gone, and this one ends at once.
"""

from __future__ import annotations

import os
import pickle
import queue
import signal
import struct
import sys
import threading
import traceback
from collections.abc import Callable
from typing import Any, BinaryIO

__all__ = ["main", "outcome_of", "read_message", "write_message"]

LENGTH = struct.Struct("<Q")


def read_message(stream: BinaryIO) -> Any:
    """Return the next message."""
    return pickle.loads(_exactly(stream, LENGTH.unpack(_exactly(stream, LENGTH.size))[0]))


def write_message(stream: BinaryIO, message: Any) -> None:
    """Write a message."""
    data = pickle.dumps(message, protocol=pickle.HIGHEST_PROTOCOL)
    stream.write(LENGTH.pack(len(data)))
    stream.write(data)
    stream.flush()


def _exactly(stream: BinaryIO, count: int) -> bytes:
    data = stream.read(count)
    if data is None or len(data) < count:
        raise EOFError
    return data


def main() -> None:
    """Serve until the input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all of a terminal: who asked for the work ends it
    answers = os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)  # what a model of a person's own prints is no answer
    messages: queue.SimpleQueue[Any] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(sys.stdin.buffer, messages), daemon=True).start()
    _serve(messages, answers)


def _listen(stream: BinaryIO, messages: queue.SimpleQueue[Any]) -> None:
    while True:
        try:
            messages.put(read_message(stream))
        except BaseException:  # noqa: BLE001  (whatever is wrong with the input: there is nothing more to do)
            os._exit(0)


def _serve(messages: queue.SimpleQueue[Any], answers: BinaryIO) -> None:
    make, study = messages.get()
    # Only now: what a message holds is imported by the thread that reads it, and two at a time see half a module.
    from bristle.core.cores import cores_for_simulations

    with cores_for_simulations():
        simulator = make(study)
        write_message(answers, ("ready", None))
        while True:
            block = messages.get()
            write_message(answers, outcome_of(lambda block=block: simulator.columns(block)))


def outcome_of(columns: Callable[[], dict[str, Any]]) -> tuple[str, Any]:
    """Return how the simulation of a block ends: ``("done", columns)``, or ``("failed", why)``."""
    try:
        return "done", columns()
    except BaseException:  # noqa: BLE001  (told where a person can read it)
        return "failed", traceback.format_exc()


if __name__ == "__main__":
    main()
