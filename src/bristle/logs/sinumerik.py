"""Traces of SINUMERIK Operate, in XML: one element a sample, with the signals that were taken then."""

from __future__ import annotations

import io
import re
from xml.etree import ElementTree

import numpy as np

from bristle.core.errors import InputError
from bristle.logs.names import distinct
from bristle.logs.table import Request, Table, without_index
from bristle.logs.tables import Series, table_of_series

__all__ = ["read"]

NO_VALUE = 9.2e18  # a NaN, written as the whole number of its bits: the value before it holds
ENTITY = re.compile(rb"<!(DOCTYPE|ENTITY)", re.IGNORECASE)
MEND = "Export the trace as CSV"


def read(data: bytes, request: Request) -> Table:
    """Return the signals of a trace in XML, each with the times at which it was taken."""
    if ENTITY.search(data[: 2**16]):
        raise InputError("declares entities, which are not read", path=str(request.source), mend=MEND)
    signals: dict[str, tuple[str, str, str]] = {}
    times: dict[str, list[float]] = {}
    values: dict[str, list[float]] = {}
    try:
        for _, element in ElementTree.iterparse(io.BytesIO(data)):
            kind = element.tag.rpartition("}")[2]
            if kind == "dataSignal":
                key = element.get("id") or f"f{len(signals) + 1}"
                name = element.get("description") or element.get("name") or key
                signals[key] = (name, element.get("units") or element.get("unit") or "", element.get("name") or "")
            elif kind == "rec":
                _keep(element.attrib, times, values)
                element.clear()
    except ElementTree.ParseError as error:
        raise InputError(f"is truncated or damaged ({error})", path=str(request.source), mend="Copy it again") from None
    keys = [key for key in signals if key in values] or list(values)
    if not keys:
        raise InputError("is no trace with records of signals", path=str(request.source), mend=MEND)
    names, notes = distinct(_names(keys, signals))
    series = [
        Series(
            name,
            np.array(values[key]) if request.choice(name) else None,
            np.array(times[key]),
            signals.get(key, ("", "", ""))[1],
            signals.get(key, ("", "", ""))[2],
        )
        for name, key in zip(names, keys, strict=True)
    ]
    return table_of_series(series, request.source, "SINUMERIK trace", notes=notes)


def _names(keys: list[str], signals: dict[str, tuple[str, str, str]]) -> list[str]:
    """Return what signals are called: as they are described, with the index of the axis where several are so."""
    heads = [signals.get(key, (key, "", "")) for key in keys]
    called = [name.strip() for name, _, _ in heads]
    indices = [address[len(without_index(address)) :].strip() for _, _, address in heads]
    return [
        f"{name} {index}" if called.count(name) > 1 and not name.endswith(index) else name
        for name, index in zip(called, indices, strict=True)
    ]


def _keep(record: dict[str, str], times: dict[str, list[float]], values: dict[str, list[float]]) -> None:
    time = float(record["time"])
    for key, text in record.items():
        if key == "time" or not text:
            continue
        value = float(text)
        if abs(value) > NO_VALUE:
            if key not in values:
                continue
            value = values[key][-1]
        times.setdefault(key, []).append(time)
        values.setdefault(key, []).append(value)
