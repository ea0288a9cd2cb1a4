"""The report of a motion to run: what it is made of, what it keeps to, what it would tell of the axis."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import groupby
from typing import TYPE_CHECKING, Any

from bristle.core.typography import number, scale_of, with_unit
from bristle.core.variable import unit_of
from bristle.excitation import PURPOSES
from bristle.report.messages import as_data, note_of
from bristle.report.model_tables import STATUS_WORDS
from bristle.report.page import Picture, picture, render
from bristle.report.table import Table

if TYPE_CHECKING:
    from bristle.excitation import Excitation, Piece
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


def piece_table(found: Excitation) -> Table:
    """Return what a motion is made of, alike pieces in one row."""
    kind = found.motion.kind
    rows = []
    placed = zip(found.motion.begins, found.motion.pieces, strict=True)
    for (purpose, name), group in groupby(placed, key=lambda one: (one[1].purpose, one[1].name)):
        members = list(group)
        begin, end = members[0][0], members[-1][0] + members[-1][1].duration
        pieces = [piece for _, piece in members]
        rows.append((
            purpose, name, str(len(pieces)), f"{begin:.1f} to {end:.1f}",
            _span([abs(one.amplitude) for one in pieces], unit_of("length", kind)),
            _span([one.speed for one in pieces], unit_of("length/time", kind)),
        ))  # fmt: skip
    return Table("The motion", ("Purpose", "Piece", "Count", "Time [s]", "Amplitude", "Speed"), rows)


def _span(values: list[float], unit: str) -> str:
    low, high = min(values), max(values)
    return with_unit(high, unit) if low == high else f"{with_unit(low, unit)} to {with_unit(high, unit)}"


def outlook_table(found: Excitation) -> Table:
    """Return what would be identified from the log of a motion, beside what was put in."""
    assert found.rehearsal is not None
    truth = found.rehearsal.truth
    heads = ("Parameter", "Meaning", "Put in", "Found", "Unit", "Error [%]", "95 % interval [%]", "Remark")
    rows = [
        _outlook(one, truth.get(one.name))
        for one in found.rehearsal.identification.best.estimates
        if one.status != "held"
    ]
    name = found.rehearsal.identification.best.name
    return Table(f"What the log would tell, by {name}", heads, rows).without_empty_columns()


def _outlook(one: Estimate, put_in: float | None) -> tuple[str, ...]:
    scale = scale_of(one.unit, one.value or put_in or 0.0)
    half = one.interval_percent
    error = _error_percent(one, put_in)
    return (
        one.name, one.description,
        "" if put_in is None else number(put_in * scale.factor),
        number(one.value * scale.factor), scale.unit or "–",
        "" if error is None else number(error, digits=2),
        "–" if half is None or not math.isfinite(half) else f"± {number(half, digits=2)}",
        "beyond its interval" if _misses(one, put_in) else STATUS_WORDS.get(one.status, one.status),
    )  # fmt: skip


def _misses(one: Estimate, put_in: float | None) -> bool:
    """Return whether a parameter that counts as identified lies further from what was put in than its interval."""
    error = _error_percent(one, put_in)
    if one.status != "identified" or error is None or one.interval_percent is None:
        return False
    return abs(error) > one.interval_percent + SMALL_PERCENT


def _error_percent(one: Estimate, put_in: float | None) -> float | None:
    return 100.0 * (one.value / put_in - 1.0) if put_in and math.isfinite(put_in) else None


def excitation_summary(
    found: Excitation, *, files: Mapping[str, str], identify: str, provenance: Mapping[str, str]
) -> dict[str, Any]:
    """Return a motion and its outlook in numbers; `files` are what was written, `identify` is the next command."""
    kind, motion = found.motion.kind, found.motion
    units = {name: unit_of(name, kind) for name in ("length", "length/time", "length/time^2", "force")}
    data: dict[str, Any] = {
        "axis": found.axis.name, "kind": kind, "files": dict(files), "identify": identify,
        "motion": {
            "duration": motion.duration, "sample_time": motion.sample_time, "samples": motion.time.size,
            "start": motion.start, "travel": float(motion.position.max() - motion.position.min()),
            "velocity_max": float(abs(motion.velocity).max()),
            "acceleration_max": float(abs(motion.acceleration).max()), "units": units,
        },
        "pieces": [_piece(one, begin) for one, begin in zip(motion.pieces, motion.begins, strict=True)],
        "assumed": found.prior.assumed, "notes": found.notes, "parameters": {}, "diagnostics": [],
        "provenance": provenance,
    }  # fmt: skip
    if found.rehearsal is not None:
        best = found.rehearsal.identification.best
        data |= {
            "model": best.name,
            "peak_effort": found.rehearsal.peak_effort,
            "diagnostics": as_data(best.diagnostics),
        }
        data["parameters"] = {
            one.name: {
                "put_in": found.rehearsal.truth.get(one.name), "value": one.value, "unit": one.unit,
                "error_percent": _error_percent(one, found.rehearsal.truth.get(one.name)),
                "interval_percent": one.interval_percent, "status": one.status, "note": note_of(one),
            }
            for one in best.estimates
        }  # fmt: skip
    return data


def _piece(one: Piece, begin: float) -> dict[str, Any]:
    return {
        "purpose": one.purpose, "name": one.name, "begin": float(begin), "duration": one.duration,
        "amplitude": one.amplitude, "speed": one.speed, "reference": one.reference.name,
    }  # fmt: skip


def excitation_report(found: Excitation, *, command: str, identify: str, provenance: Mapping[str, str]) -> str:
    """Return the report of a motion as one HTML page.

    Parameters
    ----------
    found : Excitation
        The motion, rehearsed.
    command : str
        The command that repeats it.
    identify : str
        The command that identifies the log.
    provenance : mapping of str to str
        Versions, files, checksums.
    """
    used = {one.purpose for one in found.motion.pieces}
    return render(
        "excitation.html",
        provenance=provenance,
        command=command,
        banner=None,
        axis_name=found.axis.name,
        verdict=_verdict(found),
        purposes=[(name, one.tells) for name, one in PURPOSES.items() if name in used],
        pieces=piece_table(found),
        outlook=None if found.rehearsal is None else outlook_table(found),
        limits=_limits(found),
        notes=found.notes,
        identify=identify,
        pictures=_pictures(found),
    )


def _verdict(found: Excitation) -> list[str]:
    motion, length = found.motion, unit_of("length", found.motion.kind)
    span = with_unit(float(motion.position.max() - motion.position.min()), length)
    told = [f"The motion takes {motion.duration:.3g} s and stays within {span}."]
    if found.rehearsal is None:
        return told
    rehearsal = found.rehearsal
    estimates = rehearsal.identification.best.estimates
    missed = [one.name for one in estimates if _misses(one, rehearsal.truth.get(one.name))]
    known = [one.name for one in estimates if one.status == "identified" and one.name not in missed]
    open_ = [one.name for one in estimates if one.status in ("unidentifiable", "at_edge")]
    for words, names in (("identify", known), ("not identify", open_), ("give beyond its interval", missed)):
        if names:
            told.append(f"Its log would {words} {', '.join(names)}.")
    how = "in the loop of its controller" if rehearsal.loop else "along the motion itself, as no stable loop is known"
    told.append(
        f"This was rehearsed {how}, with friction that scatters by 5 % from one reversal to the next, 0.5 % noise of "
        "the effort and the encoder of the axis; one rehearsal: the error is what an interval should cover."
    )
    if found.room.presliding is not None and rehearsal.lag > found.room.presliding:
        told.append(
            f"The controller follows the loops before sliding no closer than {with_unit(rehearsal.lag, length)}: they "
            "are smaller or larger than designed. Raise its gains for this motion, or add integral action."
        )
    limit = found.axis.effort_limit
    if limit is not None and rehearsal.peak_effort > limit:
        told.append("The effort reaches the limit of the drive: lower the limit of the acceleration, or the travel.")
    return told


def _limits(found: Excitation) -> list[tuple[str, str]]:
    motion, room, kind = found.motion, found.room, found.motion.kind
    rows = []
    for word, quantity, value, limit in (
        ("Travel", "length", motion.position.max() - motion.position.min(), room.travel),
        ("Velocity", "length/time", abs(motion.velocity).max(), room.velocity),
        ("Acceleration", "length/time^2", abs(motion.acceleration).max(), room.acceleration),
    ):
        told = with_unit(float(value), unit_of(quantity, kind))
        rows.append((word, told if limit is None else f"{told} of {with_unit(limit, unit_of(quantity, kind))} allowed"))
    if found.rehearsal is not None:
        rows.append(("Effort, as believed", with_unit(found.rehearsal.peak_effort, unit_of("force", kind))))
    return rows


def _pictures(found: Excitation) -> dict[str, Picture]:
    from bristle import figures

    drawn = {"motion": picture("motion", lambda: figures.motion(found.motion), *CAPTIONS["motion"])}
    rehearsal = found.rehearsal
    if rehearsal is not None:
        drawn["expected"] = picture(
            "expected", lambda: figures.expected(found.motion, rehearsal.friction), *CAPTIONS["expected"]
        )
    return drawn
