"""Facts and tables of a log in reports: its channels, treatment, scatter, passages and break-away."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bristle.core import Kind, number, unit_of, with_unit
from bristle.identification import Fit, Identification
from bristle.logs import Log
from bristle.report.table import Quantity, Table, interval_text, span_text

TREATMENT = {
    "cutoff": ("Cut-off of the zero-phase filter", "{:g} Hz"),
    "decimation": ("Samples for one row of the regression", "{:.0f}"),
    "dropped": ("Samples dropped at each edge", "{:.0f}"),
    "rows": ("Rows of the regression", "{:.0f}"),
    "delay": ("Delay of the effort, identified", "{:.3g} s"),
    "delay_half_width": ("Half-width of the 95 % interval of the delay", "{:.3g} s"),
    "smoothing": ("Filter of the effort beyond that of the position, identified", "{:.3g} s"),
    "position_smoothing": ("Filter of the position, identified", "{:.3g} s"),
    "slow": ("Cut-off of the acceleration", "{:.3g} Hz"),
    "lag": ("Lag of the drive, identified", "{:.3g} s"),
    "rest_percent": ("Samples at rest, left out", "{:.3g} %"),
}

KINDS = {
    "constant_velocity": "slides at constant velocity",
    "loops": "pre-sliding loops",
    "break_away": "break-away from rest",
    "chirp": "oscillation of changing frequency",
    "oscillation": "oscillation of one frequency",
    "moves": "ordinary moves",
    "rest": "rest",
}


def log_facts(log: Log, further: Sequence[Log] = ()) -> list[tuple[str, str]]:
    """Return the facts of a log, and the names of further logs."""
    count = log.time.values.size
    facts = [
        ("File", log.origin.name),
        ("SHA-256", log.origin.checksum),
        (
            "Samples",
            f"{count} in {len(log.segments)} {'stretch' if len(log.segments) == 1 else 'stretches'}",
        ),
        (
            "Sample time",
            f"{with_unit(log.sample_time, 's', 4)} ({number(1.0 / log.sample_time)} Hz)",
        ),
        ("Duration", with_unit(count * log.sample_time, "s", 4)),
    ]
    for name, channel in log.channels():
        if name != "time":
            low, high = float(np.min(channel.values)), float(np.max(channel.values))
            column = Quantity.of(channel.unit, (low, high), digits=4)
            span = f"{column.cell(low)} to {column.cell(high)} {column.scale.unit}"
            facts.append((name.capitalize(), f"column {channel.column}, {span}"))
    return facts + (
        [("Further logs", ", ".join(log.origin.name for log in further))] if further else []
    )


def treatment_facts(treatment: Mapping[str, float], kind: Kind) -> list[tuple[str, str]]:
    """Return the treatment of a log before the identification."""
    facts = [
        (word, pattern.format(treatment[key]))
        for key, (word, pattern) in TREATMENT.items()
        if key in treatment
    ]
    if "velocity_max" in treatment:
        facts.append(
            (
                "Largest speed of the rows",
                with_unit(treatment["velocity_max"], unit_of("length/time", kind)),
            )
        )
    return facts


def scatter_facts(fit: Fit) -> list[tuple[str, str]]:
    """Return the scatter of friction, the noise, and the unexplained residual."""
    resampling, kind = fit.resampling, fit.plant.kind
    if resampling is None:
        return []
    bands, scatter = resampling.bands, resampling.scatter
    value, low, high = (
        number(100.0 * share, digits=2) for share in (scatter.value, scatter.low, scatter.high)
    )
    noise, left = (
        with_unit(force, unit_of("force", kind)) for force in (bands.noise, bands.unexplained)
    )
    facts = [("Noise of the effort, sample by sample", noise)]
    if scatter.value > 0.0:
        text = f"{value} %, 95 % interval {low} to {high} %, {resampling.half_cycles} half-cycles"
        facts.append(("Scatter of friction from reversal to reversal", text))
    return [
        *facts,
        ("Residual without noise, encoder steps and scatter", f"{left}, root mean square"),
    ]


def passage_table(segments: Sequence[Mapping[str, Any]], kind: Kind) -> Table:
    """Return the passages of a log, one row for each kind."""
    rows = []
    for name, words in KINDS.items():
        of_kind = [segment for segment in segments if segment["kind"] == name]
        if of_kind:
            legs, together = (
                sum(segment["legs"] for segment in of_kind),
                sum(segment["end"] - segment["begin"] for segment in of_kind),
            )
            counts = (
                str(len(of_kind)),
                str(legs or ""),
                f"{together:.3g}",
                f"{of_kind[0]['begin']:.4g}",
            )
            spans = ("", "", "")
            if name != "rest":
                amplitudes = span_text(
                    [end for segment in of_kind for end in segment["amplitudes"]],
                    unit_of("length", kind),
                )
                speeds, remark = (
                    span_text(
                        [end for segment in of_kind for end in segment["speeds"]],
                        unit_of("length/time", kind),
                    ),
                    "",
                )
                turns = [end for segment in of_kind for end in segment["frequencies"]]
                if name == "loops":
                    depth, levels = (
                        max(segment[key] for segment in of_kind) for key in ("depth", "levels")
                    )
                    nested = f"nested {depth} deep" if depth > 2 else "not nested"
                    remark = f"{levels} {'amplitude' if levels == 1 else 'amplitudes'}, {nested}"
                elif name in ("chirp", "oscillation") and turns:
                    remark = span_text(turns, "Hz")
                spans = amplitudes, speeds, remark
            rows.append((words, *counts, *spans))
    heads = (
        "Passages",
        "Count",
        "Legs",
        "Total time [s]",
        "First begins at [s]",
        "Amplitude",
        "Speed",
        "Remark",
    )
    return Table("Motion of the log", heads, rows).without_empty_columns()


def break_away_table(identification: Identification) -> Table | None:
    """Return break-away by rate, with its 95 % intervals; None if the log has no break-away."""
    break_aways, kind = identification.break_aways, identification.best.plant.kind
    if not break_aways:
        return None
    speeds = Quantity.of(
        unit_of("length/time", kind), [break_away.speed for break_away in break_aways]
    )
    forces = Quantity.of(unit_of("force", kind), [break_away.force for break_away in break_aways])
    distances = Quantity.of(
        unit_of("length", kind), [break_away.distance for break_away in break_aways]
    )
    rows = [
        {
            speeds.head("Rate"): speeds.cell(break_away.speed),
            "Legs": str(break_away.legs),
            forces.head("Force"): forces.cell(break_away.force),
            "95 % interval of the force": _between(forces, break_away.force_interval),
            distances.head("Distance"): distances.cell(break_away.distance),
            "95 % interval of the distance": _between(distances, break_away.distance_interval),
        }
        for break_away in break_aways
    ]
    return Table.of("Measured break-away from rest, after a motion in the other direction", rows)


def _between(quantity: Quantity, interval: tuple[float, float] | None) -> str:
    return "–" if interval is None else interval_text(*map(quantity.cell, interval))
