"""Records in JSON: counts of a time are times, other large numbers are numbers, and too many names are told."""

import json

import numpy as np
import pytest

from bristle.core import InputError
from bristle.logs.readers import read_table


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
    records = [{"time": 1_790_000_000_000_000 + 1000 * k, "position": 0.1 * k, "effort": 1.0 + k} for k in range(200)]
    table = table_of(tmp_path, records)
    np.testing.assert_allclose(table.columns["time"], 1e-3 * np.arange(200), atol=1e-12)


def test_a_file_whose_every_record_has_another_name_is_refused_at_once(tmp_path):
    with pytest.raises(InputError, match=r"log\.json.*has 6000 different names in 6000 records"):
        table_of(tmp_path, [{f"t{k}": k} for k in range(6000)])


@pytest.mark.parametrize("count", [2, 3, 200])
@pytest.mark.parametrize("orient", ["split", "index", "columns"])
def test_a_data_frame_in_another_order_than_records_is_refused_with_what_to_write(tmp_path, count, orient):
    t, q = [1e-3 * k for k in range(count)], [0.1 * k for k in range(count)]
    frame = {
        "split": {"columns": ["t", "q"], "index": list(range(count)), "data": [list(row) for row in zip(t, q, strict=True)]},
        "index": {str(k): {"t": t[k], "q": q[k]} for k in range(count)},
        "columns": {"t": dict(zip(map(str, range(count)), t, strict=True)), "q": dict(zip(map(str, range(count)), q, strict=True))},
    }
    with pytest.raises(InputError, match='orient="records"'):
        table_of(tmp_path, frame[orient])


def test_rows_without_names_are_read_below_a_head_of_their_own(tmp_path):
    rows = [[1e-3 * k, 0.1 * k] for k in range(200)]
    columns = table_of(tmp_path, {"title": "run 7", "data": rows}).columns
    np.testing.assert_array_equal(np.column_stack(list(columns.values())), rows)
