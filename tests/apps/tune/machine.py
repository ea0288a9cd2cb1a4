"""The bench as a machine for `bristle tune`, with faults on request."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from tests.apps.tune.bench import Bench, Motion, drawn

from bristle.apps.tune import FrictionFeedforward, Limits, MachineStoppedError, Recording

WHY = {1: "following_error", 2: "effort", 3: "travel"}


@dataclass
class Faults:
    """Faults of a machine: samples lost in a record, a sign, a drive that ignores the effort, a guard that never trips."""

    lost: dict[str, int] = field(default_factory=dict)
    sign: float = 1.0
    ignores_effort: bool = False
    guard_fails: bool = False
    encoder_fails_at: int | None = None  # number of the motion
    stops_at: int | None = None
    feed_sign: float = 1.0
    feed_scale: float = 1.0


class BenchMachine:
    """An axis simulated without bristle behind the interface of a machine; it persists in a file, as a real controller does."""

    def __init__(
        self, bench: Bench, faults: Faults | None = None, memory: Path | None = None
    ) -> None:
        self.bench, self.faults, self.memory = bench, faults or Faults(), memory
        self.sample_time = bench.plant.sample_time
        self.feedforward: FrictionFeedforward | None = None
        self.records: list[str] = []
        self.motions = 0
        self.kept = False
        self._written: dict[str, Any] = {"guard": None, "model": None, "gain": 0.0}
        if memory is not None and memory.exists():
            self._written = json.loads(memory.read_text())

    def identity(self) -> Mapping[str, str]:
        return {"bench": f"{self.bench.seed}"}

    def writes(self) -> list[str]:
        return list(self._written)

    def state(self) -> Mapping[str, Any]:
        return dict(self._written)

    def _write(self, **values: Any) -> None:
        self._written |= values
        if self.memory is not None:
            self.memory.write_text(json.dumps(self._written))

    def arm(self, limits: Limits) -> None:
        guard = self.bench.guard
        guard.following_error, guard.effort, (guard.low, guard.high) = (
            limits.following_error,
            limits.effort,
            limits.travel,
        )
        guard.gain = guard.offset = 0.0
        self._write(guard=[limits.following_error, limits.effort, *limits.travel], gain=0.0)

    def load(self, feedforward: FrictionFeedforward) -> None:
        self.feedforward = feedforward
        self._write(model=feedforward.name, gain=0.0)

    def set(self, *, gain: float = 0.0, offset: float = 0.0) -> None:
        self.bench.guard.gain = gain
        self.bench.guard.offset = self.faults.sign * offset
        self.bench.guard.reaches_motor = not self.faults.ignores_effort
        self._write(gain=gain)

    def record(self, reference: np.ndarray, alive: Callable[[], None]) -> Recording:
        alive()
        number = len(self.records)
        self.motions += bool(np.ptp(reference))
        self.records.append(f"{reference.size}")
        feed = np.zeros(reference.size)
        if self.feedforward is not None:
            feed = (
                self.faults.feed_sign
                * self.faults.feed_scale
                * self.feedforward.along(reference, self.sample_time)
            )
        self.bench.guard.freezes_at = (
            reference.size // 2 if self.motions == self.faults.encoder_fails_at else np.inf
        )
        rows, count, why = self.bench.play(reference, feed)
        if why and not self.faults.guard_fails:
            self._write(gain=0.0)
            raise MachineStoppedError(WHY[why], f"at sample {count}")
        if number == self.faults.stops_at:
            raise MachineStoppedError("operator", "the operator stopped the axis")
        position, lost = rows[:, 0], self.faults.lost.get(str(number), 0)
        keep = slice(0, count - lost)
        self.truth = rows
        return Recording(reference[:count][keep], position[keep], rows[keep, 1])

    def keep(self) -> None:
        self.kept = True

    def restore(self, state: Mapping[str, Any]) -> None:
        self.bench.guard.gain = self.bench.guard.offset = 0.0
        self.feedforward = None
        self._write(**state)

    def close(self) -> None:
        pass


AXIS = """schema = 1
name = "bench"
kind = "translational"
[columns]
time = {{ column = "time", unit = "s" }}
position = {{ column = "pos", unit = "um" }}
reference = {{ column = "ref", unit = "um" }}
effort = {{ column = "force", unit = "N" }}
[effort]
limit = "{limit:.6g} N"
[encoder]
resolution = "{resolution:.6g} m"
[timing]
sample_time = "1 ms"
[limits]
velocity = "100 mm/s"
acceleration = "2 m/s^2"
stroke = ["-40 mm", "40 mm"]
following_error = "6 mm"
"""
MACHINE = """schema = 1
name = "bench"
machine = "bench.py"
axis = "axis.toml"
[motion]
file = "motion.csv"
cycles = {cycles}
"""


def written(folder: Path, seed: int, cycles: int = 10) -> tuple[Path, Bench, Motion]:
    """Write the machine file, axis file and motion of a random axis; return the file and the axis."""
    plant, motion = drawn(seed)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "axis.toml").write_text(
        AXIS.format(limit=2.0 * plant.limit, resolution=plant.resolution)
    )
    (folder / "machine.toml").write_text(MACHINE.format(cycles=cycles))
    time = np.arange(motion.cycle.size + 1) * plant.sample_time
    whole = np.append(motion.cycle, motion.cycle[0])
    np.savetxt(
        folder / "motion.csv",
        np.column_stack([time, 1e6 * whole]),
        fmt="%.9g",
        delimiter=",",
        header="time [s],ref [um]",
        comments="",
    )
    return folder / "machine.toml", Bench(plant, seed), motion


class Example(BenchMachine):
    """The bench as a machine of a user."""

    def __init__(self, *, sample_time: float = 1e-3, seed: int = 4) -> None:
        super().__init__(Bench(drawn(seed)[0], seed))

    @classmethod
    def example(cls) -> "Example":
        return cls()
