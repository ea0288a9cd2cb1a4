"""Records in JSON: counts of a time are times, other large numbers are numbers, and too many names are told."""

import json
from pathlib import Path

import numpy as np
import pytest

from bristle.core import InputError
from bristle.logs import json_records
from bristle.logs.readers import read_table
from bristle.logs.table import ALL, Request


def table_of(tmp_path, records):
    path = tmp_path / "log.json"
    path.write_text(json.dumps(records))
    return read_table(path)


@pytest.mark.parametrize("first", [2**52, 2**53 - 4000, 10**18])
def test_a_large_count_of_an_encoder_is_no_time(tmp_path, first):
    records = [{"t": 1e-3 * k, "position": first + 16 * k, "effort": np.sin(k)} for k in range(200)]
    moved = table_of(tmp_path, records).columns["position"]
    np.testing.assert_array_equal(moved, [float(first + 16 * k) for k in range(200)])


def test_a_count_since_long_ago_is_a_time(tmp_path):
    records = [
        {"time": 1_790_000_000_000_000 + 1000 * k, "position": 0.1 * k, "effort": 1.0 + k}
        for k in range(200)
    ]
    table = table_of(tmp_path, records)
    np.testing.assert_allclose(table.columns["time"], 1e-3 * np.arange(200), atol=1e-12)


def test_a_file_whose_every_record_has_another_name_is_refused_at_once(tmp_path):
    with pytest.raises(InputError, match=r"log\.json.*has 6000 different names in 6000 records"):
        table_of(tmp_path, [{f"t{k}": k} for k in range(6000)])


@pytest.mark.parametrize("count", [2, 3, 200])
@pytest.mark.parametrize("orient", ["split", "index", "columns"])
def test_a_data_frame_not_stored_as_records_is_refused_with_advice(tmp_path, count, orient):
    t, q = [1e-3 * k for k in range(count)], [0.1 * k for k in range(count)]
    frame = {
        "split": {
            "columns": ["t", "q"],
            "index": list(range(count)),
            "data": [list(row) for row in zip(t, q, strict=True)],
        },
        "index": {str(k): {"t": t[k], "q": q[k]} for k in range(count)},
        "columns": {
            "t": dict(zip(map(str, range(count)), t, strict=True)),
            "q": dict(zip(map(str, range(count)), q, strict=True)),
        },
    }
    with pytest.raises(InputError, match='orient="records"'):
        table_of(tmp_path, frame[orient])


def test_rows_without_names_get_default_names(tmp_path):
    rows = [[1e-3 * k, 0.1 * k] for k in range(200)]
    columns = table_of(tmp_path, {"title": "run 7", "data": rows}).columns
    np.testing.assert_array_equal(np.column_stack(list(columns.values())), rows)


REQUEST = Request(Path("log.json"), None, ALL, 2**20)


def read_text(content, **request):
    data = content if isinstance(content, bytes) else json.dumps(content).encode()
    return json_records.read(data, REQUEST._replace(**request))


ROWS = [{"t": 0.001 * k, "q": 1.5 + k, "about": {"u": k}} for k in range(6)]


def test_records_columns_and_signals_are_the_same_table():
    columns = {"t": [row["t"] for row in ROWS], "q": [row["q"] for row in ROWS]}
    signals = [
        {"name": name, "values": values, "unit": "mm"}
        for name, values in columns.items()
        if name == "q"
    ]
    for content in (ROWS, columns, {"log": columns}, {"log": ROWS, "rated": 2.5, "device": "A"}):
        table = read_text(content)
        assert table.columns["q"].tolist() == columns["q"]
        assert table.columns[table.stamps["q"]].tolist() == columns["t"]
    assert (table.constants, table.facts) == ({"rated": 2.5}, {"device": "A"})
    assert read_text(ROWS).columns["about.u"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    two = read_text([*signals, {"name": "u", "values": [1.0] * 6}])
    assert (two.units, two.columns["u"].tolist()) == ({"q": "mm"}, [1.0] * 6)
    assert read_text({"units": {"q": "mm", "t": "s"}, **columns}).units["q"] == "mm"


def test_the_longest_of_several_tables_is_read_unless_one_is_named():
    content = {"a": {"t": [0, 1, 2], "q": [1, 2, 3]}, "b": {"t": [0, 1], "q": [7, 8]}}
    assert read_text(content).columns["q"].tolist() == [1.0, 2.0, 3.0]
    assert read_text(content, table="b").columns["q"].tolist() == [7.0, 8.0]
    with pytest.raises(InputError, match="holds no table 'c'"):
        read_text(content, table="c")
    assert read_text({"a": content["a"]}, table="c").columns["q"].size == 3


def test_the_last_line_of_a_recording_may_be_cut():
    lines = "\n".join(json.dumps(row) for row in ROWS)
    contents = (lines.encode(), lines.encode()[:-4], json.dumps(ROWS).encode("utf-16"))
    assert [read_text(content).columns["q"].size for content in contents] == [6, 5, 6]
    with pytest.raises(InputError, match="is truncated or not JSON"):
        read_text((lines[:30] + lines[35:]).encode())


def test_records_without_a_value_give_a_channel_with_a_lower_rate():
    table = read_text([{"t": k, "q": k} | ({"u": 10 * k} if k % 2 else {}) for k in range(6)])
    assert table.columns["u"].tolist() == [10.0, 30.0, 50.0]
    assert (table.columns[table.stamps["u"]].tolist(), table.columns["q"].size) == (
        [1.0, 3.0, 5.0],
        6,
    )


def test_dates_and_counts_are_seconds_from_the_first():
    dates = ["2024-03-01T10:00:00", "2024-03-01T10:00:00.500", "2024-03-01T10:00:02"]
    table = read_text({"time": dates, "q": [1, 2, 3]})
    assert table.columns[table.stamps["q"]].tolist() == [0.0, 0.5, 2.0]
    for first, per_second in ((17 * 10**14, 1e6), (17 * 10**16, 1e7), (17 * 10**17, 1e9)):
        table = read_text({"time": [first, first + 5, first + 10], "q": [1, 2, 3]})
        assert table.columns[table.stamps["q"]] == pytest.approx(
            [0.0, 5.0 / per_second, 10.0 / per_second]
        )


def test_texts_of_numbers_are_numbers_and_other_texts_are_ignored_with_a_note():
    texts = read_text({"t": [0.0, 1.0], "q": ["1.5", "2.5"], "word": ["a", "b"]})
    assert (texts.columns["q"].tolist(), texts.notes) == (
        [1.5, 2.5],
        ("bristle ignores columns of text: word",),
    )
    with pytest.raises(InputError, match="holds no column of numbers"):
        read_text({"a": ["x", "y"], "b": ["z", "w"]})
