"""What simulates the blocks of a study on this machine: this process, threads of it, or processes that it begins.

A process is told what to do on its standard input and answers on its standard output, each time one pickled message.
"""

from __future__ import annotations

import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
import traceback
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import islice
from typing import Any, BinaryIO

from bristle.core.cores import Abreast, cores_for_simulations
from bristle.core.errors import BristleError
from bristle.study.block import Simulator, without_warnings
from bristle.study.plan import Block

__all__ = ["AHEAD", "PATIENCE", "Crew", "Here", "WorkerError", "outcome_of", "serve"]

TRIES = 5  # of a block, and of a worker that does not even begin
PATIENCE = 0.2  # [s]: so often signals are looked for
AHEAD = 4  # blocks for each worker: while it simulates one, others wait for it
THREADS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
Results = Generator[tuple[Block, dict[str, Any]], None, None]


class WorkerError(BristleError):
    """Workers end before they can begin, or one tells of a fault."""

    exit_code = 70

    @classmethod
    def at(cls, block: Block, reason: str) -> WorkerError:
        """Return the error of a worker that tells of a fault at a block."""
        return cls(f"a worker failed at the runs {block.first} to {block.last - 1}: {reason}")


@dataclass
class Here:
    """What simulates in this process: one block after the other, or several at once in threads."""

    simulate: Callable[[Block], dict[str, Any]]
    workers: int = 1
    lost: list[tuple[Block, int | None]] = field(default_factory=list)

    def results(self, blocks: Iterable[Block]) -> Results:
        """Yield blocks with their columns."""
        if self.workers == 1:
            yield from ((block, self.simulate(block)) for block in blocks)
            return
        with without_warnings():  # around all threads: what each restores would otherwise be what another one had set
            yield from _as_ready(self.simulate, blocks, self.workers)


@dataclass
class Crew:
    """Processes of this machine, each with a thread here that hands it blocks: whatever ends one, its block goes to the next."""

    study: Any
    workers: int
    make: Callable[[Any], Any] = Simulator
    lost: list[tuple[Block, int | None]] = field(default_factory=list)
    processes: set[subprocess.Popen[bytes]] = field(default_factory=set)
    _own: threading.local = field(default_factory=threading.local)
    _lock: Any = field(default_factory=threading.Lock)
    _ends: bool = False
    _unbegun: int = 0

    def results(self, blocks: Iterable[Block]) -> Results:
        """Yield blocks with their columns, in the order in which they are ready.

        A block whose workers ended `TRIES` times is left out, and noted among those `lost`.
        """
        try:
            for block, columns in _as_ready(self._simulated, blocks, self.workers, self._end):
                if columns is not None:
                    yield block, columns
        finally:
            for process in list(self.processes):
                self._closed(process)

    def _simulated(self, block: Block) -> dict[str, Any] | None:
        code = None
        for _ in range(TRIES):
            process = self._process()
            try:
                outcome, content = self._asked(process, block)
            except (EOFError, OSError, ValueError, pickle.UnpicklingError):
                code, self._own.process = self._closed(process), None
                continue
            if outcome == "failed":
                raise WorkerError.at(block, content)
            return content
        self.lost.append((block, code))
        return None

    def _process(self) -> subprocess.Popen[bytes]:
        """Return the process of this thread, begun anew where it ended."""
        while getattr(self._own, "process", None) is None:
            process = self._begun()
            try:
                self._asked(process, (self.make, self.study))
                self._own.process, self._unbegun = process, 0
            except (EOFError, OSError, ValueError, pickle.UnpicklingError):
                code, self._unbegun = self._closed(process), self._unbegun + 1
                if self._unbegun >= TRIES * self.workers:
                    raise WorkerError(f"{self._unbegun} workers ended before they could begin: {_ending(code)}") from None
        return self._own.process

    def _begun(self) -> subprocess.Popen[bytes]:
        code = f"import sys; sys.path[:] = {sys.path!r}; from bristle.study.workers import serve; serve()"
        with self._lock:
            if self._ends:
                raise WorkerError("the study ends")
            process = subprocess.Popen(
                [sys.executable, "-c", code],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env=os.environ | THREADS,
            )
            self.processes.add(process)
        return process

    def _asked(self, process: subprocess.Popen[bytes], message: Any) -> Any:
        orders: Any = process.stdin
        pickle.dump(message, orders, protocol=pickle.HIGHEST_PROTOCOL)
        orders.flush()
        return pickle.load(process.stdout)  # type: ignore[arg-type]

    def _closed(self, process: subprocess.Popen[bytes]) -> int:
        """End a process; return how it ended."""
        process.kill()
        for stream in (process.stdin, process.stdout):
            with suppress(OSError):
                stream.close()  # type: ignore[union-attr]
        self.processes.discard(process)
        return process.wait()

    def _end(self) -> None:
        with self._lock:
            self._ends = True
            for process in self.processes:
                process.kill()


def _as_ready(
    simulate: Callable[[Block], Any], blocks: Iterable[Block], threads: int, end: Callable[[], None] = lambda: None
) -> Iterator[tuple[Block, Any]]:
    """Yield blocks with what a function, called in threads, returns of each, in the order in which they are ready."""
    waiting, ready = iter(blocks), queue.SimpleQueue[Future[Any]]()
    under_way: dict[Future[Any], Block] = {}
    pool = Abreast(threads)

    def hand_out(count: int) -> None:
        for block in islice(waiting, count):
            future = pool.submit(simulate, block)
            under_way[future] = block
            future.add_done_callback(ready.put)

    try:
        hand_out(AHEAD * threads)
        while under_way:
            with suppress(queue.Empty):
                future = ready.get(timeout=PATIENCE)
                block, columns = under_way.pop(future), future.result()
                hand_out(1)
                yield block, columns
    finally:
        end()
        pool.shutdown(cancel_futures=True)


def _ending(code: int) -> str:
    """Return in words how a process ended."""
    return f"ended by signal {-code}{', as where memory runs out' if code == -9 else ''}" if code < 0 else f"ended with code {code}"


def serve() -> None:
    """Simulate, as a worker, the blocks that come, until the input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all of a terminal: who asked for the work ends it
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what a model of a person's own prints is no answer
    messages = queue.SimpleQueue[Any]()
    threading.Thread(target=_listen, args=(sys.stdin.buffer, messages), daemon=True).start()
    make, study = messages.get()
    with cores_for_simulations():
        simulator, answer = make(study), ("ready", None)
        while True:
            pickle.dump(answer, answers, protocol=pickle.HIGHEST_PROTOCOL)
            answers.flush()
            block = messages.get()
            answer = outcome_of(lambda block=block: simulator.columns(block))


def _listen(stream: BinaryIO, messages: queue.SimpleQueue[Any]) -> None:
    """Read messages: where the input ends, the process that asked is gone, and this one ends at once."""
    while True:
        try:
            messages.put(pickle.load(stream))
        except BaseException:  # noqa: BLE001  (whatever is wrong with the input: there is nothing more to do)
            os._exit(0)


def outcome_of(columns: Callable[[], dict[str, Any]]) -> tuple[str, Any]:
    """Return how the simulation of a block ends: ``("done", columns)``, or ``("failed", why)``."""
    try:
        return "done", columns()
    except BaseException:  # noqa: BLE001  (told where a person can read it)
        return "failed", traceback.format_exc()
