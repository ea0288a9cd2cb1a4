"""Figures of the arm: ``python -m benchmarks.arm``. The joints of a measured industrial robot, identified on one log and tested on another.

The folder named in BRISTLE_DATA holds `industrial_robot` (Weigand, Götz, Ulmen, Ruskowski, doi:10.26204/DATA/5, CC BY-SA 4.0).
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from benchmarks.timing import BRISTLE
from bristle.apps.arm.identify import read_joints
from bristle.apps.arm.motion import Motion
from bristle.apps.arm.robot import read_robot
from bristle.core import Model, content_of
from bristle.engine.motion import along
from bristle.files import axes_in, read_model

SLOWER = 1.5  # largest time of one joint, as a share of that of one axis with as many samples
LIMITS = (16.2, 15.1, 8.5, 61.7, 45.8, 48.0)
"""Largest error [% of the effort]: 0.6 of the coupled least squares for joints 1 to 3; own columns for joints 4 to 6."""


def inputs(folder: Path) -> None:
    """Write logs, robot file and axis file as a person would."""
    source = Path(os.environ["BRISTLE_DATA"]) / "industrial_robot"
    data, joints = (
        np.load(source / "robot.npz"),
        json.loads((source / "geometry.json").read_text())["joints"],
    )
    head = ",".join(
        ["t [s]", *(f"q{n} [deg]" for n in range(1, 7)), *(f"u{n} [N*m]" for n in range(1, 7))]
    )
    for part in ("train", "val"):
        rows = np.column_stack(
            [0.1 * np.arange(data[f"u_{part}"].shape[1]), data[f"y_{part}"].T, data[f"u_{part}"].T]
        )
        np.savetxt(folder / f"{part}.csv", rows, "%.9g", ",", header=head, comments="")
    robot, axis = "", AXIS
    for number, joint in enumerate(joints, start=1):
        keys = f"d = {joint['d']}\na = {joint['a']}\nalpha = '{joint['alpha']} deg'\noffset = '{joint['offset']} deg'\nmass = {joint['m']}"
        robot += f"[[joint]]\nname = 'A{number}'\n{keys}\nreversed = {str(joint.get('flip', False)).lower()}\n"
        axis += (
            f"[[joint]]\nname = 'A{number}'\ntransmission = {{ gear_ratio = {joint['gear']} }}\n"
        )
    (folder / "robot.toml").write_text(robot)
    (folder / "joints.toml").write_text(axis)


AXIS = """schema = 1
kind = "rotational"

[columns]
time = "t"
position = { column = "q{joint}", side = "load" }
effort = { column = "u{joint}", side = "motor" }

[identification]
cutoff = "4 Hz"
decimation = 1
rests = "keep"
method = "inverse_dynamics"

"""


def seconds(folder: Path, *options: str) -> float:
    """Return the processor time of an identification of the first log [s]."""
    before = os.times()
    subprocess.run(
        [BRISTLE, "identify", "train.csv", "--draws", "0", *options],
        cwd=folder,
        check=True,
        capture_output=True,
    )
    after = os.times()
    return (
        after.children_user + after.children_system - before.children_user - before.children_system
    )


def predicted(plant: Model, friction: Model, motion: Motion, joint: int) -> np.ndarray:
    """Return rotor and friction efforts of a joint [N*m] along a motion, beside the bodies of the arm."""
    v, dt = np.ascontiguousarray(motion.velocity[:, joint]), float(motion.time[1] - motion.time[0])
    x = np.ascontiguousarray(motion.position[:, joint]) + 0.5 * dt * v
    return plant.values["M"] * motion.acceleration[:, joint] + along(friction, dt=dt, v=v, x=x)


def main() -> int:
    """Identify, predict the other log, and print the errors; return 1 if one exceeds its limit."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        inputs(folder)
        of_arm = seconds(folder, "--robot", "robot.toml", "--axis", "joints.toml", "--out", "arm")
        gear = json.loads(
            (Path(os.environ["BRISTLE_DATA"]) / "industrial_robot/geometry.json").read_text()
        )["joints"][0]["gear"]
        (folder / "axis.toml").write_text(
            AXIS.replace("{joint}", "1") + f"[transmission]\ngear_ratio = {gear}\n"
        )
        of_axis = seconds(folder, "--axis", "axis.toml", "--model", "lugre", "--out", "axis")
        summary = json.loads((folder / "arm/summary.json").read_text())["arm"]["joints"]
        robot = read_robot(content_of(folder / "robot.toml"))
        motion = read_joints(folder / "val.csv", axes_in(content_of(folder / "joints.toml")))[1]
        bodies = np.array([entry["body"] for entry in summary.values()])
        arm = robot.effort(bodies, motion.position, motion.velocity, motion.acceleration)
        share = of_arm / len(summary) / of_axis
        print(
            f"one joint: {share:.2f} of the processor time of one axis with as many samples (at most {SLOWER})"
        )
        fails = int(share > SLOWER)
        for joint, name in enumerate(summary):
            file = read_model(folder / "arm" / name / "model.toml")
            effort = motion.effort[:, joint]
            error = effort - arm[:, joint] - predicted(file.plant, file.friction, motion, joint)
            percent = 100.0 * float(np.sqrt(np.mean(error**2) / np.mean(effort**2)))
            fails += percent > LIMITS[joint]
            print(
                f"{name}: {percent:.1f} % of the effort on the other log, all rows (at most {LIMITS[joint]} %)"
            )
    return int(fails > 0)


if __name__ == "__main__":
    sys.exit(main())
