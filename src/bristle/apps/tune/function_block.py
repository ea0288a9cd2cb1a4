"""A machine whose controller runs the function block ``FB_BristleTune``: PLCs by ADS or OPC UA."""

import time
import zlib
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from bristle.apps.tune.machine import (
    STOPS,
    FrictionFeedforward,
    Limits,
    MachineRefusedError,
    MachineStoppedError,
    Recording,
    State,
)
from bristle.core import InputError, did_you_mean

BLOCK = 200  # rows of the motion that one transfer writes
WRITTEN = {
    "bool": ("armed", "keep", "clear", "start"),
    "lreal": ("max_error", "max_effort", "low", "high", "gain", "offset", "ramp", "block"),
    "dint": ("patience", "alive", "rows", "block_first", "block_rows"),
    "lint": ("model",),
}
"""The allow list: variables of the function block that a run writes, by type."""
OUTPUTS = {
    "bool": ("ok", "playing"),
    "lreal": ("gain_now", "ring", "row"),
    "dint": ("cause", "motion_rows", "ring_rows"),
    "lint": ("count",),
}
KINDS = {name: kind for kind, names in WRITTEN.items() for name in names}
TYPES = (
    {name: kind for kind, names in OUTPUTS.items() for name in names}
    | KINDS
    | {"save": "bool", "saved": "bool"}
)
TRIGGERS = ("clear", "start", "block_first", "block_rows")  # the function block resets them
SLEW = 2.0  # of the gain [1/s]
STORING = 15.0  # longest time in which the controller writes its non-volatile memory [s]
POLL = 0.01  # [s]
Rows = Callable[[], np.ndarray]
"""A function that returns the rows of count, set point, position and effort that are available, shape (row, 4)."""


class FunctionBlock(ABC):
    """An axis behind ``FB_BristleTune``; a derived class reads, writes and collects its variables."""

    def __init__(
        self,
        *,
        sample_time: float,  # time of the axis between two calls of the function block [s]
        prefix: str = "",  # text before the name of each variable
        names: Mapping[str, str]
        | None = None,  # full names of variables with another prefix or name
        unit: float = 1e-3,  # one machine unit [m or rad]
        effort_unit: float = 1.0,  # one unit of the effort [N or N*m]
        patience: float = 2.0,  # without a sign of the program; then the feedforward fades [s]
        clock: float = 1.0,  # seconds of the axis in a second of the program, 1 on a real axis
    ) -> None:
        for name in names or ():
            if name not in TYPES:
                raise InputError(
                    "is not a variable of FB_BristleTune",
                    path="settings.names",
                    value=name,
                    mend=did_you_mean(name, TYPES),
                )
        self.sample_time, self._prefix, self._names = sample_time, prefix, dict(names or {})
        self._unit, self._effort_unit, self._patience, self._clock = (
            unit,
            effort_unit,
            patience,
            clock,
        )
        self._feedforward: FrictionFeedforward | None = None
        self._sent = np.empty((0, 2))

    REQUIRED: ClassVar[dict[str, tuple[str, str]]] = {}
    """Settings without which there is no connection, with meaning and example."""
    _errors: tuple[type[Exception], ...] = ()

    @contextmanager
    def _named(self, name: str) -> Iterator[None]:
        """Return a context that raises errors of the connection as refusals with the name of the variable."""
        try:
            yield
        except self._errors as error:
            raise MachineRefusedError(
                "connection",
                f"{name}: {error or type(error).__name__}",
                "Check address, names and prefix; FB_BristleTune must run in the controller",
            ) from None

    @abstractmethod
    def _read(self, name: str) -> Any:
        """Return the value of a variable."""

    @abstractmethod
    def _write(self, name: str, value: Any) -> None:
        """Write a variable."""

    @abstractmethod
    def _recorded(self) -> AbstractContextManager[Rows]:
        """Return a context of `Rows` during a motion."""

    def _full(self, name: str) -> str:
        return self._names.get(name, f"{self._prefix}{name}")

    def writes(self) -> list[str]:
        """Return the names of the variables that a run writes."""
        return [self._full(name) for name in KINDS]

    def state(self) -> State:
        """Return the values of all variables that a run writes."""
        return {name: self._read(name) for name in KINDS}

    def arm(self, limits: Limits) -> None:
        """Write the limits, at gain 0; refuse a function block that keeps the feedforward of another run."""
        if self._read("keep") or self._read("saved"):
            raise MachineRefusedError(
                "kept",
                "the function block keeps the feedforward of an earlier run",
                "Remove it: bristle tune --undo FOLDER",
            )
        low, high = sorted(value / self._unit for value in limits.travel)
        values = {
            "gain": 0.0,
            "offset": 0.0,
            "max_error": limits.following_error / abs(self._unit),
            "low": low,
            "high": high,
            "max_effort": limits.effort / abs(self._effort_unit),
            "ramp": SLEW * self.sample_time,
            "patience": max(round(self._patience * self._clock / self.sample_time), 1),
        }
        for name, value in values.items():
            self._write(name, value)
        self._sign_of_life()
        self._write("armed", True)
        self._clear()

    def _clear(self) -> None:
        """Clear a trip of the guard."""
        self._sign_of_life()
        self._write("clear", True)
        self._until(
            lambda: not self._read("clear"),
            "the function block does not run: it does not reset the variable clear",
        )

    def load(self, feedforward: FrictionFeedforward) -> None:
        """Take a feedforward at gain 0; each motion is written together with its feedforward."""
        self._write("gain", 0.0)
        self._write("model", zlib.crc32(feedforward.name.encode()))
        self._feedforward = feedforward

    def set(self, *, gain: float = 0.0, offset: float = 0.0) -> None:
        """Set gain and test effort."""
        self._write("gain", float(gain))
        self._write("offset", offset / self._effort_unit)

    def record(self, reference: np.ndarray, alive: Callable[[], None]) -> Recording:
        """Play a reference in the function block and return its rows; refuse lost rows with their number."""
        self._clear()
        self._send(reference, alive)
        before, table = int(self._read("count")), np.full((reference.size, 3), np.nan)
        complete = False
        try:
            with self._recorded() as rows:
                self._write("start", True)
                self._collect(table, before, rows, alive)
            complete = True
        finally:
            if not complete:  # the axis stops where it is
                self._write("rows", 0)
        lost = int(np.sum(np.isnan(table[:, 0])))
        if lost:
            raise MachineStoppedError(
                "lost_samples", f"{lost} of {reference.size} rows are missing, by the counter"
            )
        return Recording(
            table[:, 0] * self._unit, table[:, 1] * self._unit, table[:, 2] * self._effort_unit
        )

    def _send(self, reference: np.ndarray, alive: Callable[[], None]) -> None:
        """Write set points and feedforward in blocks, unless the function block contains them."""
        capacity = int(self._read("motion_rows"))
        if reference.size > capacity:
            raise MachineRefusedError(
                "too_long",
                f"a motion has {reference.size} samples, and the function block {capacity} rows",
            )
        feed = (
            np.zeros(reference.size)
            if self._feedforward is None
            else self._feedforward.along(reference, self.sample_time)
        )
        motion = np.column_stack([reference / self._unit, feed / self._effort_unit])
        if not np.array_equal(motion, self._sent):
            self._write("rows", 0)
            self._sent = np.empty((0, 2))
            for first in range(0, len(motion), BLOCK):
                self._transfer(first, motion[first : first + BLOCK])
                alive()
        self._write("rows", reference.size)
        self._sent = motion

    def _transfer(self, first: int, rows: np.ndarray) -> None:
        values = np.zeros(2 * BLOCK)
        values[: rows.size] = rows.ravel()
        self._sign_of_life()
        self._write("block", values.tolist())
        self._write("block_first", first)
        self._write("block_rows", len(rows))
        self._until(
            lambda: self._read("block_rows") == 0,
            "the function block does not run: it does not take a block of the motion",
        )

    def _collect(
        self, table: np.ndarray, before: int, rows: Rows, alive: Callable[[], None]
    ) -> None:
        """Fill the table by the counter, until the motion has ended; raise if the guard trips."""
        size, fetched, step = len(table), before, max(int(self._read("ring_rows")) // 4, 1)
        end = time.monotonic() + 3.0 * size * self.sample_time / self._clock + 10.0
        while time.monotonic() < end:
            self._sign_of_life()
            alive()
            count = int(self._read("count"))
            if not self._read("ok"):
                raise MachineStoppedError(
                    STOPS[int(self._read("cause")) - 1], f"at sample {count - before}"
                )
            if count - fetched >= step or count - before >= size:
                fetched = count
                fill(table, before, rows())
            if count - before >= size:
                self._drain(table, before, rows)
                return
            time.sleep(POLL)
        raise MachineRefusedError("no_end", "the motion did not end in three times its duration")

    def _drain(self, table: np.ndarray, before: int, rows: Rows) -> None:
        """Fill the table from rows that are still on their way."""
        fill(table, before, rows())

    def _sign_of_life(self) -> None:
        self._write("alive", (int(self._read("alive")) + 1) % 2**30)

    def _until(
        self,
        reached: Callable[[], bool],
        reason: str,
        longest: float = 1.0,
        mend: str = "Call FB_BristleTune in each cycle",
    ) -> None:
        """Wait for the function block."""
        end = time.monotonic() + longest
        while not reached():
            if time.monotonic() > end:
                raise MachineRefusedError("no_cycle", reason, mend)
            time.sleep(1e-3)

    def keep(self) -> None:
        """Keep the feedforward with its motion when this program ends, also if the guard tripped while this program computed."""
        self._write("keep", True)
        self._clear()
        if not self._read("ok"):
            raise MachineStoppedError(STOPS[int(self._read("cause")) - 1])

    def saved(self) -> Mapping[str, str]:
        """Return the checksum of the model whose feedforward is in force after a restart."""
        return {self._full("saved"): str(self._read("model")) if self._read("saved") else ""}

    def save(self, folder: Path) -> Mapping[str, str]:
        """Have the controller write the persistent variables, which contain feedforward and motion."""
        try:
            self._store(True)
        except MachineRefusedError:
            for name in ("saved", "save"):
                self._write(name, False)
            raise
        return {self._full("saved"): str(self._read("model"))}

    def unsave(self) -> None:
        """Have the controller write the persistent variables of the restored function block."""
        self._store(False)

    def _store(self, saved: bool) -> None:
        self._write("saved", saved)
        self._write("save", True)
        reason = (
            "the program of the controller does not report that the persistent variables are stored"
        )
        self._until(
            lambda: not self._read("save"),
            reason,
            STORING,
            "Connect store and stored of the function block, as the head of FB_BristleTune.st shows",
        )

    def restore(self, state: State) -> None:
        """Fade the feedforward, and write all variables back."""
        if self._read("armed"):
            for name in ("gain", "offset"):
                self._write(name, 0.0)
            self._sign_of_life()
            self._until(
                lambda: self._read("gain_now") == 0.0,
                "the feedforward does not fade: the function block does not run",
                1.0 + 1.0 / (SLEW * self._clock),
            )
        self._write("armed", False)
        self._write("clear", True)
        self._until(
            lambda: not any(self._read(name) for name in TRIGGERS),
            "the function block does not reset its triggers",
        )
        for name in KINDS:
            if name not in (*TRIGGERS, "armed"):
                self._write(name, state[name])
        self._write("armed", state["armed"])
        self._feedforward, self._sent = None, np.empty((0, 2))


def fill(table: np.ndarray, before: int, rows: np.ndarray) -> None:
    """Put rows at their places by the counter."""
    place = rows[:, 0].astype(np.int64) - before - 1
    inside = (place >= 0) & (place < len(table))
    table[place[inside]] = rows[inside, 1:]
