"""Step 6 of the page: the gain of friction feedforward in the simulated loop, and the values for the drive."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bristle.apps.lab.server.errand import Answer, Errand, as_table, zipped
from bristle.core import Axis, Component, InputError, between
from bristle.files import edited, form_of, key_of, logs_and_axes, write_whole
from bristle.models import controllers

if TYPE_CHECKING:
    from bristle.identification import Fit
    from bristle.logs import Log
    from bristle.prediction import Following
    from bristle.report.identified import Identified, Outcome
    from bristle.simulation import SimulationResult

POINTS = 20  # of a drive table
IDENTIFIED = (
    "identified.pickle"  # beside the results: the identification without its logs, and its command
)
# Fields of an axis that only its simulated loop uses.
OF_LOOP = ("controller", "effort_limit", "lag", "seeks_lag", "presliding")


def controller_fields() -> list[dict[str, Any]]:
    """Return every controller with key, meaning and unit of its parameters, for the form."""
    return [
        {"name": law.name, "description": law.description, "fields": _fields(law)}
        for law in controllers.CONTROLLERS.values()
    ]


def _fields(law: Component) -> list[tuple[str, str, str]]:
    numbers = {
        f"controller.{key_of(name)}": of for name, of in law.variables.items() if not of.choices
    }
    return [
        (
            key,
            of.description,
            " or ".join(dict.fromkeys(map(of.unit, ("translational", "rotational")))),
        )
        for key, of in numbers.items()
    ]


def compensate(errand: Errand) -> Answer:
    """Simulate the loop of the log with the identified model, after edits of the controller, without another identification."""
    identified, command = pickle.loads((errand.model.parent / IDENTIFIED).read_bytes())
    errand = replace(
        errand,
        axis_text=edited(errand.axis_text, errand.options.get("edits") or {}, errand.axis_label),
    )
    axis, before = errand.axis(), identified.axis
    if replace(axis, **{name: getattr(before, name) for name in OF_LOOP}) != before:
        raise InputError(
            "changes the meaning of the log",
            path=errand.axis_label,
            mend="Check the logs, and identify again",
        )
    first, *further = (
        log
        for log, _ in logs_and_axes(
            [log.content for log in errand.fitted], axis, size_limit=errand.size_limit
        )
    )
    if reason := reason_without_loop(identified.best, axis, first):
        raise InputError(reason, path="the loop cannot be simulated")
    identified = replace(
        identified, log=first, further_logs=tuple(further), axes=(axis,) * len(identified.axes)
    )
    return {"axis_text": errand.axis_text}, write_results(
        errand, identified, command, errand.model
    )[1]


def write_results(
    errand: Errand, identified: Identified, command: str, place: Path
) -> tuple[Outcome, dict[str, Any]]:
    """Write all results of an identification into a folder and its archive; return them, and the contents of the page."""
    from bristle.files import results_folder

    own = {"axis_name": errand.axis().name, "files": {"axis": [errand.axis_file]}}
    outcome = identified.outcome_with(
        command=command, progress=between(errand.report, 0.95, 1.0), **own
    )
    with results_folder(place, force=True) as folder:
        outcome.write(folder)
    zipped(place)
    without_logs = replace(identified, log=None, further_logs=())  # which the analysis has
    write_whole(place.parent / IDENTIFIED, pickle.dumps((without_logs, command)))
    return outcome, _findings(errand, identified, outcome)


def _findings(errand: Errand, identified: Identified, outcome: Outcome) -> dict[str, Any]:
    """Return the contents of the page: the verdict, the models, the loop."""
    from bristle.report.judgement import feedforward_of, misfit, ruling_of
    from bristle.report.model_tables import parameter_table

    best, judgement = identified.best, ruling_of(identified, outcome.following)
    return {
        "verdict": judgement.as_data(),
        "misfit": [*misfit(best), f"feedforward: {feedforward_of(identified)}"],
        "parameters": as_table(parameter_table(best, identified.axis)),
        "command": outcome.command,
        "unfinished": identified.unfinished,
        "loop": _loop_view(errand, identified, outcome, usable=judgement.level != "measure_again"),
        "model": best.name,
    }


def reason_without_loop(fit: Fit, axis: Axis, log: Log) -> str:
    """Return why the loop of a log cannot be simulated; empty if it can."""
    if fit.position_rmse is not None:
        return "the model was fitted to the position of an open loop"
    if log.reference is None:
        return (
            "the log has no reference. Record the desired position, or select its column in step 2"
        )
    return (
        ""
        if axis.controller is not None
        else "the controller is missing. Select it, and enter its gains"
    )


def _loop_view(
    errand: Errand, identified: Identified, outcome: Outcome, *, usable: bool
) -> dict[str, Any]:
    """Return the contents of step 6: the gain or why it is unknown, the values for the drive, the fields of the form."""
    from bristle.prediction import drive_table
    from bristle.report.model_tables import drive_rows, values_to_enter

    fit, axis, log = identified.best, errand.axis(), identified.log
    kind, table = fit.plant.kind, drive_table(fit, POINTS)
    gain, reason = None, reason_without_loop(fit, axis, log)
    if outcome.simulation is not None:
        gain, reason = _gain(outcome.simulation, outcome.following)
    facts = {
        "log": errand.fitted[0].label,
        "sample_time": log.sample_time,
        "kind": kind,
        "tables": form_of(errand.axis_file)["tables"],
    }
    if not usable:
        return facts | {
            "gain": None,
            "reason": "the log does not determine the friction: measure again",
            "values": None,
            "drive": None,
        }
    drive = as_table(drive_rows(table, kind, axis)) if table else None
    return facts | {
        "gain": gain,
        "reason": reason,
        "values": as_table(values_to_enter(fit, axis)),
        "drive": drive,
    }


def _gain(
    simulation: SimulationResult, following: Following | None
) -> tuple[dict[str, Any] | None, str]:
    """Return the gain, or why bristle predicts no gain."""
    from bristle.report.compensation import NO_CHANGE, gain_of
    from bristle.report.messages import message
    from bristle.report.table import length_text

    gain = gain_of(simulation)
    if following is not None and following.contradiction is not None:
        return None, message(following.contradiction)
    if following is None or gain is None or not gain.steps:
        return None, "the simulated loop is unstable. Correct the gains and their units"
    before, after = gain.steps[-2:]
    sizes = {"without": before, "with": after, "measured": following.measured}
    facts = {name: length_text(error.peak_to_peak, gain.kind) for name, error in sizes.items()}
    helps = after.peak_to_peak < (1.0 - NO_CHANGE) * before.peak_to_peak
    return facts | {"headline": gain.headline, "helps": helps, "caveat": gain.caveat}, ""
