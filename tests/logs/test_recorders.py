"""Recorders whose channels bring their own times: names, times, units, and values that hold on."""

import json
import logging
from pathlib import Path

import numpy as np
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


def test_each_signal_of_a_trace_has_the_times_at_which_it_was_taken():
    data = trace(
        ['id="f1" description="Lage" units="mm" name="/a [u1, 3]"', 'id="f2" name="Strom" unit="A"'],
        [(0.5, 'f1="1.5"'), (1.0, 'f1="2.5" f2="7"'), (1.5, 'f2="8"')],
    )
    table = read_sinumerik(data, REQUEST)
    assert table.columns["Lage"].tolist() == [1.5, 2.5]
    assert table.columns[table.stamps["Lage"]].tolist() == [0.5, 1.0]
    assert table.columns["Strom"].tolist() == [7.0, 8.0]
    assert table.columns[table.stamps["Strom"]].tolist() == [1.0, 1.5]
    assert (table.units["Lage"], table.units["Strom"]) == ("mm", "A")
    assert table.about == {"Lage": "/a [u1, 3]", "Strom": "Strom"}
    assert table.format == "SINUMERIK trace"


def test_missing_values_repeat_the_previous_and_a_missing_start_is_left_out():
    data = trace(
        ['id="f1" name="q"'], [(0, 'f1=""'), (1, 'f1="9.3e18"'), (2, 'f1="4"'), (3, 'f1="9.3e18"'), (4, 'f1=""'), (5, 'f1="-9.1e18"')]
    )
    table = read_sinumerik(data, REQUEST)
    assert table.columns["q"].tolist() == [4.0, 4.0, -9.1e18]
    assert table.columns[table.stamps["q"]].tolist() == [2.0, 3.0, 5.0]


def test_signals_with_equal_descriptions_have_the_index_of_their_axis():
    alike = ['id="f1" description="Lage" name="/a [u1, 3]"', 'id="f2" description="Lage" name="/a [u1, 4]"']
    table = read_sinumerik(trace(alike, [(0, 'f1="1" f2="2"'), (1, 'f1="3" f2="4"')]), REQUEST)
    assert {"Lage [u1, 3]", "Lage [u1, 4]"} <= set(table.columns)
    unnamed = read_sinumerik(trace([], [(0, 'f7="1"'), (1, 'f7="3"')]), REQUEST)
    assert "f7" in unnamed.columns


def test_xml_without_a_trace_is_refused():
    with pytest.raises(InputError, match="is not a trace with records of signals"):
        read_sinumerik(trace(['id="f1" name="q"'], []), REQUEST)
    with pytest.raises(InputError, match="is truncated or damaged"):
        read_sinumerik(trace(['id="f1" name="q"'], [(0, 'f1="1"')])[:-9], REQUEST)
    with pytest.raises(InputError, match="declares XML entities"):
        read_sinumerik(b'<!DOCTYPE a [<!ENTITY b "c">]><a/>', REQUEST)


class Stamp:
    def __init__(self, sec, nanosec):
        self.sec, self.nanosec = sec, nanosec


class Plain:
    def __init__(self, **fields):
        self.__dict__.update(fields)


def test_a_message_has_its_stated_time():
    assert recorders._stamp(Plain(header=Plain(stamp=Stamp(3, 5)))) == 3_000_000_005
    assert recorders._stamp(Plain(header=None, stamp=Stamp(0, 7))) == 7
    assert recorders._stamp({"stamp": {"sec": 2, "nsec": 9}}) == 2_000_000_009
    assert recorders._stamp(Plain(header=None, stamp=Stamp(0, 0))) is None  # a clock that was never set
    assert recorders._stamp({"stamp": 3.0}) is None
    assert recorders._stamp({}) is None


def test_numbers_of_a_message_have_the_path_of_their_field():
    content = {"header": {"seq": 3}, "stamp": 9.0, "a": {"b": [1, 2.5]}, "on": True, "word": "x"}
    assert list(recorders._numbers(content)) == [("a.b[0]", 1.0), ("a.b[1]", 2.5), ("on", 1.0)]
    assert list(recorders._numbers({"long": [0.0] * 1001})) == []
    assert len(list(recorders._numbers({"long": [0.0] * 1000}))) == 1000
    joints = Plain(name=["j1", "j2"], position=[1.0, 2.0], velocity=[], effort=[3.0, 4.0])
    assert list(recorders._numbers(joints)) == [("j1.position", 1.0), ("j2.position", 2.0), ("j1.effort", 3.0), ("j2.effort", 4.0)]
    deep = {"a": {"a": {"a": {"a": {"a": {"a": {"a": 1.0}}}}}}}
    assert list(recorders._numbers(deep)) in ([("a.a.a.a.a.a.a", 1.0)], [])
    assert list(recorders._numbers({"a": deep})) == []


def recording(messages):
    writer_library = pytest.importorskip("mcap.writer")
    import io

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
    messages = [("/a", "json", 1_500_000_000, {"x": 1}), ("/b", "json", 1_000_000_000, {"x": 5}), ("/a", "json", 2_000_000_000, {"x": 2})]
    table = read_mcap(recording(messages), REQUEST)
    assert table.columns["/a/x"].tolist() == [1.0, 2.0]
    assert table.columns[table.stamps["/a/x"]].tolist() == [0.5, 1.0]
    assert table.columns[table.stamps["/b/x"]].tolist() == [0.0]
    single = read_mcap(recording(messages), REQUEST._replace(table="/a"))
    assert single.columns["x"].tolist() == [1.0, 2.0]
    assert single.columns[single.stamps["x"]].tolist() == [0.0, 0.5]
    with pytest.raises(InputError, match="holds no readable messages with numbers"):
        read_mcap(recording(messages), REQUEST._replace(table="/c"))
    odd = [*messages, ("/d", "protobuf", 3_000_000_000, {})]
    assert read_mcap(recording(odd), REQUEST).notes == ("bristle ignores messages in unsupported encodings: /d (protobuf)",)


def test_a_tdms_file_ends_with_its_last_segment():
    with pytest.raises(InputError, match=r"is damaged, or not a TDMS file \(at byte 0\)"):
        read_tdms(b"x" * 40, REQUEST)
    lead = b"TDSm" + bytes(8) + (12).to_bytes(8, "little") + bytes(8)
    with pytest.raises(InputError, match="its last segment is not complete"):
        recorders._refuse_truncated(lead + bytes(11), REQUEST.source)
    recorders._refuse_truncated(lead + bytes(12), REQUEST.source)
    big = b"TDSm" + (1 << 6).to_bytes(4, "little") + bytes(4) + (12).to_bytes(8, "big") + bytes(8)
    recorders._refuse_truncated(big + bytes(12) + lead + bytes(12), REQUEST.source)
    with pytest.raises(InputError, match="at byte 40"):
        recorders._refuse_truncated(big + bytes(12) + bytes(40), REQUEST.source)


def test_a_file_that_is_cut_off_within_a_lead_in_is_truncated():
    lead = b"TDSm" + bytes(8) + (12).to_bytes(8, "little") + bytes(8)
    with pytest.raises(InputError, match="is truncated"):
        recorders._refuse_truncated(lead + bytes(12) + b"TDSm", REQUEST.source)
    assert np.isfinite(recorders.NO_VALUE)


def test_remarks_of_a_library_on_damage_are_collected_and_not_printed():
    log_manager = pytest.importorskip("nptdms.log").log_manager
    handler, before = log_manager.console_handler, list(log_manager.console_handler.filters)
    try:
        remarks = recorders._remarks_kept()
        for text in ("Segment size is wrong", "Error decoding string of a name"):
            assert not handler.filter(logging.LogRecord("nptdms", logging.WARNING, "", 0, text, (), None))
        assert remarks == ["Segment size is wrong"]
    finally:
        handler.filters[:] = before
