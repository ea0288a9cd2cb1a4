"""Read machine files: the machine, its axis file and the motion of its user, for `bristle tune`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from bristle.core import Axis, Content, InputError, Readable, located
from bristle.files.axis import read_axis
from bristle.files.components import check_schema
from bristle.files.motion import axis_of_motion
from bristle.files.schema import Strict, validated
from bristle.files.toml import read_toml
from bristle.logs import read_log

MOST_CYCLES = 1000
NEEDED = {
    "velocity_limit": 'velocity = "100 mm/s"',
    "acceleration_limit": 'acceleration = "2 m/s^2"',
    "stroke": 'stroke = ["-40 mm", "40 mm"]',
    "following_error_limit": 'following_error = "2 mm"',
}
"""Limits of the axis that a run needs, with an example of their line under [limits]."""


class MotionEntry(Strict):
    """The motion of the user: a file with one cycle, which ends where it starts."""

    file: str
    cycles: Annotated[int, Field(ge=6, le=MOST_CYCLES)] = 10


class MachineEntry(Strict):
    """Complete machine file; the table with the name of the machine has its own keys."""

    schema_version: Literal[1] = Field(alias="schema")
    name: str = "axis"
    machine: str
    axis: str
    motion: MotionEntry
    effort_ratio: Annotated[float, Field(ge=1.0, le=10.0)] = 1.05
    settings: dict[str, Any] = Field(default_factory=dict)


@dataclass(frozen=True)
class MachineFile:
    """A machine file.

    Parameters
    ----------
    source : Path
        The file; names in it are relative to its folder.
    content : Content or None
        Its content.
    name : str
        Name of the axis on the machine.
    machine : str
        Name of a built-in machine, or a Python file.
    settings : mapping
        The settings of the machine.
    axis : Axis
        The axis, with the limits of a run.
    cycle : ndarray, shape (sample,)
        One cycle of the motion of the user [m or rad]; it ends where it starts.
    cycles : int
        Number of cycles of a record.
    effort_ratio : float
        Largest rms effort with the feedforward, as a ratio to that without it. An axis that follows better moves more.
    """

    source: Path
    content: Content | None
    name: str
    machine: str
    settings: dict[str, Any]
    axis: Axis
    cycle: np.ndarray
    cycles: int
    effort_ratio: float = 1.05


def read_machine(path: Readable) -> MachineFile:
    """Return the content of a machine file.

    Raises
    ------
    InputError
        With the file, the key, the value and the allowed values: a limit that a run needs is missing, the motion does not end
        where it starts, or its sample time is not that of the axis.
    """
    data, source, content = read_toml(path, path="machine", what="a machine file")
    with located(source):
        check_schema(data)
        entry = validated(MachineEntry, data)
        axis = read_axis(source.parent / entry.axis)
        for name, line in NEEDED.items():
            if getattr(axis, name) is None:
                raise InputError(
                    f"is needed: without it, a run has no limit for {name.removesuffix('_limit').replace('_', ' ')}",
                    path=f"{entry.axis}: limits",
                    mend=f"Write {line} under [limits] of {entry.axis}",
                )
        if axis.effort_limit is None:
            raise InputError(
                "is needed",
                path=f"{entry.axis}: effort.limit",
                mend='Write limit = "400 N" under [effort] of the axis file',
            )
        for channel in ("position", "reference", "effort"):
            if channel not in axis.columns:
                raise InputError(
                    "is needed for the records of a run", path=f"{entry.axis}: columns.{channel}"
                )
        cycle, sample_time = _cycle(source.parent / entry.motion.file, axis)
    settings = {**entry.settings, "sample_time": sample_time}
    return MachineFile(
        source,
        content,
        entry.name,
        entry.machine,
        settings,
        axis,
        cycle,
        entry.motion.cycles,
        entry.effort_ratio,
    )


def _cycle(path: Path, axis: Axis) -> tuple[np.ndarray, float]:
    """Return one cycle of a motion without its last sample, which is the first of the next cycle, and its sample time."""
    log = read_log(path, axis_of_motion(path, axis) or axis)
    position = np.asarray(
        log.reference.values if log.reference is not None else log.position.values
    )
    step = float(np.max(np.abs(np.diff(position))))
    gap = abs(float(position[-1] - position[0]))
    if gap > step:
        raise InputError(
            "does not end where it starts",
            path="motion.file",
            value=f"{gap:g}",
            allowed=f"up to {step:g}, in SI",
            mend="End the motion at its first position, so that cycles can follow each other",
        )
    assert axis.stroke is not None
    if position.min() < axis.stroke[0] or position.max() > axis.stroke[1]:
        raise InputError(
            "leaves the stroke of the axis",
            path="motion.file",
            value=f"{position.min():g} to {position.max():g}",
            allowed=f"{axis.stroke[0]:g} to {axis.stroke[1]:g}, in SI",
        )
    return position[:-1] if gap < 0.5 * step else position, log.sample_time
