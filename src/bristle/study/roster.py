"""Which workers of a cluster may simulate: each that joins is asked what it is, and another bristle is refused."""

from __future__ import annotations

import importlib
import time
import warnings
from dataclasses import dataclass, field
from typing import Any

from bristle.core.errors import InputError, InputWarning, shortened, told_by
from bristle.study.remote import LIBRARIES, described

__all__ = ["Roster"]

LOOKS = 0.5  # [s]: so often it is looked which workers there are
ANSWERS = 10.0  # [s] until which a scheduler says which
SAYS = 60.0  # [s] until which workers that are there have said what they are: they load libraries for it
ALONE = 5.0  # [s] without a worker, after which it is told
CAUSE = 300  # letters
# The scheduler reads what is called: it needs no bristle where that is Python's own.
_DESCRIBED = "import_module('bristle.study.remote').described()"


@dataclass
class Roster:
    """The workers of a cluster."""

    client: Any
    address: str
    name: str
    fit: dict[str, int] = field(default_factory=dict)
    """Threads of each worker that may simulate, by its address."""
    unfit: dict[str, InputError] = field(default_factory=dict)
    """Why each other one may not."""
    _meeting: bool = True
    _asking: dict[str, Any] = field(default_factory=dict)
    _count: int = 0
    _looked: float = float("-inf")
    _alone: float | None = None

    def meet(self) -> None:
        """Look which workers there are, and wait until they have said what they are."""
        end = time.monotonic() + SAYS
        self.look()
        while self._asking and not self.unfit and time.monotonic() < end:
            time.sleep(LOOKS)
            self.look()
        for refusal in self.unfit.values():
            raise refusal
        self._meeting = False

    def look(self) -> None:
        """Look which workers there are, unless that was done a moment ago; one that is refused now is told."""
        now = time.monotonic()
        if now < self._looked + LOOKS or self.client.status != "running":
            return
        self._looked = now
        try:
            threads = self.client.nthreads(callback_timeout=ANSWERS)
        except (OSError, TimeoutError):  # the client sees by itself that the connection is lost
            return
        self.fit = {address: threads[address] for address in self.fit if address in threads}
        for workers in (self.unfit, self._asking):
            for address in workers.keys() - threads.keys():
                del workers[address]
        for address, future in list(self._asking.items()):
            if future.done():
                del self._asking[address]
                self._judge(address, threads[address], future)
        for address in threads.keys() - self.fit.keys() - self.unfit.keys() - self._asking.keys():
            self._ask(address)
        self._tell_if_alone(bool(threads), now)

    def _ask(self, address: str) -> None:
        self._count += 1
        self._asking[address] = self.client.submit(
            eval,
            _DESCRIBED,
            {"import_module": importlib.import_module},
            key=f"{self.name}-asks-{self._count}",
            workers=[address],
            priority=1,
            pure=False,
        )

    def _judge(self, address: str, threads: int, future: Any) -> None:
        own = described()
        if future.status == "finished":
            self._compare(address, threads, future.result(timeout=ANSWERS), own)
        elif future.status == "error" and isinstance(cause := future.exception(), (ImportError, AttributeError)):
            value = shortened(f"{type(cause).__name__}: {told_by(cause)}", CAUSE)
            self._refuse(address, "the worker cannot load this bristle", value, own)
        # What became of any other is that the worker, or the connection, is gone: if it is there, it is asked again.

    def _compare(self, address: str, threads: int, facts: dict[str, str], own: dict[str, str]) -> None:
        if (facts["bristle"], facts["code"]) != (own["bristle"], own["code"]):
            self._refuse(address, "the worker has another bristle", _named(facts), own)
            return
        self.fit[address] = threads
        different = [f"{name} {facts[name]} (here {own[name]})" for name in LIBRARIES if facts[name] != own[name]]
        if different:
            warnings.warn(
                f"the worker {address} has {', '.join(different)}: the last digits of its numbers may be other ones",
                InputWarning,
                stacklevel=2,
            )

    def _refuse(self, address: str, fault: str, value: str, own: dict[str, str]) -> None:
        refusal = InputError(
            fault,
            path=address,
            value=value,
            allowed=_named(own),
            mend="Install the same in the Python that it runs in and start it again, or stop it",
        )
        self.unfit[address] = refusal
        if not self._meeting:  # what runs is not ended by it
            warnings.warn(f"{refusal}; until then it gets no runs", InputWarning, stacklevel=2)

    def _tell_if_alone(self, anybody: bool, now: float) -> None:
        """Tell once whenever there has been no worker for a while."""
        if anybody:
            self._alone = None
        elif self._alone is None:
            self._alone = now
        elif now > self._alone + ALONE:
            self._alone = float("inf")
            warnings.warn(
                f"{self.address} has no workers. Waiting for one: dask worker {self.address} --nworkers auto --nthreads 1",
                InputWarning,
                stacklevel=2,
            )


def _named(facts: dict[str, str]) -> str:
    return f"bristle {facts['bristle']}, code {facts['code']}"
