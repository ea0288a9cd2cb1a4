"""Workers that simulate the blocks of a study: threads of this process, or the processes of a Dask cluster.

The cluster is that of a scheduler elsewhere, or one of this machine that lasts as long as the study. The study is a separate
task, sent once. Workers pass the study on, and repeat this task if the study was lost.
"""

from __future__ import annotations

import asyncio
import hashlib
import logging
import os
import pickle
import platform
import queue
import subprocess
import sys
import threading
import time
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
from typing import Any

from bristle.apps.study.plan import Block
from bristle.core import (
    LOADING,
    Abreast,
    BristleError,
    InputError,
    InputWarning,
    cores_for_simulations,
    library,
    said_by_library,
)

TRIES = 5  # of the processes of this machine, if they fail to start
PATIENCE = 0.2  # [s]: interval of checks for signals
AHEAD = 4  # blocks for each worker: one in simulation, others in its queue
# Command that needs a cluster, and the extra with its libraries.
WANTED_BY = ("bristle study --scheduler", "study")
WANTED_HERE = ("--workers", "study")
ANSWERS = 10.0  # [s] timeout for an answer of the scheduler
ENDS = 3.0  # [s] timeout for the end of the processes of this machine
WORKERS_JOIN = 60.0  # [s] timeout for the first worker, and for the next worker of this machine
# A worker or scheduler ends if it cannot unpickle a function of bristle, so tasks call built-in functions.
SIMULATED = (
    "__import__('bristle.apps.study.workers', fromlist=['']).simulated(plan, software, first, last)"
)
SINGLE = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
DASK = {
    "DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL": "None",  # a long run in compiled code is no sign of a dead worker
    "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "3",  # workers that may end in a block
    "DASK_DISTRIBUTED__SCHEDULER__HTTP__ROUTES": "[]",  # other users of this machine could read them
    "DASK_DISTRIBUTED__WORKER__HTTP__ROUTES": "[]",
    "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False",  # a tenth of the processor time
}
Make = Callable[[Any], Any]  # what makes the simulator of a study
Results = Generator[tuple[Block, dict[str, Any]], None, None]


class WorkerError(BristleError):
    """Error of processes of this machine that end, or of a worker that reports a fault."""

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
    lost: list[Block] = field(default_factory=list)

    def results(self, blocks: Iterable[Block]) -> Results:
        """Yield blocks with their columns."""
        if self.workers == 1:
            yield from ((block, self.simulate(block)) for block in blocks)
            return
        # Around all threads, because each thread would restore the filters of another.
        with warnings.catch_warnings(action="ignore"):
            yield from _in_threads(self.simulate, blocks, self.workers)


class Cluster:
    """Workers of a Dask cluster; they may come and go, and their blocks move to others."""

    wanted_by = WANTED_BY

    def __init__(self, study: Any, make: Make, address: str) -> None:
        self.study = study
        self.make = make
        self.address = address
        self.lost: list[Block] = []
        self._library = library("distributed", *self.wanted_by)
        self._security = self._library.Security()

    def results(self, blocks: Iterable[Block]) -> Results:
        """Yield blocks with their columns, as they arrive.

        If the workers of a block ended in all tries of the scheduler, the block gets the same number of tries at the end,
        alone in the cluster, because other blocks may have ended its workers. If these also fail, it is added to `lost`.
        """
        with _silent(), self._connected() as client:
            self._announce_code()
            pool = client.get_executor(pure=False)
            content = pickle.dumps((self.make, self.study), protocol=pickle.HIGHEST_PROTOCOL)
            with warnings.catch_warnings():  # the study is sent only once
                warnings.filterwarnings("ignore", "Sending large graph")
                plan = client.submit(bytes, content, pure=False)

            def submit(block: Block) -> Future[Any]:
                return pool.submit(
                    eval,
                    SIMULATED,
                    {
                        "plan": plan,
                        "software": described(),
                        "first": block.first,
                        "last": block.last,
                    },
                )

            def alone() -> int:
                self._threads(client)  # an error if no worker can come any more
                return 1

            yield from self._arrived(
                _as_ready(submit, blocks, lambda: AHEAD * max(self._threads(client), 1))
            )
            suspects = self.lost
            self.lost = []
            for block in suspects:
                yield from self._arrived(_as_ready(submit, [block], alone))

    @contextmanager
    def _connected(self) -> Iterator[Any]:
        """Connect to the scheduler, and wait for a worker; cancel the remaining tasks at the end."""
        fault = "no Dask scheduler answers at this address"
        client = None
        distributed = self._library

        async def identity() -> None:  # the library alone would wait without a timeout
            arguments = self._security.get_connection_args("client")
            async with distributed.rpc(self.address, connection_args=arguments) as scheduler:
                await asyncio.wait_for(scheduler.identity(), ANSWERS)

        try:
            try:
                with Abreast(1) as thread:  # this thread may run an event loop, as in a notebook
                    thread.submit(asyncio.run, asyncio.wait_for(identity(), ANSWERS)).result()
                client = distributed.Client(
                    self.address,
                    timeout=ANSWERS,
                    security=self._security,
                    set_as_default=False,
                    name="bristle",
                )
                fault = "the scheduler has no workers"
                client.wait_for_workers(1, timeout=WORKERS_JOIN)
            except Exception as error:  # noqa: BLE001  (what answers there may be anything)
                raise self._fault(
                    f"{fault}{said_by_library(error)}",
                    f"Start dask scheduler --port 8786, then dask worker {self.address} --nworkers auto --nthreads 1",
                ) from None
            yield client
        finally:
            if client is not None:
                with suppress(OSError, TimeoutError):
                    client.close(timeout=ANSWERS)

    def _announce_code(self) -> None:
        """Warn of code of the user, which runs on machines of others."""
        for origin in self.study.origins.get("code", ()):
            warnings.warn(
                f"bristle runs the code in {origin.name} (SHA-256 {origin.checksum}) on every worker of {self.address}",
                InputWarning,
                stacklevel=2,
            )

    def _threads(self, client: Any) -> int:
        """Return the present count of threads of the workers."""
        try:
            return sum(client.nthreads(callback_timeout=ANSWERS).values())
        except (OSError, TimeoutError, RuntimeError):
            raise self._scheduler_lost() from None

    def _scheduler_lost(self) -> BristleError:
        return self._fault(
            "the scheduler no longer answers",
            "The results written so far remain. Start scheduler and workers, and repeat the command",
        )

    def _fault(self, message: str, mend: str) -> BristleError:
        return InputError(message, path="--scheduler", value=self.address, mend=mend)

    def _unfit(self, software: str) -> BristleError:
        return InputError(
            "the software of a worker differs",
            path=self.address,
            value=software,
            allowed=", ".join(f"{name} {value}" for name, value in described().items()),
            mend="Install the allowed versions on this worker and restart the worker, or stop it",
        )

    def _arrived(self, futures: Iterator[tuple[Block, Future[Any]]]) -> Results:
        """Yield blocks with their columns; note those whose workers ended."""
        for block, future in futures:
            try:
                outcome, content = future.result()
            except self._library.KilledWorker:
                self.lost.append(block)
                continue
            except CancelledError:
                raise self._scheduler_lost() from None
            except Exception as error:  # noqa: BLE001  (the worker could not even begin)
                raise WorkerError.at(block, f"{type(error).__name__}: {error}") from None
            if outcome == "failed":
                raise WorkerError.at(block, content)
            if outcome == "unfit":
                raise self._unfit(content)
            yield block, content


class OwnCluster(Cluster):
    """A Dask cluster of processes of this machine. They end with the study, or with this process."""

    wanted_by = WANTED_HERE

    def __init__(self, study: Any, make: Make, workers: int) -> None:
        super().__init__(study, make, "")
        library("cryptography", *self.wanted_by)
        self.workers = workers

    @contextmanager
    def _connected(self) -> Iterator[Any]:
        # Other users of this machine can reach the scheduler.
        self._security = self._library.Security.temporary()
        with self._held(), super()._connected() as client:
            self._last_alive = time.monotonic()
            yield client

    @contextmanager
    def _held(self) -> Iterator[None]:
        """Hold the cluster in a process of its own: a script of the user needs no guard, and the terminal stays silent."""
        code = f"import sys; sys.path[:] = {sys.path!r}; from bristle.apps.study.holder import hold_cluster; hold_cluster()"
        pipe = subprocess.PIPE
        ending = 0
        options = {"n_workers": self.workers, "security": self._security}
        for _ in range(TRIES):
            with subprocess.Popen(
                [sys.executable, "-c", code],
                env=_environment(),
                stdin=pipe,
                stdout=pipe,
                stderr=subprocess.DEVNULL,
            ) as holder:
                try:
                    self.address = _answer(holder, options)
                    if self.address:
                        yield
                        return
                    ending = holder.wait()
                finally:
                    _end(holder)
        cause = f"with code {ending}"
        if ending < 0:
            cause = f"by signal {-ending}"
        raise WorkerError(
            f"the processes of this machine ended {TRIES} times before they could start, the last time {cause}"
        )

    def _announce_code(self) -> None:
        """Say nothing: the user allowed the code on this machine."""

    def _threads(self, client: Any) -> int:
        """Return the present count of workers; a process that ended is replaced, unless no process can start any more."""
        threads = super()._threads(client)
        if threads > 0:
            self._last_alive = time.monotonic()
        elif time.monotonic() > self._last_alive + WORKERS_JOIN:
            raise self._fault("no process starts any more", "")
        return threads

    def _unfit(self, software: str) -> BristleError:
        return WorkerError(
            f"the code of bristle changed while the study ran ({software}). The finished runs stay. Repeat the command"
        )

    def _fault(self, message: str, mend: str) -> BristleError:
        return WorkerError(
            f"on this machine, {message}. The finished runs stay. Check the free memory, then repeat the command"
        )


def _environment() -> dict[str, str]:
    """Return the environment of the processes of this machine, without the settings of the user for Dask."""
    own = {name: text for name, text in os.environ.items() if not name.startswith("DASK_")}
    return own | SINGLE | DASK


def _answer(process: Any, message: object) -> str:
    """Return the line that a process answers to a message; an empty one if the process ended, or did not answer in time."""
    too_long = threading.Timer(WORKERS_JOIN, process.kill)
    too_long.daemon = True
    too_long.start()
    try:
        pickle.dump(message, process.stdin)
        process.stdin.flush()
        return process.stdout.readline().decode().strip()
    except OSError:
        return ""
    finally:
        too_long.cancel()


def _end(process: Any) -> None:
    """End a process that ends with its input and cleans up; kill it if that takes too long."""
    try:
        with suppress(OSError, subprocess.TimeoutExpired):
            process.stdin.close()
            process.wait(timeout=ENDS)
    finally:
        process.kill()


@contextmanager
def _silent() -> Iterator[None]:
    """Silence messages of Dask about lost connections, because bristle reports their effects."""
    names = [
        name
        for name in logging.root.manager.loggerDict
        if name.partition(".")[0] in ("distributed", "tornado", "asyncio")
    ]
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
    return names | {"code": checksum_of_code(Path(__file__).parents[2])}


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
        different = ", ".join(
            f"{name} {value}" for name, value in described().items() if software.get(name) != value
        )
        return "unfit", f"{different} on {platform.node()}"

    def columns() -> dict[str, Any]:
        with cores_for_simulations():
            with LOADING:  # made once in this process, by the first thread that needs it
                simulator = _simulator(plan)
            return simulator.columns(Block(first, last))

    return outcome_of(columns)


@lru_cache(4)
def _simulator(plan: bytes) -> Any:
    make, study = pickle.loads(plan)
    return make(study)


def _as_ready(
    submit: Callable[[Block], Future[Any]], blocks: Iterable[Block], ahead: Callable[[], int]
) -> Iterator[tuple[Block, Future[Any]]]:
    """Yield blocks with their results, as they finish; at most so many are in work at once."""
    waiting = iter(blocks)
    ready = queue.SimpleQueue[Future[Any]]()
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
    simulate: Callable[[Block], Any], blocks: Iterable[Block], threads: int
) -> Iterator[tuple[Block, Any]]:
    """Yield blocks with the results of a function called in threads, as they finish."""
    pool = Abreast(threads)
    try:
        for block, future in _as_ready(
            partial(pool.submit, simulate), blocks, lambda: AHEAD * threads
        ):
            yield block, future.result()
    finally:
        pool.shutdown(cancel_futures=True)


def outcome_of(columns: Callable[[], dict[str, Any]]) -> tuple[str, Any]:
    """Return the outcome of the simulation of a block: ``("done", columns)``, or ``("failed", reason)``."""
    try:
        return "done", columns()
    except BaseException:  # noqa: BLE001  (a person can read it)
        return "failed", traceback.format_exc()
