"""The report of two logs of one axis: the effect of a change on the machine, with its uncertainty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from bristle.core import number, unit_of, with_unit
from bristle.report.cards import COMPARE, Card, Step
from bristle.report.compensation import NO_CHANGE, change_text
from bristle.report.log_tables import log_facts
from bristle.report.messages import as_data, message, picked
from bristle.report.page import Block, Figures, Front, Ruling, Section, about, report_page
from bristle.report.sentences import SENTENCES
from bristle.report.table import Table, capital, fixed, length_text, percent_text

if TYPE_CHECKING:
    from bristle.logs import Log
    from bristle.prediction.comparison import Change, Comparison

RMS = "following_error.rms"
WORDS = {
    RMS: "Following error, root mean square",
    "following_error.peak": "Following error, largest in a cycle",
    "reversals.forward_to_backward": "Following error after a reversal, forward to backward",
    "reversals.backward_to_forward": "Following error after a reversal, backward to forward",
    "effort.rms": "Effort, root mean square",
    "effort.peak": "Effort, largest in a cycle",
    "friction.level": "Friction level",
}
SHORT = {"root mean square": "rms", "largest in a cycle": "peak"}
MOST_CARDS = 4
ENOUGH = 10  # cycles on each side
HEADS = ("Quantity", "Before", "After", "Change", "95 % interval", "Verdict")


class Wording(NamedTuple):
    """The texts on a change of the following error, for each verdict."""

    level: str
    words: str
    reason: str
    advice: str
    is_open: bool = False

    @property
    def sentence(self) -> str:
        """The verdict in a sentence."""
        return f"{'These logs do not show whether the change helped' if self.is_open else self.words}: {self.reason}."


KEEP = "keep the change, and identify the remaining friction: `bristle identify AFTER --axis axis.toml`"
BACK = "undo the change, then `bristle identify BEFORE --axis axis.toml`"
ZERO = "the 95 % interval of the change in following error contains zero"
VERDICTS = {
    "lower": Wording("usable", "It helped", "the following error is lower", KEEP),
    "hardly": Wording(
        "with_care",
        "It hardly helped",
        f"the following error is lower, by less than {100.0 * NO_CHANGE:g} %",
        KEEP,
    ),
    "higher": Wording("no", "It did not help", "the following error is higher", BACK),
    "no_change": Wording("with_care", "No clear change", ZERO, "", is_open=True),
    "unknown": Wording(
        "with_care", "Effect unknown", "a single cycle gives no interval", "", is_open=True
    ),
}
CELLS = {"no_change": "no clear change", "unknown": "no interval"}


def _wording(change: Change) -> Wording:
    hardly = change.verdict == "lower" and abs(change.change_percent) < 100.0 * NO_CHANGE
    return VERDICTS["hardly" if hardly else change.verdict]


def comparison_report(
    compared: Comparison,
    *,
    name: str,
    further: Sequence[Section] = (),
    changed: Mapping[str, Any] | None = None,
    **options: Any,
) -> str:
    """Return the report of two logs as an HTML page, with further sections and a changed front; options as of `report_page`."""
    sides = {"before": compared.logs_before, "after": compared.logs_after}
    warnings = [
        message(diagnostic) for diagnostic in compared.diagnostics if diagnostic.severity != "note"
    ]
    notes = [note for logs in sides.values() for log in logs for note in log.notes]
    logs = [
        Block("facts", log_facts(logs[0], logs[1:]), (f"The log {side}",))
        for side, logs in sides.items()
    ]
    shares = (compared.shared.before_percent, compared.shared.after_percent)
    partly = (
        [
            f"motion common to both: {percent_text(shares[0])} before, {percent_text(shares[1])} after"
        ]
        if min(shares) < 99.0
        else []
    )
    basis = [
        Block("items", warnings, ("warnings",)),
        Block("items", [*remarks_of(compared)[len(warnings) :], *partly]),
    ]
    rows = [
        _row(with_unit(at, unit_of("length/time", compared.kind)), change)
        for at, change in compared.friction_curve
    ]
    friction = Table("Friction at the same speeds", ("Speed", *HEADS[1:]), rows) if rows else None
    sections = [
        Section("changes", "Changes", [change_table(compared)]),
        Section("basis", "Basis and warnings", basis, "Basis"),
        Section("courses", "Where they differ", [Figures("courses"), friction], "Courses"),
        Section("log", "The logs", [*logs, Block("items", notes)], "Logs"),
    ]
    files = {side: logs[0].source.name.strip("<>") for side, logs in sides.items()}
    facts = {"comparison": compared, "log_name": ", ".join(filter(None, files.values()))}
    front = _front(compared, name, files)._replace(**(changed or {}))
    return report_page("comparison", facts, front, [*sections, *further], **options)


def comparison_sentences(compared: Comparison) -> list[str]:
    """Return the verdict, then each quantity with its numbers."""
    rms = compared.changes.get(RMS)
    wording = _wording(rms) if rms else None
    lines = [
        wording.sentence
        if wording
        else "Without a reference, the effect on the following error is unknown."
    ]
    for change in compared.changes.values():
        word, (before, after) = (
            WORDS[change.name],
            (with_unit(side, change.unit) for side in (change.before, change.after)),
        )
        interval = _with_interval(change)
        if change.verdict == "unknown":
            lines.append(f"{word}: {before} before, {after} after, with unknown uncertainty.")
        elif change.verdict == "no_change":
            lines.append(f"{word}: no clear change, {before} before and {after} after{interval}.")
        else:
            lines.append(f"{word}: {change.verdict}, {after} instead of {before}{interval}.")
    return lines


def _signed(value: float, change: Change) -> str:
    """Return a percentage with its sign and the digits that its interval allows, at most to 0.1 %."""
    ends = change.interval_percent
    # Percent to two digits.
    text = number(value, None if ends is None else max(0.5 * (ends[1] - ends[0]), 0.1), digits=2)
    return text if text.startswith(("−", "–")) or not text.strip("0.") else f"+{text}"


def _with_interval(change: Change) -> str:
    return (
        f", {percent_of(change)} (95 % interval {interval_of(change)})"
        if change.interval_percent
        else ""
    )


def percent_of(change: Change) -> str:
    """Return a change in percent of the value before."""
    return f"{_signed(change.change_percent, change)} %"


def interval_of(change: Change) -> str:
    """Return the ends of the 95 % interval of a change."""
    ends = change.interval_percent
    return "–" if ends is None else f"{_signed(ends[0], change)} to {_signed(ends[1], change)} %"


def change_rows(compared: Comparison) -> list[tuple[str, ...]]:
    """Return a row for each quantity, under `HEADS`."""
    return [_row(WORDS[change.name], change) for change in compared.changes.values()]


def _row(head: str, change: Change) -> tuple[str, ...]:
    before, after = (with_unit(side, change.unit) for side in (change.before, change.after))
    return (
        head,
        before,
        after,
        percent_of(change),
        interval_of(change),
        CELLS.get(change.verdict, change.verdict),
    )


def change_table(compared: Comparison) -> Table:
    """Return each quantity before and after, with its change."""
    return Table("Before and after", HEADS, change_rows(compared))


def remarks_of(compared: Comparison) -> list[str]:
    """Return warnings, which begin with ``warning:``, and the basis of the comparison, in sentences."""
    doubts = [
        f"{doubt.severity}: {message(doubt)}"
        for doubt in compared.diagnostics
        if doubt.severity != "note"
    ]
    notes = [message(note) for note in compared.diagnostics if note.severity == "note"]
    shared = compared.shared
    motions = "one motion" if shared.motions == 1 else f"{shared.motions} motions"
    drawn = "in pairs" if shared.paired else "separately for each side"
    window = (
        f". The window after a reversal is {with_unit(compared.window, 's')}"
        if compared.window and compared.turns
        else ""
    )
    pieces = f"{shared.cycles_before} {'cycles' if shared.complete else 'pieces'} before and {shared.cycles_after} after"
    return [
        *doubts,
        f"bristle compared {pieces}, of {motions}. The intervals resample them {drawn}{window}",
        *notes,
    ]


def comparison_ruling(compared: Comparison) -> Ruling:
    """Return the verdict on the change, with its reasons."""
    doubts = [
        SENTENCES[diagnostic.code].means
        for diagnostic in compared.diagnostics
        if diagnostic.severity != "note"
    ]
    change = compared.changes.get(RMS)
    if change is None:
        return Ruling(
            "with_care",
            "Effect unknown",
            tuple(dict.fromkeys(["without a reference, the following error is unknown", *doubts])),
        )
    wording, word = _wording(change), WORDS[RMS]
    instead = f"{_text(change, change.after)} instead of {_text(change, change.before)}{_with_interval(change)}"
    reasons = [f"{word[0].lower()}{word[1:]}: {instead}"]
    reasons += [wording.reason] if wording.is_open else []
    level = "with_care" if doubts and wording.level == "usable" else wording.level
    return Ruling(level, wording.words, tuple(dict.fromkeys([*reasons, *doubts])))


def advice_of(compared: Comparison) -> str:
    """Return the next step in a sentence, its command in backticks."""
    change = compared.changes.get(RMS)
    return (change and _wording(change).advice) or _more(compared)


def _more(compared: Comparison) -> str:
    """Return the advice to record more than these logs hold."""
    cycles = min(compared.shared.cycles_before, compared.shared.cycles_after)
    few = cycles < ENOUGH or compared.shared.motions > 1
    count = {
        True: "ten cycles or more of one motion",
        False: f"{4 * cycles} cycles, which halves the intervals,",
    }[few]
    return f"record {count} on each side{', with the reference' * (RMS not in compared.changes)}: {COMPARE}"


def _text(change: Change, value: float) -> str:
    return (
        length_text(value, change.kind)
        if change.quantity == "length"
        else fixed(value, change.unit)
    )


def _front(compared: Comparison, name: str, files: Mapping[str, str]) -> Front:
    change, shared = compared.changes.get(RMS), compared.shared
    ruling = comparison_ruling(compared)
    first = change or next(iter(compared.changes.values()), None)
    arrow, title = " → ".join(filter(None, files.values())), ""
    if first:
        word, _, statistic = WORDS[first.name].partition(", ")
        title = f"{word}: {change_text(first.before, first.after, partial(_text, first), SHORT.get(statistic, statistic))}"
    return Front(
        f"{name}: before and after",
        about(
            f"{shared.cycles_before} and {shared.cycles_after} {'cycles' if shared.complete else 'pieces'}"
        ),
        ruling.beyond_title if change else ruling,
        title=title,
        basis=f"({arrow})" if arrow else "",
        cards=[_card(item) for item in list(compared.changes.values())[:MOST_CARDS]],
        next=Step.of(advice_of(compared)),
    )


def _card(change: Change) -> Card:
    """Return the change of a quantity, with its 95 % interval."""
    ends, percent = (
        change.interval_percent,
        CELLS["no_change"] if change.verdict == "no_change" else percent_of(change),
    )
    word, _, statistic = WORDS[change.name].partition(", ")
    label = (
        statistic
        if "reversal" in word
        else f"{word}, {SHORT.get(statistic, statistic)}"
        if statistic
        else word
    )
    return Card(
        capital(label), percent, "no interval" if ends is None else f"95 %: {interval_of(change)}"
    )


def comparison_summary(
    compared: Comparison, *, name: str, provenance: Mapping[str, str]
) -> dict[str, Any]:
    """Return two logs in numbers, in SI units of the axis."""
    groups: dict[str, Any] = {
        group: {} for group in ("following_error", "reversals", "effort", "friction")
    }
    for full, change in compared.changes.items():
        group, _, own = full.partition(".")
        groups[group][own] = change.as_data()
    if groups["reversals"]:
        groups["reversals"] = {"window": compared.window} | groups["reversals"]
    if groups["friction"]:
        groups["friction"]["at_speeds"] = [
            {"speed": at} | change.as_data() for at, change in compared.friction_curve
        ]
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
        picked(log, "sample_time", "duration", "notes")
        | {"name": log.origin.name, "samples": len(log)}
        for log in logs
    ]
