"""Measurement data files (MDF 4, of ASAM): groups of channels, each group with its own times."""

from __future__ import annotations

import io
import logging
import math
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core.content import refuse_larger
from bristle.core.errors import InputError, said_by_library
from bristle.logs.table import Choice, Request, Table
from bristle.logs.tables import Series, table_of_series

__all__ = ["read"]

NUMBER_BYTES = 16  # of a sample and its time
MASTERS = (2, 3)  # kinds of channels that others are sampled by: real ones, and those that are only counted


def read(data: bytes, request: Request) -> Table:
    """Return the channels of a measurement data file, converted to their physical units.

    A channel has its own name where no other has it, else the number of its group before it.
    """
    import asammdf  # pyright: ignore[reportMissingImports]

    logging.disable(logging.CRITICAL)  # what the library tells of a file is for those who make such files
    try:
        with asammdf.MDF(io.BytesIO(data)) as content:
            return _table(content, request.source, request.choice, request.limit)
    except InputError:
        raise
    except Exception as error:  # noqa: BLE001  (a damaged file makes the library raise anything)
        raise InputError(
            f"is truncated or damaged{said_by_library(error)}", path=str(request.source), mend="Copy or record it again"
        ) from None


def _table(content: Any, source: Path, choice: Choice, limit: int) -> Table:
    places = [
        (channel.name, group_index, index)
        for group_index, group in enumerate(content.groups)
        for index, channel in enumerate(group.channels)
        if getattr(channel, "channel_type", 0) not in MASTERS and content.masters_db.get(group_index) != index
    ]
    count = Counter(name for name, *_ in places)
    called = {(name if count[name] == 1 else f"{group}/{name}"): (group, index) for name, group, index in places}
    cycles = [content.groups[group].channel_group.cycles_nr for group, _ in called.values()]
    refuse_larger(NUMBER_BYTES * sum(cycles), limit, source)
    series, notes = [], []
    for name, (group, index) in called.items():
        signal = content.get(group=group, index=index)
        samples = np.asarray(signal.samples)
        if samples.dtype.kind not in "fiub" or samples.ndim != 1 or not samples.size:
            notes.append(f"channel {name!r} holds no numbers and was left out")
            continue
        valid = None if signal.invalidation_bits is None else ~np.asarray(signal.invalidation_bits, dtype=bool)
        values, times = samples.astype(float), np.asarray(signal.timestamps, dtype=float)
        if valid is not None and valid.shape == values.shape:
            values, times = values[valid], times[valid]
        unit = signal.unit if isinstance(signal.unit, str) else ""
        about = " ".join(text for text in (signal.comment, content.groups[group].channel_group.acq_name) if text)
        series.append(Series(name, values if choice(name) else None, times, unit.strip(), about[:200]))
    finite = [
        channel_series
        for channel_series in series
        if channel_series.times is None or (channel_series.times.size and math.isfinite(float(channel_series.times[-1])))
    ]
    return table_of_series(finite, source, "MF4", notes=notes)
