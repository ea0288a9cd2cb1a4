"""The state of a run, read from its journal, also while another process writes it."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bristle.core import number, unit_of, with_unit
from bristle.tune.journal import Journal
from bristle.tune.report import sentences_of, undo_command
from bristle.tune.steps import STEPS, Step
from bristle.tune.tuning import Tuning

if TYPE_CHECKING:
    from bristle.core import Kind

STATES = {"begun": "running", "done": "passed", "kept": "passed", "stopped": "refused"}


def run_status(folder: Path, kind: Kind) -> dict[str, Any] | None:
    """Return the steps of the latest run in a folder, its outcome in sentences, and the command that undoes it; None without a journal."""
    journal = Journal(folder)
    if not journal.entries:
        return None
    first = max((place for place, entry in enumerate(journal.entries) if _is_begin(entry)), default=0)
    latest = journal.entries[first:]
    result = _result(folder, journal, latest, kind)
    steps = [_step(step, journal, latest, result) for step in STEPS]
    change = result.facts.get("comparison", {}).get("changes", {}).get("following_error.rms")
    return {
        "steps": steps,
        "outcome": result.outcome,
        "sentences": [] if result.outcome == "running" else sentences_of(result),
        "change": change and {side: with_unit(change[side], change["unit"]) for side in ("before", "after")},
        "undo": undo_command(result) if journal.has_written or journal.is_kept else "",
        "age": time.time() - journal.path.stat().st_mtime,
        "report": result.outcome != "running" and (folder / "report.html").is_file(),
    }


def _is_begin(entry: dict[str, Any]) -> bool:
    return entry["event"] == "begun" and entry["step"] == STEPS[0].name


def _result(folder: Path, journal: Journal, latest: list[dict[str, Any]], kind: Kind) -> Tuning:
    """Return the result of the latest run; its outcome is "running" before its end."""
    facts = {entry["step"]: entry["facts"] for entry in latest if entry["event"] == "done"}
    last, stopped = latest[-1], next((entry for entry in reversed(latest) if entry["event"] == "stopped"), None)
    outcome = "running"
    if last["event"] == "restored":
        outcome = "undone" if last["cause"] == "undo" else "restored"
    elif journal.is_kept:
        outcome = "kept"
    elif last["event"] == "stopped" and not journal.has_written:
        outcome = "restored"
    code, reason = (stopped["code"], stopped["reason"]) if stopped else ("", last.get("cause", ""))
    return Tuning(folder, outcome, code, reason or code, facts, last.get("identical", True), kind)


def _step(step: Step, journal: Journal, latest: list[dict[str, Any]], result: Tuning) -> dict[str, Any]:
    """Return title, state, and main fact or reason of a step."""
    entry = next((entry for entry in reversed(latest) if entry["step"] == step.name and entry["event"] in STATES), None)
    if entry is None and step.resumes:  # an interrupted run did it
        entry = journal.last("done", step=step.name)
    state = STATES[entry["event"]] if entry is not None else "waiting"
    if state == "running" and result.outcome != "running":
        state = "refused"
    text = ""
    if state == "refused":
        text = result.reason
    elif state == "passed" and entry is not None:
        text = f"gain {result.facts['comparison']['gain']:.3g}" if entry["event"] == "kept" else _fact(step.name, entry["facts"], result.kind)
    return {"name": step.name, "title": step.title, "state": state, "text": text}


def _fact(name: str, facts: dict[str, Any], kind: Kind) -> str:
    """Return the main fact of a finished step."""
    error = f"rms following error {with_unit(facts['error'], unit_of('length', kind))}" if "error" in facts else ""
    match name:
        case "identity":
            return ", ".join(map(str, facts["identity"].values()))
        case "backup":
            return f"{len(facts['state'])} values, read twice"
        case "check":
            effort, moved = with_unit(facts["test_effort"], unit_of("force", kind)), with_unit(facts["moved"], unit_of("length", kind))
            return f"{effort} move the axis by {moved}"
        case "warm_up":
            return f"{facts['cycles']} cycles, {error}"
        case "excitation":
            return f"{facts['duration']:.0f} s, {error}"
        case "identification":
            return f"{facts['model']}: {facts['verdict']}, model error {number(facts['error_percent'], digits=3)} %"
        case "stages" | "comparison":
            return f"gain {facts['gain']:.3g}"
    return error
