"""The logs of the golden cases: measured ones from the folder named in BRISTLE_DATA, and simulated ones."""

from __future__ import annotations

import io
import os
import shutil
import tempfile
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io
from benchmarks.loops import recorded_in_loop
from tests.excitation.axes import STAGE
from tests.identification.known_logs import log_of

from bristle import friction
from bristle.cli.main import main
from bristle.core import Axis
from bristle.demo import axis_simulated
from bristle.engine import force_along
from bristle.excitation import excite
from bristle.files import read_axis, read_curves, read_log
from bristle.files.motion import write_motion
from bristle.friction import find
from bristle.logs.curves import Curves
from bristle.logs.log import Log

EXAMPLES = Path(__file__).parents[2] / "examples"
DAMPER = "dataset-1__characterization_datasets__{}tension"


def data() -> Path:
    """Return the folder of the measured logs."""
    return Path(os.environ["BRISTLE_DATA"])


def axis_of(example: str, name: str = "axis.toml") -> Axis:
    """Return the axis of an example."""
    return read_axis(EXAMPLES / example / name)


@cache
def emps(name: str = "axis.toml") -> tuple[Log, Axis]:
    """Return the measured positioning system."""
    axis = axis_of("emps", name)
    return read_log(data() / "emps" / "DATA_EMPS.mat", axis), axis


@cache
def tribometer() -> tuple[Log, Axis]:
    """Return the reciprocating contact."""
    axis = axis_of("tribometer")
    return read_log(data() / "tribometer" / "test_data_2.txt", axis), axis


@cache
def damper(*tests: str) -> tuple[list[Log], Axis]:
    """Return tests of the friction damper."""
    axis, file = axis_of("friction_damper"), data() / "friction_damper" / "brfd_all.npz"
    return [read_log(f"{file}::{DAMPER.format(one)}", axis) for one in tests], axis


@cache
def bouc_wen() -> tuple[Log, Axis]:
    """Return the training record of the Bouc-Wen benchmark."""
    axis = axis_of("bouc_wen")
    return read_log(data() / "bouc_wen" / "train.h5", axis), axis


@cache
def bouc_wen_test() -> Log:
    """Return the test record of the Bouc-Wen benchmark."""
    columns = {}
    for name in "uy":
        read = scipy.io.loadmat(data() / "bouc_wen" / f"{name}val_multisine.mat")
        columns[name] = next(one for key, one in read.items() if not key.startswith("__")).ravel()
    with tempfile.TemporaryDirectory() as place:
        np.savez(Path(place) / "test.npz", **columns)
        return read_log(Path(place) / "test.npz", axis_of("bouc_wen"))


@cache
def magnet() -> Curves:
    """Return the reversal curves of a magnet."""
    return read_curves(data() / "forc" / "forc_curves.npz", EXAMPLES / "forc" / "axis.toml")


@cache
def demo(seed: int = 1) -> tuple[Log, Axis]:
    """Return a log of the demonstration."""
    with tempfile.TemporaryDirectory() as place:
        axis_simulated.write_log(Path(place) / "log.csv", seed)
        return read_log(Path(place) / "log.csv", axis_simulated.axis()), axis_simulated.axis()


@cache
def ball_screw() -> tuple[Log, Axis]:
    """Return the log of the virtual ball screw, as its page makes it."""
    with tempfile.TemporaryDirectory() as temporary:
        place = Path(temporary) / "ball_screw"
        shutil.copytree(EXAMPLES / "virtual_ball_screw", place)
        axis = read_axis(place / "axis.toml")
        motion = excite(axis, rehearsed=False).motion
        (place / "motion").mkdir()
        signals = {name: getattr(motion, name) for name in ("time", "position", "velocity", "acceleration")}
        write_motion(place / "motion" / "motion.csv", axis, signals)
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            assert main(["run", str(place / "record.toml"), "--log", "--out", str(place / "recorded")]) == 0
        return read_log(place / "recorded" / "log.csv", axis), axis


STRIBECK = friction.stribeck(F_C=20.0, F_S=28.0, v_S=3e-3, F_v=200.0)
LUGRE = friction.lugre(F_C=35.0, F_S=44.0, v_S=5e-3, sigma_0=1e6, sigma_1=2e3, sigma_2=200.0)


@cache
def in_loop(*, pairs: int = 5, scatter: float = 0.0) -> Log:
    """Return a simulated closed loop whose drive lags, with pulses beside its controller."""
    return recorded_in_loop(STRIBECK, 3, pairs=pairs, scatter=scatter, lag=0.8e-3, pulses=6.0)


PULLED = replace(STAGE, resolution=2e-8, sample_time=5e-4, jerk_limit=None)


@cache
def pulls() -> tuple[Log, Any]:
    """Return pulls from rest at three rates, on elements whose level scatters from leg to leg, and the elements."""
    limits, reach = np.array([18.0, 24.0, 18.0]), np.array([2e-6, 4e-6, 7e-6])
    truth = find("maxwell_slip")(F_C=60.0, nu_i=limits / 60.0, k_i=limits / reach, offset=5.0)
    motion = excite(PULLED, duration="24 s", purposes="break-away", model=truth, rehearsed=False).motion
    v, dt, rng = motion.velocity, motion.sample_time, np.random.default_rng(0)
    sides = np.sign(v)
    moving = np.flatnonzero(sides)
    turns = moving[1:][sides[moving[1:]] != sides[moving[:-1]]]
    leg = np.searchsorted(turns, np.arange(v.size), side="right")
    levels = 1.0 + 0.05 * rng.standard_normal(turns.size + 1)
    force = (force_along(truth, v, dt, motion.position + 0.5 * dt * v) - 5.0) * levels[leg] + 5.0
    effort = 28.0 * motion.acceleration + force + 0.3 * rng.standard_normal(v.size)
    return log_of(motion, effort, step=PULLED.resolution), truth
