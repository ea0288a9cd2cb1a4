"""Recordings of robots (MCAP): messages of ROS 2 or in JSON, with joints by name."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from bristle.core.content import refuse_larger
from bristle.core.errors import InputError
from bristle.logs.table import NUMBER_BYTES, Request, Table
from bristle.logs.tables import Series, table_of_series

SECOND = 1_000_000_000  # [ns]


def read(data: bytes, request: Request) -> Table:
    """Return the numbers in the messages of a recording, each with its times.

    A joint of a `JointState` is ``NAME.position``, ``NAME.velocity`` and ``NAME.effort``; any other number has the path
    of its field. Where several topics are recorded, theirs stands before it.
    """
    from mcap.reader import make_reader  # pyright: ignore[reportMissingImports]
    from mcap_ros2.decoder import DecoderFactory  # pyright: ignore[reportMissingImports]

    fields: dict[tuple[str, str], tuple[list[int], list[float]]] = {}
    unknown: set[str] = set()
    decoders, factory, count = {}, DecoderFactory(), 0
    for schema, channel, message in make_reader(io.BytesIO(data)).iter_messages():
        if channel.message_encoding not in ("cdr", "json") or (schema is None and channel.message_encoding == "cdr"):
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
    notes = [f"messages that are not understood were left out: {', '.join(sorted(unknown)[:8])}"] if unknown else []
    table = request.table
    chosen = {key: value for key, value in fields.items() if table is None or key[0] == table or key[1].startswith(f"{table}.")}
    if not chosen:
        message, allowed = "holds no messages with numbers that are understood", ", ".join(sorted({topic for topic, _ in fields})[:8])
        raise InputError(message, path=str(request.source), value=table, allowed=allowed, mend="Record messages of ROS 2, or JSON")
    topics = {topic for topic, _ in chosen}
    origin = min(times[0] for times, _ in chosen.values())
    series = []
    for (topic, field), (times, values) in chosen.items():
        name = field if len(topics) == 1 else f"{topic}/{field}"
        stamps = (np.array(times, dtype=np.int64) - origin) / SECOND
        series.append(Series(name, np.array(values), stamps, "", topic))
    return table_of_series(series, request, "MCAP", notes=notes)


def _numbers(content: Any) -> Iterator[tuple[str, float]]:
    """Yield the numbers of a message, with what they are called."""
    names = _field(content, "name")
    if not (isinstance(names, (list, tuple)) and names and all(isinstance(name, str) for name in names)):
        yield from _flat(content, "", 0)
        return
    for quantity in ("position", "velocity", "effort"):
        values = _field(content, quantity)
        if values is not None and len(values) == len(names):
            yield from ((f"{name}.{quantity}", float(value)) for name, value in zip(names, values, strict=True))


def _flat(node: Any, path: str, depth: int) -> Iterator[tuple[str, float]]:
    if isinstance(node, (bool, int, float, np.number)):
        yield path, float(node)
    elif isinstance(node, str) or depth > 6:
        return
    elif isinstance(node, (list, tuple, np.ndarray)):
        for index, value in enumerate(node if len(node) <= 1000 else ()):  # of one message
            yield from _flat(value, f"{path}[{index}]", depth + 1)
    else:
        fields = map(str, node) if isinstance(node, Mapping) else getattr(node, "__slots__", None) or getattr(node, "__dict__", {})
        for name in fields:
            if name not in ("header", "stamp", "timestamp"):
                yield from _flat(_field(node, name), f"{path}.{name}" if path else name, depth + 1)


def _field(node: Any, name: str) -> Any:
    return node.get(name) if isinstance(node, Mapping) else getattr(node, name, None)


def _stamp(content: Any) -> int | None:
    """Return when a message was made [ns], as it says itself; None where it does not."""
    header = _field(content, "header")
    stamp = _field(header, "stamp") if header is not None else _field(content, "stamp")
    if stamp is None or isinstance(stamp, (int, float, str)):
        return None
    seconds, rest = _field(stamp, "sec"), _field(stamp, "nanosec")
    rest = _field(stamp, "nsec") if rest is None else rest
    return None if seconds is None or not (seconds or rest) else SECOND * int(seconds) + int(rest or 0)
