"""The report of two logs of one axis: whether it helped on the machine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from bristle.core.typography import with_unit
from bristle.core.variable import unit_of
from bristle.report.changes import WORDS, interval_of, percent_of
from bristle.report.compensation import NO_CHANGE
from bristle.report.fronts.comparison import comparison_front, comparison_ruling
from bristle.report.further import further_figures
from bristle.report.log_facts import log_facts
from bristle.report.messages import as_data, message
from bristle.report.page import Picture, picture, render
from bristle.report.table import Table

if TYPE_CHECKING:
    from bristle.comparison.result import Change, Comparison
    from bristle.figures.report_figure import ReportFigure
    from bristle.logs.log import Log

__all__ = ["HEADS", "change_rows", "change_table", "comparison_report", "comparison_sentences", "comparison_summary", "remarks_of"]

VERDICTS = {"lower": "lower", "higher": "higher", "no_change": "no change told", "unknown": "no interval"}
HEADS = ("Quantity", "Before", "After", "Change", "95 % interval", "Verdict")
HELPED = {
    "lower": "It helped: the following error is lower.",
    "higher": "It did not help: the following error is higher.",
    "no_change": "Whether it helped these logs cannot tell: the interval of the following error's change holds zero.",
    "unknown": "Whether it helped these logs cannot tell: one cycle gives no interval.",
}
HARDLY = f"It hardly helped: the following error is lower, by less than {100.0 * NO_CHANGE:g} %."
GROUPS = ("following_error", "reversals", "effort", "friction")


def comparison_sentences(compared: Comparison) -> list[str]:
    """Return whether it helped, then each quantity with its numbers."""
    rms = compared.changes.get("following_error.rms")
    head = [_head(rms)] if rms else ["Whether the axis follows better nobody can tell without a reference."]
    return [*head, *map(_sentence, compared.changes.values())]


def _head(change: Change) -> str:
    hardly = change.verdict == "lower" and abs(change.change_percent) < 100.0 * NO_CHANGE
    return HARDLY if hardly else HELPED[change.verdict]


def _sentence(change: Change) -> str:
    word, (before, after) = WORDS[change.name], (with_unit(side, change.unit) for side in (change.before, change.after))
    interval = f", {percent_of(change)} (95 % interval {interval_of(change)})" if change.interval_percent else ""
    if change.verdict == "unknown":
        return f"{word}: {before} before, {after} after; nothing tells how sure that is."
    if change.verdict == "no_change":
        return f"{word}: no change that these logs can tell, {before} before and {after} after{interval}."
    return f"{word}: {change.verdict}, {after} instead of {before}{interval}."


def change_rows(compared: Comparison) -> list[tuple[str, ...]]:
    """Return a row for each quantity, under `HEADS`."""
    return [
        (
            WORDS[change.name],
            with_unit(change.before, change.unit),
            with_unit(change.after, change.unit),
            percent_of(change),
            interval_of(change),
            VERDICTS[change.verdict],
        )
        for change in compared.changes.values()
    ]


def change_table(compared: Comparison) -> Table:
    """Return each quantity before and after, with its change."""
    return Table("Before and after", HEADS, change_rows(compared))


def remarks_of(compared: Comparison) -> list[str]:
    """Return what was compared, and what may mislead, in sentences; the latter begin with ``warning:``."""
    doubts = [f"{doubt.severity}: {message(doubt)}" for doubt in compared.diagnostics if doubt.severity != "note"]
    notes = [message(note) for note in compared.diagnostics if note.severity == "note"]
    return [*doubts, _compared(compared), *notes]


def _compared(compared: Comparison) -> str:
    shared = compared.shared
    pieces = "cycles" if shared.complete else "pieces"
    motions = "one motion" if shared.motions == 1 else f"{shared.motions} motions"
    drawn = "each with its counterpart" if shared.paired else "each side by itself"
    window = f"; a reversal reaches {with_unit(compared.window, 's')}" if compared.window and compared.turns else ""
    return f"compared: {shared.cycles_before} {pieces} before and {shared.cycles_after} after, of {motions}, drawn anew {drawn}{window}"


def comparison_report(
    compared: Comparison,
    *,
    name: str,
    command: str,
    provenance: Mapping[str, str],
    banner: str | None = None,
    figures: Sequence[ReportFigure] = (),
) -> str:
    """Return the report of two logs as one HTML page."""
    from bristle.figures import comparison

    sides = {"before": compared.logs_before, "after": compared.logs_after}
    warnings = [message(diagnostic) for diagnostic in compared.diagnostics if diagnostic.severity != "note"]
    return render(
        "comparison.html",
        provenance=provenance,
        command=command,
        banner=banner,
        name=name,
        front=comparison_front(compared, name, _short_picture(compared)),
        sentences=comparison_sentences(compared),
        warnings=warnings,
        remarks=remarks_of(compared)[len(warnings) :],
        changes=change_table(compared),
        friction=_friction_table(compared),
        picture=picture("comparison", lambda: comparison(compared), *_caption(compared)),
        logs=[(f"The log {side}", log_facts(logs[0], logs[1:])) for side, logs in sides.items()],
        notes=[note for logs in sides.values() for log in logs for note in log.notes],
        further=further_figures(figures, {"comparison": compared}),
    )


def _short_picture(compared: Comparison) -> Picture:
    from bristle import figures

    signal = "following error" if "following_error.rms" in compared.changes else "effort"
    place = f"the mean {signal} around reversals" if compared.turns else f"the mean {signal} over the cycles"
    return picture(
        "short",
        lambda: figures.comparison_in_short(compared),
        f"{signal.capitalize()} before and after, and each change",
        f"Above, {place}: light before, dark after. Below, each change in percent of before: a full point is one whose "
        "interval leaves out zero.",
    )


def _caption(compared: Comparison) -> tuple[str, str]:
    signal = "following error" if "following_error.rms" in compared.changes else "effort"
    parts = [f"Above, the mean over cycles of the {signal}: light before, dark after."]
    if compared.turns:
        parts.append("Then the mean around reversals, with the window shaded in which the peak is looked for.")
    if compared.friction_curve:
        parts.append("Friction at the same speeds is half the difference of the effort between the directions.")
    parts.append("Below, each change in percent of before: a full point is one whose interval leaves out zero.")
    return f"{signal.capitalize()} and friction before and after, and each change with its interval", " ".join(parts)


def _friction_table(compared: Comparison) -> Table | None:
    if not compared.friction_curve:
        return None
    speed = unit_of("length/time", compared.kind)
    rows = [
        (
            with_unit(at, speed),
            with_unit(change.before, change.unit),
            with_unit(change.after, change.unit),
            percent_of(change),
            interval_of(change),
            VERDICTS[change.verdict],
        )
        for at, change in compared.friction_curve
    ]
    return Table("Friction at the same speeds", ("Speed", *HEADS[1:]), rows)


def comparison_summary(compared: Comparison, *, name: str, provenance: Mapping[str, str]) -> dict[str, Any]:
    """Return two logs in numbers, in SI of the axis."""
    groups: dict[str, Any] = {group: {} for group in GROUPS}
    for full, change in compared.changes.items():
        group, _, own = full.partition(".")
        groups[group][own] = change.as_data()
    if groups["reversals"]:
        groups["reversals"] = {"window": compared.window} | groups["reversals"]
    if groups["friction"]:
        groups["friction"]["at_speeds"] = [{"speed": at} | change.as_data() for at, change in compared.friction_curve]
    return (
        {
            "name": name,
            "kind": compared.kind,
            "helped": compared.helped,
            "error_unit": unit_of("length", compared.kind),
            "effort_unit": unit_of("force", compared.kind),
            "verdict": comparison_ruling(compared).as_data(),
            "sentences": comparison_sentences(compared),
        }
        | {group: numbers or None for group, numbers in groups.items()}
        | {
            "shared": vars(compared.shared),
            "diagnostics": as_data(compared.diagnostics),
            "logs": {"before": _logs(compared.logs_before), "after": _logs(compared.logs_after)},
            "provenance": provenance,
        }
    )


def _logs(logs: Sequence[Log]) -> list[dict[str, Any]]:
    return [
        {"name": log.origin.name, "samples": len(log), "sample_time": log.sample_time, "duration": log.duration, "notes": list(log.notes)}
        for log in logs
    ]
