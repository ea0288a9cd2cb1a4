"""The arm on the command line: `identify --robot`, and `predict` with the results of an arm."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bristle.cli.options import Output, size_limit, toml_content
from bristle.cli.predict import predicted_log
from bristle.cli.terminal import NO, complain

if TYPE_CHECKING:
    from bristle.apps.arm import Arm
    from bristle.core import Content
    from bristle.files import Growing
    from bristle.simulation import Prediction


def identified_arm(
    logs: Sequence[Path],
    axes: Sequence[Content],
    robot: Content,
    report: Callable[[float, str], None],
) -> Arm:
    """Identify the dynamics of an arm from one log."""
    from bristle.apps.arm import identify_arm
    from bristle.core import InputError

    if len(logs) != 1 or len(axes) != 1:
        raise InputError(
            "needs one log of all joints and one axis file",
            path="--robot",
            value=f"{len(logs)} logs, {len(axes)} axis files",
        )
    report(0.0, "identifying the bodies of the arm")
    return identify_arm(logs[0], robot, axes[0], size_limit=size_limit())


def along_the_log(folder: Path, log: Path) -> dict[str, Prediction]:
    """Return the efforts that an identified arm predicts along its log, of each identified joint."""
    from bristle.apps.arm import logs_of_joints
    from bristle.files import read_model
    from bristle.prediction import predict

    predictions: dict[str, Prediction] = {}
    for name, (recorded, axis) in logs_of_joints(folder, log, size_limit=size_limit()).items():
        if (place := folder / name / "model.toml").exists():
            plant, friction, facts = read_model(place)
            assert plant is not None
            predictions[name] = predict(
                plant, friction, recorded, axis, "inverse", **facts["treatment"]
            )
    return predictions


def write_arm(arm: Arm, folder: Growing) -> None:
    """Write the files of an arm for other programs, with the friction of the joints that bristle identified."""
    from bristle.files import read_model

    places = {name: folder / name / "model.toml" for name in arm.tables}
    frictions = {
        name: read_model(place).friction for name, place in places.items() if place.exists()
    }
    contents, notes = arm.exported(frictions)
    for name, content in contents.items():
        folder.write(name, content)
    for joint, note in notes.items():
        complain(f"arm.xml, {joint}: {note}")


def predict_arm(results: Path, log: Path, mode: str, output: Output, *, allow_code: bool) -> int:
    """Predict the efforts of all joints of an arm; write a report for each joint and one with a row per joint."""
    from bristle.apps.arm import logs_of_joints
    from bristle.apps.arm.report import arm_prediction
    from bristle.core import InputError
    from bristle.report.results import write_report

    with output.opened("predicting", [log]) as (folder, report):
        joints = logs_of_joints(results, log, size_limit=size_limit())
        summaries = dict[str, dict[str, Any]]()
        predictions: dict[str, Prediction] = {}
        for place, (name, (recorded, axis)) in enumerate(joints.items()):
            report(place / len(joints), name)
            model = results / name / "model.toml"
            if not model.exists():
                raise InputError(
                    "is missing, because the log of the identification did not identify this joint",
                    path=str(model),
                )
            options = {"mode": mode, "allow_code": allow_code, "page": bool(folder)}
            predictions[name], summaries[name], page = predicted_log(
                toml_content(model), recorded, axis, output, **options
            )
            if folder:
                folder.write(f"{name}/report.html", page)
        summary, table, page = arm_prediction(
            summaries, predictions, results.name, log.name, output.command
        )
        if folder:
            write_report(folder, page, summary)
    output.tell(summary, f"{summary['verdict']['words']}.", table, *summary["verdict"]["reasons"])
    return 0 if summary["completed"] else NO
