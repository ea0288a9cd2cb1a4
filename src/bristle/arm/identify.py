"""`identify_arm`: the dynamics of an arm from the logs of all joints, and the axis of each joint with these dynamics."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bristle.arm.files import arm_scene, with_inertias
from bristle.arm.motion import Motion, motion_of
from bristle.arm.parameters import Dynamics, identify_dynamics
from bristle.arm.robot import Robot, read_robot
from bristle.core import SIZE_LIMIT, Axis, Content, InputError, Model, Readable, cached_property, content_of
from bristle.files import as_toml, axes_in, joints_in, read_axis, write_whole
from bristle.logs import read_log

COLUMN = "arm"  # name of the known column of a joint: its effort from the bodies of the arm
FOLDER = "joints"


@dataclass(frozen=True)
class Arm:
    """An identified arm."""

    robot: Robot
    dynamics: Dynamics
    motion: Motion
    tables: Mapping[str, dict[str, Any]]
    """Axis file of each joint, by name."""

    def axes(self, folder: Path) -> list[Axis]:
        """Return the axis of each joint with the effort of the arm as a known column, for results in a folder."""
        return [read_axis(Content(folder / name, text)) for name, text in self.files.items() if name.endswith(".toml")]

    def write(self, folder: Path | str) -> list[Axis]:
        """Write the axis files of the joints, and the efforts of the bodies, into a folder, and return the axes for `bristle.identify`."""
        place = Path(folder)
        (place / FOLDER).mkdir(parents=True, exist_ok=True)
        for name, text in self.files.items():
            write_whole(place / name, text)
        return self.axes(place)

    def exported(self, frictions: Mapping[str, Model]) -> tuple[dict[str, str | bytes], dict[str, str]]:
        """Return files for other programs, with the friction of the joints, and by joint the error of approximated friction."""
        scene, notes = arm_scene(self.robot, self.dynamics.bodies, self.dynamics.rotors, frictions)
        return {"arm.xml": scene} | ({"arm.urdf": with_inertias(self.robot, self.dynamics.bodies)} if self.robot.urdf else {}), notes

    @cached_property
    def files(self) -> dict[str, bytes]:
        """Axis file of each joint, and table with the effort of the arm, by the name in the folder of the results."""
        motion, contents = self.motion, dict[str, bytes]()
        efforts = self.robot.effort(self.dynamics.bodies, motion.position, motion.velocity, motion.acceleration)
        for (name, table), effort, rotor in zip(self.tables.items(), efforts.T, self.dynamics.rotors.tolist(), strict=True):
            rows = (f"{time:.9g},{value:.9g}" for time, value in zip(motion.time.tolist(), effort.tolist(), strict=True))
            known_effort = "\n".join([f"time [s],{COLUMN}", *rows, ""]).encode()
            entry = {"column": COLUMN, "name": COLUMN, "coefficient": 1.0, "file": f"{name}.csv"}
            plant = {"inertia" if table.get("kind") == "rotational" else "mass": rotor} | table.get("plant", {})
            axis = table | {"plant": plant, "known": [*table.get("known", []), entry]}
            head = f"# Effort of the arm: SHA-256 {hashlib.sha256(known_effort).hexdigest()}\n"
            contents |= {f"{FOLDER}/{name}.csv": known_effort, f"{FOLDER}/{name}.toml": (head + as_toml(axis)).encode()}
        return contents


def identify_arm(log: Readable, robot: Readable, axis: Readable, *, size_limit: int = SIZE_LIMIT) -> Arm:
    """Identify the dynamics of an arm from one log of all joints.

    Parameters
    ----------
    log : path-like or Content
        The log, with angle and effort of each joint.
    robot : path-like or Content
        URDF, or TOML with Denavit-Hartenberg parameters.
    axis : path-like or Content
        Axis file with a ``[[joint]]`` table for each joint, named as in the robot file.
    size_limit : int
        Largest log [byte].

    Returns
    -------
    Arm
        The bodies, the base parameters, and the motion; ``write(folder)`` returns the axes of the joints for `bristle.identify`.

    Raises
    ------
    InputError
        If a file is invalid, or the axis file names a joint that the robot lacks.
    """
    described = content_of(axis)
    tables = joints_in(described)
    moved, motion = read_robot(content_of(robot)).of(list(tables)), read_joints(log, described, size_limit=size_limit)
    return Arm(moved, identify_dynamics(moved, motion), motion, tables)


def read_joints(log: Readable, axis: Content, *, size_limit: int = SIZE_LIMIT) -> Motion:
    """Return the motion of all joints in a log."""
    described = axes_in(axis)
    if not described:
        raise InputError("is missing", path="joint", mend="Write a [[joint]] table into the axis file for each joint of the robot")
    return motion_of([read_log(log, joint, size_limit=size_limit) for joint in described.values()], list(described))
