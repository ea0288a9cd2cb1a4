"""The experiments that a log contains, as a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from bristle.core.typography import interval_text, with_unit
from bristle.core.variable import Kind, unit_of
from bristle.logs.break_away import BreakAway
from bristle.logs.passages import KINDS
from bristle.report.table import Quantity, Table

__all__ = ["break_away_table", "passage_table"]


def passage_table(segments: Sequence[Mapping[str, Any]], kind: Kind) -> Table:
    """Return what a log contains, one row for each kind of passage."""
    rows = []
    for name, words in KINDS.items():
        of_kind = [segment for segment in segments if segment["kind"] == name]
        if of_kind:
            legs, together = (sum(segment["legs"] for segment in of_kind), sum(segment["end"] - segment["begin"] for segment in of_kind))
            rows.append(
                (
                    words,
                    str(len(of_kind)),
                    str(legs or ""),
                    f"{together:.3g}",
                    format(of_kind[0]["begin"], ".4g"),
                    *_ranges(name, of_kind, kind),
                )
            )
    heads = ("Passages", "Count", "Legs", "Together [s]", "First at [s]", "Amplitude", "Speed", "Remark")
    return Table("What the motion of the log is", heads, rows).without_empty_columns()


def break_away_table(break_aways: Sequence[BreakAway], kind: Kind) -> Table:
    """Return break-away by rate, with its 95 % intervals."""
    speeds = Quantity.of(unit_of("length/time", kind), [break_away.speed for break_away in break_aways])
    forces = Quantity.of(unit_of("force", kind), [break_away.force for break_away in break_aways])
    distances = Quantity.of(unit_of("length", kind), [break_away.distance for break_away in break_aways])
    rows = [
        (
            speeds.cell(break_away.speed),
            str(break_away.legs),
            forces.cell(break_away.force),
            _between(forces, break_away.force_interval),
            distances.cell(break_away.distance),
            _between(distances, break_away.distance_interval),
        )
        for break_away in break_aways
    ]
    interval = "95 % interval"
    heads = (speeds.head("Rate"), "Legs", forces.head("Force"), interval, distances.head("Distance"), interval)
    return Table("Break-away from rest, after a motion the other way, as measured", heads, rows)


def _between(quantity: Quantity, interval: tuple[float, float] | None) -> str:
    return "–" if interval is None else interval_text(*map(quantity.cell, interval))


def _ranges(name: str, of_kind: Sequence[Mapping[str, Any]], kind: Kind) -> tuple[str, str, str]:
    if name == "rest":
        return "", "", ""
    amplitudes = _span([end for segment in of_kind for end in segment["amplitudes"]], unit_of("length", kind))
    speeds = _span([end for segment in of_kind for end in segment["speeds"]], unit_of("length/time", kind))
    if name == "loops":
        depth, levels = max(segment["depth"] for segment in of_kind), max(segment["levels"] for segment in of_kind)
        nested = f"nested {depth} deep" if depth > 2 else "none inside another"
        return amplitudes, speeds, f"{levels} {'amplitude' if levels == 1 else 'amplitudes'}, {nested}"
    if name in ("chirp", "oscillation"):
        return amplitudes, speeds, _span([end for segment in of_kind for end in segment["frequencies"]], "Hz")
    return amplitudes, speeds, ""


def _span(values: Sequence[float], unit: str) -> str:
    low, high = (with_unit(end, unit) for end in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"
