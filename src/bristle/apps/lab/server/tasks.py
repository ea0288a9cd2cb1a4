"""The jobs: each is a function of an errand that calls the public API of bristle. Also the axis file as a form."""

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from bristle.apps.lab.server.errand import Answer, Errand, thinned, zipped
from bristle.apps.lab.server.loop import POINTS, compensate, write_results
from bristle.apps.lab.server.tune import plan, tune, undo
from bristle.core import Content, InputError, TooShortError, between
from bristle.exports import NAME
from bristle.files import (
    CHANNELS,
    EMPTY,
    FILL_IN,
    edited,
    form_of,
    logs_and_axes,
    with_columns_of_motion,
)
from bristle.models.friction import DEFAULT_MODELS
from bristle.report.log import Inspected, inspect_log
from bristle.report.log_tables import passage_table

PLOTTED = ("position", "velocity", "reference", "effort")


def look(errand: Errand) -> Answer:
    """Return the axis file of the first log, or a proposed file, and the data read with it."""
    content = errand.fitted[0].content
    errand.report(0.1, "reading the log")
    text, proposed = errand.options.get("text") or errand.axis_text, None
    if not text:
        proposed = inspect_log(content, size_limit=errand.size_limit)
        text = proposed.proposal.text if proposed.proposal else f"{EMPTY}\n[columns]\n"
    text = edited(text, errand.options.get("edits") or {}, errand.axis_label)
    errand = replace(errand, axis_text=text)
    axis, refusal = None, ""
    try:
        axis = errand.axis()
    except InputError as error:  # why its file is incomplete
        refusal = str(error)
    if axis is not None or proposed is None:
        inspected = inspect_log(content, axis, size_limit=errand.size_limit)
    else:
        inspected = proposed
    form = form_of(errand.axis_file)
    if axis is not None and inspected.log:  # channels in SI units of the axis
        time = inspected.log.time.values
        plots = [
            _plot(name, channel.unit, channel.column, thinned(time, channel.values), "s")
            for name, channel in inspected.log.channels()
            if name in PLOTTED
        ]
    else:
        plots = _of_columns(inspected, form["tables"]["columns"])
    numbers = {
        name: inspected.summary[name]
        for name in ("columns", "notes", "problems", "diagnostics", "kind")
    }
    if axis is None:
        numbers |= {"problems": [], "diagnostics": []}
    data = {
        "log": errand.fitted[0].label,
        "form": form,
        "channels": CHANNELS,
        "refusal": refusal,
        "plots": plots,
    } | numbers
    facts = {
        "axis_text": text,
        "missing": form["missing"],
        "ready": axis is not None and not numbers["problems"],
    }
    return facts, data


def _plot(
    word: str, unit: str, column: str, curve: list[list[Any]], time_unit: str
) -> dict[str, Any]:
    return {"word": word, "unit": unit, "column": column, "curve": curve, "time_unit": time_unit}


def _of_columns(inspected: Inspected, columns: dict[str, Any]) -> list[dict[str, Any]]:
    """Return columns as recorded, as long as the axis file does not describe them."""
    plots, recorded = [], inspected.table.columns
    time = recorded.get(columns.get("time", {}).get("column"))
    for name in PLOTTED:
        entry = columns.get(name, {})
        values = recorded.get(entry.get("column"))
        if values is None or not values.size:
            continue
        timed = time is not None and time.size == values.size
        along = np.arange(values.size) if time is None or not timed else time
        unit = "as recorded" if entry.get("unit", "") in ("", FILL_IN) else entry["unit"]
        time_unit = columns["time"].get("unit", "") if timed else "sample"
        plots.append(_plot(name, unit, entry["column"], thinned(along, values), time_unit))
    return plots


DRAWS = 100
MODE = "inverse"
LEFT_OUT = "bristle leaves this log out"
# Of the summary of a log.
SHOWN = ("rate", "duration", "kind", "channels", "notes", "diagnostics", "problems")


def check(errand: Errand) -> Answer:
    """Return rates, experiments, diagnostics and problems of every log."""
    axis, logs = errand.axis(), []
    for place, log in enumerate(errand.logs):
        errand.report(place / len(errand.logs), f"reading {log.label}")
        try:
            summary = inspect_log(log.content, axis, size_limit=errand.size_limit).summary
        except InputError as error:
            logs.append({"label": log.label, "role": log.role, "problems": [str(error)]})
            continue
        passages = (
            passage_table(summary["passages"], summary["kind"])._asdict()
            if summary["passages"]
            else None
        )
        logs.append(
            {"label": log.label, "role": log.role, "passages": passages}
            | {name: summary[name] for name in SHOWN}
        )
    _leave_out(errand, logs)
    problems = sum(len(log["problems"]) for log in logs)
    warnings = sum(
        entry["severity"] != "note" for log in logs for entry in log.get("diagnostics", ())
    )
    return {"problems": problems, "warnings": warnings, "ready": not problems}, {"logs": logs}


def _leave_out(errand: Errand, logs: Sequence[dict[str, object]]) -> None:
    """Let the problem of a log that is too short be a reason to leave it out, if another log to fit can be used."""
    import bristle

    if all(facts["problems"] for facts in logs if facts["role"] == "fit"):
        return
    for log, facts in zip(errand.logs, logs, strict=True):
        try:
            if facts["problems"]:
                bristle.read_log(log.content, errand.axis(), size_limit=errand.size_limit)
        except TooShortError as error:
            facts |= {"problems": [], "left_out": f"{LEFT_OUT}: {error}"}
        except InputError:
            continue


def identify(errand: Errand) -> Answer:
    """Return the verdict of an identification, and keep its results."""
    import bristle

    axis = errand.axis()
    pairs = logs_and_axes(
        [log.content for log in errand.fitted], axis, size_limit=errand.size_limit
    )
    logs = [log for log, _ in pairs]
    models = [name.strip() for name in errand.text("models", DEFAULT_MODELS).split(",")]
    options: dict[str, Any] = {
        "draws": errand.count("draws", DRAWS),
        "cutoff": errand.text("cutoff") or None,
    }
    draws = "" if options["draws"] == DRAWS else str(options["draws"])
    flags = {
        "--axis": errand.axis_label,
        "--model": ",".join(models),
        "--draws": draws,
        "--cutoff": options["cutoff"],
        "--out": "results",
    }
    command = _command("identify", [log.label for log in errand.fitted], flags)
    with errand.interruptible():
        identified = bristle.identify(
            logs,
            models,
            axis=[axis] * len(logs),
            progress=between(errand.report, 0.0, 0.95),
            **options,
        )
    outcome, findings = write_results(errand, identified, command, errand.folder / "results")
    facts = {
        "level": outcome.summary["verdict"]["level"],
        "model": identified.best.name,
        "unfinished": identified.unfinished,
    }
    return facts, findings


def _command(name: str, files: Sequence[str], options: Mapping[str, str | None]) -> str:
    """Return the equivalent terminal command, with the options that have a value."""
    words = [word for option, value in options.items() if value for word in (option, value)]
    return shlex.join(["bristle", name, *files, *words])


def predict(errand: Errand) -> Answer:
    """Return the error of the model on each held-out log."""
    import bristle
    from bristle.report.prediction import prediction_ruling

    axis, model, logs = errand.axis(), bristle.load(errand.model), []
    chosen = [log for log in errand.logs if log.role == "held_out"]
    for place, log in enumerate(chosen):
        errand.report(place / len(chosen), f"predicting {log.label}")
        try:
            recorded = bristle.read_log(log.content, axis, size_limit=errand.size_limit)
            prediction = model.predict(recorded, MODE, axis=axis)
        except TooShortError as error:
            logs.append({"label": log.label, "left_out": f"{LEFT_OUT}: {error}"})
            continue
        assert prediction.effort is not None
        assert prediction.effort_predicted is not None
        logs.append(
            {
                "label": log.label,
                "error_percent": prediction.metrics["force_error_percent"],
                "inside_percent": prediction.inside_percent,
                "verdict": prediction_ruling(prediction).as_data(),
                "time": thinned(prediction.time, prediction.effort, prediction.effort_predicted),
            }
        )
    return {"logs": len(logs)}, {"logs": logs, "mode": MODE, "kind": axis.kind}


def export(errand: Errand) -> Answer:
    """Write the model as an archive for a target, and return the simplifications of the target."""
    from bristle.files import results_folder
    from bristle.report.exported import export_model_file

    model = errand.model / "model.toml"
    target, name = errand.text("target", "table"), errand.text("name") or NAME
    points = errand.count("points", POINTS)
    errand.report(0.2, f"writing for {target}")
    axis = errand.axis_file if errand.axis_text else None
    flags = {
        "--to": target,
        "--out": f"{name}_{target}",
        "--name": name,
        "--axis": errand.axis_label if axis else "",
    }
    command = _command(
        "export", ["results"], flags | {"--points": "" if points == POINTS else str(points)}
    )
    exported = export_model_file(
        model, target, command=command, name=name, axis=axis, points=points
    )
    with results_folder(errand.folder / "export") as folder:
        exported.write(folder)
    zipped(errand.folder / "export")
    # The first short text, for display before the download.
    texts = [
        {"file": file, "text": text}
        for file, text in exported.product.files.items()
        if isinstance(text, str)
    ]
    short = [shown for shown in texts if len(shown["text"]) < 6000]
    facts = {"target": target, "file": f"{name}_{target}.zip"}
    data = {
        "notes": exported.summary["notes"],
        "files": exported.summary["files"],
        "shown": short[0] if short else None,
    }
    return facts, data


def excite(errand: Errand) -> Answer:
    """Write a motion as an archive, and return the parameters that its log will identify."""
    from bristle.files import results_folder
    from bristle.report.excitation import designed_motion

    text = with_columns_of_motion(
        edited(errand.axis_text or EMPTY, errand.options.get("edits") or {}, errand.axis_label)
    )
    axis_file = Content(Path(errand.axis_label), text.encode())
    duration, purposes = errand.text("duration", "60 s"), errand.text("purposes")
    travel = errand.text("travel") or None
    command = _command(
        "excite",
        [errand.axis_label],
        {"--out": "motion", "--duration": duration, "--for": purposes, "--travel": travel},
    )
    with errand.interruptible():
        motion = designed_motion(
            axis_file,
            command=command,
            duration=duration,
            travel=travel,
            purposes=purposes or None,
            progress=errand.report,
        )
    following = motion.next_command("motion/axis.toml")
    with results_folder(errand.folder / "motion") as folder:
        motion.write(folder, following)
    zipped(errand.folder / "motion")
    excitation = motion.excitation
    return {"duration": float(excitation.motion.time[-1])}, {"notes": excitation.notes}


# By their names in the page.
TASKS = {
    task.__name__: task
    for task in (look, check, identify, predict, compensate, export, excite, plan, tune, undo)
}
