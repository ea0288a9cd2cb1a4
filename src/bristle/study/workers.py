"""Workers that simulate the blocks of a study: this process, its threads, child processes, or a Dask cluster.

A child process receives pickled messages on its standard input and answers on its standard output. On a cluster the study
is a separate task, sent once. Workers pass the study on, and repeat this task if the study was lost.
"""

from __future__ import annotations

import asyncio
import hashlib
import logging
import os
import pickle
import platform
import queue
import signal
import subprocess
import sys
import threading
import traceback
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import CancelledError, Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cache, lru_cache, partial
from importlib.metadata import version
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO

from bristle.core import LOADING, Abreast, BristleError, InputError, InputWarning, cores_for_simulations, library, said_by_library
from bristle.study.block import Simulator
from bristle.study.plan import Block, Study

TRIES = 5  # of a block, and of a worker that fails to start
PATIENCE = 0.2  # [s]: interval of checks for signals
AHEAD = 4  # blocks for each worker: one in simulation, others in its queue
CLUSTER = ("distributed", "bristle study --scheduler", "study")  # the library, the command that needs it, the extra with it
ANSWERS = 10.0  # [s] timeout for an answer of the scheduler
WORKERS_JOIN = 60.0  # [s] timeout for the first worker
# A worker or scheduler ends if it cannot unpickle a function of bristle, so tasks call built-in functions.
SIMULATED = "__import__('bristle.study.workers', fromlist=['']).simulated(plan, software, first, last)"
THREADS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
Results = Generator[tuple[Block, dict[str, Any]], None, None]


class WorkerError(BristleError):
    """Error of workers that end before they start, or report a fault."""

    exit_code = 70

    @classmethod
    def at(cls, block: Block, reason: str) -> WorkerError:
        """Return the error of a worker that reports a fault at a block."""
        return cls(f"a worker failed at the runs {block.first} to {block.last - 1}: {reason}")


@dataclass
class Here:
    """Simulator in this process: one block after the other, or several blocks at once in threads."""

    simulate: Callable[[Block], dict[str, Any]]
    workers: int = 1
    lost: list[tuple[Block, int | None]] = field(default_factory=list)

    def results(self, blocks: Iterable[Block]) -> Results:
        """Yield blocks with their columns."""
        if self.workers == 1:
            yield from ((block, self.simulate(block)) for block in blocks)
            return
        with warnings.catch_warnings(action="ignore"):  # around all threads, because each thread would restore the filters of another
            yield from _in_threads(self.simulate, blocks, self.workers)


@dataclass
class Crew:
    """Processes of this machine, each fed by a thread; the block of a process that ends goes to the next process."""

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
        """Yield blocks with their columns, as they finish.

        A block whose workers ended `TRIES` times is not yielded but added to `lost`.
        """
        try:
            for block, columns in _in_threads(self._simulated, blocks, self.workers, self._end):
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
        """Return the process of this thread, restarted if it ended."""
        code = f"import sys; sys.path[:] = {sys.path!r}; from bristle.study.workers import serve; serve()"
        while getattr(self._own, "process", None) is None:
            with self._lock:
                if self._ends:
                    raise WorkerError("the study ends")
                pipe, command = subprocess.PIPE, [sys.executable, "-c", code]
                process = subprocess.Popen(command, env=os.environ | THREADS, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL)
                self.processes.add(process)
            try:
                self._asked(process, (self.make, self.study))
                self._own.process, self._unbegun = process, 0
            except (EOFError, OSError, ValueError, pickle.UnpicklingError):
                ending, self._unbegun = self._closed(process), self._unbegun + 1
                if self._unbegun >= TRIES * self.workers:
                    cause = f"by signal {-ending}" if ending < 0 else f"with code {ending}"
                    raise WorkerError(f"{self._unbegun} workers ended before they could start, the last one {cause}") from None
        return self._own.process

    def _asked(self, process: subprocess.Popen[bytes], message: Any) -> Any:
        orders: Any = process.stdin
        pickle.dump(message, orders, protocol=pickle.HIGHEST_PROTOCOL)
        orders.flush()
        return pickle.load(process.stdout)  # type: ignore[arg-type]

    def _closed(self, process: subprocess.Popen[bytes]) -> int:
        """End a process; return its exit code."""
        process.kill()
        for stream in (process.stdin, process.stdout):
            with suppress(OSError):
                stream.close()  # type: ignore[union-attr]
        self.processes.discard(process)
        return process.wait()

    def _end(self) -> None:
        with self._lock:
            self._ends = True
            for process in list(self.processes):
                process.kill()


class Cluster:
    """Workers of a Dask cluster; they may come and go, and their blocks move to others."""

    def __init__(self, study: Study, address: str) -> None:
        self.study, self.address, self.lost = study, address, list[tuple[Block, int | None]]()
        self._library = library(*CLUSTER)

    def results(self, blocks: Iterable[Block]) -> Results:
        """Yield blocks with their columns, as they arrive.

        If the workers of a block ended in all tries of the scheduler, the block gets the same number of tries at the end,
        alone in the cluster, because other blocks may have ended its workers. If these also fail, it is added to `lost`.
        """
        with _silent(), self._connected() as client:
            for origin in self.study.origins.get("code", ()):
                sentence = f"bristle runs the code in {origin.name} (SHA-256 {origin.checksum}) on every worker of {self.address}"
                warnings.warn(sentence, InputWarning, stacklevel=2)
            pool = client.get_executor(pure=False)
            with warnings.catch_warnings():
                warnings.filterwarnings("ignore", "Sending large graph")  # the study is sent only once
                plan = client.submit(bytes, pickle.dumps(self.study, protocol=pickle.HIGHEST_PROTOCOL), pure=False)

            def submit(block: Block) -> Future[Any]:
                return pool.submit(eval, SIMULATED, {"plan": plan, "software": described(), "first": block.first, "last": block.last})

            yield from self._arrived(_as_ready(submit, blocks, lambda: AHEAD * max(self._threads(client), 1)))
            suspects, self.lost = self.lost, []
            for block, _ in suspects:
                yield from self._arrived(_as_ready(submit, [block], lambda: 1))

    @contextmanager
    def _connected(self) -> Iterator[Any]:
        """Connect to the scheduler, and wait for a worker; cancel the remaining tasks at the end."""
        mend = f"Start dask scheduler --port 8786, then dask worker {self.address} --nworkers auto --nthreads 1"
        fault, client, distributed = "no Dask scheduler answers at this address", None, self._library

        async def identity() -> None:  # the library alone would wait without a timeout
            arguments = distributed.Security().get_connection_args("client")
            async with distributed.rpc(self.address, connection_args=arguments) as scheduler:
                await asyncio.wait_for(scheduler.identity(), ANSWERS)

        try:
            try:
                with Abreast(1) as thread:  # this thread may run an event loop, as in a notebook
                    thread.submit(asyncio.run, asyncio.wait_for(identity(), ANSWERS)).result()
                client = distributed.Client(self.address, timeout=ANSWERS, set_as_default=False, name="bristle")
                fault = "the scheduler has no workers"
                client.wait_for_workers(1, timeout=WORKERS_JOIN)
            except Exception as error:  # noqa: BLE001  (what answers there may be anything)
                raise InputError(f"{fault}{said_by_library(error)}", path="--scheduler", value=self.address, mend=mend) from None
            yield client
        finally:
            if client is not None:
                with suppress(OSError, TimeoutError):
                    client.close(timeout=ANSWERS)

    def _threads(self, client: Any) -> int:
        """Return the present count of threads of the workers."""
        try:
            return sum(client.nthreads(callback_timeout=ANSWERS).values())
        except (OSError, TimeoutError, RuntimeError):
            raise self._scheduler_lost() from None

    def _scheduler_lost(self) -> InputError:
        mend = "The results written so far remain. Start scheduler and workers, and repeat the command"
        return InputError("the scheduler no longer answers", path="--scheduler", value=self.address, mend=mend)

    def _arrived(self, futures: Iterator[tuple[Block, Future[Any]]]) -> Results:
        """Yield blocks with their columns; note those whose workers ended."""
        for block, future in futures:
            try:
                outcome, content = future.result()
            except self._library.KilledWorker:
                self.lost.append((block, None))
                continue
            except CancelledError:
                raise self._scheduler_lost() from None
            except Exception as error:  # noqa: BLE001  (the worker could not even begin)
                raise WorkerError.at(block, f"{type(error).__name__}: {error}") from None
            if outcome == "failed":
                raise WorkerError.at(block, content)
            if outcome == "unfit":
                mend = "Install the allowed versions on this worker and restart the worker, or stop it"
                allowed = ", ".join(f"{name} {value}" for name, value in described().items())
                raise InputError("the software of a worker differs", path=self.address, value=content, allowed=allowed, mend=mend)
            yield block, content


@contextmanager
def _silent() -> Iterator[None]:
    """Silence messages of Dask about lost connections, because bristle reports their effects."""
    names = [name for name in logging.root.manager.loggerDict if name.partition(".")[0] in ("distributed", "asyncio")]
    loggers = [logger for logger in map(logging.getLogger, names) if not logger.disabled]
    try:
        for logger in loggers:
            logger.disabled = True
        yield
    finally:
        for logger in loggers:
            logger.disabled = False


@cache
def described() -> dict[str, str]:
    """Return the software of this process: version and code of bristle, versions of its libraries."""
    names = {name: version(name) for name in ("bristle", "numpy", "scipy", "numba")}
    return names | {"code": checksum_of_code(Path(__file__).parents[1])}


def checksum_of_code(root: Path) -> str:
    """Return the first letters of a SHA-256 of the Python code in a folder: the same version number can have different code."""
    digest = hashlib.sha256()
    for name in sorted(file.relative_to(root).as_posix() for file in root.rglob("*.py")):
        content = (root / name).read_bytes().replace(b"\r\n", b"\n")
        digest.update(f"{name} {hashlib.sha256(content).hexdigest()} ".encode())
    return digest.hexdigest()[:12]


def simulated(plan: bytes, software: dict[str, str], first: int, last: int) -> tuple[str, Any]:
    """Return the columns of a block on a worker of a cluster; or the differences, if its software is not that of the command."""
    if described() != software:
        different = ", ".join(f"{name} {value}" for name, value in described().items() if software.get(name) != value)
        return "unfit", f"{different} on {platform.node()}"

    def columns() -> dict[str, Any]:
        with cores_for_simulations():
            with LOADING:  # made once in this process, by the first thread that needs it
                simulator = _simulator(plan)
            return simulator.columns(Block(first, last))

    return outcome_of(columns)


@lru_cache(4)
def _simulator(plan: bytes) -> Simulator:
    return Simulator(pickle.loads(plan))


def _as_ready(
    submit: Callable[[Block], Future[Any]], blocks: Iterable[Block], ahead: Callable[[], int]
) -> Iterator[tuple[Block, Future[Any]]]:
    """Yield blocks with their results, as they finish; at most so many are in work at once."""
    waiting, ready = iter(blocks), queue.SimpleQueue[Future[Any]]()
    under_way: dict[Future[Any], Block] = {}
    while True:
        for block in islice(waiting, max(ahead() - len(under_way), 0)):
            future = submit(block)
            under_way[future] = block
            future.add_done_callback(ready.put)
        if not under_way:
            return
        with suppress(queue.Empty):
            future = ready.get(timeout=PATIENCE)
            yield under_way.pop(future), future


def _in_threads(
    simulate: Callable[[Block], Any], blocks: Iterable[Block], threads: int, end: Callable[[], None] = lambda: None
) -> Iterator[tuple[Block, Any]]:
    """Yield blocks with the results of a function called in threads, as they finish."""
    pool = Abreast(threads)
    try:
        for block, future in _as_ready(partial(pool.submit, simulate), blocks, lambda: AHEAD * threads):
            yield block, future.result()
    finally:
        end()
        pool.shutdown(cancel_futures=True)


def serve() -> None:
    """Simulate incoming blocks as a worker, until the input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all processes of a terminal: the parent ends this one
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # keep prints of user models out of the answers
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
    """Read messages; at the end of the input the parent is gone, and this process ends at once."""
    while True:
        try:
            messages.put(pickle.load(stream))
        except BaseException:  # noqa: BLE001  (whatever is wrong with the input: there is nothing more to do)
            os._exit(0)


def outcome_of(columns: Callable[[], dict[str, Any]]) -> tuple[str, Any]:
    """Return the outcome of the simulation of a block: ``("done", columns)``, or ``("failed", reason)``."""
    try:
        return "done", columns()
    except BaseException:  # noqa: BLE001  (a person can read it)
        return "failed", traceback.format_exc()
