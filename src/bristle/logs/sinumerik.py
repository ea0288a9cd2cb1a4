"""Traces of SINUMERIK Operate, in XML: one element a sample, with the signals that were taken then."""

from __future__ import annotations

import io
import re
from xml.etree import ElementTree

import numpy as np

from bristle.core.errors import InputError
from bristle.logs.table import Request, Table, without_index
from bristle.logs.tables import Series, table_of_series
from bristle.logs.words import distinct

NO_VALUE = 9.2e18  # a NaN, written as the whole number of its bits: the value before it holds
ENTITY = re.compile(rb"<!(DOCTYPE|ENTITY)", re.IGNORECASE)
MEND = "Export the trace as CSV"


def read(data: bytes, request: Request) -> Table:
    """Return the signals of a trace in XML, each with the times at which it was taken."""
    place = str(request.source)
    if ENTITY.search(data[: 2**16]):
        raise InputError("declares entities, which are not read", path=place, mend=MEND)
    signals: dict[str, tuple[str, str, str]] = {}
    records: dict[str, tuple[list[float], list[float]]] = {}
    try:
        for _, element in ElementTree.iterparse(io.BytesIO(data)):
            kind = element.tag.rpartition("}")[2]
            if kind == "dataSignal":
                key = element.get("id") or f"f{len(signals) + 1}"
                name = element.get("description") or element.get("name") or key
                signals[key] = (name, element.get("units") or element.get("unit") or "", element.get("name") or "")
            elif kind == "rec":
                time = float(element.attrib.pop("time"))
                for key, text in element.attrib.items():
                    value = float(text) if text else np.inf
                    if abs(value) > NO_VALUE and (not text or key not in records):
                        continue
                    times, values = records.setdefault(key, ([], []))
                    times.append(time)
                    values.append(values[-1] if abs(value) > NO_VALUE else value)
                element.clear()
    except ElementTree.ParseError as error:
        raise InputError(f"is truncated or damaged ({error})", path=place, mend="Copy it again") from None
    keys = [key for key in signals if key in records] or list(records)
    if not keys:
        raise InputError("is no trace with records of signals", path=place, mend=MEND)
    heads = [signals.get(key, (key, "", "")) for key in keys]
    called = [name.strip() for name, _, _ in heads]
    # With the index of the axis where several are described alike.
    indices = [address[len(without_index(address)) :].strip() for _, _, address in heads]
    indexed = (f"{n} {i}" if called.count(n) > 1 and not n.endswith(i) else n for n, i in zip(called, indices, strict=True))
    names, notes = distinct(indexed)
    series = [
        Series(name, np.array(records[key][1]), np.array(records[key][0]), unit, address)
        for name, key, (_, unit, address) in zip(names, keys, heads, strict=True)
    ]
    return table_of_series(series, request, "SINUMERIK trace", notes=notes)
