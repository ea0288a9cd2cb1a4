"""The report of a motion to run: verdict, pieces, limits, and the parameters that its log would determine."""

import math
import shlex
from collections.abc import Mapping
from itertools import groupby
from typing import Any, NamedTuple

from bristle.core import Content, number, scale_of, unit_of, with_unit
from bristle.files import Results, origins_of_code, provenance
from bristle.identification import OPEN, Estimate
from bristle.logs import Log
from bristle.prediction.excitation import NARROWER, Excitation, excite
from bristle.report.cards import Card, Step, quantity_text
from bristle.report.messages import as_data, note_of, picked
from bristle.report.model_tables import STATUS_WORDS, half_text
from bristle.report.page import Block, Front, Ruling, Section, about, report_page
from bristle.report.results import write_report
from bristle.report.sweep import sweep_table
from bristle.report.table import Table, capital, fixed, length_text, span_text

EXCEEDED = {
    "effort": "the effort exceeds the limit of the drive",
    "following error": "the following error exceeds the limit of the axis",
}
FILES = {"motion": "motion.csv", "moves": "moves.csv", "program": "motion.nc", "axis": "axis.toml"}
"""Names of the files of a motion, by their content."""


class DesignedMotion(NamedTuple):
    """A motion to run on an axis, with its axis file and model file."""

    excitation: Excitation
    axis_file: Content
    model_file: Content | None
    command: str
    log: Log | None = None

    @property
    def provenance(self) -> dict[str, str]:
        """Versions, files, checksums."""
        code = origins_of_code([self.excitation.prior.friction.component])
        return provenance(
            self.command, axis=self.axis_file, model=self.model_file, log=self.log, code=code
        )

    def next_command(self, axis: str) -> str:
        """Return the command that identifies the log of the motion, with the axis file of this name."""
        rehearsal = self.excitation.rehearsal
        model = (
            rehearsal.identification.best.name if rehearsal else self.excitation.prior.friction.name
        )
        presliding = any(piece.purpose == "presliding" for piece in self.excitation.motion.pieces)
        if presliding and model != "maxwell_slip":
            # Nested loops show whether the contact has non-local memory.
            model += ",maxwell_slip"
        # The log at hand takes part while it is better for a parameter, and alone if the motion is worse.
        logs = ["LOG"] * (not self.excitation.is_worse) + [
            str(log.source) for log in [self.log] if log and _wider(self.excitation)
        ]
        return shlex.join(
            ["bristle", "identify", *logs, "--axis", axis, "--model", model, "--out", "results"]
        )

    def summary(self, files: dict[str, str], identify: str) -> dict[str, Any]:
        """Return the motion in numbers, with the names of its files and the next command."""
        return excitation_summary(
            self.excitation, files=files, identify=identify, provenance=self.provenance
        )

    def write(self, folder: Results, identify: str) -> None:
        """Write the motion, its moves and its report into a folder of results, with the next command."""
        page = excitation_report(
            self.excitation, command=self.command, identify=identify, provenance=self.provenance
        )
        self.excitation.write(folder / FILES["motion"])
        for name, text in zip(("moves", "program"), self.excitation.moves, strict=True):
            folder.write(FILES[name], text)
        folder.write(FILES["axis"], self.axis_file.data)
        write_report(folder, page, self.summary(FILES, identify))


def designed_motion(
    axis_file: Content,
    *,
    command: str,
    model_file: Content | None = None,
    log: Log | None = None,
    **options: Any,
) -> DesignedMotion:
    """Return the motion to run on an axis."""
    return DesignedMotion(
        excite(axis_file, model=model_file, log=log, **options), axis_file, model_file, command, log
    )


def excitation_report(excitation: Excitation, *, identify: str, **options: Any) -> str:
    """Return the report of a motion as an HTML page; `identify` is the command for its log, options as of `report_page`."""
    rehearsal = excitation.rehearsal
    demands, basis = _limits(excitation), ""
    if rehearsal is not None:
        effort = (
            "effort by the assumed model",
            rehearsal.peak_effort,
            excitation.axis.effort_limit,
        )
        demands.append((*effort, unit_of("force", excitation.motion.kind)))
        if rehearsal.loop:
            error = (
                "following error in the loop",
                rehearsal.following_error,
                excitation.axis.following_error_limit,
            )
            demands.append((*error, unit_of("length", excitation.motion.kind)))
        loop = (
            "in the loop of its controller"
            if rehearsal.loop
            else "along the motion, without a stable loop"
        )
        basis = f"One rehearsal, {loop}. Its encoder is that of the axis, and its friction scatters by 5 %."
    limits = [
        (
            capital(word),
            with_unit(value, unit)
            + ("" if limit is None else f" of {with_unit(limit, unit)} allowed"),
        )
        for word, value, limit, unit in demands
    ]
    motion = [
        "Set points: `motion.csv`. The same motion as a list of moves: `moves.csv`. As a program for an NC: `motion.nc`.",
        Block("facts", excitation.purposes, ("Purpose of each part",)),
        piece_table(excitation),
        Block("facts", limits, ("Demands on the axis",)),
    ]
    sections = [
        Section("motion", "The motion", motion, "Motion"),
        Section("outlook", "Expected results", [basis, *outlook_tables(excitation)], "Outlook"),
        Section(
            "assumptions", "Omissions and assumptions", [Block("items", excitation.notes)], "Limits"
        ),
    ]
    facts = {
        "motion": excitation.motion,
        "expected": None if rehearsal is None else rehearsal.friction,
    }
    return report_page("excitation", facts, _front(excitation, identify), sections, **options)


def piece_table(excitation: Excitation) -> Table:
    """Return the pieces of a motion, with equal pieces in one row."""
    kind, rows = excitation.motion.kind, []
    placed = zip(excitation.motion.begins, excitation.motion.pieces, strict=True)
    for (purpose, name), group in groupby(
        placed, key=lambda entry: (entry[1].purpose, entry[1].name)
    ):
        members = list(group)
        begin, end = members[0][0], members[-1][0] + members[-1][1].duration
        amplitudes, speeds = (
            [abs(piece.amplitude) for _, piece in members],
            [piece.speed for _, piece in members],
        )
        spans = (
            span_text(amplitudes, unit_of("length", kind)),
            span_text(speeds, unit_of("length/time", kind)),
        )
        rows.append((purpose, name, str(len(members)), f"{begin:.1f} to {end:.1f}", *spans))
    return Table(
        "The motion", ("Purpose", "Piece", "Count", "Time [s]", "Amplitude", "Speed"), rows
    )


def outlook_tables(excitation: Excitation) -> list[Table]:
    """Return the results of the rehearsal: parameters, and stiffness and damping from sweeps."""
    if excitation.rehearsal is None:
        return []
    sweep = sweep_table(excitation.rehearsal.identification)
    return [outlook_table(excitation), *([sweep] if sweep else [])]


def outlook_table(excitation: Excitation) -> Table:
    """Return the parameters identified in the rehearsal, with their true values."""
    assert excitation.rehearsal is not None
    rows = []
    for estimate in _sought(excitation):
        put_in = excitation.rehearsal.truth.get(estimate.name)
        half, error = estimate.interval_percent, _error(estimate, put_in)
        at_zero = put_in == 0.0
        known = estimate.status == "identified" and (at_zero or (half or 0.0) < OPEN)
        scale = scale_of(
            estimate.unit, estimate.value if known and estimate.value else put_in or 0.0
        )
        rows.append(
            {
                "Parameter": estimate.name,
                "Meaning": estimate.description,
                "True value": "" if put_in is None else number(put_in * scale.factor),
                "Identified": ("≈ 0" if at_zero else number(estimate.value * scale.factor))
                if known
                else "not identified",
                "Unit": scale.unit or "–",
                "Error [%]": "" if error is None or not known else number(error, digits=2),
                "95 % interval [%]": f"± {number(half, digits=2)}"
                if half is not None and known and not at_zero
                else "–",
                "Log at hand": half_text(excitation.half_widths[estimate.name][0])
                if estimate.name in excitation.half_widths
                else "",
                "Remark": "true value outside the interval"
                if _misses(estimate, put_in)
                else STATUS_WORDS.get(estimate.status, estimate.status),
            }
        )
    return Table.of(
        f"Expected results, by a fit of {excitation.rehearsal.identification.best.name}", rows
    ).without_empty_columns()


def _error(estimate: Estimate, put_in: float | None) -> float | None:
    """Return the error of a parameter of the rehearsal [%]."""
    return 100.0 * (estimate.value / put_in - 1.0) if put_in and math.isfinite(put_in) else None


def _misses(estimate: Estimate, put_in: float | None) -> bool:
    """Return whether an identified parameter misses its true value by more than its interval."""
    error, half = _error(estimate, put_in), estimate.interval_percent
    # Errors up to 2 % do not matter.
    return (
        estimate.status == "identified"
        and error is not None
        and half is not None
        and abs(error) > half + 2.0
    )


def _sought(excitation: Excitation) -> list[Estimate]:
    """Return the parameters that the rehearsal fitted."""
    estimates = (
        [] if excitation.rehearsal is None else excitation.rehearsal.identification.best.estimates
    )
    return [estimate for estimate in estimates if estimate.status != "held"]


def _sure(excitation: Excitation, *, sure: bool = True) -> list[Estimate]:
    """Return the identified parameters with intervals smaller than their values, or the others."""
    truth = {} if excitation.rehearsal is None else excitation.rehearsal.truth
    identified = [
        estimate
        for estimate in _sought(excitation)
        if estimate.status == "identified" and truth.get(estimate.name) != 0.0
    ]
    return [
        estimate for estimate in identified if ((estimate.interval_percent or 0.0) < OPEN) == sure
    ]


def _limits(excitation: Excitation) -> list[tuple[str, float, float | None, str]]:
    """Return the demands of a motion on an axis: word, value, limit or None, and unit."""
    motion, limits, kind = excitation.motion, excitation.limits, excitation.motion.kind
    return [
        (
            "travel",
            float(motion.position.max() - motion.position.min()),
            limits.travel,
            unit_of("length", kind),
        ),
        (
            "velocity",
            float(abs(motion.velocity).max()),
            limits.velocity,
            unit_of("length/time", kind),
        ),
        (
            "acceleration",
            float(abs(motion.acceleration).max()),
            limits.acceleration,
            unit_of("length/time^2", kind),
        ),
    ]


def excitation_summary(
    excitation: Excitation,
    *,
    files: Mapping[str, str],
    identify: str,
    provenance: Mapping[str, str],
) -> dict[str, Any]:
    """Return a motion and its expected results in numbers, with its `files` and the next command `identify`."""
    kind, motion, rehearsal = excitation.motion.kind, excitation.motion, excitation.rehearsal
    travel, velocity, acceleration = (value for _, value, _, _ in _limits(excitation))
    data: dict[str, Any] = {
        "axis": excitation.axis.name,
        "kind": kind,
        "files": dict(files),
        "identify": identify,
        "verdict": excitation_ruling(excitation).as_data(),
        "motion": {
            **picked(motion, "duration", "sample_time", "start"),
            "samples": motion.time.size,
            "travel": travel,
            "velocity_max": velocity,
            "acceleration_max": acceleration,
            "units": {
                name: unit_of(name, kind)
                for name in ("length", "length/time", "length/time^2", "force")
            },
        },
        "pieces": [
            picked(piece, "purpose", "name", "duration", "amplitude", "speed")
            | {"begin": float(begin), "reference": piece.reference.name}
            for piece, begin in zip(motion.pieces, motion.begins, strict=True)
        ],
        "assumed": excitation.prior.assumed,
        "notes": excitation.notes,
        "parameters": {},
        "diagnostics": [],
        "provenance": provenance,
    }
    if rehearsal is None:
        return data
    best = rehearsal.identification.best
    data |= {
        "model": best.name,
        "peak_effort": rehearsal.peak_effort,
        "diagnostics": as_data(best.diagnostics),
        "following_error": rehearsal.following_error if rehearsal.loop else None,
        "parameters": {
            estimate.name: picked(estimate, "value", "unit", "interval_percent", "status")
            | {
                "put_in": rehearsal.truth.get(estimate.name),
                "error_percent": _error(estimate, rehearsal.truth.get(estimate.name)),
                "note": note_of(estimate),
            }
            for estimate in best.estimates
        },
    }
    return data


def excitation_ruling(excitation: Excitation) -> Ruling:
    """Return the verdict on a motion, with its reasons."""
    rehearsal, limit, presliding = (
        excitation.rehearsal,
        excitation.axis.effort_limit,
        excitation.limits.presliding,
    )
    exceeded = set(excitation.exceeded)
    if limit is not None and rehearsal is not None and rehearsal.peak_effort > limit:
        exceeded.add("effort")
    against = [words for name, words in EXCEEDED.items() if name in exceeded]
    if rehearsal is None:
        reasons = (*against, "the motion was not rehearsed")
        return (
            Ruling("no", "Do not run it", reasons)
            if against
            else Ruling("with_care", "Run it, with care", reasons)
        )
    sought = _sought(excitation)
    groups = (
        (
            "not identified: {}",
            [estimate for estimate in sought if estimate.status in ("unidentifiable", "at_edge")],
        ),
        ("hardly identified: {}", _sure(excitation, sure=False)),
        (
            "biased: {}",
            [
                estimate
                for estimate in sought
                if _misses(estimate, rehearsal.truth.get(estimate.name))
            ],
        ),
    )
    reasons = [
        text.format(", ".join(estimate.name for estimate in estimates))
        for text, estimates in groups
        if estimates
    ]
    if presliding is not None and rehearsal.lag > presliding:
        lag = length_text(rehearsal.lag, excitation.motion.kind)
        reasons.append(
            f"raise the gains for this motion: the controller follows the pre-sliding loops only within {lag}"
        )
    wider = _wider(excitation)
    if excitation.is_worse:
        against.append(f"no motion within the limits is better than the log at hand: {wider}")
    elif wider:
        reasons.append(
            f"identify both logs together, because the log at hand is better for some parameters: {wider}"
        )
    if against:
        return Ruling("no", "Do not run it", (*against, *reasons))
    return (
        Ruling("with_care", "Run it, with care", tuple(reasons))
        if reasons
        else Ruling("usable", "Run it")
    )


def _wider(excitation: Excitation) -> str:
    """Return the half-widths after a motion and by the earlier log where the log is clearly better, or as good if the motion is worse."""
    least = NARROWER ** (2 * excitation.is_worse - 1)
    return ", ".join(
        f"{name} {half_text(then)} against {half_text(now)}"
        for name, (now, then) in excitation.half_widths.items()
        if then > least * now
    )


def _front(excitation: Excitation, identify: str) -> Front:
    motion, sure = excitation.motion, _sure(excitation)
    travel, speed, _ = _limits(excitation)
    cards = [
        Card(
            estimate.description.partition(",")[0].partition(" or ")[0].capitalize(),
            quantity_text(estimate.value, estimate.interval_percent, estimate.unit),
            estimate.name,
            estimate.interval_percent,
        )
        for estimate in sorted(sure, key=lambda estimate: estimate.interval_percent or 0.0)[:2]
    ]
    cards += [
        Card(word.capitalize(), fixed(value, of), f"of {fixed(most, of)}" if most else "")
        for word, value, most, of in (travel, speed)
    ]
    sought = len(_sought(excitation))
    title = (
        f"Determines {len(sure)} of {sought} parameters"
        if sought
        else f"A motion of {motion.duration:.3g} s"
    )
    return Front(
        f"{excitation.axis.name}: a motion to run",
        about(f"{motion.duration:.3g} s"),
        excitation_ruling(excitation),
        title=title,
        basis="(rehearsed)" if excitation.rehearsal else "(not rehearsed)",
        cards=cards,
        next=Step(
            "Identify the log at hand:"
            if excitation.is_worse
            else "Run motion.csv, then identify its log:",
            identify,
        ),
    )
