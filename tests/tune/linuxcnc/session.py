"""A random axis in LinuxCNC's HAL: its plant as a component, a PID loop by rule, and the files of a machine."""

import fcntl
import math
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from tests.exports.linuxcnc import LACKING, LOCK, MODULES
from tests.tune.machine import AXIS

from bristle.tune.linuxcnc.hal import Hal

HERE = Path(__file__).parents[3] / "examples/linuxcnc"
CLOCK = 10  # seconds of the axis in a second of the thread
MACHINE = """schema = 1
name = "x"
machine = "linuxcnc"
axis = "axis.toml"
effort_ratio = 1.3
[motion]
file = "motion.csv"
[settings]
reference = "ref"
position = "pos"
effort = "eff"
motor = "rplant.0.effort"
thread = "servo"
save = "config/bristle.hal"
clock = {clock}
"""


def drawn(seed: int) -> tuple[dict[str, float], dict[str, float], np.ndarray]:
    """Return parameters of a random plant, gains of its loop, and a cycle of its motion [mm]."""
    r = np.random.default_rng(seed)

    def log(low: float, high: float) -> float:
        return float(math.exp(r.uniform(math.log(low), math.log(high))))

    mass, coulomb = log(8, 80), log(15, 120)
    plant: dict[str, float] = {"kind": seed % 4, "seed": seed, "mass": mass, "coulomb": coulomb, "rise": float(r.uniform(0, 0.5))}
    plant |= {"stribeck": log(1e-3, 8e-3), "asymmetry": float(r.uniform(-0.12, 0.12)), "viscous": float(coulomb * r.uniform(1, 8))}
    plant |= {"reach": log(8, 120), "lag": log(2e-4, 1e-3), "delay": int(r.integers(0, 4)), "resolution": log(5e-8, 2e-6)}
    plant |= {"noise": float(coulomb * r.uniform(0, 0.01))}
    if plant["kind"] == 1:
        plant["damping"] = 0.3 * math.sqrt(3 * coulomb / (plant["reach"] * 1e-6) * mass)
    if plant["kind"] == 2 or seed % 5 == 0:
        plant |= {"gravity": float(r.uniform(-1, 1) * coulomb), "cogging": float(coulomb * r.uniform(0.05, 0.2))}
        plant |= {"pitch": float(r.choice([0.005, 0.01, 0.02]))}
    late = (plant["delay"] + 1.5) * 1e-3 + plant["lag"]
    crossover = 0.5 / late
    if seed % 3 == 0:
        first = float(r.uniform(120, 250))
        plant |= {"load": mass * 0.6, "mass": mass * 0.4}
        reduced = plant["load"] * plant["mass"] / mass
        plant |= {"spring": (2 * math.pi * first) ** 2 * reduced, "damper": 0.2 * math.sqrt((2 * math.pi * first) ** 2 * reduced * reduced)}
        crossover = min(crossover, 0.12 * 2 * math.pi * first)
    gains = {"Pgain": 0.4 * mass * crossover**2 / 1e3, "Igain": 0.4 * mass * crossover**3 / 20 / 1e3 * CLOCK}
    gains |= {"Dgain": mass * crossover / 1e3 / CLOCK, "FF2": 0.97 * mass / 1e3 / CLOCK**2}
    gains |= {"maxoutput": coulomb * 4 + abs(plant.get("gravity", 0.0)) + 6 * mass}
    amplitude, period, dwell = log(0.5, 8), float(np.round(r.uniform(1.2, 3.0), 3)), 0.15 * float(r.uniform() >= 0.5)
    half, rest = round(period / 2 / 1e-3), round(dwell / 1e-3)
    t = np.arange(half) / half
    way = (1 - np.cos(math.pi * t)) / 2 if rest == 0 else t - np.sin(2 * math.pi * t) / (2 * math.pi)
    return plant, gains, 2 * amplitude * np.concatenate([way, np.ones(rest), 1 - way, np.zeros(rest)])


@contextmanager
def axis(seed: int, folder: Path) -> Iterator[tuple[Hal, Path, np.ndarray]]:
    """Run a random axis in HAL, one session of a machine at a time; give HAL, the machine file and the cycle [mm]."""
    if LACKING:
        pytest.skip(LACKING)
    plant, gains, cycle = drawn(seed)
    with LOCK.open("w") as lock, tempfile.TemporaryDirectory(prefix="hal") as socket:
        fcntl.flock(lock, fcntl.LOCK_EX)
        os.chmod(socket, 0o777)
        os.environ["RTAPI_FIFO_PATH"] = f"{socket}/fifo"
        if not (MODULES / "rplant.so").exists():
            with tempfile.TemporaryDirectory() as building:
                shutil.copy(HERE / "rplant.comp", building)
                subprocess.run(["halcompile", "--install", "rplant.comp"], cwd=building, check=True, capture_output=True)
        hal = Hal()
        try:
            start(hal, seed)
            yield hal, _files(folder, plant, gains, cycle), cycle
        finally:
            _ended(hal, ["halrun", "-U"])
            for module in MODULES.glob("bristle_*.so"):
                module.unlink()
            (MODULES / "rplant.so").unlink(missing_ok=True)


def start(hal: Hal, seed: int) -> None:
    """Start HAL with a random axis; a running session ends."""
    plant, gains, _ = drawn(seed)
    _ended(hal, ["halrun", "-U"])
    _ended(hal, ["/usr/lib/linuxcnc/realtime", "start"])
    hal.run(
        f"loadrt threads name1=servo period1={round(1e6 / CLOCK)}", "loadrt streamer depth=500000 cfg=f", "loadrt rplant",
        "loadrt pid num_chan=1", "setp streamer.0.enable 0", "addf streamer.0 servo", "addf rplant.0 servo",
        "addf pid.0.do-pid-calcs servo", "net ref streamer.0.pin.0 => pid.0.command", "net pos rplant.0.position => pid.0.feedback",
        "net eff pid.0.output => rplant.0.effort", f"setp rplant.0.clock {CLOCK}",
        *(f"setp rplant.0.{name} {value:.9g}" for name, value in plant.items()),
        *(f"setp pid.0.{name} {value:.9g}" for name, value in gains.items()),
        "setp pid.0.error-previous-target 1", "setp pid.0.enable 1", "start",
    )  # fmt: skip
    time.sleep(0.5)


def _ended(hal: Hal, command: list[str]) -> None:
    environment = hal.environment | {"RTAPI_FIFO_PATH": os.environ["RTAPI_FIFO_PATH"]}
    with tempfile.TemporaryFile() as out:  # the program that HAL starts inherits the outputs
        subprocess.run(command, env=environment, stdout=out, stderr=out, check=False)


def _files(folder: Path, plant: dict[str, float], gains: dict[str, float], cycle: np.ndarray) -> Path:
    (folder / "config").mkdir(parents=True, exist_ok=True)
    text = AXIS.format(limit=2.0 * gains["maxoutput"], resolution=plant["resolution"])
    (folder / "axis.toml").write_text(text.replace('unit = "um"', 'unit = "mm"'))
    (folder / "machine.toml").write_text(MACHINE.format(clock=float(CLOCK)))
    whole = np.append(cycle, cycle[0])
    table = np.column_stack([1e-3 * np.arange(whole.size), whole])
    np.savetxt(folder / "motion.csv", table, fmt="%.9g", delimiter=",", header="time [s],ref [mm]", comments="")
    return folder / "machine.toml"
