"""Logs that LabVIEW streamed to disk (TDMS)."""

from __future__ import annotations

import io
import logging
import math
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bristle.core.content import refuse_larger
from bristle.core.errors import InputError
from bristle.logs.table import Choice, Request, Table
from bristle.logs.tables import Series, table_of_series

__all__ = ["read"]

LEAD_IN_BYTES = 28
BIG_ENDIAN = 1 << 6
NAME_REMARK = "Error decoding string"  # a name or remark in another alphabet, not damage
UNIT_PROPERTIES = ("unit_string", "NI_UnitDescription")
NUMBER_BYTES = 8


def read(data: bytes, request: Request) -> Table:
    """Return the channels of a TDMS file, scaled as the file says.

    A channel has its own name where no other has it, else ``group/channel``.
    """
    _refuse_truncated(data, request.source)
    with _remarks_kept() as remarks:
        columns, about = _channels(data, request.source, request.choice, request.limit, remarks)
    if remarks:
        raise InputError(f"is damaged ({remarks[0][:80]})", path=str(request.source), mend="Copy or record it again")
    if not about.names:
        raise InputError("holds no channel of numbers", path=str(request.source))
    if len(set(about.increments.values())) > 1 and set(about.increments) >= set(columns):
        return _with_own_times(columns, about, request.source)
    if len(set(about.increments.values())) > 1:
        about.notes.append("the channels differ in their sample time, which was ignored")
    periods = set(about.increments.values())
    sample_time = periods.pop() if len(periods) == 1 else None
    return Table(columns, about.units, sample_time=sample_time, notes=tuple(about.notes), format="TDMS", names=tuple(about.names))


def _with_own_times(columns: dict[str, np.ndarray], about: _About, source: Path) -> Table:
    """Return the table of channels that differ in their sample time: each has its times."""
    times = {name: about.increments[name] * np.arange(values.size) for name, values in columns.items()}
    series = [Series(name, columns.get(name), times.get(name), about.units.get(name, "")) for name in about.names]
    return table_of_series(series, source, "TDMS", notes=about.notes)


class _About(NamedTuple):
    """What is told of the channels: their names, units and sample times, and what was left out."""

    names: list[str]
    units: dict[str, str]
    increments: dict[str, float]
    notes: list[str]


def _channels(data: bytes, source: Path, choice: Choice, limit: int, remarks: list[str]) -> tuple[dict[str, np.ndarray], _About]:
    """Return the channels of a file; what its reader would mend by itself goes into `remarks`."""
    import nptdms

    columns, about = {}, _About([], {}, {}, [])
    try:
        with nptdms.TdmsFile.open(io.BytesIO(data)) as content:
            channels = [channel for group in content.groups() for channel in group.channels()]
            count = Counter(channel.name for channel in channels)
            named = {c.name if count[c.name] == 1 else f"{c.group_name}/{c.name}": c for c in channels}
            refuse_larger(sum(NUMBER_BYTES * len(c) for name, c in named.items() if choice(name)), limit, source)
            for name, channel in named.items():
                _read_channel(name, channel, choice(name), columns, about)
    except InputError:
        raise
    except Exception as error:  # noqa: BLE001  (a damaged file makes the reader raise anything)
        remarks.append(f"{error}")
    return columns, about


def _read_channel(name: str, channel: Any, chosen: bool, columns: dict[str, np.ndarray], about: _About) -> None:
    kind = getattr(channel.dtype, "kind", "O")
    if kind not in "fiubM" or not len(channel):
        about.notes.append(f"channel {name!r} holds no numbers and was left out")
        return
    about.names.append(name)
    step = channel.properties.get("wf_increment")
    if isinstance(step, (int, float)) and 0.0 < step < math.inf:
        about.increments[name] = float(step)
    elif step is not None:
        about.notes.append(f"channel {name!r} has a sample time that is none, which was ignored")
    if unit := _unit_of(channel.properties):
        about.units[name] = unit
    if not chosen:
        return
    numbers = np.asarray(channel[:])
    if numbers.dtype.kind == "M":
        about.units[name] = "s"
        numbers = (numbers - numbers[:1]) / np.timedelta64(1, "s")
    columns[name] = numbers.astype(float)


@contextmanager
def _remarks_kept() -> Iterator[list[str]]:
    """Keep what the reader prints where a file is damaged, before it reads on."""
    from nptdms.log import log_manager

    remarks: list[str] = []
    console = log_manager.console_handler
    console.addFilter(remark := _remark_in(remarks))
    try:
        yield remarks
    finally:
        console.removeFilter(remark)


def _remark_in(remarks: list[str]) -> Callable[[logging.LogRecord], bool]:
    """Return a filter that keeps what the reader prints where a file is damaged, before it reads on."""

    def keep(record: logging.LogRecord) -> bool:
        message = record.getMessage()
        if not message.startswith(NAME_REMARK):
            remarks.append(message)
        return False

    return keep


def _unit_of(properties: Any) -> str:
    return next((str(properties[key]).strip() for key in UNIT_PROPERTIES if properties.get(key)), "")


def _refuse_truncated(data: bytes, source: Path) -> None:
    """Walk over the segments, each of which says its length: the last must end with the file."""
    at = 0
    while at < len(data):
        lead_in = data[at : at + LEAD_IN_BYTES]
        if len(lead_in) == LEAD_IN_BYTES and lead_in[:4] != b"TDSm":
            raise InputError(f"is damaged, or no TDMS file (at byte {at})", path=str(source))
        order = "big" if int.from_bytes(lead_in[4:8], "little") & BIG_ENDIAN else "little"
        length = int.from_bytes(lead_in[12:20], order)
        at += LEAD_IN_BYTES + length
        if len(lead_in) < LEAD_IN_BYTES or at > len(data):
            raise InputError(
                "is truncated: its last segment is not complete",
                path=str(source),
                mend="Copy it again, or let LabVIEW close the file before it is copied",
            )
