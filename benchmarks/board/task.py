"""Tasks of the score board: one file each, with its data, split and scores."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.board.record import MEASURED, Data, Record
from bristle.core import Axis, InputError, content_of, did_you_mean
from bristle.files import TOML_LIMIT, as_toml, read_axis, read_log, read_toml

FOLDER = Path(__file__).with_name("tasks")
TASKS = tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))
SCORES = {
    "force": "error of the predicted force [% of its rms]",
    "reversals": "error of the predicted force within 0.1 s of each reversal [% of the rms force of the record]",
    "loop": "error of the predicted following error [% of the part that friction causes]",
    "parameters": "mean error of the parameters [%], at most 100 % each",
    "compensation": "following error with feedforward, or with another law [% of that without]",
}


@dataclass(frozen=True)
class Task:
    """A task."""

    name: str
    table: Mapping[str, Any]
    checksum: str

    @property
    def title(self) -> str:
        """Title in words."""
        return self.table["title"]

    @property
    def scores(self) -> tuple[str, ...]:
        """Scores of the task."""
        return tuple(self.table["scores"])

    @property
    def cases(self) -> tuple[str, ...]:
        """Cases: the record, or the draws of the simulated axes."""
        if "simulated" not in self.table:
            return ("record",)
        from benchmarks.board.simulated import cases_of

        return cases_of(self.table)

    @property
    def missing(self) -> str:
        """Reason why the task cannot run here; empty if it can."""
        file = self.table.get("file") or self.table.get("arm")
        if not file:
            return ""
        folder = os.environ.get(MEASURED)
        if not folder:
            return f"{MEASURED} is not set: set it to the folder with {file}"
        return (
            ""
            if (Path(folder) / file).exists()
            else f"{MEASURED} names {folder}, which has no {file}: name the folder that has it"
        )

    def data(self, case: str, seed: int) -> Data:
        """Return the data of a case; the seed draws the simulated axes."""
        if "simulated" in self.table:
            from benchmarks.board.simulated import simulated

            return simulated(self.table, case, seed)
        axis = read_axis(dict(self.table["axis"]))
        place = Path(os.environ[MEASURED])
        return (
            _arm(place / self.table["arm"], axis, self.table)
            if "arm" in self.table
            else self._measured(place, axis)
        )

    def _measured(self, folder: Path, axis: Axis) -> Data:
        table, file = self.table, folder / self.table["file"]
        if "train_tables" in table:
            train, test = (
                [
                    _recorded(read_log(f"{file}::{name}", axis), axis)[0]
                    for name in table[f"{key}_tables"]
                ]
                for key in SIDES
            )
            return Data(train, test)
        log = read_log(file, axis)
        (train, _), (test, reference) = (_recorded(log, axis, table[key]) for key in SIDES)
        if reference is None:
            return Data([train], [test])
        return Data(
            [train], [test], reference, reference.position - test.position, table["loop_mass"]
        )


SIDES = ("train", "test")


def tasks_named(names: tuple[str, ...] = ()) -> tuple[Task, ...]:
    """Return tasks by name; by default all."""
    for name in names:
        if name not in TASKS:
            raise InputError(
                "is not a task",
                path="--task",
                value=name,
                allowed=", ".join(TASKS),
                mend=did_you_mean(name, TASKS),
            )
    chosen = []
    for name in TASKS:
        if not names or name in names:
            content = content_of(FOLDER / f"{name}.toml", limit=TOML_LIMIT)
            chosen.append(Task(name, read_toml(content)[0], content.checksum))
    return tuple(chosen)


def _recorded(
    log: Any, axis: Axis, span: list[float] | None = None
) -> tuple[Record, Record | None]:
    """Return the record of a part of a log, and its desired motion if the log has a reference."""
    time = log.time.values - log.time.values[0]
    part = slice(None) if span is None else slice(*np.searchsorted(time, span))
    plain, time = replace(axis, columns={}, text=b""), time[part] - time[part][0]
    record = Record.of(time, log.position.values[part], log.effort.values[part], plain)
    return record, None if log.reference is None else Record.of(
        time, log.reference.values[part], None, plain
    )


def _arm(folder: Path, axis: Axis, table: Mapping[str, Any]) -> Data:
    """Return the records of an arm: angles [rad] and torques [N*m] at its joints."""
    import json

    arrays, joints = (
        np.load(folder / "robot.npz"),
        json.loads((folder / "geometry.json").read_text(encoding="utf-8"))["joints"],
    )
    gears, plain, records = (
        np.array([joint["gear"] for joint in joints]),
        replace(axis, columns={}, text=b""),
        [],
    )
    robot = as_toml(
        {
            "joint": [
                {
                    "name": f"A{number}",
                    "d": joint["d"],
                    "a": joint["a"],
                    "mass": joint["m"],
                    "reversed": joint.get("flip", False),
                }
                | {key: f"{joint[key]} deg" for key in ("alpha", "offset")}
                for number, joint in enumerate(joints, 1)
            ]
        }
    )
    for part, count in (("train", table["train_samples"]), ("val", None)):
        position, effort = (
            np.deg2rad(arrays[f"y_{part}"].T[:count]),
            arrays[f"u_{part}"].T[:count] * gears,
        )
        records.append(Record.of(0.1 * np.arange(len(position)), position, effort, plain, robot))
    return Data([records[0]], [records[1]])
