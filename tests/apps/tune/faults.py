"""A small machine in a file, and faults at any of its calls and at any write of the journal."""

import errno
import json
import os
import signal
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from bristle.apps.tune import MachineStoppedError, Recording, tuning
from bristle.apps.tune.contract import FEEDFORWARD
from bristle.apps.tune.steps import ORDER, REFINED, RESULTS, STEPS, cycles_compared

SAMPLE_TIME = 2e-3  # [s]
CALLS = ("identity", "writes", "state", "arm", "load", "set", "record", "keep", "restore", "close")
INITIAL = {"guard": None, "model": None, "gain": 0.0}
AXIS = """schema = 1
name = "small"
kind = "translational"
[columns]
time = { column = "time", unit = "s" }
position = { column = "pos", unit = "um" }
reference = { column = "ref", unit = "um" }
effort = { column = "force", unit = "N" }
[effort]
limit = "100 N"
[encoder]
resolution = "0.1 um"
[timing]
sample_time = "2 ms"
[limits]
velocity = "100 mm/s"
acceleration = "2 m/s^2"
stroke = ["-40 mm", "40 mm"]
following_error = "6 mm"
"""
MACHINE = """schema = 1
name = "small"
machine = "small.py"
axis = "axis.toml"
[motion]
file = "motion.csv"
cycles = 6
"""


def small_files(folder):
    """Write machine file, axis file and a motion of 0.3 s."""
    (folder / "axis.toml").write_text(AXIS)
    (folder / "machine.toml").write_text(MACHINE)
    time = SAMPLE_TIME * np.arange(151)
    wave = 1e3 * (1.0 - np.cos(2.0 * np.pi * time / 0.3))
    np.savetxt(
        folder / "motion.csv",
        np.column_stack([time, wave]),
        delimiter=",",
        header="time [s],ref [um]",
        comments="",
    )
    return folder / "machine.toml"


class Small:
    """An axis with Coulomb friction and a lag that its feedforward removes; its writes last in a file."""

    def __init__(self, memory: Path) -> None:
        self.memory, self.sample_time, self.offset = memory, SAMPLE_TIME, 0.0
        if not memory.exists():
            self._write(**INITIAL)

    def _write(self, **values):
        kept = json.loads(self.memory.read_text()) if self.memory.exists() else {}
        self.memory.write_text(json.dumps(kept | values))

    def identity(self):
        return {"machine": "small"}

    def writes(self):
        return list(INITIAL)

    def state(self):
        return json.loads(self.memory.read_text())

    def arm(self, limits):
        self._write(guard=[limits.following_error, limits.effort, *limits.travel], gain=0.0)

    def load(self, feedforward):
        self._write(model=feedforward.name, gain=0.0)

    def set(self, *, gain=0.0, offset=0.0):
        self.offset = offset
        self._write(gain=gain)

    def record(self, reference, alive):
        alive()
        low, high = self.state()["guard"][2:]
        side = np.sign(np.gradient(reference))
        position = reference - 1e-4 * (1.0 - 0.9 * self.state()["gain"]) * side + 1e-7 * self.offset
        if np.any((position < low) | (position > high)):
            self._write(gain=0.0)
            raise MachineStoppedError("travel", "outside")
        return Recording(reference, position, 10.0 * side)

    def keep(self):
        pass

    def restore(self, state):
        self._write(**state)

    def close(self):
        pass


def reset(machine):
    raise ConnectionResetError(errno.ECONNRESET, "connection reset by peer")


def cut(machine):
    """Fail, and every later call, too: the connection is gone."""
    machine.is_cut = True
    reset(machine)


def broken(machine):
    raise ValueError("a fault in the code of the machine")


def terminated(machine):
    os.kill(os.getpid(), signal.SIGTERM)


def killed(machine):
    os.kill(os.getpid(), signal.SIGKILL)


def full(number):
    """Return a fault of a disk."""

    def fail(_):
        raise OSError(number, os.strerror(number))

    return fail


FAULTS = {"reset": reset, "cut": cut, "broken": broken, "terminated": terminated, "killed": killed}
DISK = {
    "ENOSPC": full(errno.ENOSPC),
    "EROFS": full(errno.EROFS),
    "EIO": full(errno.EIO),
    "terminated": terminated,
    "killed": killed,
}


class Faulty(Small):
    """The machine with a fault before or behind one of its calls."""

    def __init__(self, memory, fault=None, at=-1, *, behind=False):
        super().__init__(memory)
        self.fault, self.at, self.behind, self.count, self.is_cut = fault, at, behind, 0, False

    def __getattribute__(self, name):
        found = super().__getattribute__(name)
        if name not in CALLS:
            return found

        def call(*arguments, **named):
            number, self.count = self.count, self.count + 1
            if self.is_cut:
                reset(self)
            if number == self.at and not self.behind:
                self.fault(self)
            result = found(*arguments, **named)
            if number == self.at and self.behind:
                self.fault(self)
            return result

        return call


def with_short_steps(patch):
    """Replace what computes for long by its facts; each write, record and gate of these steps stays."""

    def identified(results):
        return {
            "model": "coulomb",
            "verdict": "Usable",
            "error_percent": 1.0,
            "lead": 0.0,
            "usable": True,
            "results": results,
        }

    def excitation(run):
        run.record("excitation", run.motion(1))
        run.finish(duration=1.0, error=1e-4)

    def identification(run):
        run.finish(**identified(RESULTS))

    def refinement(run):
        run.set(gain=run.facts["stages"]["gain"])
        run.record("refinement", run.motion(1))
        run.load(FEEDFORWARD)
        run.finish(**identified(REFINED), gain=1.0, error=1e-5)

    def comparison(run):
        for number, side in enumerate(ORDER):
            run.set(gain=side * 1.0)
            run.record(f"side_{number}", run.motion(cycles_compared(6)))
        run.set()
        lower = {
            "before": 1e-4,
            "after": 1e-5,
            "change_percent": -90.0,
            "interval_percent": [-91.0, -89.0],
        }
        change = lower | {"verdict": "lower", "unit": "m"}
        run.finish(changes={"following_error.rms": change}, ratios={}, helped=True, gain=1.0)

    short = {
        "excitation": excitation,
        "identification": identification,
        "refinement": refinement,
        "comparison": comparison,
    }
    patch.setattr(
        tuning, "STEPS", tuple(step._replace(act=short.get(step.name, step.act)) for step in STEPS)
    )
    patch.setattr("bristle.apps.tune.steps._feedforward", lambda run, facts: FEEDFORWARD)
    patch.setattr("bristle.apps.tune.report.tune_report", lambda *_, **__: "a page")


def with_faulty_journal(patch, fault, at):
    """Let a write of the journal fail, before its line is on the disk (an even number) or behind it."""
    append, calls = tuning.Journal.__init__.__globals__["_append"], SimpleNamespace(count=0)

    def faulty(path, data):
        number, calls.count = calls.count, calls.count + 1
        if number == at // 2 and at % 2 == 0:
            with path.open("ab") as file:
                file.write(data[: len(data) // 2])
            fault(None)
        append(path, data)
        if number == at // 2 and at % 2 == 1:
            fault(None)

    patch.setattr("bristle.apps.tune.journal._append", faulty)
    return calls
