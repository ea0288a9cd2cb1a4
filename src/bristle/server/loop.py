"""Step 6 of the page: the gain of friction feedforward in the simulated loop, and the values for the drive."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.controllers import CONTROLLERS
from bristle.core import InputError, between, number, printable, typeset, unit_of
from bristle.core.dimensions import KINDS
from bristle.files import edited, form_of
from bristle.files.components import key_of
from bristle.server.errand import Answer, Errand, as_table, thinned

if TYPE_CHECKING:
    from bristle.core import Axis
    from bristle.identification import Fit
    from bristle.logs import Log
    from bristle.prediction import DriveUnit, Following
    from bristle.report.table import Table
    from bristle.simulation import SimulationResult

POINTS = 20  # of a drive table
WORTH = 0.95  # of the error without friction feedforward: a smaller error counts as a gain
LOOP = ("controller", "effort_limit", "lag", "seeks_lag", "presliding")  # fields of an axis that only its simulated loop uses
# Quantity of a level of friction -> its name in `LevelValues` and its label.
LEVELS = (
    ("forward", "Friction forward, F+", "force"),
    ("backward", "Friction backward, F\u2212", "force"),
    ("viscous_forward", "Viscous friction forward", "force*time/length"),
    ("viscous_backward", "Viscous friction backward", "force*time/length"),
    ("constant", "Constant force", "force"),
    ("inertia", "Mass or inertia", "mass"),
)


def controller_fields() -> list[dict[str, Any]]:
    """Return every controller with the fields of its parameters, for the form."""
    return [
        {
            "name": name,
            "description": law.description,
            "fields": [
                {"key": f"controller.{key_of(key)}", "word": variable.description, "units": {kind: variable.unit(kind) for kind in KINDS}}
                for key, variable in law.variables.items()
                if not variable.choices
            ],
        }
        for name, law in CONTROLLERS.items()
    ]


def compensate(errand: Errand) -> Answer:
    """Simulate the loop of the log with the identified model, after edits of the controller, without another identification."""
    import bristle
    from bristle.identification import Settings
    from bristle.prediction import TREATED, following_of, loop_of
    from bristle.simulation import simulate

    loaded = bristle.load(errand.model)
    errand = replace(errand, axis_text=edited(errand.axis_text, errand.options.get("edits") or {}, errand.axis_label))
    axis, before = errand.axis(), loaded.axis
    if before is None or replace(axis, **{name: getattr(before, name) for name in LOOP}) != before:
        raise InputError("changes the meaning of the log", path=errand.axis_label, mend="Check the logs, and identify again")
    log = bristle.read_log(errand.fitted[0].content, axis, size_limit=errand.size_limit)
    if reason := reason_without_loop(loaded.best, axis, log):
        raise InputError(reason, path="the loop cannot be simulated")
    errand.report(0.3, "simulating the loop")
    treatment = {name: loaded.treatment.get(name) for name in TREATED}
    experiment = loop_of(loaded.plant, loaded.model, log, axis, lag=loaded.best.lag, **treatment)
    assert experiment is not None
    simulation = simulate(experiment, between(errand.report, 0.3, 0.9))
    following = following_of(log, simulation, Settings(**axis.settings))
    usable = loaded.summary["verdict"]["level"] != "measure_again"
    return {"axis_text": errand.axis_text}, loop_view(errand, loaded.best, axis, log, simulation, following, usable=usable)


def reason_without_loop(fit: Fit, axis: Axis, log: Log) -> str:
    """Return why the loop of a log cannot be simulated; empty if it can."""
    if fit.position_rmse is not None:
        return "the model was fitted to the position of an open loop"
    if log.reference is None:
        return "the log has no reference. Record the desired position, or select its column in step 2"
    return "" if axis.controller is not None else "the controller is missing. Select it, and enter its gains"


def loop_view(
    errand: Errand, fit: Fit, axis: Axis, log: Log, simulation: SimulationResult | None, following: Following | None, *, usable: bool
) -> dict[str, Any]:
    """Return the contents of step 6: the gain or why it is unknown, the values for the drive, the fields of the form."""
    from bristle.prediction import drive_table, drive_units
    from bristle.report.model_tables import drive_rows

    kind, table = fit.plant.kind, drive_table(fit, POINTS)
    rows = _drive_units_first(drive_rows(table, kind, axis), drive_units(axis, kind).velocities)
    gain, reason = (None, reason_without_loop(fit, axis, log)) if simulation is None else _gain(simulation, following)
    return {
        "gain": gain if usable else None,
        "reason": reason if usable else "the log does not determine the friction: measure again",
        "log": errand.fitted[0].label,
        "sample_time": log.sample_time,
        "kind": kind,
        "values": as_table(_values(fit, axis)) if usable else None,
        "drive": as_table(rows) if table and usable else None,
        "tables": form_of(errand.axis_file)["tables"],
    }


def _gain(simulation: SimulationResult, following: Following | None) -> tuple[dict[str, Any] | None, str]:
    """Return the gain with the following error around the worst reversal, or why bristle predicts no gain."""
    from bristle.report.compensation import gain_of
    from bristle.report.messages import message
    from bristle.report.table import length_text
    from bristle.simulation import worst_reversal

    gain = gain_of(simulation)
    if following is not None and following.contradiction is not None:
        return None, message(following.contradiction)
    if following is None or gain is None or not gain.steps:
        return None, "the simulated loop is unstable. Correct the gains and their units"
    before, after = gain.steps[-2:]
    times = before.peak_to_peak / after.peak_to_peak if after.peak_to_peak > 0.0 else np.inf
    results, run = [simulation.variants[step.name] for step in (before, after)], simulation.experiment.variants[0].run
    count = min(following.error.size, *(result.reference.size for result in results))
    first = round(run.settle / run.sample_time)
    without, compensated = ((result.reference - result.measured)[first:count] for result in results)
    at = worst_reversal(results[0].reference[first:count], without) or slice(0, without.size)
    error = [without[at], compensated[at], following.error[first:count][at]]
    old, new = (length_text(step.peak_to_peak, gain.kind) for step in (before, after))
    return {
        "helps": after.peak_to_peak < WORTH * before.peak_to_peak,
        "times": number(times, digits=2 if times < 100.0 else 3),
        "without": old,
        "with": new,
        "measured": length_text(following.measured.peak_to_peak, gain.kind),
        "caveat": gain.caveat,
        "error": thinned(run.sample_time * np.arange(error[0].size), *error),
    }, ""


def _values(fit: Fit, axis: Axis) -> Table:
    """Return friction, constant force and inertia, in the units of the drive first."""
    from bristle.prediction import drive_units, level_values
    from bristle.report.table import Table, fixed

    kind, levels, rows = fit.plant.kind, level_values(fit), []
    units = drive_units(axis, kind)
    for name, label, quantity in LEVELS if levels is not None else ():
        if value := getattr(levels, name):
            words = [f"{number(unit.of(value), digits=3)} {typeset(printable(unit.name))}" for unit in units.of(quantity)]
            rows.append((label, "; ".join(words), fixed(value, unit_of(quantity, kind))))
    return Table("Values to enter into the drive", ("Value", "In the drive's units", "SI"), rows)


def _drive_units_first(table: Table, velocities: tuple[DriveUnit, ...]) -> Table:
    """Return the drive table with the columns in the units of the drive before those in SI."""
    names = {f"[{typeset(printable(unit.name))}]": "Velocity " for unit in velocities}
    order = sorted(range(len(table.heads)), key=lambda place: (place > 0, not table.heads[place].startswith("[")))
    heads = [f"{names.get(head, 'Effort ') if head.startswith('[') else ''}{head}" for head in table.heads]
    return table._replace(heads=tuple(heads[k] for k in order), rows=[tuple(row[k] for k in order) for row in table.rows])
