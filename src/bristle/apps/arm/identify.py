"""`identify_arm`: the dynamics of an arm from the logs of all joints, and the axis of each joint with these dynamics."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bristle.apps.arm.files import arm_scene, with_inertias
from bristle.apps.arm.motion import Motion, motion_of
from bristle.apps.arm.parameters import Dynamics, identify_dynamics, joints_with_springs
from bristle.apps.arm.robot import Robot, read_robot
from bristle.core import (
    SIZE_LIMIT,
    Axis,
    Content,
    InputError,
    KnownColumn,
    Model,
    Readable,
    cached_property,
    content_of,
    guarded,
    located,
)
from bristle.files import as_toml, axes_in, joints_in, read_axis, write_whole
from bristle.logs import Channel, Log, read_log

COLUMN = "arm"  # name of the known column of a joint: its effort from the bodies of the arm
FOLDER, ARM = "joints", "arm.toml"


@dataclass(frozen=True)
class Arm:
    """An identified arm."""

    robot: Robot
    dynamics: Dynamics
    motion: Motion
    tables: Mapping[str, dict[str, Any]]
    """Axis file of each joint, by name."""
    file: Content
    """The robot file."""
    pulled: tuple[str, ...] = ()
    """The joints with a spring or a cable that bristle found."""

    def axes(self, folder: Path) -> list[Axis]:
        """Return the axis of each joint with the effort of the arm as a known column, for results in a folder."""
        return [
            read_axis(Content(folder / name, text))
            for name, text in self.files.items()
            if name in self._axis_files
        ]

    def write(self, folder: Path | str) -> list[Axis]:
        """Write the axis files of the joints, and the efforts of the bodies, into a folder, and return the axes for `bristle.identify`."""
        place = Path(folder)
        (place / FOLDER).mkdir(parents=True, exist_ok=True)
        for name, text in self.files.items():
            write_whole(place / name, text)
        return self.axes(place)

    def exported(
        self, frictions: Mapping[str, Model]
    ) -> tuple[dict[str, str | bytes], dict[str, str]]:
        """Return files for other programs, with the friction of the joints, and by joint the error of approximated friction."""
        scene, notes = arm_scene(self.robot, self.dynamics.bodies, self.dynamics.rotors, frictions)
        return {"arm.xml": scene} | (
            {"arm.urdf": with_inertias(self.robot, self.dynamics.bodies)} if self.robot.urdf else {}
        ), notes

    @cached_property
    def files(self) -> dict[str, bytes]:
        """Axis file of each joint, effort of the arm, robot and bodies, by the name in the folder of the results."""
        motion, robot = self.motion, f"robot{self.file.source.suffix}"
        joints = [
            table | {"body": body}
            for table, body in zip(self.tables.values(), self.dynamics.bodies.tolist(), strict=True)
        ]
        head = "# Identified arm. body: m, mc_x, mc_y, mc_z, I_xx, I_xy, I_yy, I_xz, I_yz, I_zz in the frame of the joint [kg, m].\n"
        contents = {
            robot: self.file.data,
            ARM: (head + as_toml({"schema": 1, "robot": robot, "joint": joints})).encode(),
        }
        efforts = self.robot.effort(
            self.dynamics.bodies, motion.position, motion.velocity, motion.acceleration
        )
        for (name, table), effort, rotor in zip(
            self.tables.items(), efforts.T, self.dynamics.rotors.tolist(), strict=True
        ):
            rows = (
                f"{time:.9g},{value:.9g}"
                for time, value in zip(motion.time.tolist(), effort.tolist(), strict=True)
            )
            known_effort = "\n".join([f"time [s],{COLUMN}", *rows, ""]).encode()
            entry = {
                "column": COLUMN,
                "name": COLUMN,
                "coefficient": 1.0,
                "file": f"{name}.csv",
            } | ({"log": motion.log} if motion.log else {})
            plant = {"inertia" if table["kind"] == "rotational" else "mass": rotor} | table.get(
                "plant", {}
            )
            axis = table | {"plant": plant, "known": [*table.get("known", []), entry]}
            head = f"# Effort of the arm: SHA-256 {hashlib.sha256(known_effort).hexdigest()}\n"
            if name in self.dynamics.rotors_in_sums:
                head += "# The log determines the inertia of this rotor only in a sum with bodies: see the base parameters.\n"
            contents |= {
                f"{FOLDER}/{name}.csv": known_effort,
                f"{FOLDER}/{name}.toml": (head + as_toml(axis)).encode(),
            }
        return contents

    @property
    def _axis_files(self) -> list[str]:
        return [f"{FOLDER}/{name}.toml" for name in self.tables]


@guarded()
def identify_arm(
    log: Readable, robot: Readable, axis: Readable, *, size_limit: int = SIZE_LIMIT
) -> Arm:
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
    with located("robot"):
        file = content_of(robot)
    axes, moved = axes_in(described), read_robot(file).of(list(tables))
    logs, motion = read_joints(log, axes, size_limit=size_limit)
    tables = {
        name: {"kind": log.kind, **table}
        for (name, table), log in zip(tables.items(), logs, strict=True)
    }
    pulled = [name for name in joints_with_springs(moved, motion) if _is_open(axes[name])]
    for name in pulled:
        tables[name]["plant"] = {**tables[name].get("plant", {}), "spring": "cubic"}
        axes[name] = replace(axes[name], spring="cubic")
    motion = motion_of(logs, axes) if pulled else motion
    return Arm(moved, identify_dynamics(moved, motion), motion, tables, file, tuple(pulled))


def _is_open(axis: Axis) -> bool:
    """Return whether an axis file leaves it to bristle to find a spring."""
    return axis.spring is None and float(axis.settings.get("lines_gain", 0.0)) < 1.0


def read_joints(
    log: Readable, axes: Mapping[str, Axis], *, size_limit: int = SIZE_LIMIT
) -> tuple[list[Log], Motion]:
    """Return the logs of all joints in a log, and their common motion."""
    if not axes:
        raise InputError(
            "is missing",
            path="joint",
            mend="Write a [[joint]] table into the axis file for each joint of the robot",
        )
    logs = [read_log(log, joint, size_limit=size_limit) for joint in axes.values()]
    return logs, motion_of(logs, axes)


@guarded()
def logs_of_joints(
    folder: Path | str, log: Readable, *, size_limit: int = SIZE_LIMIT
) -> dict[str, tuple[Log, Axis]]:
    """Return the log and the axis of each joint of an identified arm, with the effort of its bodies along another log.

    Parameters
    ----------
    folder : path-like
        Results of an arm: its bodies, with ``model.toml`` of each joint in a folder with the name of the joint.
    log : path-like or Content
        A log of all joints, with the columns of the log of the identification.
    size_limit : int
        Largest log [byte].

    Returns
    -------
    dict of str to (Log, Axis)
        By the name of the joint, for `bristle.predict`.

    Raises
    ------
    InputError
        If the folder holds no arm, or the log lacks a joint.
    """
    place = Path(folder) / ARM
    if not place.is_file():
        raise InputError(
            f"contains no {ARM}, so it is not the results of an arm",
            path=str(folder),
            mend="Name the model.toml of one axis, or the results of bristle identify --robot",
        )
    tables = joints_in(content_of(place))
    bodies, (file, *_) = (
        np.array([table.pop("body") for table in tables.values()]),
        [table.pop("robot") for table in tables.values()],
    )
    axes = {
        name: read_axis(Content(place, as_toml(table).encode())) for name, table in tables.items()
    }
    robot, (logs, motion) = (
        read_robot(content_of(place.with_name(file))).of(list(axes)),
        read_joints(log, axes, size_limit=size_limit),
    )
    efforts = robot.effort(bodies, motion.position, motion.velocity, motion.acceleration)
    term, joints = KnownColumn(COLUMN, COLUMN, coefficient=1.0), dict[str, tuple[Log, Axis]]()
    for (name, axis), recorded, effort in zip(axes.items(), logs, efforts.T, strict=True):
        column = Channel(np.ascontiguousarray(effort), "1", COLUMN)
        joints[name] = (
            replace(recorded, regressors=(*recorded.regressors, column)),
            replace(axis, regressors=(*axis.regressors, term), text=b""),
        )
    return joints
