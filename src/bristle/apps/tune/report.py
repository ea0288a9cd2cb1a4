"""The report of a run: before, after, the interval, the values written and how to undo it; and the plan in rows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bristle.apps.tune.machine import STOPS
from bristle.core import Kind, number, unit_of, with_unit
from bristle.report.cards import Step
from bristle.report.comparison import comparison_report
from bristle.report.page import Block, Front, Ruling, Section, about, report_page
from bristle.report.table import Table, capital

if TYPE_CHECKING:
    from bristle.apps.tune.run import Run, Tuning


QUANTITIES = {
    "following_error": "length",
    "travel": "length",
    "effort": "force",
    "offset": "force",
    "lead": "time",
}


def sentences_of(result: Tuning) -> list[str]:
    """Return the outcome in sentences, verdict first."""
    change = result.facts.get("comparison", {}).get("changes", {}).get("following_error.rms")
    lines = []
    if result.outcome == "undone":
        return [*map(_sentence, result.remarks), f"Undone. {last_line(result)}"]
    if result.outcome == "saved":
        facts = result.facts["save"]
        lines += [
            f"Saved, and read back: {', '.join(facts['places'])}.",
            *([facts["loads"]] if facts["loads"] else []),
            "Restart the controller, and repeat this command: it refuses if the feedforward was not loaded again.",
        ]
    elif result.outcome == "kept":
        lines.append(f"Kept, at gain {result.facts['comparison']['gain']:.3g}.")
    else:
        lines.append(f"{_state(result)}. {_sentence(result.reason)}")
    if change is not None:
        before, after = (with_unit(change[side], change["unit"]) for side in ("before", "after"))
        ends = [number(float(end), digits=3) for end in change["interval_percent"] or ()]
        interval = f" (95 % interval {' to '.join(ends)} %)" if ends else ""
        lines.append(
            f"Following error, rms: {before} before, {after} after, {number(change['change_percent'], digits=3)} %{interval}."
        )
    if result.outcome == "kept" and result.facts.get("identity", {}).get("saves"):
        lines.append(
            f"Keep it over a restart of the controller: bristle tune --save {result.folder}"
        )
    lines += map(_sentence, result.remarks)
    return [*lines, last_line(result)]


def last_line(result: Tuning) -> str:
    """Return how the machine reads now, and the one command that follows."""
    undo, way_out = undo_command(result), result.way_out
    if result.outcome in ("kept", "saved"):
        return f"The machine has the feedforward. Undo: {undo}"
    if way_out is not None and way_out.fault:
        return f"NOT RESTORED: the machine does not answer ({way_out.fault}). As soon as it answers: {undo}"
    if way_out is not None and way_out.different:
        different = ", ".join(
            f"{name} {now} instead of {before}" for name, (before, now) in way_out.different.items()
        )
        return f"NOT RESTORED: the machine differs from its backup: {different}. Restore it: {undo}"
    state = (
        "The run wrote nothing on the machine."
        if way_out is None
        else "The machine reads back as before the run."
    )
    return f"{state} Run again: {result.again}" if result.again else state


def _state(result: Tuning) -> str:
    """Return the outcome of a run that was stopped, in a word."""
    if result.way_out is None:
        return "Stopped"
    return "Restored" if result.restored else "NOT RESTORED"


def _sentence(text: str) -> str:
    return f"{capital(text)}{'' if text.endswith('.') else '.'}"


def undo_command(result: Tuning) -> str:
    """Return the command that restores the machine as before the run."""
    return f"bristle tune --undo {result.folder}"


def plan_rows(result: Tuning) -> list[tuple[str, ...]]:
    """Return a row for each step: title, duration, travel, writes."""
    unit = unit_of("length", result.kind)
    rows = []
    for facts in result.facts.values():
        travel = (
            " to ".join(with_unit(end, unit) for end in facts["travel"]) if facts["travel"] else ""
        )
        seconds = f"{facts['seconds']:.0f} s" if facts["seconds"] else ""
        rows.append((facts["title"], seconds, travel, ", ".join(facts["writes"])))
    return rows


def tune_report(run: Run, result: Tuning, **options: Any) -> str:
    """Return the report of a run as an HTML page; options as of `report_page`."""
    is_kept = result.outcome == "kept"
    ruling = Ruling("usable", "Kept") if is_kept else Ruling("no", capital(_state(result).lower()))
    following = Step("Keep it, or undo it:" if is_kept else "Undo again:", undo_command(result))
    if not _is_changed(result):
        following = Step(
            "Run again:" if result.code == STOPS[-1] else "Mend the cause, and run again:",
            options["command"],
        )
    steps = [
        (name.replace("_", " "), ", ".join(map(" ".join, _short(facts))))
        for name, facts in result.facts.items()
    ]
    identified = _short(result.facts.get("refinement") or result.facts.get("identification", {}))
    model = [(name.capitalize(), text) for name, text in identified]
    sections = [
        Section(
            "written",
            "Values written",
            [Table("Values written", ("Step", "Write", "Value"), _writes(run))],
            "Written",
        ),
        Section("steps", "Steps", [Table("Steps", ("Step", "Result"), steps)], "Steps"),
        Section(
            "model", "The model", [Block("facts", model, ("The identified feedforward",))], "Steps"
        ),
    ]
    heading = f"{run.file.name}: {'tuned' if is_kept else 'not tuned'}"
    if run.compared is not None:
        reasons = () if is_kept else (result.reason,)
        changed = {
            "heading": heading,
            "ruling": ruling._replace(reasons=reasons),
            "next": following,
        }
        return comparison_report(
            run.compared, name=run.file.name, further=sections, changed=changed, **options
        )
    front = Front(
        heading, about(run.file.machine), ruling, title=capital(result.reason), next=following
    )
    return report_page("tune", {"run": run}, front, sections, **options)


def _writes(run: Run) -> list[tuple[str, ...]]:
    rows = []
    for entry in run.journal.entries:
        if entry["event"] == "write":
            values = {
                key: value
                for key, value in entry.items()
                if key not in ("n", "step", "event", "what", "previous")
            }
            texts = (
                f"{key.replace('_', ' ')} {_text(value, key, run.axis.kind)}"
                for key, value in values.items()
            )
            rows.append((entry["step"], entry["what"], ", ".join(texts)))
    return rows


def _short(facts: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the names and texts of those facts that are one text or one number."""
    return [
        (key.replace("_", " "), _text(value))
        for key, value in facts.items()
        if isinstance(value, (str, int, float))
    ]


def _is_changed(result: Tuning) -> bool:
    """Return whether the machine differs from its state before the run."""
    return result.outcome in ("kept", "saved") or not result.restored


def _text(value: Any, key: str = "", kind: Kind = "translational") -> str:
    """Return a value as text, with the unit of its name."""
    if isinstance(value, (list, tuple)):
        return " to ".join(_text(part, key, kind) for part in value)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return str(value)
    if key in QUANTITIES:
        return with_unit(float(value), unit_of(QUANTITIES[key], kind))
    return number(float(value), digits=3)
