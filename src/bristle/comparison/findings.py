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
ALL_PERCENT = 99.0  # percent of a motion that is all of it
FEW = 6  # cycles of a side
NOTED = 2.0  # cycles that count as one, from where on it is said
ALIKE = 1e-3  # relative difference of sample times that is none


@dataclass(frozen=True)
class Findings:
    """What diagnostics of a comparison are made of."""

    before: Sequence[Log]
    after: Sequence[Log]
    shared: Shared
    tells_friction: bool
    reason: InputError | None
    kind: Kind
    widths: Sequence[float]


def findings_of(findings: Findings) -> tuple[Diagnostic, ...]:
    """Return what may mislead, then what the comparison rests on."""
    kind = findings.kind

    def about(code: str, severity: Severity = "warning", numbers: Mapping[str, Number] | None = None) -> Diagnostic:
        return Diagnostic(code, "", severity, numbers or {}, kind)

    diagnostics = [*_about_channels(findings), *_about_motion(findings)]
    if all(log.effort is not None for log in (*findings.before, *findings.after)) and not findings.tells_friction:
        reason = str(findings.reason) if findings.reason else ""
        diagnostics.append(about("friction_not_told", numbers={"why": reason}))
    times = [log.sample_time for side in (findings.before, findings.after) for log in side]
    if max(times) > min(times) * (1.0 + ALIKE):
        diagnostics.append(about("sample_times_differ", "note", {"longest": max(times)}))
    if len(findings.before) == 1 or len(findings.after) == 1:
        diagnostics.append(about("one_recording", "note"))
    return tuple(sorted(diagnostics, key=lambda diagnostic_: diagnostic_.severity == "note"))


def _about_channels(findings: Findings) -> list[Diagnostic]:
    diagnostics = []
    sides = {"before": findings.before, "after": findings.after}
    for channel, code in (("reference", "no_reference"), ("effort", "no_effort")):
        lacking = tuple(name for name, logs in sides.items() if any(getattr(log, channel) is None for log in logs))
        if lacking:
            diagnostics.append(Diagnostic(code, "", "warning", {"sides": lacking}, findings.kind))
    return diagnostics


def _about_motion(findings: Findings) -> list[Diagnostic]:
    shared, diagnostics = findings.shared, []
    if min(shared.before_percent, shared.after_percent) < ALL_PERCENT:
        shares: dict[str, Number] = {"before_percent": shared.before_percent, "after_percent": shared.after_percent}
        diagnostics.append(Diagnostic("motions_differ", numbers=shares, kind=findings.kind))
    if not shared.complete:
        diagnostics.append(Diagnostic("pieces_for_cycles", kind=findings.kind))
    fewest = min(shared.cycles_before, shared.cycles_after)
    if not findings.widths:
        diagnostics.append(Diagnostic("no_interval", kind=findings.kind))
    else:
        if shared.complete and fewest < FEW:
            diagnostics.append(Diagnostic("few_cycles", numbers={"cycles": fewest}, kind=findings.kind))
        if min(findings.widths) < IDENTICAL:
            diagnostics.append(Diagnostic("cycles_identical", kind=findings.kind))
    if shared.as_one > NOTED:
        diagnostics.append(Diagnostic("cycles_alike", "", "note", {"cycles": shared.as_one}, findings.kind))
    return diagnostics
