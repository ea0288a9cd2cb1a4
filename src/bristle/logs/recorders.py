"""Logs of recorders, whose channels have separate times: TDMS (LabVIEW), MDF 4 (ASAM), MCAP (robots), SINUMERIK Operate XML."""

import io
import json
import logging
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from bristle.core.content import refuse_larger
from bristle.core.errors import InputError
from bristle.logs.table import NUMBER_BYTES, Request, Table, without_index
from bristle.logs.tables import Series, by_name, table_of_series
from bristle.logs.words import distinct

LEAD_IN_BYTES = 28


def read_tdms(data: bytes, request: Request) -> Table:
    """Return the channels of a TDMS file, scaled as the file states."""
    import nptdms

    _refuse_truncated(data, request.source)
    remarks = _remarks_kept()
    series, periods, notes = [], {}, []
    with nptdms.TdmsFile.open(io.BytesIO(data)) as content:
        called = by_name(
            (channel.name, group.name, channel)
            for group in content.groups()
            for channel in group.channels()
        )
        refuse_larger(
            sum(NUMBER_BYTES * len(c) for name, c in called.items() if request.choice(name)),
            request.limit,
            request.source,
        )
        for name, channel in called.items():
            if getattr(channel.dtype, "kind", "O") not in "fiubM" or not len(channel):
                notes.append(f"bristle ignores channel {name!r}, because it holds no numbers")
                continue
            step = channel.properties.get("wf_increment")
            if isinstance(step, (int, float)) and 0.0 < step < math.inf:
                periods[name] = float(step)
            elif step is not None:
                notes.append(
                    f"bristle ignores the sample time of channel {name!r}, because it is invalid"
                )
            numbers = np.asarray(channel[:]) if request.choice(name) else None
            unit = next(
                (
                    str(channel.properties[key]).strip()
                    for key in ("unit_string", "NI_UnitDescription")
                    if channel.properties.get(key)
                ),
                "",
            )
            if numbers is not None and numbers.dtype.kind == "M":
                numbers, unit = (numbers - numbers[:1]) / np.timedelta64(1, "s"), "s"
            series.append(Series(name, numbers, unit=unit))
    if remarks:
        raise InputError(
            f"is damaged ({remarks[0][:80]})",
            path=str(request.source),
            mend="Copy or record it again",
        )
    if len(set(periods.values())) > 1:
        if all(channel.values is None or channel.name in periods for channel in series):
            series = [
                c
                if c.values is None
                else c._replace(times=periods[c.name] * np.arange(c.values.size))
                for c in series
            ]
        else:
            notes.append("bristle ignores the sample times of the channels, because they differ")
    table = table_of_series(series, request, "TDMS", notes=notes)
    return (
        replace(table, sample_time=periods.popitem()[1])
        if len(set(periods.values())) == 1
        else table
    )


def _remarks_kept() -> list[str]:
    """Return a list that collects the prints of the library about damage, in this process."""
    from nptdms.log import log_manager

    remarks: list[str] = []

    def keep(record: logging.LogRecord) -> bool:
        message = record.getMessage()
        # A name or remark in another alphabet, not damage.
        if not message.startswith("Error decoding string"):
            remarks.append(message)
        return False

    log_manager.console_handler.addFilter(keep)
    return remarks


def _refuse_truncated(data: bytes, source: Path) -> None:
    """Walk over the segments by their lengths: the last must end with the file."""
    at = 0
    while at < len(data):
        lead_in = data[at : at + LEAD_IN_BYTES]
        if len(lead_in) == LEAD_IN_BYTES and lead_in[:4] != b"TDSm":
            raise InputError(f"is damaged, or not a TDMS file (at byte {at})", path=str(source))
        order = "big" if int.from_bytes(lead_in[4:8], "little") & (1 << 6) else "little"
        at += LEAD_IN_BYTES + int.from_bytes(lead_in[12:20], order)
        if len(lead_in) < LEAD_IN_BYTES or at > len(data):
            raise InputError(
                "is truncated: its last segment is not complete",
                path=str(source),
                mend="Copy it again, or let LabVIEW close the file before it is copied",
            )


def read_mf4(data: bytes, request: Request) -> Table:
    """Return the channels of a measurement data file, converted to their physical units."""
    import asammdf  # pyright: ignore[reportMissingImports]

    logging.disable(logging.CRITICAL)  # messages of the library address authors of such files
    with asammdf.MDF(io.BytesIO(data)) as opened:
        content: Any = opened
        # Channels of kinds 2 and 3 are the time bases of others: recorded, and virtual.
        places = [
            (channel.name, str(group_index), (group_index, index))
            for group_index, group in enumerate(content.groups)
            for index, channel in enumerate(group.channels)
            if getattr(channel, "channel_type", 0) not in (2, 3)
            and content.masters_db.get(group_index) != index
        ]
        called = by_name(places)
        cycles = [content.groups[group].channel_group.cycles_nr for group, _ in called.values()]
        refuse_larger(2 * NUMBER_BYTES * sum(cycles), request.limit, request.source)
        series, notes = [], []
        for name, (group, index) in called.items():
            signal = content.get(group=group, index=index)
            values, times = np.asarray(signal.samples), np.asarray(signal.timestamps, dtype=float)
            if values.dtype.kind not in "fiub" or values.ndim != 1 or not values.size:
                notes.append(f"bristle ignores channel {name!r}, because it holds no numbers")
                continue
            bits = signal.invalidation_bits
            valid = (
                np.ones(values.shape, dtype=bool) if bits is None else ~np.asarray(bits, dtype=bool)
            )
            if valid.shape == values.shape:
                values, times = values[valid], times[valid]
            unit = signal.unit.strip() if isinstance(signal.unit, str) else ""
            about = " ".join(
                text
                for text in (signal.comment, content.groups[group].channel_group.acq_name)
                if text
            )
            if times.size and np.isfinite(times[-1]):
                series.append(Series(name, values, times, unit, about[:200]))
    return table_of_series(series, request, "MF4", notes=notes)


SECOND = 1_000_000_000  # [ns]


def read_mcap(data: bytes, request: Request) -> Table:
    """Return the numbers in the messages of a recording with their times, named by joint, or by topic and path of the field."""
    from mcap.reader import make_reader  # pyright: ignore[reportMissingImports]
    from mcap_ros2.decoder import DecoderFactory  # pyright: ignore[reportMissingImports]

    fields: dict[tuple[str, str], tuple[list[int], list[float]]] = {}
    unknown: set[str] = set()
    decoders, factory, count = {}, DecoderFactory(), 0
    for schema, channel, message in make_reader(io.BytesIO(data)).iter_messages():
        if channel.message_encoding not in ("cdr", "json") or (
            schema is None and channel.message_encoding == "cdr"
        ):
            unknown.add(f"{channel.topic} ({channel.message_encoding or 'unknown'})")
            continue
        if channel.message_encoding == "json":
            content = json.loads(message.data)
        else:
            if channel.schema_id not in decoders:
                decoders[channel.schema_id] = factory.decoder_for(channel.message_encoding, schema)
            content = decoders[channel.schema_id](message.data)
        stamp = _stamp(content) or message.log_time
        for name, value in _numbers(content):
            times, values = fields.setdefault((channel.topic, name), ([], []))
            times.append(stamp)
            values.append(value)
            count += 1
        refuse_larger(2 * NUMBER_BYTES * count, request.limit, request.source)
    notes = (
        [f"bristle ignores messages in unsupported encodings: {', '.join(sorted(unknown)[:8])}"]
        if unknown
        else []
    )
    table = request.table
    chosen = {
        key: value
        for key, value in fields.items()
        if table is None or key[0] == table or key[1].startswith(f"{table}.")
    }
    if not chosen:
        allowed = (
            f"topics: {', '.join(sorted({topic for topic, _ in fields})[:8])}" if fields else ""
        )
        raise InputError(
            "holds no readable messages with numbers",
            path=str(request.source),
            value=table,
            allowed=allowed,
            mend="Record messages of ROS 2, or JSON",
        )
    topics = {topic for topic, _ in chosen}
    origin = min(times[0] for times, _ in chosen.values())
    series = []
    for (topic, field), (times, values) in chosen.items():
        name = field if len(topics) == 1 else f"{topic}/{field}"
        stamps = (np.array(times, dtype=np.int64) - origin) / SECOND
        series.append(Series(name, np.array(values), stamps, "", topic))
    return table_of_series(series, request, "MCAP", notes=notes)


def _numbers(content: Any) -> Iterator[tuple[str, float]]:
    """Yield the numbers of a message, with their names."""
    names = _field(content, "name")
    if not (
        isinstance(names, (list, tuple)) and names and all(isinstance(name, str) for name in names)
    ):
        yield from _flat(content, "", 0)
        return
    for quantity in ("position", "velocity", "effort"):
        values = _field(content, quantity)
        if values is not None and len(values) == len(names):
            yield from (
                (f"{name}.{quantity}", float(value))
                for name, value in zip(names, values, strict=True)
            )


def _flat(node: Any, path: str, depth: int) -> Iterator[tuple[str, float]]:
    if isinstance(node, (bool, int, float, np.number)):
        yield path, float(node)
    elif isinstance(node, str) or depth > 6:
        return
    elif isinstance(node, (list, tuple, np.ndarray)):
        for index, value in enumerate(node if len(node) <= 1000 else ()):  # of one message
            yield from _flat(value, f"{path}[{index}]", depth + 1)
    else:
        fields = (
            map(str, node)
            if isinstance(node, Mapping)
            else getattr(node, "__slots__", None) or getattr(node, "__dict__", {})
        )
        for name in fields:
            if name not in ("header", "stamp", "timestamp"):
                yield from _flat(_field(node, name), f"{path}.{name}" if path else name, depth + 1)


def _field(node: Any, name: str) -> Any:
    return node.get(name) if isinstance(node, Mapping) else getattr(node, name, None)


def _stamp(content: Any) -> int | None:
    """Return the time at which a message was made [ns], from the message; None if it has none."""
    header = _field(content, "header")
    stamp = _field(header, "stamp") if header is not None else _field(content, "stamp")
    if stamp is None or isinstance(stamp, (int, float, str)):
        return None
    seconds, rest = _field(stamp, "sec"), _field(stamp, "nanosec")
    rest = _field(stamp, "nsec") if rest is None else rest
    return (
        None if seconds is None or not (seconds or rest) else SECOND * int(seconds) + int(rest or 0)
    )


NO_VALUE = 9.2e18  # a NaN, written as the integer of its bits: the previous value remains valid
ENTITY = re.compile(rb"<!(DOCTYPE|ENTITY)", re.IGNORECASE)
MEND = "Export the trace as CSV"


def read_sinumerik(data: bytes, request: Request) -> Table:
    """Return the signals of a trace in XML, each with its times."""
    place = str(request.source)
    if ENTITY.search(data[: 2**16]):
        raise InputError(
            "declares XML entities, which bristle does not read", path=place, mend=MEND
        )
    signals: dict[str, tuple[str, str, str]] = {}
    records: dict[str, tuple[list[float], list[float]]] = {}
    try:
        for _, element in ElementTree.iterparse(io.BytesIO(data)):
            kind = element.tag.rpartition("}")[2]
            if kind == "dataSignal":
                key = element.get("id") or f"f{len(signals) + 1}"
                name = element.get("description") or element.get("name") or key
                signals[key] = (
                    name,
                    element.get("units") or element.get("unit") or "",
                    element.get("name") or "",
                )
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
        raise InputError(
            f"is truncated or damaged ({error})", path=place, mend="Copy it again"
        ) from None
    keys = [key for key in signals if key in records] or list(records)
    if not keys:
        raise InputError("is not a trace with records of signals", path=place, mend=MEND)
    heads = [signals.get(key, (key, "", "")) for key in keys]
    called = [name.strip() for name, _, _ in heads]
    # Add the index of the axis if several have the same description.
    indices = [address[len(without_index(address)) :].strip() for _, _, address in heads]
    indexed = (
        f"{n} {i}" if called.count(n) > 1 and not n.endswith(i) else n
        for n, i in zip(called, indices, strict=True)
    )
    names, notes = distinct(indexed)
    series = [
        Series(name, np.array(records[key][1]), np.array(records[key][0]), unit, address)
        for name, key, (_, unit, address) in zip(names, keys, heads, strict=True)
    ]
    return table_of_series(series, request, "SINUMERIK trace", notes=notes)
