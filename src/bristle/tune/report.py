"""The report of a run: before, after, the interval, the values written and how to undo it; and the plan in rows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bristle.core import number, unit_of, with_unit
from bristle.report.cards import Step
from bristle.report.comparison import comparison_report
from bristle.report.page import Block, Front, Ruling, Section, about, report_page
from bristle.report.table import Table

if TYPE_CHECKING:
    from bristle.tune.run import Run
    from bristle.tune.tuning import Tuning


def sentences_of(result: Tuning) -> list[str]:
    """Return the outcome in sentences, verdict first."""
    change = result.facts.get("comparison", {}).get("changes", {}).get("following_error.rms")
    lines = []
    if result.outcome == "undone":
        return ["Undone: the machine reads back as before the run."]
    if result.outcome == "kept":
        lines.append(f"Kept, at gain {result.facts['comparison']['gain']:.3g}.")
    else:
        state = "Restored" if result.restored else "NOT RESTORED: the machine differs from its backup"
        lines.append(f"{state}. {result.reason}.")
    if change is not None:
        before, after = (with_unit(change[side], change["unit"]) for side in ("before", "after"))
        ends = [number(float(end), digits=3) for end in change["interval_percent"] or ()]
        interval = f" (95 % interval {' to '.join(ends)} %)" if ends else ""
        lines.append(f"Following error, rms: {before} before, {after} after, {number(change['change_percent'], digits=3)} %{interval}.")
    lines.append(f"Undo: {undo_command(result)}")
    return lines


def undo_command(result: Tuning) -> str:
    """Return the command that restores the machine as before the run."""
    return f"bristle tune --undo {result.folder}"


def plan_rows(result: Tuning) -> list[tuple[str, ...]]:
    """Return a row for each step: title, duration, travel, writes."""
    unit = unit_of("length", result.kind)
    rows = []
    for facts in result.facts.values():
        travel = " to ".join(with_unit(end, unit) for end in facts["travel"]) if facts["travel"] else ""
        seconds = f"{facts['seconds']:.0f} s" if facts["seconds"] else ""
        rows.append((facts["title"], seconds, travel, ", ".join(facts["writes"])))
    return rows


def tune_report(run: Run, result: Tuning, **options: Any) -> str:
    """Return the report of a run as an HTML page; options as of `report_page`."""
    is_kept = result.outcome == "kept"
    ruling = Ruling("usable", "Kept") if is_kept else Ruling("no", "Restored" if result.restored else "Not restored", (result.reason,))
    following = Step("Keep it, or undo it:" if is_kept else "Undo again:", undo_command(result))
    sections = [
        Section("written", "Values written", [Table("Values written", ("Step", "Write", "Value"), _writes(run))], "Written"),
        Section("steps", "Steps", [Table("Steps", ("Step", "Result"), _steps(result))], "Steps"),
        Section("model", "The model", [Block("facts", _model(result), ("The identified feedforward",))], "Steps"),
    ]
    heading = f"{run.file.name}: {'tuned' if is_kept else 'not tuned'}"
    if run.compared is not None:
        changed = {"heading": heading, "ruling": ruling, "next": following}
        return comparison_report(run.compared, name=run.file.name, further=sections, changed=changed, **options)
    front = Front(heading, about(run.file.machine), ruling, title=result.reason, next=following)
    return report_page("tune", {"run": run}, front, sections, **options)


def _writes(run: Run) -> list[tuple[str, ...]]:
    rows = []
    for entry in run.journal.entries:
        if entry["event"] == "write":
            values = {key: value for key, value in entry.items() if key not in ("n", "step", "event", "what", "previous")}
            rows.append((entry["step"], entry["what"], ", ".join(f"{key} {_text(value)}" for key, value in values.items())))
    return rows


def _steps(result: Tuning) -> list[tuple[str, ...]]:
    return [
        (name.replace("_", " "), ", ".join(f"{key.replace('_', ' ')} {_text(value)}" for key, value in facts.items() if _is_short(value)))
        for name, facts in result.facts.items()
    ]


def _model(result: Tuning) -> list[tuple[str, str]]:
    facts = result.facts.get("identification", {})
    return [(key.replace("_", " ").capitalize(), _text(value)) for key, value in facts.items() if _is_short(value)]


def _is_short(value: Any) -> bool:
    return isinstance(value, (str, int, float, bool))


def _text(value: Any) -> str:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return " to ".join(map(_text, value)) if isinstance(value, (list, tuple)) else str(value)
    return number(float(value), digits=3)
