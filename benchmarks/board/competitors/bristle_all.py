"""bristle with --model all, the best model by the error on held-out parts of the log; an arm by its bodies."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from benchmarks.board.of_bristle import effort, friction_force, identified, numbers
from bristle.apps.arm import identify_arm
from bristle.core import Content, Feedforward
from bristle.files import read_log
from bristle.identification import identify
from bristle.simulation import feedforward_effort


def fit(train):
    return identified(train, "all")


predict, feedforward, parameters = effort, friction_force, numbers


def fit_arm(train):
    """Return the bodies of the arm, and the best default model of each joint beside them."""
    (record,) = train
    numbers = range(1, record.position.shape[1] + 1)
    names = [f"A{number}" for number in numbers]
    heads = ",".join(
        [
            "t [s]",
            *(f"q{number} [rad]" for number in numbers),
            *(f"u{number} [N*m]" for number in numbers),
        ]
    )
    rows = np.column_stack([record.time, record.position, record.effort])
    text = "\n".join([heads, *(",".join(f"{value:.9g}" for value in row) for row in rows), ""])
    log = Content(Path("train.csv"), text.encode())
    with tempfile.TemporaryDirectory() as folder:
        axis = Content(
            Path("axis.toml"),
            (AXIS + "".join(f"[[joint]]\nname = '{name}'\n" for name in names)).encode(),
        )
        arm = identify_arm(log, Content(Path("robot.toml"), record.robot.encode()), axis)
        best = [
            identify(read_log(log, joint), "lugre", axis=joint, draws=0, blocks=0).best
            for joint in arm.write(folder)
        ]
    return arm, best


def predict_arm(fitted, motion):
    """Return the efforts of the bodies, and those of rotor and friction of each joint."""
    arm, best = fitted
    efforts = arm.robot.effort(
        arm.dynamics.bodies, motion.position, motion.velocity, motion.acceleration
    )
    for joint, model in enumerate(best):
        fed = Feedforward(friction=model.friction)
        friction = feedforward_effort(
            fed, motion.position[:, joint], motion.acceleration[:, joint], motion.sample_time
        )
        efforts[:, joint] += model.plant.values["M"] * motion.acceleration[:, joint] + friction
    return efforts


AXIS = """schema = 1
kind = "rotational"
columns = { time = "t", position = { column = "q{joint}" }, effort = { column = "u{joint}" } }
identification = { cutoff = "4 Hz", decimation = 1, rests = "keep", method = "inverse_dynamics" }

"""
