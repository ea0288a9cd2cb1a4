"""A random axis in LinuxCNC's HAL: its plant as a component, a PID loop by rule, and the files of a machine."""

import fcntl
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
from tests.apps.targets.linuxcnc import LACKING, LOCK, MODULES
from tests.apps.tune.bench import cycle_of, drawn_plant, log_uniform
from tests.apps.tune.machine import AXIS

from bristle.apps.tune.linuxcnc.hal import Hal

HERE = Path(__file__).parents[4] / "examples/linuxcnc"
ALWAYS = [
    "kind",
    "mass",
    "coulomb",
    "rise",
    "stribeck",
    "asymmetry",
    "viscous",
    "reach",
    "lag",
    "delay",
    "resolution",
    "noise",
]
SOMETIMES = ["damping", "gravity", "cogging", "load", "spring", "damper"]
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
    made = drawn_plant(r, seed)
    plant = (
        {"seed": seed}
        | {name: getattr(made, name) for name in ALWAYS}
        | {name: getattr(made, name) for name in SOMETIMES if getattr(made, name)}
    )
    plant["reach"] *= 1e6
    if made.cogging:
        plant["pitch"] = made.pitch
    gains = {
        "Pgain": made.p / 1e3,
        "Igain": made.i / 1e3 * CLOCK,
        "Dgain": made.d / 1e3 / CLOCK,
        "FF2": made.inertia / 1e3 / CLOCK**2,
    }
    amplitude, period, dwell = (
        log_uniform(r, 0.5, 8),
        float(np.round(r.uniform(1.2, 3.0), 3)),
        0.15 * float(r.uniform() >= 0.5),
    )
    return plant, gains | {"maxoutput": made.limit}, cycle_of(amplitude, period, dwell)


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
                subprocess.run(
                    ["halcompile", "--install", "rplant.comp"],
                    cwd=building,
                    check=True,
                    capture_output=True,
                )
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


def _files(
    folder: Path, plant: dict[str, float], gains: dict[str, float], cycle: np.ndarray
) -> Path:
    (folder / "config").mkdir(parents=True, exist_ok=True)
    text = AXIS.format(limit=2.0 * gains["maxoutput"], resolution=plant["resolution"])
    (folder / "axis.toml").write_text(text.replace('unit = "um"', 'unit = "mm"'))
    (folder / "machine.toml").write_text(MACHINE.format(clock=float(CLOCK)))
    whole = np.append(cycle, cycle[0])
    table = np.column_stack([1e-3 * np.arange(whole.size), whole])
    np.savetxt(
        folder / "motion.csv",
        table,
        fmt="%.9g",
        delimiter=",",
        header="time [s],ref [mm]",
        comments="",
    )
    return folder / "machine.toml"
