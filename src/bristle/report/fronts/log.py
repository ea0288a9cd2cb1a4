"""The first page of a log: whether it can be identified, what is in it, what to mend."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from bristle.core.typography import number
from bristle.core.variable import unit_of
from bristle.logs.passages import KINDS
from bristle.report.front import Front, Ruling, about, answered, fixed
from bristle.report.messages import sentence_of

if TYPE_CHECKING:
    from bristle.logs.log import Log
    from bristle.logs.passages import Passage
    from bristle.report.page import Picture

__all__ = ["log_front", "log_ruling"]


def log_ruling(log: Log, diagnostics: Sequence[Mapping[str, Any]]) -> Ruling:
    """Return whether a log can be identified, and why."""
    grave, doubts = (
        [sentence_of(diagnostic["code"]).means for diagnostic in diagnostics if diagnostic["severity"] == severity]
        for severity in ("error", "warning")
    )
    if log.effort is None:
        grave.insert(0, "it has no effort, and friction is an effort")
    reasons = tuple(dict.fromkeys([*grave, *doubts]))
    if grave:
        return Ruling("no", "Mend it first", reasons)
    return Ruling("with_care", "Use with care", reasons) if doubts else Ruling("usable", "It can be identified")


def log_front(log: Log, segments: Sequence[Passage], diagnostics: Sequence[Mapping[str, Any]], name: str, figure: Picture) -> Front:
    """Return the first page of a log."""
    ruling, source = log_ruling(log, diagnostics), log.source.name.strip("<>")
    duration = len(log) * log.sample_time
    advice = (sentence_of(diagnostic["code"]).advice for diagnostic in diagnostics if diagnostic["severity"] != "note")
    lines = [line for line in dict.fromkeys(advice) if line != "nothing"]
    then = [f"fit models to it: `bristle identify {source} --axis axis.toml --out results`"] if ruling.level != "no" else []
    return Front(
        f"{name}: a log",
        about(f"log {source}, {fixed(duration, 's')}"),
        *ruling[:2],
        ruling.reasons,
        answered(
            _contents(segments),
            lines or ["nothing is to be mended in the axis file"],
            _spans(log),
            _trust(log),
            then or ["mend it, then look at it again: `bristle log`"],
            third="How far, and how hard",
        ),
        figure,
        "check",
        "Nothing in it speaks against it.",
    )


def _contents(segments: Sequence[Passage]) -> list[str]:
    """Return how long the log does what, the longest first."""
    times: dict[str, float] = {}
    for segment in segments:
        times[segment.kind] = times.get(segment.kind, 0.0) + segment.end - segment.begin
    order = sorted(times.items(), key=lambda entry: -entry[1])
    return [f"{KINDS[kind]}: {fixed(time, 's')}" for kind, time in order] or ["it does not move"]


def _spans(log: Log) -> list[str]:
    lines = []
    for name, quantity in (("position", "length"), ("effort", "force")):
        channel = getattr(log, name)
        if channel is not None:
            span = float(channel.values.max() - channel.values.min())
            lines.append(f"{name} spans {fixed(span, unit_of(quantity, log.kind))} (column {channel.column})")
    return lines


def _trust(log: Log) -> list[str]:
    count = len(log.segments)
    lines = [f"{len(log)} samples in {count} {'stretch' if count == 1 else 'stretches'}"]
    lines.append(f"a sample every {fixed(log.sample_time, 's')} ({number(1.0 / log.sample_time)} Hz)")
    reference = "with a reference: the following error is told" if log.reference is not None else "without a reference"
    return [*lines, reference]
