"""Measurement data files (MDF 4, of ASAM): groups of channels, each group with its own times."""

from __future__ import annotations

import io
import logging
from typing import Any

import numpy as np

from bristle.core.content import refuse_larger
from bristle.logs.table import NUMBER_BYTES, Request, Table
from bristle.logs.tables import Series, by_name, table_of_series

MASTERS = (2, 3)  # kinds of channels that others are sampled by: real ones, and those that are only counted


def read(data: bytes, request: Request) -> Table:
    """Return the channels of a measurement data file, converted to their physical units."""
    import asammdf  # pyright: ignore[reportMissingImports]

    logging.disable(logging.CRITICAL)  # what the library tells of a file is for those who make such files
    with asammdf.MDF(io.BytesIO(data)) as opened:
        content: Any = opened
        places = [
            (channel.name, str(group_index), (group_index, index))
            for group_index, group in enumerate(content.groups)
            for index, channel in enumerate(group.channels)
            if getattr(channel, "channel_type", 0) not in MASTERS and content.masters_db.get(group_index) != index
        ]
        called = by_name(places)
        cycles = [content.groups[group].channel_group.cycles_nr for group, _ in called.values()]
        refuse_larger(2 * NUMBER_BYTES * sum(cycles), request.limit, request.source)
        series, notes = [], []
        for name, (group, index) in called.items():
            signal = content.get(group=group, index=index)
            values, times = np.asarray(signal.samples), np.asarray(signal.timestamps, dtype=float)
            if values.dtype.kind not in "fiub" or values.ndim != 1 or not values.size:
                notes.append(f"channel {name!r} holds no numbers and was left out")
                continue
            bits = signal.invalidation_bits
            valid = np.ones(values.shape, dtype=bool) if bits is None else ~np.asarray(bits, dtype=bool)
            if valid.shape == values.shape:
                values, times = values[valid], times[valid]
            unit = signal.unit.strip() if isinstance(signal.unit, str) else ""
            about = " ".join(text for text in (signal.comment, content.groups[group].channel_group.acq_name) if text)
            if times.size and np.isfinite(times[-1]):
                series.append(Series(name, values, times, unit, about[:200]))
    return table_of_series(series, request, "MF4", notes=notes)
