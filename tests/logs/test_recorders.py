"""Recorders whose channels bring their own times: names, times, units, and values that hold on."""

import io
import json
import logging
from pathlib import Path
from types import SimpleNamespace as Plain

import pytest

from bristle.core.errors import InputError
from bristle.logs import recorders
from bristle.logs.recorders import read_mcap, read_sinumerik, read_tdms
from bristle.logs.table import ALL, Request

REQUEST = Request(Path("trace.xml"), None, ALL, 2**24)


def trace(signals, records):
    heads = "".join(f"<dataSignal {head}/>" for head in signals)
    rows = "".join(f'<rec time="{time}" {values}/>' for time, values in records)
    return f'<?xml version="1.0"?><trace xmlns="x">{heads}{rows}</trace>'.encode()


def lists(table):
    """The times and numbers of each signal."""
    return {
        name: (table.columns[time].tolist(), table.columns[name].tolist())
        for name, time in table.stamps.items()
    }


def test_each_signal_of_a_trace_has_the_times_at_which_it_was_taken():
    data = trace(
        [
            'id="f1" description="Lage" units="mm" name="/a [u1, 3]"',
            'id="f2" name="Strom" unit="A"',
        ],
        [(0.5, 'f1="1.5"'), (1.0, 'f1="2.5" f2="7"'), (1.5, 'f2="8"')],
    )
    table = read_sinumerik(data, REQUEST)
    assert lists(table) == {"Lage": ([0.5, 1.0], [1.5, 2.5]), "Strom": ([1.0, 1.5], [7.0, 8.0])}
    assert (table.units["Lage"], table.units["Strom"], table.format) == (
        "mm",
        "A",
        "SINUMERIK trace",
    )
    assert table.about == {"Lage": "/a [u1, 3]", "Strom": "Strom"}


def test_missing_values_repeat_the_previous_and_a_missing_start_is_left_out():
    values = ("", "9.3e18", "4", "9.3e18", "", "-9.1e18")
    data = trace(
        ['id="f1" name="q"'], [(time, f'f1="{value}"') for time, value in enumerate(values)]
    )
    assert lists(read_sinumerik(data, REQUEST)) == {"q": ([2.0, 3.0, 5.0], [4.0, 4.0, -9.1e18])}


def test_signals_with_equal_descriptions_have_the_index_of_their_axis():
    alike = [
        'id="f1" description="Lage" name="/a [u1, 3]"',
        'id="f2" description="Lage" name="/a [u1, 4]"',
    ]
    table = read_sinumerik(trace(alike, [(0, 'f1="1" f2="2"'), (1, 'f1="3" f2="4"')]), REQUEST)
    assert {"Lage [u1, 3]", "Lage [u1, 4]"} <= set(table.columns)
    unnamed = read_sinumerik(trace([], [(0, 'f7="1"'), (1, 'f7="3"')]), REQUEST)
    assert "f7" in unnamed.columns


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (trace(['id="f1" name="q"'], []), "is not a trace with records of signals"),
        (trace(['id="f1" name="q"'], [(0, 'f1="1"')])[:-9], "is truncated or damaged"),
        (b'<!DOCTYPE a [<!ENTITY b "c">]><a/>', "declares XML entities"),
    ],
)
def test_xml_without_a_trace_is_refused(data, words):
    with pytest.raises(InputError, match=words):
        read_sinumerik(data, REQUEST)


@pytest.mark.parametrize(
    ("content", "time"),
    [
        (Plain(header=Plain(stamp=Plain(sec=3, nanosec=5))), 3_000_000_005),
        (Plain(header=None, stamp=Plain(sec=0, nanosec=7)), 7),
        ({"stamp": {"sec": 2, "nsec": 9}}, 2_000_000_009),
        (Plain(header=None, stamp=Plain(sec=0, nanosec=0)), None),  # a clock that was never set
        ({"stamp": 3.0}, None),
        ({}, None),
    ],
)
def test_a_message_has_its_stated_time(content, time):
    assert recorders._stamp(content) == time


JOINTS = Plain(name=["j1", "j2"], position=[1.0, 2.0], velocity=[], effort=[3.0, 4.0])


@pytest.mark.parametrize(
    ("content", "numbers"),
    [
        (
            {"header": {"seq": 3}, "stamp": 9.0, "a": {"b": [1, 2.5]}, "on": True, "word": "x"},
            [("a.b[0]", 1.0), ("a.b[1]", 2.5), ("on", 1.0)],
        ),
        ({"long": [0.0] * 1001}, []),
        ({"long": [0.0] * 1000}, [(f"long[{k}]", 0.0) for k in range(1000)]),
        (
            JOINTS,
            [("j1.position", 1.0), ("j2.position", 2.0), ("j1.effort", 3.0), ("j2.effort", 4.0)],
        ),
        ({"a": {"a": {"a": {"a": {"a": {"a": {"a": {"a": 1.0}}}}}}}}, []),  # too deep
    ],
)
def test_numbers_of_a_message_have_the_path_of_their_field(content, numbers):
    assert list(recorders._numbers(content)) == numbers


def recording(messages):
    writer_library = pytest.importorskip("mcap.writer")
    stream = io.BytesIO()
    writer = writer_library.Writer(stream)
    writer.start()
    channels = {}
    for topic, encoding, time, content in messages:
        if topic not in channels:
            channels[topic] = writer.register_channel(topic, encoding, 0)
        data = json.dumps(content).encode() if encoding == "json" else b"\0"
        writer.add_message(channels[topic], log_time=time, data=data, publish_time=time)
    writer.finish()
    return stream.getvalue()


def test_several_topics_prefix_the_names_of_their_fields():
    pytest.importorskip("mcap_ros2")
    messages = [
        ("/a", "json", 1_500_000_000, {"x": 1}),
        ("/b", "json", 1_000_000_000, {"x": 5}),
        ("/a", "json", 2_000_000_000, {"x": 2}),
    ]
    assert lists(read_mcap(recording(messages), REQUEST)) == {
        "/a/x": ([0.5, 1.0], [1.0, 2.0]),
        "/b/x": ([0.0], [5.0]),
    }
    assert lists(read_mcap(recording(messages), REQUEST._replace(table="/a"))) == {
        "x": ([0.0, 0.5], [1.0, 2.0])
    }
    with pytest.raises(InputError, match="holds no readable messages with numbers"):
        read_mcap(recording(messages), REQUEST._replace(table="/c"))
    odd = [*messages, ("/d", "protobuf", 3_000_000_000, {})]
    assert read_mcap(recording(odd), REQUEST).notes == (
        "bristle ignores messages in unsupported encodings: /d (protobuf)",
    )


LEAD = b"TDSm" + bytes(8) + (12).to_bytes(8, "little") + bytes(8)
BIG = b"TDSm" + (1 << 6).to_bytes(4, "little") + bytes(4) + (12).to_bytes(8, "big") + bytes(8)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (LEAD + bytes(11), "its last segment is not complete"),
        (BIG + bytes(12) + bytes(40), "at byte 40"),
        (LEAD + bytes(12) + b"TDSm", "is truncated"),
    ],
)
def test_a_tdms_file_ends_with_its_last_segment(data, words):
    with pytest.raises(InputError, match=words):
        recorders._refuse_truncated(data, REQUEST.source)
    recorders._refuse_truncated(LEAD + bytes(12), REQUEST.source)
    recorders._refuse_truncated(BIG + bytes(12) + LEAD + bytes(12), REQUEST.source)
    with pytest.raises(InputError, match=r"is damaged, or not a TDMS file \(at byte 0\)"):
        read_tdms(b"x" * 40, REQUEST)


def test_remarks_of_a_library_on_damage_are_collected_and_not_printed(monkeypatch):
    handler = pytest.importorskip("nptdms.log").log_manager.console_handler
    monkeypatch.setattr(handler, "filters", [])
    remarks = recorders._remarks_kept()
    for text in ("Segment size is wrong", "Error decoding string of a name"):
        assert not handler.filter(
            logging.LogRecord("nptdms", logging.WARNING, "", 0, text, (), None)
        )
    assert remarks == ["Segment size is wrong"]
