"""The report of a motion to run: what it is made of, what it keeps to, what it would tell of the axis."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import groupby
from typing import TYPE_CHECKING, Any

from bristle.core.typography import number, scale_of, with_unit
from bristle.core.variable import unit_of
from bristle.excitation import PURPOSES
from bristle.report.fronts.excitation import excitation_front, excitation_ruling
from bristle.report.messages import as_data, note_of
from bristle.report.model_tables import STATUS_WORDS
from bristle.report.page import Picture, picture, render
from bristle.report.table import Table

if TYPE_CHECKING:
    from bristle.excitation import Excitation, ExcitationPiece
    from bristle.identification.result import Estimate

__all__ = ["excitation_report", "excitation_summary", "outlook_table", "piece_table"]

SMALL_PERCENT = 2.0  # an error that nobody minds
CAPTIONS = {
    "motion": (
        "Position over time, for each purpose",
        "Position from the start of the motion; each panel has its own scale. The loops before sliding are so small "
        "that only the encoder sees them.",
    ),
    "expected": (
        "Friction expected over position and over speed",
        "What the motion would show if the axis were what it is believed to be: loops before sliding over position, "
        "and friction over the speed of the steady slides. Where the loops do not close at their ends into sliding, "
        "the pre-sliding distance is larger than believed.",
    ),
}


def piece_table(excitation: Excitation) -> Table:
    """Return what a motion is made of, alike pieces in one row."""
    kind = excitation.motion.kind
    rows = []
    placed = zip(excitation.motion.begins, excitation.motion.pieces, strict=True)
    for (purpose, name), group in groupby(placed, key=lambda entry: (entry[1].purpose, entry[1].name)):
        members = list(group)
        begin, end = members[0][0], members[-1][0] + members[-1][1].duration
        pieces = [piece for _, piece in members]
        rows.append(
            (
                purpose,
                name,
                str(len(pieces)),
                f"{begin:.1f} to {end:.1f}",
                _span([abs(piece.amplitude) for piece in pieces], unit_of("length", kind)),
                _span([piece.speed for piece in pieces], unit_of("length/time", kind)),
            )
        )
    return Table("The motion", ("Purpose", "Piece", "Count", "Time [s]", "Amplitude", "Speed"), rows)


def _span(values: list[float], unit: str) -> str:
    low, high = min(values), max(values)
    return with_unit(high, unit) if low == high else f"{with_unit(low, unit)} to {with_unit(high, unit)}"


def outlook_table(excitation: Excitation) -> Table:
    """Return what would be identified from the log of a motion, beside what was put in."""
    assert excitation.rehearsal is not None
    truth = excitation.rehearsal.truth
    heads = ("Parameter", "Meaning", "Put in", "Found", "Unit", "Error [%]", "95 % interval [%]", "Remark")
    rows = [
        _outlook(estimate, truth.get(estimate.name))
        for estimate in excitation.rehearsal.identification.best.estimates
        if estimate.status != "held"
    ]
    name = excitation.rehearsal.identification.best.name
    return Table(f"What the log would tell, by {name}", heads, rows).without_empty_columns()


def _outlook(estimate: Estimate, put_in: float | None) -> tuple[str, ...]:
    scale = scale_of(estimate.unit, estimate.value or put_in or 0.0)
    half = estimate.interval_percent
    error = _error_percent(estimate, put_in)
    return (
        estimate.name,
        estimate.description,
        "" if put_in is None else number(put_in * scale.factor),
        number(estimate.value * scale.factor),
        scale.unit or "–",
        "" if error is None else number(error, digits=2),
        "–" if half is None or not math.isfinite(half) else f"± {number(half, digits=2)}",
        "beyond its interval" if _misses(estimate, put_in) else STATUS_WORDS.get(estimate.status, estimate.status),
    )


def _misses(estimate: Estimate, put_in: float | None) -> bool:
    """Return whether a parameter that counts as identified lies further from what was put in than its interval."""
    error = _error_percent(estimate, put_in)
    if estimate.status != "identified" or error is None or estimate.interval_percent is None:
        return False
    return abs(error) > estimate.interval_percent + SMALL_PERCENT


def _missed(excitation: Excitation) -> list[str]:
    """Return the parameters that the rehearsal gives beyond their intervals."""
    if (rehearsal := excitation.rehearsal) is None:
        return []
    estimates = rehearsal.identification.best.estimates
    return [estimate.name for estimate in estimates if _misses(estimate, rehearsal.truth.get(estimate.name))]


def _error_percent(estimate: Estimate, put_in: float | None) -> float | None:
    return 100.0 * (estimate.value / put_in - 1.0) if put_in and math.isfinite(put_in) else None


def excitation_summary(excitation: Excitation, *, files: Mapping[str, str], identify: str, provenance: Mapping[str, str]) -> dict[str, Any]:
    """Return a motion and its outlook in numbers; `files` are what was written, `identify` is the next command."""
    kind, motion = excitation.motion.kind, excitation.motion
    units = {name: unit_of(name, kind) for name in ("length", "length/time", "length/time^2", "force")}
    data: dict[str, Any] = {
        "axis": excitation.axis.name,
        "kind": kind,
        "files": dict(files),
        "identify": identify,
        "verdict": excitation_ruling(excitation, _missed(excitation)).as_data(),
        "motion": {
            "duration": motion.duration,
            "sample_time": motion.sample_time,
            "samples": motion.time.size,
            "start": motion.start,
            "travel": float(motion.position.max() - motion.position.min()),
            "velocity_max": float(abs(motion.velocity).max()),
            "acceleration_max": float(abs(motion.acceleration).max()),
            "units": units,
        },
        "pieces": [_piece(piece, begin) for piece, begin in zip(motion.pieces, motion.begins, strict=True)],
        "assumed": excitation.prior.assumed,
        "notes": excitation.notes,
        "parameters": {},
        "diagnostics": [],
        "provenance": provenance,
    }
    if excitation.rehearsal is not None:
        best = excitation.rehearsal.identification.best
        data |= {"model": best.name, "peak_effort": excitation.rehearsal.peak_effort, "diagnostics": as_data(best.diagnostics)}
        data["parameters"] = {
            estimate.name: {
                "put_in": excitation.rehearsal.truth.get(estimate.name),
                "value": estimate.value,
                "unit": estimate.unit,
                "error_percent": _error_percent(estimate, excitation.rehearsal.truth.get(estimate.name)),
                "interval_percent": estimate.interval_percent,
                "status": estimate.status,
                "note": note_of(estimate),
            }
            for estimate in best.estimates
        }
    return data


def _piece(piece: ExcitationPiece, begin: float) -> dict[str, Any]:
    return {
        "purpose": piece.purpose,
        "name": piece.name,
        "begin": float(begin),
        "duration": piece.duration,
        "amplitude": piece.amplitude,
        "speed": piece.speed,
        "reference": piece.reference.name,
    }


def excitation_report(excitation: Excitation, *, command: str, identify: str, provenance: Mapping[str, str]) -> str:
    """Return the report of a motion as one HTML page."""
    pictures = _pictures(excitation)
    used = {piece.purpose for piece in excitation.motion.pieces}
    return render(
        "excitation.html",
        provenance=provenance,
        command=command,
        banner=None,
        axis_name=excitation.axis.name,
        front=excitation_front(excitation, identify, _missed(excitation), pictures["motion"]),
        verdict=_verdict(excitation),
        purposes=[(name, purpose.tells) for name, purpose in PURPOSES.items() if name in used],
        pieces=piece_table(excitation),
        outlook=None if excitation.rehearsal is None else outlook_table(excitation),
        limits=_limits(excitation),
        notes=excitation.notes,
        identify=identify,
        pictures=pictures,
    )


def _verdict(excitation: Excitation) -> list[str]:
    motion, length = excitation.motion, unit_of("length", excitation.motion.kind)
    span = with_unit(float(motion.position.max() - motion.position.min()), length)
    lines = [f"The motion takes {motion.duration:.3g} s and stays within {span}."]
    if excitation.rehearsal is None:
        return lines
    rehearsal = excitation.rehearsal
    estimates = rehearsal.identification.best.estimates
    missed = _missed(excitation)
    identified = [estimate.name for estimate in estimates if estimate.status == "identified" and estimate.name not in missed]
    open_ = [estimate.name for estimate in estimates if estimate.status in ("unidentifiable", "at_edge")]
    for words, names in (("identify", identified), ("not identify", open_), ("give beyond its interval", missed)):
        if names:
            lines.append(f"Its log would {words} {', '.join(names)}.")
    setting = "in the loop of its controller" if rehearsal.loop else "along the motion itself, as no stable loop is known"
    lines.append(
        f"This was rehearsed {setting}, with friction that scatters by 5 % from one reversal to the next, 0.5 % noise "
        "of the effort and the encoder of the axis; one rehearsal: the error is what an interval should cover."
    )
    if excitation.limits.presliding is not None and rehearsal.lag > excitation.limits.presliding:
        lines.append(
            f"The controller follows the loops before sliding no closer than {with_unit(rehearsal.lag, length)}: they "
            "are smaller or larger than designed. Raise its gains for this motion, or add integral action."
        )
    limit = excitation.axis.effort_limit
    if limit is not None and rehearsal.peak_effort > limit:
        lines.append("The effort reaches the limit of the drive: lower the limit of the acceleration, or the travel.")
    return lines


def _limits(excitation: Excitation) -> list[tuple[str, str]]:
    motion, limits, kind = excitation.motion, excitation.limits, excitation.motion.kind
    rows = []
    for word, quantity, value, limit in (
        ("Travel", "length", motion.position.max() - motion.position.min(), limits.travel),
        ("Velocity", "length/time", abs(motion.velocity).max(), limits.velocity),
        ("Acceleration", "length/time^2", abs(motion.acceleration).max(), limits.acceleration),
    ):
        amount = with_unit(float(value), unit_of(quantity, kind))
        rows.append((word, amount if limit is None else f"{amount} of {with_unit(limit, unit_of(quantity, kind))} allowed"))
    if excitation.rehearsal is not None:
        rows.append(("Effort, as believed", with_unit(excitation.rehearsal.peak_effort, unit_of("force", kind))))
    return rows


def _pictures(excitation: Excitation) -> dict[str, Picture]:
    from bristle import figures

    drawn = {"motion": picture("motion", lambda: figures.motion(excitation.motion), *CAPTIONS["motion"])}
    rehearsal = excitation.rehearsal
    if rehearsal is not None:
        drawn["expected"] = picture("expected", lambda: figures.expected(excitation.motion, rehearsal.friction), *CAPTIONS["expected"])
    return drawn
