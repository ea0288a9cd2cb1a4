"""Do bands of 95 % hold on a second record? Measured axes, and the joints of a measured robot.

Each record is cut in two: bristle identifies the first part, and predicts the effort along the second with its band. The
other record of the robot is not used. ``python -m benchmarks second_records`` reads the folder named in BRISTLE_DATA.
"""

from __future__ import annotations

import os
import tempfile
import warnings
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from benchmarks import arm
from benchmarks.coverage import Share
from benchmarks.timing import EXAMPLES
from bristle.apps.arm.identify import identify_arm
from bristle.apps.arm.motion import Motion
from bristle.core import Axis, content_of
from bristle.core.cores import core_count
from bristle.files import axes_in, read_axis
from bristle.files.model import TREATMENT
from bristle.identification import identify
from bristle.logs import read_log
from bristle.logs.log import Channel, Log
from bristle.prediction import predict

__all__ = ["second_records"]

LEAST, MOST = 90.0, 98.0  # % of the rows
FIRST = 0.6  # of a record: identified
RECORDS = {
    "EMPS, stribeck_free+asymmetry": ("emps/DATA_EMPS.mat", "emps", "stribeck_free+asymmetry"),
    "EMPS, lugre": ("emps/DATA_EMPS.mat", "emps", "lugre"),
    "pendulum, stribeck_free": ("servo_pendulum/arm_200g.json", "servo_pendulum", "stribeck_free"),
    "cogging, coulomb_viscous": ("cogging/speed_test1.txt", "cogging", "coulomb_viscous"),
}


def second_records() -> Iterator[Share]:
    """Yield the share of the rows of each second record within the band."""
    folder = os.environ.get("BRISTLE_DATA")
    if not folder:
        print("second_records: skipped, BRISTLE_DATA is not set")
        return
    with ProcessPoolExecutor(core_count()) as pool, tempfile.TemporaryDirectory() as place:
        jobs = {
            name: (_record, Path(folder) / file, axis, model)
            for name, (file, axis, model) in RECORDS.items()
        }
        jobs |= {f"robot, {name}": (_joint, *files) for name, files in _joints(Path(place)).items()}
        for name, (share, rows) in zip(jobs, pool.map(_called, jobs.values()), strict=True):
            yield Share(
                f"bands of {name}",
                share,
                LEAST,
                MOST,
                rows,
                "rows of the second part of the record",
            )


def _called(job: tuple[Any, ...]) -> tuple[float, int]:
    return job[0](*job[1:])


def _record(file: Path, example: str, model: str) -> tuple[float, int]:
    axis = read_axis(EXAMPLES / example / "axis.toml")
    log = read_log(file, axis)
    middle = round(FIRST * len(log))
    return inside(cut(log, slice(0, middle)), cut(log, slice(middle, len(log))), axis, axis, model)


def _joint(first: Path, second: Path, axes: tuple[Path, Path]) -> tuple[float, int]:
    axis, axis_of_second = map(read_axis, axes)
    return inside(
        read_log(first, axis), read_log(second, axis_of_second), axis, axis_of_second, "lugre"
    )


def inside(
    first: Log, second: Log, axis: Axis, axis_of_second: Axis, model: str
) -> tuple[float, int]:
    """Identify a record; return the share of the rows of a second record within the band [%], and their number."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = identify(first, model, axis=axis)
        assert result.best.resampling is not None
        treatment: Mapping[str, Any] = {
            name: result.treatment[name] for name in TREATMENT if name in result.treatment
        }
        bands = result.best.resampling.bands
        predicted = predict(
            result.best.plant,
            result.best.friction,
            second,
            axis_of_second,
            bands=bands,
            **treatment,
        )
    assert predicted.inside_percent is not None
    assert predicted.effort is not None
    return predicted.inside_percent, predicted.effort.size


def cut(log: Log, span: slice) -> Log:
    """Return a part of a log."""

    def part(value: Any) -> Any:
        if isinstance(value, Channel):
            return replace(value, values=value.values[span])
        if isinstance(value, tuple):
            return tuple(part(item) for item in value)
        return (
            {name: part(item) for name, item in value.items()}
            if isinstance(value, Mapping)
            else value
        )

    parts = {
        field.name: part(getattr(log, field.name))
        for field in fields(log)
        if field.name not in ("segments", "findings", "notes")
    }
    starts = [
        (max(segment.start, span.start), min(segment.stop, span.stop)) for segment in log.segments
    ]
    return replace(
        log,
        **parts,
        segments=tuple(slice(a - span.start, b - span.start) for a, b in starts if b > a),
    )


def _joints(folder: Path) -> dict[str, tuple[Path, Path, tuple[Path, Path]]]:
    """Write logs and axes of both parts of the robot's record; return those of each joint."""
    arm.inputs(folder)
    head, *lines = (folder / "train.csv").read_text().splitlines()
    middle = round(FIRST * len(lines))
    files = {"first": folder / "first.csv", "second": folder / "second.csv"}
    for file, part in zip(files.values(), (lines[:middle], lines[middle:]), strict=True):
        file.write_text("\n".join([head, *part, ""]))
    robot, table = content_of(folder / "robot.toml"), content_of(folder / "joints.toml")
    identified = identify_arm(files["first"], robot, table)
    motions: dict[str, Motion] = {
        "first": identified.motion,
        "second": arm.read_joints(files["second"], axes_in(table))[1],
    }
    for name, motion in motions.items():
        for file, text in replace(identified, motion=motion).files.items():
            path = folder / name / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(text)
    return {
        joint: (
            files["first"],
            files["second"],
            (folder / "first/joints" / f"{joint}.toml", folder / "second/joints" / f"{joint}.toml"),
        )
        for joint in identified.tables
    }
