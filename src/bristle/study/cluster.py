"""A Dask cluster that simulates the blocks of a study: its workers come and go, and what they hold goes to others.

The scheduler reads every task: they call nothing but what Python brings, so that it needs no bristle. The study travels
once, as a task of its own, whose result the cluster keeps, hands on between workers, and makes anew where it was lost.
"""

from __future__ import annotations

import asyncio
import hashlib
import importlib
import logging
import math
import pickle
import queue
import re
import secrets
import socket
import time
import warnings
from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cache, lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from bristle.core.cores import Abreast, cores_for_simulations
from bristle.core.errors import InputError, InputWarning, said_by_library, shortened, told_by
from bristle.core.locks import LOADING
from bristle.core.tabular import library
from bristle.study.block import REASON, Simulator
from bristle.study.plan import Block, Study
from bristle.study.workers import AHEAD, PATIENCE, Results, WorkerError, outcome_of

__all__ = ["Cluster", "checked", "checksum_of_code", "described", "host_and_port", "simulated"]

OPTION, FEATURE = "--scheduler", "bristle study --scheduler"
PORT = 8786
ANSWERS = 10.0  # [s] until which something answers at an address, and a scheduler that was lost is there again
SAYS = 60.0  # [s] until which workers have said what they are: they load libraries for it
ALONE = 5.0  # [s] without a worker, after which it is told
LIBRARIES = ("numpy", "scipy", "numba")
UNFIT = "unfit"
LETTERS = 12
_ADDRESS = re.compile(r"(?:tcp|tls)://(?P<host>\[[0-9A-Fa-f:.%]+\]|[^\s/:\[\]]+):(?P<port>\d{1,5})/?")
_SIMULATED = "import_module('bristle.study.cluster').simulated(plan, checksum, code, first, last)"
_DESCRIBED = "import_module('bristle.study.cluster').described()"


def host_and_port(address: str) -> tuple[str, int]:
    """Return host and port of the address of a scheduler.

    Examples
    --------
    >>> host_and_port("tcp://big-machine:8786")
    ('big-machine', 8786)
    """
    match = _ADDRESS.fullmatch(address)
    if match is None or not 0 < int(match["port"]) < 2**16:
        raise InputError(
            "is no address of a scheduler",
            path=OPTION,
            value=address,
            allowed=f"tcp://HOST:PORT or tls://HOST:PORT, the usual port being {PORT}",
        )
    return match["host"].strip("[]"), int(match["port"])


def checked(address: str) -> Any:
    """Return the library that connects to a scheduler, once its address is one; refuse what is none, or no library."""
    host_and_port(address)
    return library("distributed", FEATURE, "study")


class Cluster:
    """The workers of a Dask cluster, as a `Crew` is those of this machine."""

    def __init__(self, study: Study, address: str) -> None:
        self.study, self.address, self.lost = study, address, list[tuple[Block, int | None]]()
        self._library = checked(address)
        self._pickled = pickle.dumps(study, protocol=pickle.HIGHEST_PROTOCOL)
        self._name, self._count = f"bristle-{secrets.token_hex(8)}", 0
        self._looked, self._populated = 0.0, time.monotonic()  # [s]
        self._fit: dict[str, int] = {}  # threads of each worker that may simulate, by its address
        self._unfit: dict[str, InputError] = {}
        self._has_begun, self._plan, self._alone = False, None, ""
        self._blocks, self._suspects = deque[Block](), deque[Block]()
        self._under_way: dict[Any, Block] = {}
        self._arrivals = queue.SimpleQueue[Any]()

    @property
    def workers(self) -> int:
        """How many workers there are that simulate."""
        return len(self._fit)

    def results(self, blocks: Iterable[Block]) -> Results:
        """Yield blocks with their columns, in the order in which they arrive.

        A block whose workers ended as often as the scheduler tries is tried as often once more at the end, with no
        other in the cluster that might have ended them; then it is left out, and noted among those `lost`.
        """
        with self._connected():
            yield from self._arriving(blocks)

    @contextmanager
    def _connected(self) -> Iterator[None]:
        """Connect, and ask the workers that are there what they are; at the end take back what is handed out."""
        with _silent():
            self._client = _connected(self._library, self.address)
            try:
                self._look()
                for refusal in self._unfit.values():
                    raise refusal
                self._has_begun = True
                for origin in self.study.origins.get("code", ()):
                    _warn(f"the code in {origin.name} (SHA-256 {origin.checksum}) is run on every worker of {self.address}")
                yield
            finally:
                with suppress(OSError, TimeoutError):
                    self._client.close(timeout=ANSWERS)

    def _arriving(self, blocks: Iterable[Block]) -> Results:
        self._blocks.extend(blocks)
        while self._blocks or self._under_way or self._suspects:
            if self._client.status in ("closing", "closed"):
                raise InputError(
                    "the scheduler is gone",
                    path=OPTION,
                    value=self.address,
                    mend="What is written stays. Start it and its workers, and give the same command again",
                )
            self._look()
            self._hand_out()
            with suppress(queue.Empty):
                future = self._arrivals.get(timeout=PATIENCE)
                block = self._under_way.pop(future.key)
                if (columns := self._columns(block, future)) is not None:
                    yield block, columns

    def _look(self) -> None:
        """Look which workers there are, once a while, and ask those that are new what they are."""
        now = time.monotonic()
        if now < self._looked + PATIENCE or self._client.status != "running":
            return
        self._looked = now
        try:  # where that fails, the client sees by itself that the connection is lost
            threads = self._client.nthreads(callback_timeout=ANSWERS)
            self._fit = {address: threads[address] for address in self._fit if address in threads}
            self._unfit = {address: refusal for address, refusal in self._unfit.items() if address in threads}
            new = [address for address in threads if address not in self._fit and address not in self._unfit]
            names = {"import_module": importlib.import_module}
            answers = self._client.run(eval, _DESCRIBED, names, workers=new, on_error="return", callback_timeout=SAYS) if new else {}
        except (OSError, TimeoutError):
            return
        for address, facts in answers.items():
            self._judge(address, threads[address], facts)
        if threads:
            self._populated = now
        elif now > self._populated + ALONE:
            self._populated = math.inf  # told once
            _warn(f"{self.address} has no workers. Waiting for one: dask worker {self.address} --nworkers auto --nthreads 1")

    def _judge(self, address: str, threads: int, facts: Any) -> None:
        """Let a worker simulate, or refuse it, by what it says of itself."""
        own = described()
        if isinstance(facts, (ImportError, AttributeError)):
            self._refuse(address, "the worker cannot load this bristle", shortened(f"{type(facts).__name__}: {told_by(facts)}", REASON))
        elif isinstance(facts, Exception):
            return  # it is gone; where it is there, it is asked again
        elif (facts["bristle"], facts["code"]) != (own["bristle"], own["code"]):
            self._refuse(address, "the worker has another bristle", _named(facts))
        else:
            self._fit[address] = threads
            different = [f"{name} {facts[name]} (here {own[name]})" for name in LIBRARIES if facts[name] != own[name]]
            if different:
                _warn(f"the worker {address} has {', '.join(different)}: the last digits of its numbers may be other ones")

    def _refuse(self, address: str, fault: str, value: str) -> None:
        mend = "Install the same in the Python that it runs in and start it again, or stop it"
        self._unfit[address] = InputError(fault, path=address, value=value, allowed=_named(described()), mend=mend)
        if self._has_begun:  # what runs is not ended by it
            _warn(f"{self._unfit[address]}; until then it gets no runs")

    def _hand_out(self) -> None:
        if self._client.status != "running" or not self._fit:  # it may look for a scheduler that was lost
            return
        while self._blocks and len(self._under_way) < AHEAD * sum(self._fit.values()):
            self._send(self._blocks.popleft())
        if self._suspects and not self._under_way:
            self._alone = self._send(self._suspects.popleft())

    def _send(self, block: Block) -> str:
        """Hand out a block; return the key of its task."""
        if self._plan is None or self._plan.status not in ("pending", "finished"):  # it was lost with all of its tasks
            self._plan = self._submit("plan", {"plan": self._pickled})
        names = {
            "import_module": importlib.import_module,
            "plan": self._plan,
            "checksum": hashlib.sha256(self._pickled).hexdigest(),
            "code": described()["code"],
            "first": block.first,
            "last": block.last,
        }
        # Where all of these end, the scheduler may take others: one that is unfit gives the block back.
        future = self._submit(_SIMULATED, names, workers=sorted(self._fit), allow_other_workers=True)
        self._under_way[future.key] = block
        future.add_done_callback(self._arrivals.put)
        return future.key

    def _submit(self, expression: str, names: dict[str, Any], **options: Any) -> Any:
        self._count += 1
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Sending large graph")  # the study is sent once
            return self._client.submit(eval, expression, names, key=f"{self._name}-{self._count}", pure=False, **options)

    def _columns(self, block: Block, future: Any) -> dict[str, Any] | None:
        """Return the columns of a block that has ended; None where its worker has, and it goes to another."""
        content: Any = None
        if future.status == "error":
            error = future.exception()
            if isinstance(error, self._library.KilledWorker):
                self.lost.append((block, None)) if future.key == self._alone else self._suspects.append(block)
                return None
            if not self._unfit:
                raise WorkerError.at(block, f"{type(error).__name__}: {error}")
            outcome = UNFIT  # it came to one of those, which cannot even say so
        else:
            try:
                outcome, content = future.result(timeout=ANSWERS)
            except (OSError, TimeoutError, self._library.CancelledError):  # all that the cluster had, or the way to it
                self._blocks.appendleft(block)
                return None
        if outcome == "failed":
            raise WorkerError.at(block, content)
        if outcome == UNFIT:  # all are asked again: one may have begun anew as another one
            self._blocks.appendleft(block)
            self._fit.clear()
        return content


def _warn(sentence: str) -> None:
    warnings.warn(sentence, InputWarning, stacklevel=3)


def _named(facts: dict[str, str]) -> str:
    return f"bristle {facts['bristle']}, code {facts['code']}"


def _connected(distributed: Any, address: str) -> Any:
    """Return a connection to a scheduler."""
    mend = f"Start one, dask scheduler --port {PORT}, and workers: dask worker {address} --nworkers auto --nthreads 1"
    fault = "nothing answers there"

    async def identity() -> Any:  # the library itself would wait for it for ever
        arguments = distributed.Security().get_connection_args("client")
        async with distributed.rpc(address, connection_args=arguments) as scheduler:
            return await asyncio.wait_for(scheduler.identity(), ANSWERS)

    try:
        # The library asks again for as long as it may: here a machine that refuses is told at once.
        socket.create_connection(host_and_port(address), timeout=ANSWERS).close()
        fault = "what answers there is no scheduler of Dask"
        with Abreast(1) as thread:  # this one may run a loop of its own, as in a notebook
            kind = thread.submit(asyncio.run, identity()).result()["type"]
        if kind != "Scheduler":
            raise ValueError(f"it is a {kind}")
        return distributed.Client(address, timeout=ANSWERS, set_as_default=False, name="bristle")
    except Exception as error:  # noqa: BLE001  (what answers there may be anything)
        raise InputError(f"{fault}{said_by_library(error)}", path=OPTION, value=address, mend=mend) from None


@contextmanager
def _silent() -> Iterator[None]:
    """Leave out what the library says of connections that are lost: what comes of them is told."""
    names = [name for name in logging.root.manager.loggerDict if name.partition(".")[0] in ("distributed", "asyncio")]
    levels = {name: logging.getLogger(name).level for name in names}
    try:
        for name in names:
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
        yield
    finally:
        for name, level in levels.items():
            logging.getLogger(name).setLevel(level)


# What follows is called on the workers, of the plan that came with the call: no file of the study is read there.


@cache
def described() -> dict[str, str]:
    """Return what computes in this process: version and code of bristle, versions of its libraries."""
    names = {name: version(name) for name in ("bristle", *LIBRARIES)}
    return names | {"code": checksum_of_code(Path(__file__).parents[1])}


def checksum_of_code(root: Path) -> str:
    """Return the first letters of a SHA-256 over the Python below a folder: two copies may say the same version."""
    digest = hashlib.sha256()
    for name in sorted(file.relative_to(root).as_posix() for file in root.rglob("*.py")):
        content = (root / name).read_bytes().replace(b"\r\n", b"\n")
        digest.update(f"{name} {hashlib.sha256(content).hexdigest()} ".encode())
    return digest.hexdigest()[:LETTERS]


def simulated(plan: bytes, checksum: str, code: str, first: int, last: int) -> tuple[str, Any]:
    """Return what is kept of a block, as a worker of this machine tells it; of a bristle that is unfit, that it is."""

    def columns() -> dict[str, Any]:
        with cores_for_simulations():
            with LOADING:  # made once in this process, whichever of its threads asks first
                simulator = _simulator(plan, checksum)
            return simulator.columns(Block(first, last))

    return outcome_of(columns) if described()["code"] == code else (UNFIT, None)


@lru_cache(4)
def _simulator(plan: bytes, checksum: str) -> Simulator:
    if hashlib.sha256(plan).hexdigest() != checksum:
        raise ValueError("the study did not arrive as it was sent")
    return Simulator(pickle.loads(plan))
