"""The state of a run, read from its journal, also while another process writes it."""

import time
from pathlib import Path
from typing import Any

from bristle.apps.tune.journal import Journal
from bristle.apps.tune.report import sentences_of, undo_command
from bristle.apps.tune.restoring import Restoration
from bristle.apps.tune.run import Tuning
from bristle.apps.tune.steps import STEPS, Step
from bristle.core import Kind, number, unit_of, with_unit

STATES = {"begun": "running", "done": "passed", "kept": "passed", "stopped": "refused"}


def run_status(folder: Path, kind: Kind) -> dict[str, Any] | None:
    """Return the steps of the latest run in a folder, its outcome in sentences, and the command that undoes it; None without a journal."""
    journal = Journal(folder)
    begins = [
        entry["n"]
        for entry in journal.entries
        if entry["event"] == "begun" and entry["step"] == STEPS[0].name
    ]
    if not begins:
        return None
    latest = journal.entries[begins[-1] :]
    result = _result(folder, journal, latest, kind)
    return {
        "steps": [_step(step, journal, latest, result) for step in STEPS],
        "outcome": result.outcome if result.restored else "not_restored",
        "sentences": sentences_of(result) if result.outcome != "running" else [],
        "change": _error(result.facts.get("comparison", {})),
        "undo": undo_command(result)
        if journal.has_written or journal.is_kept or not result.restored
        else "",
        "age": time.time() - journal.path.stat().st_mtime,
        "report": result.outcome != "running" and (folder / "report.html").is_file(),
    }


def _result(folder: Path, journal: Journal, latest: list[dict[str, Any]], kind: Kind) -> Tuning:
    """Return the result of the latest run; its outcome is "running" before its end."""
    facts = {entry["step"]: entry["facts"] for entry in latest if entry["event"] == "done"}
    last = next(
        (entry for entry in reversed(latest) if entry["event"] in ("write", "restored", "kept")), {}
    )
    stopped = next((entry for entry in latest if entry["event"] == "stopped"), {})
    outcome = "kept" if journal.is_kept else "running"
    if last.get("event") == "restored" or (stopped and not journal.has_written):
        outcome = "undone" if last.get("cause") == "undo" else "restored"
    reason = stopped.get("reason") or stopped.get("code") or last.get("cause", "")
    way_out = (
        Restoration(last.get("different", {}), last.get("fault", ""))
        if last.get("event") == "restored"
        else None
    )
    return Tuning(folder, outcome, stopped.get("code", ""), reason, facts, kind, way_out)


def _step(
    step: Step, journal: Journal, latest: list[dict[str, Any]], result: Tuning
) -> dict[str, Any]:
    """Return title, state, and main fact or reason of a step."""
    entry = next(
        (
            entry
            for entry in reversed(latest)
            if entry["step"] == step.name and entry["event"] in STATES
        ),
        None,
    )
    if entry is None and step.resumes:  # an interrupted run did it
        entry = journal.last("done", step=step.name)
    state = STATES[entry["event"]] if entry else "waiting"
    if state == "running" and result.outcome != "running":
        state = "refused"
    text = (
        result.reason
        if state == "refused"
        else _fact(step.name, entry["facts"], result.kind)
        if entry and "facts" in entry
        else ""
    )
    return {"title": step.title, "state": state, "text": text}


def _fact(name: str, facts: dict[str, Any], kind: Kind) -> str:
    """Return the main fact of a finished step."""
    error = (
        f"rms following error {with_unit(facts['error'], unit_of('length', kind))}"
        if "error" in facts
        else ""
    )
    match name:
        case "identity":
            return ", ".join(map(str, facts["identity"].values()))
        case "backup":
            return f"{len(facts['state'])} values, read twice"
        case "check":
            effort, moved = (
                with_unit(facts["test_effort"], unit_of("force", kind)),
                with_unit(facts["moved"], unit_of("length", kind)),
            )
            return f"{effort} move the axis by {moved}"
        case "warm_up":
            return f"{facts['cycles']} cycles, {error}"
        case "excitation":
            return f"{facts['duration']:.0f} s, {error}"
        case "identification":
            return f"{facts['model']}: {facts['verdict']}, model error {number(facts['error_percent'], digits=3)} %"
        case "stages":
            return f"gain {facts['gain']:.3g}, {error}"
        case "refinement":
            return f"{facts['model']}, model error {number(facts['error_percent'], digits=3)} %; gain {facts['gain']:.3g}, {error}"
        case "comparison":
            return "rms following error {} before, {} after".format(*_error(facts))
    return error


def _error(comparison: dict[str, Any]) -> list[str]:
    """Return the rms following error before and after, with its unit; empty without a comparison."""
    change = comparison.get("changes", {}).get("following_error.rms", {})
    return [
        with_unit(change[side], change["unit"]) for side in ("before", "after") if side in change
    ]
