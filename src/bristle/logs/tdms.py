"""Logs that LabVIEW streamed to disk (TDMS)."""

from __future__ import annotations

import io
import logging
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core.errors import InputError, MissingExtraError
from bristle.logs.table import Table

__all__ = ["read_tdms"]

LEAD_IN_BYTES = 28
BIG_ENDIAN = 1 << 6
NAME_REMARK = "Error decoding string"  # a name or remark in another alphabet, not damage
UNIT_PROPERTIES = ("unit_string", "NI_UnitDescription")


def read_tdms(data: bytes, source: Path) -> Table:
    """Return the channels of a TDMS file, scaled as the file says.

    A channel has its own name where no other has it, else ``group/channel``.

    Raises
    ------
    MissingExtraError
        If the reader of TDMS files is not installed.
    InputError
        If the file is truncated or damaged, or holds no channel of numbers.
    """
    _refuse_truncated(data, source)
    channels = _channels(data, source)
    count = Counter(channel.name for channel, _ in channels)
    columns, units, increments, notes = {}, {}, set(), []
    for channel, numbers in channels:
        name = channel.name if count[channel.name] == 1 else f"{channel.group_name}/{channel.name}"
        if numbers.dtype.kind == "M":
            numbers = (numbers - numbers[:1]) / np.timedelta64(1, "s")
            units[name] = "s"
        if numbers.dtype.kind not in "fiub" or not numbers.size:
            notes.append(f"channel {name!r} holds no numbers and was left out")
            continue
        columns[name] = numbers.astype(float)
        if unit := _unit_of(channel.properties):
            units[name] = unit
        if step := channel.properties.get("wf_increment"):
            increments.add(float(step))
    if not columns:
        raise InputError("holds no channel of numbers", path=str(source))
    if len(increments) > 1:
        notes.append("the channels differ in their sample time, which was ignored")
    sample_time = increments.pop() if len(increments) == 1 else None
    return Table(columns, units, sample_time=sample_time, notes=tuple(notes), format="TDMS")


def _channels(data: bytes, source: Path) -> list[tuple[Any, np.ndarray]]:
    """Return every channel of a file with its values, or refuse what its reader would mend by itself."""
    try:
        import nptdms
        from nptdms.log import log_manager
    except ImportError:
        raise MissingExtraError.of(f"{source}: reading TDMS", "io") from None
    remarks: list[str] = []
    found: list[tuple[Any, np.ndarray]] = []
    console = log_manager.console_handler
    console.addFilter(remark := _remark_in(remarks))
    try:
        with nptdms.TdmsFile.read(io.BytesIO(data)) as content:
            found = [(channel, np.asarray(channel[:])) for group in content.groups() for channel in group.channels()]
    except Exception as error:  # noqa: BLE001  (a damaged file makes the reader raise anything)
        remarks.append(f"{error}")
    finally:
        console.removeFilter(remark)
    if remarks:
        raise InputError(f"is damaged ({remarks[0][:80]})", path=str(source), mend="Copy or record it again")
    return found


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
