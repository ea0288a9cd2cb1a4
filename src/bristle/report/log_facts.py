"""What there is to know of a log and of how it was treated, in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from bristle.core.typography import number, with_unit
from bristle.core.variable import Kind, unit_of
from bristle.report.table import Quantity

if TYPE_CHECKING:
    from bristle.identification.result import Resampling
    from bristle.logs.log import Log

__all__ = ["log_facts", "scatter_facts", "treatment_facts"]

TREATMENT = {
    "cutoff": ("Cut-off of the zero-phase filter", "{:g} Hz"),
    "decimation": ("Samples for one row of the regression", "{:.0f}"),
    "dropped": ("Samples dropped at each edge", "{:.0f}"),
    "rows": ("Rows of the regression", "{:.0f}"),
    "delay": ("Delay of the effort, identified", "{:.3g} s"),
    "delay_half_width": ("Half-width of its 95 % interval", "{:.3g} s"),
    "smoothing": ("Filter of the effort beyond that of the position, identified", "{:.3g} s"),
    "position_smoothing": ("Filter of the position, identified", "{:.3g} s"),
    "slow": ("Cut-off of the acceleration", "{:.3g} Hz"),
    "lag": ("Lag of the drive behind its controller, identified", "{:.3g} s"),
    "rest_percent": ("Samples at rest, left out", "{:.3g} %"),
}


def log_facts(log: Log, further: Sequence[Log] = ()) -> list[tuple[str, str]]:
    """Return what there is to know of a log, and the names of those that were used beside it."""
    count = log.time.values.size
    facts = [
        ("File", log.origin.name),
        ("SHA-256", log.origin.checksum),
        ("Samples", f"{count} in {len(log.segments)} {'stretch' if len(log.segments) == 1 else 'stretches'}"),
        ("Sample time", f"{with_unit(log.sample_time, 's', 4)} ({number(1.0 / log.sample_time)} Hz)"),
        ("Duration", with_unit(count * log.sample_time, "s", 4)),
    ]
    for name, channel in log.channels():
        if name == "time":
            continue
        values = np.asarray(channel.values)
        low, high = float(values.min()), float(values.max())
        column = Quantity.of(channel.unit, (low, high), digits=4)
        span = f"{column.cell(low)} to {column.cell(high)} {column.scale.unit}"
        facts.append((name.capitalize(), f"column {channel.column}, {span}"))
    if further:
        facts.append(("Further logs", ", ".join(log.origin.name for log in further)))
    return facts


def treatment_facts(treatment: Mapping[str, float], kind: Kind) -> list[tuple[str, str]]:
    """Return how a log was treated before the identification."""
    facts = [(word, pattern.format(treatment[key])) for key, (word, pattern) in TREATMENT.items() if key in treatment]
    if "velocity_max" in treatment:
        facts.append(("Largest speed of the rows", with_unit(treatment["velocity_max"], unit_of("length/time", kind))))
    return facts


def scatter_facts(resampling: Resampling | None, kind: Kind) -> list[tuple[str, str]]:
    """Return how repeatable the friction of a log is, and what else keeps a fit from being exact."""
    if resampling is None:
        return []
    bands, scatter = resampling.bands, resampling.scatter
    low, high = (number(100.0 * bound, digits=2) for bound in (scatter.low, scatter.high))
    facts = [("Noise of the effort, sample by sample", with_unit(bands.noise, unit_of("force", kind)))]
    if scatter.value > 0.0:
        text = f"{number(100.0 * scatter.value, digits=2)} %, 95 % interval {low} to {high} %"
        facts.append(("Scatter of friction from reversal to reversal", f"{text}, {resampling.half_cycles} half-cycles"))
    left = with_unit(bands.unexplained, unit_of("force", kind))
    facts.append(("Residual that noise, encoder and scatter do not explain", f"{left}, root mean square"))
    return facts
