"""Logs that LabVIEW streamed to disk (TDMS)."""

from __future__ import annotations

import io
import logging
import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from bristle.core.content import refuse_larger
from bristle.core.errors import InputError
from bristle.logs.table import NUMBER_BYTES, Request, Table
from bristle.logs.tables import Series, by_name, table_of_series

LEAD_IN_BYTES = 28
UNIT_PROPERTIES = ("unit_string", "NI_UnitDescription")


def read(data: bytes, request: Request) -> Table:
    """Return the channels of a TDMS file, scaled as the file says."""
    import nptdms

    _refuse_truncated(data, request.source)
    remarks = _remarks_kept()
    series, periods, notes = [], {}, []
    with nptdms.TdmsFile.open(io.BytesIO(data)) as content:
        called = by_name((channel.name, group.name, channel) for group in content.groups() for channel in group.channels())
        refuse_larger(sum(NUMBER_BYTES * len(c) for name, c in called.items() if request.choice(name)), request.limit, request.source)
        for name, channel in called.items():
            if getattr(channel.dtype, "kind", "O") not in "fiubM" or not len(channel):
                notes.append(f"channel {name!r} holds no numbers and was left out")
                continue
            step = channel.properties.get("wf_increment")
            if isinstance(step, (int, float)) and 0.0 < step < math.inf:
                periods[name] = float(step)
            elif step is not None:
                notes.append(f"channel {name!r} has a sample time that is none, which was ignored")
            numbers = np.asarray(channel[:]) if request.choice(name) else None
            unit = next((str(channel.properties[key]).strip() for key in UNIT_PROPERTIES if channel.properties.get(key)), "")
            if numbers is not None and numbers.dtype.kind == "M":
                numbers, unit = (numbers - numbers[:1]) / np.timedelta64(1, "s"), "s"
            series.append(Series(name, numbers, unit=unit))
    if remarks:
        raise InputError(f"is damaged ({remarks[0][:80]})", path=str(request.source), mend="Copy or record it again")
    if len(set(periods.values())) > 1:
        if all(channel.values is None or channel.name in periods for channel in series):
            series = [c if c.values is None else c._replace(times=periods[c.name] * np.arange(c.values.size)) for c in series]
        else:
            notes.append("the channels differ in their sample time, which was ignored")
    table = table_of_series(series, request, "TDMS", notes=notes)
    return replace(table, sample_time=periods.popitem()[1]) if len(set(periods.values())) == 1 else table


def _remarks_kept() -> list[str]:
    """Return a list into which goes, in this process, what the library prints where a file is damaged, before it reads on."""
    from nptdms.log import log_manager

    remarks: list[str] = []

    def keep(record: logging.LogRecord) -> bool:
        message = record.getMessage()
        if not message.startswith("Error decoding string"):  # a name or remark in another alphabet, not damage
            remarks.append(message)
        return False

    log_manager.console_handler.addFilter(keep)
    return remarks


def _refuse_truncated(data: bytes, source: Path) -> None:
    """Walk over the segments, each of which says its length: the last must end with the file."""
    at = 0
    while at < len(data):
        lead_in = data[at : at + LEAD_IN_BYTES]
        if len(lead_in) == LEAD_IN_BYTES and lead_in[:4] != b"TDSm":
            raise InputError(f"is damaged, or no TDMS file (at byte {at})", path=str(source))
        order = "big" if int.from_bytes(lead_in[4:8], "little") & (1 << 6) else "little"
        at += LEAD_IN_BYTES + int.from_bytes(lead_in[12:20], order)
        if len(lead_in) < LEAD_IN_BYTES or at > len(data):
            mend = "Copy it again, or let LabVIEW close the file before it is copied"
            raise InputError("is truncated: its last segment is not complete", path=str(source), mend=mend)
