"""Logs of the golden cases: measured logs from the folder named in BRISTLE_DATA, the demo and the examples."""

from __future__ import annotations

import io
import shutil
import tempfile
from contextlib import redirect_stderr, redirect_stdout
from functools import cache
from pathlib import Path

import numpy as np
import scipy.io
from tests.examples.data import measured

from bristle.cli.demonstration import axis_simulated
from bristle.cli.main import main
from bristle.core import Axis
from bristle.files import read_axis, read_curves, read_log
from bristle.files.motion import write_motion
from bristle.logs.curves import Curves
from bristle.logs.log import Log
from bristle.prediction.excitation import excite
from bristle.prediction.excitation.motion import ExcitationMotion

EXAMPLES = Path(__file__).parents[2] / "examples"
DAMPER = "dataset-1__characterization_datasets__{}tension"


def axis_of(example: str, name: str = "axis.toml") -> Axis:
    """Return the axis of an example."""
    return read_axis(EXAMPLES / example / name)


@cache
def emps(name: str = "axis.toml") -> tuple[Log, Axis]:
    """Return the measured positioning system."""
    axis = axis_of("emps", name)
    return read_log(measured("emps", "DATA_EMPS.mat"), axis), axis


@cache
def tribometer() -> tuple[Log, Axis]:
    """Return the reciprocating contact."""
    axis = axis_of("tribometer")
    return read_log(measured("tribometer", "test_data_2.txt"), axis), axis


@cache
def damper(*tests: str) -> tuple[list[Log], Axis]:
    """Return tests of the friction damper."""
    axis, file = axis_of("friction_damper"), measured("friction_damper", "brfd_all.npz")
    return [read_log(f"{file}::{DAMPER.format(test)}", axis) for test in tests], axis


@cache
def bouc_wen() -> tuple[Log, Axis]:
    """Return the training record of the Bouc-Wen benchmark."""
    axis = axis_of("bouc_wen")
    return read_log(measured("bouc_wen", "train.h5"), axis), axis


@cache
def bouc_wen_test() -> Log:
    """Return the test record of the Bouc-Wen benchmark."""
    columns = {}
    for name in "uy":
        read = scipy.io.loadmat(measured("bouc_wen", f"{name}val_multisine.mat"))
        columns[name] = next(item for key, item in read.items() if not key.startswith("__")).ravel()
    with tempfile.TemporaryDirectory() as place:
        np.savez(Path(place) / "test.npz", **columns)
        return read_log(Path(place) / "test.npz", axis_of("bouc_wen"))


@cache
def magnet() -> Curves:
    """Return the reversal curves of a magnet."""
    return read_curves(measured("forc", "forc_curves.npz"), EXAMPLES / "forc" / "axis.toml")


@cache
def demo(seed: int = 1) -> tuple[Log, Axis]:
    """Return a log of the demonstration."""
    with tempfile.TemporaryDirectory() as place:
        axis_simulated.write_log(Path(place) / "log.csv", seed)
        return read_log(Path(place) / "log.csv", axis_simulated.axis()), axis_simulated.axis()


def run_ball_screw(place: Path) -> tuple[Axis, ExcitationMotion]:
    """Let the virtual ball screw of the example be excited and recorded in a new folder, as its page does it."""
    shutil.copytree(EXAMPLES / "virtual_ball_screw", place)
    axis = read_axis(place / "axis.toml")
    motion = excite(axis, rehearsed=False).motion
    (place / "motion").mkdir()
    signals = {
        name: getattr(motion, name) for name in ("time", "position", "velocity", "acceleration")
    }
    write_motion(place / "motion" / "motion.csv", axis, signals)
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        assert (
            main(["run", str(place / "record.toml"), "--log", "--out", str(place / "recorded")])
            == 0
        )
    return axis, motion


@cache
def ball_screw() -> tuple[Log, Axis]:
    """Return the log of the virtual ball screw."""
    with tempfile.TemporaryDirectory() as temporary:
        place = Path(temporary) / "ball_screw"
        axis, _ = run_ball_screw(place)
        return read_log(place / "recorded" / "log.csv", axis), axis
