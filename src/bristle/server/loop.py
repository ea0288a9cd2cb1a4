"""Step 6 of the page: the gain of friction feedforward in the simulated loop, and the values for the drive."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle import controllers
from bristle.core import InputError
from bristle.files import LOOP, NextExperiment, edited, form_of, key_of, write_whole
from bristle.server.errand import Answer, Errand, as_table, thinned

if TYPE_CHECKING:
    from bristle.core import Axis, Component
    from bristle.identification import Fit
    from bristle.logs import Log
    from bristle.prediction import Following
    from bristle.simulation import SimulationResult

POINTS = 20  # of a drive table
OF_LOOP = ("controller", "effort_limit", "lag", "seeks_lag", "presliding")  # fields of an axis that only its simulated loop uses


def controller_fields() -> list[dict[str, Any]]:
    """Return every controller with key, meaning and unit of its parameters, for the form."""
    return [{"name": law.name, "description": law.description, "fields": _fields(law)} for law in controllers.CONTROLLERS.values()]


def _fields(law: Component) -> list[tuple[str, str, str]]:
    numbers = {f"controller.{key_of(name)}": of for name, of in law.variables.items() if not of.choices}
    return [(key, of.description, " or ".join(dict.fromkeys(map(of.unit, ("translational", "rotational"))))) for key, of in numbers.items()]


def compensate(errand: Errand) -> Answer:
    """Simulate the loop of the log with the identified model, after edits of the controller, without another identification."""
    import bristle
    from bristle.identification import Settings
    from bristle.prediction import TREATED, following_of, loop_of
    from bristle.simulation import simulate

    loaded = bristle.load(errand.model)
    errand = replace(errand, axis_text=edited(errand.axis_text, errand.options.get("edits") or {}, errand.axis_label))
    axis, before = errand.axis(), loaded.axis
    if before is None or replace(axis, **{name: getattr(before, name) for name in OF_LOOP}) != before:
        raise InputError("changes the meaning of the log", path=errand.axis_label, mend="Check the logs, and identify again")
    log = bristle.read_log(errand.fitted[0].content, axis, size_limit=errand.size_limit)
    if reason := reason_without_loop(loaded.best, axis, log):
        raise InputError(reason, path="the loop cannot be simulated")
    of_axis = loaded.plant, loaded.model, log, axis
    experiment = loop_of(*of_axis, lag=loaded.best.lag, **{name: loaded.treatment.get(name) for name in TREATED})
    assert experiment is not None
    simulation, base = simulate(experiment), experiment.variants[0]
    following = NextExperiment.beside_model(loaded.plant, axis, log, errand.model, has_axis_file=True, loop=base)
    for name, text in (("axis.toml", errand.axis_text), ("experiment.toml", following.text), (LOOP, following.loop)):
        write_whole(errand.model / name, text or "")
    simulated = simulation, following_of(log, simulation, Settings(**axis.settings))
    usable = loaded.summary["verdict"]["level"] != "measure_again"
    return {"axis_text": errand.axis_text}, loop_view(errand, loaded.best, axis, log, simulated, usable=usable)


def reason_without_loop(fit: Fit, axis: Axis, log: Log) -> str:
    """Return why the loop of a log cannot be simulated; empty if it can."""
    if fit.position_rmse is not None:
        return "the model was fitted to the position of an open loop"
    if log.reference is None:
        return "the log has no reference. Record the desired position, or select its column in step 2"
    return "" if axis.controller is not None else "the controller is missing. Select it, and enter its gains"


def loop_view(errand: Errand, fit: Fit, axis: Axis, log: Log, simulated: tuple[Any, Any], *, usable: bool) -> dict[str, Any]:
    """Return the contents of step 6: the gain or why it is unknown, the values for the drive, the fields of the form."""
    from bristle.prediction import drive_table
    from bristle.report.model_tables import drive_rows, values_to_enter

    kind, table = fit.plant.kind, drive_table(fit, POINTS)
    gain, reason = (None, reason_without_loop(fit, axis, log)) if simulated[0] is None else _gain(simulated[0], simulated[1])
    facts = {"log": errand.fitted[0].label, "sample_time": log.sample_time, "kind": kind, "tables": form_of(errand.axis_file)["tables"]}
    if not usable:
        return facts | {"gain": None, "reason": "the log does not determine the friction: measure again", "values": None, "drive": None}
    drive = as_table(drive_rows(table, kind, axis)) if table else None
    return facts | {"gain": gain, "reason": reason, "values": as_table(values_to_enter(fit, axis)), "drive": drive}


def _gain(simulation: SimulationResult, following: Following | None) -> tuple[dict[str, Any] | None, str]:
    """Return the gain with the following error around the worst reversal, or why bristle predicts no gain."""
    from bristle.report.compensation import NO_CHANGE, gain_of
    from bristle.report.messages import message
    from bristle.report.table import length_text
    from bristle.simulation import worst_reversal

    gain = gain_of(simulation)
    if following is not None and following.contradiction is not None:
        return None, message(following.contradiction)
    if following is None or gain is None or not gain.steps:
        return None, "the simulated loop is unstable. Correct the gains and their units"
    (before, after), run = gain.steps[-2:], simulation.experiment.variants[0].run
    results = [simulation.variants[step.name] for step in (before, after)]
    count = min(following.error.size, *(result.reference.size for result in results))
    first = round(run.settle / run.sample_time)
    without, compensated = ((result.reference - result.measured)[first:count] for result in results)
    at = worst_reversal(results[0].reference[first:count], without) or slice(0, without.size)
    error = [without[at], compensated[at], following.error[first:count][at]]
    sizes = {"without": before, "with": after, "measured": following.measured}
    facts = {name: length_text(error.peak_to_peak, gain.kind) for name, error in sizes.items()}
    facts |= {"headline": gain.headline, "helps": after.peak_to_peak < (1.0 - NO_CHANGE) * before.peak_to_peak, "caveat": gain.caveat}
    return facts | {"error": thinned(run.sample_time * np.arange(error[0].size), *error)}, ""
