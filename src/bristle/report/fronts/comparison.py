"""The first page of two logs: whether it helped on the machine, by how much, and how sure that is."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bristle.report.changes import WORDS, interval_of, percent_of
from bristle.report.compensation import NO_CHANGE
from bristle.report.front import Front, Ruling, about, answered, fixed, length_text, percent_text
from bristle.report.messages import sentence_of

if TYPE_CHECKING:
    from bristle.comparison.result import Change, Comparison
    from bristle.report.page import Picture

__all__ = ["comparison_front", "comparison_ruling"]

RMS = "following_error.rms"
VERDICTS = {
    "lower": ("usable", "It helped"),
    "higher": ("no", "It did not help"),
    "no_change": ("with_care", "No change told"),
    "unknown": ("with_care", "Not told"),
}
HARDLY = ("with_care", "It hardly helped")
WHY_NOT = {"no_change": "the interval of the following error's change holds zero", "unknown": "one cycle gives no interval"}
NEXT = {
    "lower": "keep the change; what the axis still errs by: `bristle identify AFTER --axis axis.toml`",
    "higher": "take the change back, then `bristle identify BEFORE --axis axis.toml`",
    "no_change": "record more cycles of each side, several times",
    "unknown": "record ten cycles or more of each side",
}


def comparison_ruling(compared: Comparison) -> Ruling:
    """Return whether it helped on the machine, and why."""
    doubts = [sentence_of(diagnostic.code).means for diagnostic in compared.diagnostics if diagnostic.severity != "note"]
    change = compared.changes.get(RMS)
    if change is None:
        return Ruling("with_care", "Not told", tuple(dict.fromkeys(["no reference tells a following error", *doubts])))
    level, words = HARDLY if _hardly(change) else VERDICTS[change.verdict]
    reasons = [_instead(change)]
    if change.verdict in WHY_NOT:
        reasons.append(WHY_NOT[change.verdict])
    if doubts and level == "usable":
        level = "with_care"
    return Ruling(level, words, tuple(dict.fromkeys([*reasons, *doubts])))


def _hardly(change: Change) -> bool:
    return change.verdict == "lower" and abs(change.change_percent) < 100.0 * NO_CHANGE


def _text(change: Change, value: float) -> str:
    return length_text(value, change.kind) if change.quantity == "length" else fixed(value, change.unit)


def _instead(change: Change) -> str:
    word = WORDS[change.name]
    line = f"{word[0].lower()}{word[1:]}: {_text(change, change.after)} instead of {_text(change, change.before)}"
    if change.interval_percent is None:
        return line
    return f"{line}, {percent_of(change)} (95 % interval {interval_of(change)})"


def comparison_front(compared: Comparison, name: str, figure: Picture) -> Front:
    """Return the first page of two logs."""
    ruling = comparison_ruling(compared)
    sides = {"before": compared.logs_before, "after": compared.logs_after}
    named = {side: logs[0].source.name.strip("<>") for side, logs in sides.items()}
    return Front(
        f"{name}: before and after",
        about(*(f"{side}: {file}" for side, file in named.items() if file)),
        *ruling[:2],
        ruling.reasons,
        answered(
            _lines(compared, ("following_error", "reversals"), "no following error: the logs have no reference"),
            [_typed(compared.changes.get(RMS))],
            _lines(compared, ("effort", "friction"), "no effort in these logs"),
            _trust(compared),
            _next(compared),
        ),
        figure,
        "basis",
    )


def _lines(compared: Comparison, groups: tuple[str, ...], otherwise: str) -> list[str]:
    """Return the changes of these groups, but for the one that stands in the verdict."""
    changes = [change for name, change in compared.changes.items() if name.partition(".")[0] in groups]
    return [_short(change) for change in changes if change.name != RMS or len(changes) == 1] or [otherwise]


def _short(change: Change) -> str:
    verdict = "no change told" if change.verdict == "no_change" else percent_of(change)
    return f"{WORDS[change.name]}: {_text(change, change.after)}, before {_text(change, change.before)} ({verdict})"


def _typed(change: Change | None) -> str:
    if change is None or change.verdict in WHY_NOT:
        return "nothing: these logs tell neither way"
    state = "what stood there after" if change.verdict == "lower" else "what stood there before"
    return f"nothing new: {state} the change"


def _trust(compared: Comparison) -> list[str]:
    shared = compared.shared
    pieces = "cycles" if shared.complete else "pieces"
    lines = [f"{shared.cycles_before} {pieces} before, {shared.cycles_after} after; intervals from their scatter"]
    if min(shared.before_percent, shared.after_percent) < 99.0:
        shares = (percent_text(shared.before_percent), percent_text(shared.after_percent))
        lines.append(f"alike in both: {shares[0]} of the motion before, {shares[1]} after")
    if min(len(compared.logs_before), len(compared.logs_after)) == 1:
        lines.append("what differs from one recording to the next, as temperature does, is in no interval")
    return lines


def _next(compared: Comparison) -> list[str]:
    change = compared.changes.get(RMS)
    if change is None:
        return ["record the reference too, and name its column in the axis file"]
    lines = [NEXT[change.verdict]]
    if min(len(compared.logs_before), len(compared.logs_after)) == 1:
        lines.append("to be surer, further logs of each side: `--before`, `--after`")
    return lines
