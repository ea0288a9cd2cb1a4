"""A Dask cluster that simulates the blocks of a study: its workers come and go, and what they hold goes to others.

The scheduler reads every task: they call nothing but what Python brings, so that it needs no bristle. The study travels
once, as a task of its own, whose result the cluster keeps, hands on between workers, and makes anew where it was lost.
"""

from __future__ import annotations

import asyncio
import hashlib
import importlib
import logging
import pickle
import queue
import re
import secrets
import socket
import warnings
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any

from bristle.core.cores import Abreast
from bristle.core.errors import InputError, InputWarning, said_by_library
from bristle.core.tabular import library
from bristle.study.crew import PATIENCE, WorkerError
from bristle.study.plan import Block, Study
from bristle.study.remote import UNFIT, described
from bristle.study.roster import Roster

__all__ = ["Cluster", "checked", "host_and_port"]

OPTION, FEATURE = "--scheduler", "bristle study --scheduler"
PORT = 8786
ANSWERS = 5.0  # [s] until which something answers at the address
BEGINS = 10.0  # [s] until which that turns out to be a scheduler, or one that was lost is there again
SENDS = 10.0  # [s] until which the columns of a block arrive
AHEAD = 4  # blocks for each thread: while it simulates one, others are on their way there and back
_ADDRESS = re.compile(r"(?:tcp|tls)://(?P<host>\[[0-9A-Fa-f:.%]+\]|[^\s/:\[\]]+):(?P<port>\d{1,5})/?")
_SIMULATED = "import_module('bristle.study.remote').simulated(plan, checksum, code, first, last)"


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
    """Return the library that connects to a scheduler, once its address is one.

    Raises
    ------
    InputError
        If it is none, or the library is not installed.
    """
    host_and_port(address)
    return library("distributed", FEATURE, "study")


@dataclass(frozen=True)
class _HandedOut:
    """A block that the cluster has, what its columns come with, and whether it has no other."""

    block: Block
    future: Any
    is_alone: bool


@dataclass
class Cluster:
    """The workers of a Dask cluster, as a `Crew` is those of this machine."""

    study: Study
    address: str
    lost: list[tuple[Block, int | None]] = field(default_factory=list)
    _library: Any = None
    _client: Any = None
    _roster: Any = None
    _plan: Any = None
    _pickled: bytes = b""
    _checksum: str = ""
    _handed_out: dict[str, _HandedOut] = field(default_factory=dict)
    _blocks: deque[Block] = field(default_factory=deque)
    _suspects: deque[Block] = field(default_factory=deque)
    _arrivals: queue.SimpleQueue[Any] = field(default_factory=queue.SimpleQueue)
    _count: int = 0
    _stack: ExitStack = field(default_factory=ExitStack)

    def __enter__(self) -> Cluster:
        """Connect, and meet the workers that are there."""
        with ExitStack() as stack:
            self._library = checked(self.address)
            stack.enter_context(_silent())
            self._client = _connected(self._library, self.address)
            stack.callback(self._leave)
            self._roster = Roster(self._client, self.address, f"bristle-{secrets.token_hex(8)}")
            self._roster.meet()
            self._pickled = pickle.dumps(self.study, protocol=pickle.HIGHEST_PROTOCOL)
            self._checksum = hashlib.sha256(self._pickled).hexdigest()
            for origin in self.study.origins.get("code", ()):
                warnings.warn(
                    f"the code in {origin.name} (SHA-256 {origin.checksum}) is run on every worker of {self.address}",
                    InputWarning,
                    stacklevel=2,
                )
            self._stack = stack.pop_all()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: Any, trace: TracebackType | None) -> None:
        """Take back what is handed out: a block that a worker has begun it ends, for nobody."""
        self._stack.close()

    @property
    def workers(self) -> int:
        """How many workers there are that simulate."""
        return len(self._roster.fit)

    def results(self, blocks: Iterable[Block]) -> Iterator[tuple[Block, dict[str, Any]]]:
        """Yield blocks with their columns, in the order in which they arrive.

        A block whose workers ended as often as the scheduler tries is tried as often once more at the end, with no
        other in the cluster that might have ended them; then it is left out, and noted among those `lost`.
        """
        self._blocks.extend(blocks)
        while self._blocks or self._handed_out or self._suspects:
            self._look()
            self._hand_out()
            with suppress(queue.Empty):
                arrival = self._arrivals.get(timeout=PATIENCE)
                held = self._handed_out.pop(arrival.key, None)
                if held is not None and (columns := self._columns(held)) is not None:
                    yield held.block, columns

    def _look(self) -> None:
        """Look which workers there are."""
        if self._client.status in ("closing", "closed"):
            raise InputError(
                "the scheduler is gone",
                path=OPTION,
                value=self.address,
                mend="What is written stays. Start it and its workers, and give the same command again",
            )
        self._roster.look()

    def _hand_out(self) -> None:
        if self._client.status != "running" or not self._roster.fit:  # it may look for a scheduler that was lost
            return
        most = AHEAD * sum(self._roster.fit.values())
        while self._blocks and len(self._handed_out) < most:
            self._send(self._blocks.popleft(), is_alone=False)
        if self._suspects and not self._handed_out:
            self._send(self._suspects.popleft(), is_alone=True)

    def _send(self, block: Block, *, is_alone: bool) -> None:
        names = {
            "import_module": importlib.import_module,
            "plan": self._plan_there(),
            "checksum": self._checksum,
            "code": described()["code"],
            "first": block.first,
            "last": block.last,
        }
        # Where all of these end, the scheduler may take others: one that is unfit gives the block back.
        future = self._submit(_SIMULATED, names, workers=sorted(self._roster.fit), allow_other_workers=True)
        self._handed_out[future.key] = _HandedOut(block, future, is_alone)
        future.add_done_callback(self._arrivals.put)

    def _plan_there(self) -> Any:
        """Return the study as the cluster has it; where it lost it with all of its tasks, it gets it again."""
        if self._plan is None or self._plan.status not in ("pending", "finished"):
            self._plan = self._submit("plan", {"plan": self._pickled})
        return self._plan

    def _submit(self, expression: str, names: dict[str, Any], **options: Any) -> Any:
        self._count += 1
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Sending large graph")  # the study is sent once
            return self._client.submit(eval, expression, names, key=f"{self._roster.name}-{self._count}", pure=False, **options)

    def _columns(self, held: _HandedOut) -> dict[str, Any] | None:
        """Return the columns of a block that has ended; None where its worker has, and it goes to another."""
        if held.future.status == "error":
            self._note_ending(held, held.future.exception())
            return None
        try:
            outcome, content = held.future.result(timeout=SENDS)
        except (OSError, TimeoutError, self._library.CancelledError):  # all that the cluster had, or the way to it
            self._blocks.appendleft(held.block)
            return None
        if outcome == "failed":
            raise _failure(held.block, content)
        if outcome == UNFIT:
            self._take_from_unfit(held.block)
        return content

    def _note_ending(self, held: _HandedOut, error: Any) -> None:
        if isinstance(error, self._library.KilledWorker):
            if held.is_alone:
                self.lost.append((held.block, None))
            else:
                self._suspects.append(held.block)
        elif self._roster.unfit:  # it came to one of those, which cannot even say so
            self._take_from_unfit(held.block)
        else:
            raise _failure(held.block, f"{type(error).__name__}: {error}")

    def _take_from_unfit(self, block: Block) -> None:
        """Take a block back, and ask all workers again: one may have begun anew as another one."""
        self._blocks.appendleft(block)
        self._roster.fit.clear()

    def _leave(self) -> None:
        with suppress(OSError, TimeoutError):
            self._client.close(timeout=ANSWERS)


def _failure(block: Block, why: str) -> WorkerError:
    return WorkerError(f"a worker failed at the runs {block.first} to {block.last - 1}: {why}")


def _connected(distributed: Any, address: str) -> Any:
    """Return a connection to a scheduler."""
    mend = f"Start one, dask scheduler --port {PORT}, and workers: dask worker {address} --nworkers auto --nthreads 1"
    try:
        # The library asks again for as long as it may: here a machine that refuses is told at once.
        socket.create_connection(host_and_port(address), timeout=ANSWERS).close()
    except OSError as error:
        raise InputError(f"nothing answers there{said_by_library(error)}", path=OPTION, value=address, mend=mend) from None
    try:
        with Abreast(1) as thread:  # this one may run a loop of its own, as in a notebook
            identity = thread.submit(asyncio.run, _identity(distributed, address)).result()
        if identity["type"] != "Scheduler":
            raise ValueError(f"it is a {identity['type']}")
        return distributed.Client(address, timeout=BEGINS, set_as_default=False, name="bristle")
    except Exception as error:  # noqa: BLE001  (what answers there may be anything)
        raise InputError(
            f"what answers there is no scheduler of Dask{said_by_library(error)}", path=OPTION, value=address, mend=mend
        ) from None


async def _identity(distributed: Any, address: str) -> Mapping[str, Any]:
    """Return what answers at an address; the library itself would wait for it for ever."""
    arguments = distributed.Security().get_connection_args("client")
    async with distributed.rpc(address, connection_args=arguments) as scheduler:
        return await asyncio.wait_for(scheduler.identity(), BEGINS)


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
