"""The first page of a motion to run: whether to run it, what it takes of the axis, what its log would tell."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from bristle.core.typography import number
from bristle.core.variable import unit_of
from bristle.report.front import Front, Ruling, about, answered, fixed, length_text

if TYPE_CHECKING:
    from bristle.excitation import Excitation
    from bristle.identification.result import Estimate
    from bristle.report.page import Picture

__all__ = ["excitation_front", "excitation_ruling"]


FULL_PERCENT = 100.0  # percent: an interval as wide as the value


def excitation_ruling(excitation: Excitation, missed: Sequence[str]) -> Ruling:
    """Return whether to run a motion, and why."""
    rehearsal, limit = excitation.rehearsal, excitation.axis.effort_limit
    if rehearsal is None:
        return Ruling("with_care", "Run it, with care", ("it was not rehearsed",))
    reasons = []
    open_ = [estimate.name for estimate in _estimates(excitation) if estimate.status in ("unidentifiable", "at_edge")]
    reasons += [f"its log would not identify {', '.join(open_)}"] if open_ else []
    vague = [estimate.name for estimate in _sure(excitation, sure=False)]
    reasons += [f"it would hardly tell {', '.join(vague)}: intervals as wide as the values"] if vague else []
    reasons += [f"it would give {', '.join(missed)} beyond the interval"] if missed else []
    if excitation.limits.presliding is not None and rehearsal.lag > excitation.limits.presliding:
        lag = length_text(rehearsal.lag, excitation.motion.kind)
        reasons.append(f"the controller follows the loops before sliding no closer than {lag}")
    if limit is not None and rehearsal.peak_effort > limit:
        return Ruling("no", "Do not run it", ("the effort reaches the limit of the drive", *reasons))
    return Ruling("with_care", "Run it, with care", tuple(reasons)) if reasons else Ruling("usable", "Run it")


def _estimates(excitation: Excitation) -> list[Estimate]:
    if excitation.rehearsal is None:
        return []
    return [estimate for estimate in excitation.rehearsal.identification.best.estimates if estimate.status != "held"]


def _sure(excitation: Excitation, *, sure: bool = True) -> list[Estimate]:
    """Return the parameters that would be identified within their own size, or those that would not."""
    truth = {} if excitation.rehearsal is None else excitation.rehearsal.truth
    identified = [estimate for estimate in _estimates(excitation) if estimate.status == "identified" and truth.get(estimate.name) != 0.0]
    return [estimate for estimate in identified if ((estimate.interval_percent or 0.0) < FULL_PERCENT) == sure]


def excitation_front(excitation: Excitation, identify: str, missed: Sequence[str], figure: Picture) -> Front:
    """Return the first page of a motion to run; `identify` is the command for its log."""
    ruling, motion = excitation_ruling(excitation, missed), excitation.motion
    return Front(
        f"{excitation.axis.name}: a motion to run",
        about(f"{motion.duration:.3g} s", "for the controller of the axis"),
        *ruling[:2],
        ruling.reasons,
        answered(
            _quality(excitation),
            ["set points: `motion.csv`", "or a list of moves: `moves.csv`", "or a program for an NC: `motion.nc`"],
            _cost(excitation),
            _trust(excitation),
            [f"run it, log what the axis file names, then `{identify}`"],
        ),
        figure,
        "assumptions",
        "In the rehearsal its log identifies everything.",
    )


def _quality(excitation: Excitation) -> list[str]:
    identified = _sure(excitation)
    if not identified:
        return ["nothing that its log would surely identify"]
    widths = ", ".join(
        estimate.name if estimate.interval_percent is None else f"{estimate.name} ± {number(estimate.interval_percent, digits=2)} %"
        for estimate in identified
    )
    return ["its log would identify, with 95 % intervals:", widths]


def _cost(excitation: Excitation) -> list[str]:
    motion, limits, kind = excitation.motion, excitation.limits, excitation.motion.kind
    lines = [f"{motion.duration:.3g} s of the axis"]
    for word, quantity, value, limit in (
        ("travel", "length", motion.position.max() - motion.position.min(), limits.travel),
        ("velocity", "length/time", abs(motion.velocity).max(), limits.velocity),
        ("acceleration", "length/time^2", abs(motion.acceleration).max(), limits.acceleration),
    ):
        unit = unit_of(quantity, kind)
        lines.append(f"{word} {fixed(float(value), unit)}" + (f" of {fixed(limit, unit)} allowed" if limit else ""))
    if excitation.rehearsal is not None:
        unit, limit = unit_of("force", kind), excitation.axis.effort_limit
        allowed = "" if limit is None else f" of {fixed(limit, unit)}"
        lines.append(f"effort up to {fixed(excitation.rehearsal.peak_effort, unit)}{allowed}, as believed")
    return lines


def _trust(excitation: Excitation) -> list[str]:
    if excitation.rehearsal is None:
        return ["nothing was rehearsed"]
    loop = "in the loop of its controller" if excitation.rehearsal.loop else "along the motion: no stable loop is known"
    believed = len(excitation.prior.assumed)
    lines = [f"one rehearsal, {loop}, with the encoder of the axis and 5 % of scatter"]
    return [*lines, f"{believed} {'value was' if believed == 1 else 'values were'} assumed, below"] if believed else lines
