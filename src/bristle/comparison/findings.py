"""What there is to know of a comparison besides its numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from bristle.comparison.result import Shared
from bristle.core.diagnostic import Diagnostic, Number, Severity
from bristle.core.errors import InputError
from bristle.core.variable import Kind
from bristle.logs.log import Log

__all__ = ["Findings", "findings_of"]

IDENTICAL = 1e-6  # of a value: an interval so narrow is that of cycles without scatter
WHOLE = 99.0  # percent of a motion that is all of it
FEW = 6  # cycles of a side
NOTED = 2.0  # cycles that count as one, from where on it is said
ALIKE = 1e-3  # relative difference of sample times that is none


@dataclass(frozen=True)
class Findings:
    """What diagnostics of a comparison are made of.

    Parameters
    ----------
    before, after : sequence of Log
        The two sides.
    shared : Shared
        What was compared.
    tells_friction : bool
        Whether friction was told.
    why : InputError or None
        Why a log tells no friction.
    kind : {"translational", "rotational"}
        Kind of axis.
    widths : sequence of float
        Half-width of each interval over the value before.
    """

    before: Sequence[Log]
    after: Sequence[Log]
    shared: Shared
    tells_friction: bool
    why: InputError | None
    kind: Kind
    widths: Sequence[float]


def findings_of(findings: Findings) -> tuple[Diagnostic, ...]:
    """Return what may mislead, then what the comparison rests on."""
    kind = findings.kind

    def one(code: str, severity: Severity = "warning", numbers: Mapping[str, Number] | None = None) -> Diagnostic:
        return Diagnostic(code, "", severity, numbers or {}, kind)

    found = [*_about_channels(findings), *_about_motion(findings)]
    if all(log.effort is not None for log in (*findings.before, *findings.after)) and not findings.tells_friction:
        why = str(findings.why) if findings.why else ""
        found.append(one("friction-not-told", numbers={"why": why}))
    times = [log.sample_time for side in (findings.before, findings.after) for log in side]
    if max(times) > min(times) * (1.0 + ALIKE):
        found.append(one("sample-times-differ", "note", {"longest": max(times)}))
    if len(findings.before) == 1 or len(findings.after) == 1:
        found.append(one("one-recording", "note"))
    return tuple(sorted(found, key=lambda each: each.severity == "note"))


def _about_channels(findings: Findings) -> list[Diagnostic]:
    found = []
    sides = {"before": findings.before, "after": findings.after}
    for channel, code in (("reference", "no-reference"), ("effort", "no-effort")):
        lacking = tuple(name for name, logs in sides.items() if any(getattr(log, channel) is None for log in logs))
        if lacking:
            found.append(Diagnostic(code, "", "warning", {"sides": lacking}, findings.kind))
    return found


def _about_motion(findings: Findings) -> list[Diagnostic]:
    shared, found = findings.shared, []
    if min(shared.before_percent, shared.after_percent) < WHOLE:
        shares: dict[str, Number] = {"before_percent": shared.before_percent, "after_percent": shared.after_percent}
        found.append(Diagnostic("motions-differ", numbers=shares, kind=findings.kind))
    if not shared.whole:
        found.append(Diagnostic("pieces-for-cycles", kind=findings.kind))
    fewest = min(shared.cycles_before, shared.cycles_after)
    if not findings.widths:
        found.append(Diagnostic("no-interval", kind=findings.kind))
    else:
        if shared.whole and fewest < FEW:
            found.append(Diagnostic("few-cycles", numbers={"cycles": fewest}, kind=findings.kind))
        if min(findings.widths) < IDENTICAL:
            found.append(Diagnostic("cycles-identical", kind=findings.kind))
    if shared.as_one > NOTED:
        found.append(Diagnostic("cycles-alike", "", "note", {"cycles": shared.as_one}, findings.kind))
    return found
