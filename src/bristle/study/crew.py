"""Several workers that simulate the blocks of a study: whatever ends one of them, its block goes to the next."""

from __future__ import annotations

import os
import queue
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any

from bristle.core.errors import BristleError
from bristle.study.block import Simulator
from bristle.study.plan import Block
from bristle.study.worker import read_message, write_message

__all__ = ["Crew", "WorkerError"]

TRIES = 5  # of a block, and of a worker that does not even begin
PATIENCE = 0.2  # [s]: so often signals are looked for
THREADS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


class WorkerError(BristleError):
    """Workers end before they can begin, or one tells of a fault."""

    exit_code = 70


@dataclass
class _Ended:
    """What a worker left when it ended: the block that it had, and how it ended."""

    block: Block | None
    code: int | None


@dataclass
class Crew:
    """Workers, each a process of its own with a thread here that hands it blocks."""

    study: Any
    count: int
    simulator: Callable[[Any], Any] = Simulator
    lost: list[tuple[Block, int | None]] = field(default_factory=list)
    _processes: dict[int, subprocess.Popen[bytes]] = field(default_factory=dict)
    _threads: list[threading.Thread] = field(default_factory=list)
    _blocks: deque[Block] = field(default_factory=deque)
    _answers: queue.SimpleQueue[Any] = field(default_factory=queue.SimpleQueue)
    _lock: Any = field(default_factory=threading.Lock)
    _ends: bool = False

    def __enter__(self) -> Crew:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: Any, trace: TracebackType | None) -> None:
        """End every worker at once."""
        with self._lock:
            self._ends = True
            processes = list(self._processes.values())
        for process in processes:
            process.kill()
        for thread in self._threads:  # each waits for its worker
            thread.join()

    @property
    def workers(self) -> int:
        """How many workers there are."""
        return len(self._processes)

    def results(self, blocks: Iterable[Block]) -> Iterator[tuple[Block, dict[str, Any]]]:
        """Yield blocks with their columns, in the order in which they are ready.

        A block whose workers ended `TRIES` times is left out, and noted among those `lost`.
        """
        self._blocks.extend(blocks)
        waiting, tries, unbegun = len(self._blocks), dict[int, int](), 0
        if not waiting:
            return
        for _ in range(min(self.count, waiting)):
            self._begin()
        while waiting:
            try:
                answer = self._answers.get(timeout=PATIENCE)
            except queue.Empty:
                continue
            if not isinstance(answer, _Ended):
                block, (outcome, content) = answer
                if outcome == "failed":
                    raise WorkerError(f"a worker failed at the runs {block.first} to {block.last - 1}: {content}")
                waiting, unbegun = waiting - 1, 0
                yield block, content
                continue
            if answer.block is None:
                unbegun += 1
                if unbegun >= TRIES * self.count:
                    raise WorkerError(f"{unbegun} workers ended before they could begin: {_ending(answer.code)}")
            else:
                tries[answer.block.first] = tries.get(answer.block.first, 0) + 1
                if tries[answer.block.first] < TRIES:
                    self._blocks.appendleft(answer.block)
                else:
                    self.lost.append((answer.block, answer.code))
                    waiting -= 1
            if waiting:
                self._begin()

    def _begin(self) -> None:
        code = f"import sys; sys.path[:] = {sys.path!r}; import bristle.study.worker; bristle.study.worker.main()"
        with self._lock:
            if self._ends:
                return
            process = subprocess.Popen(
                [sys.executable, "-c", code],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env=os.environ | THREADS,
            )
            self._processes[process.pid] = process
        thread = threading.Thread(target=self._drive, args=(process,), daemon=True)
        self._threads.append(thread)
        thread.start()

    def _drive(self, process: subprocess.Popen[bytes]) -> None:
        """Hand blocks to a worker until there are none, or it ends."""
        block = None
        orders: Any = process.stdin
        answers: Any = process.stdout
        try:
            write_message(orders, (self.simulator, self.study))
            read_message(answers)
            while (block := self._next()) is not None:
                write_message(orders, block)
                answer = read_message(answers)
                handed, block = block, None
                self._answers.put((handed, answer))
        except (EOFError, OSError, ValueError):
            process.kill()
            self._answers.put(_Ended(block, process.wait()))
        for stream in (orders, answers):  # a worker ends where its input does
            with suppress(OSError):
                stream.close()
        process.wait()
        with self._lock:
            self._processes.pop(process.pid, None)

    def _next(self) -> Block | None:
        try:
            return self._blocks.popleft()
        except IndexError:
            return None


def _ending(code: int | None) -> str:
    """Return in words how a process ended."""
    if code is not None and code < 0:
        return f"ended by signal {-code}{', as where memory runs out' if code == -9 else ''}"
    return f"ended with code {code}"
