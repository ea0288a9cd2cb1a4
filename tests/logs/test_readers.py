"""MAT and TDMS, and which reader is chosen; files of several tables are in `test_tables`."""

from __future__ import annotations

import hashlib
import sys

import numpy as np
import pytest
import scipy.io
from tests.logs.conftest import WRITERS, write_tdms

from bristle.core.errors import InputError, MissingExtraError
from bristle.logs.readers import read_table


def test_every_kind_of_file_holds_the_same_columns(any_file, recording):
    table = read_table(any_file)
    for name, values in recording.items():
        np.testing.assert_allclose(table.columns[name], values, rtol=1e-11, atol=1e-15)
    assert (table.origin.checksum, table.source) == (
        hashlib.sha256(any_file.read_bytes()).hexdigest(),
        any_file,
    )


def test_the_content_decides_not_the_ending(any_file, recording):
    lying = any_file.rename(any_file.with_suffix(".txt"))
    assert set(read_table(lying).columns) == set(recording)


@pytest.fixture
def tdms(tmp_path, recording, here):
    """Write the bytes of a TDMS file, changed or cut, and return where; and the bytes, and where the first segment ends."""
    data = write_tdms(tmp_path / "log.tdms", recording).read_bytes()

    def written(content):
        (tmp_path / "log.tdms").write_bytes(content)
        return tmp_path / "log.tdms"

    return written, data, 28 + int.from_bytes(data[12:20], "little")


@pytest.mark.parametrize("compressed", [True, False])
def test_structures_matrices_and_constants_of_mat_files(tmp_path, compressed):
    path = tmp_path / "log.mat"
    content = {
        "log": {"t": np.arange(5.0), "note": "text"},
        "both": np.arange(10.0).reshape(5, 2),
        "wide": np.arange(10.0).reshape(2, 5),
        "count": np.arange(5, dtype=np.int16),
        "kp": 160.18,
    }
    scipy.io.savemat(path, content, do_compression=compressed)
    table = read_table(path)
    assert set(table.columns) == {"log.t", "both[0]", "both[1]", "wide[0]", "wide[1]", "count"}
    np.testing.assert_array_equal(
        [table.columns["both[1]"], table.columns["wide[1]"]], [[1, 3, 5, 7, 9], [5, 6, 7, 8, 9]]
    )
    assert table.constants == {"kp": 160.18}


def test_a_mat_file_of_version_4_is_read(tmp_path):
    scipy.io.savemat(tmp_path / "log.mat", {"t": np.arange(5.0)}, format="4")
    np.testing.assert_array_equal(read_table(tmp_path / "log.mat").columns["t"], np.arange(5.0))


@pytest.mark.parametrize("compressed", [True, False])
def test_a_mat_file_cut_anywhere_is_refused(tmp_path, recording, compressed):
    whole = tmp_path / "whole.mat"
    scipy.io.savemat(whole, recording, do_compression=compressed)
    data = whole.read_bytes()
    ends = _ends_of_variables(data)
    cuts = set(np.random.default_rng(1).integers(1, len(data), 40).tolist()) | {
        127,
        128,
        130,
        136,
        len(data) - 1,
    }
    for cut in cuts - ends:
        (tmp_path / "part.mat").write_bytes(data[:cut])
        with pytest.raises(InputError, match=r"truncated|damaged"):
            read_table(tmp_path / "part.mat")


def _ends_of_variables(data: bytes) -> set[int]:
    """Where a shorter file would be a valid one, with fewer variables: the reader then misses a column."""
    ends, at = set(), 128
    while at < len(data):
        at += 8 + int.from_bytes(data[at + 4 : at + 8], "little")
        ends.add(at)
    return ends


@pytest.mark.parametrize("count", [1, pytest.param(15, marks=pytest.mark.slow)])
def test_a_tdms_file_cut_anywhere_is_refused(tdms, count):
    written, data, first = tdms
    cuts = set(np.random.default_rng(2).integers(1, len(data), count).tolist()) | {
        27,
        28,
        first + 3,
        len(data) - 1,
    }
    for cut in cuts - {first}:
        with pytest.raises(InputError, match="truncated"):
            read_table(written(data[:cut]))


def test_a_tdms_recording_that_was_never_closed_is_refused(tdms):
    written, data, first = tdms
    with pytest.raises(InputError, match="its last segment is not complete"):
        read_table(written(data[: first + 12] + b"\xff" * 8 + data[first + 20 :]))


def test_a_damaged_tdms_file_is_refused_without_library_prints(tdms, capfd, monkeypatch):
    written, data, _ = tdms
    monkeypatch.undo()  # the other process keeps what a library prints
    at = data.index(b"/'axis'/'t'") + len(b"/'axis'/'t'") + 12  # the count of samples in a chunk
    count = int.from_bytes(data[at : at + 8], "little")
    with pytest.raises(InputError, match="is damaged"):
        read_table(written(data[:at] + (count + 1).to_bytes(8, "little") + data[at + 8 :]))
    assert capfd.readouterr().err == ""


def test_units_and_sample_time_of_tdms_channels(tmp_path, here):
    nptdms = pytest.importorskip("nptdms")
    path = tmp_path / "log.tdms"
    wave = {"wf_increment": 5e-4, "unit_string": "mm"}
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment(
            [
                nptdms.ChannelObject("a", "x", np.arange(8.0), wave),
                nptdms.ChannelObject("a", "y", np.arange(8.0), {"wf_increment": 5e-4}),
                nptdms.ChannelObject("b", "y", np.arange(8, dtype=np.int32), {}),
                nptdms.ChannelObject("b", "remark", ["one", "two"], {}),
            ]
        )
    table = read_table(path)
    assert (set(table.columns), table.units, table.sample_time) == (
        {"x", "a/y", "b/y"},
        {"x": "mm"},
        5e-4,
    )
    assert "'remark', because it holds no numbers" in table.notes[0]


@pytest.mark.parametrize(
    ("kind", "module"), [("h5", "h5py"), ("parquet", "pyarrow"), ("tdms", "nptdms")]
)
def test_a_missing_extra_names_the_line_to_type(tmp_path, recording, monkeypatch, kind, module):
    path = WRITERS[kind](tmp_path / f"log.{kind}", recording)
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(MissingExtraError, match=r'pip install "bristle\[io\]"'):
        read_table(path)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "is empty"),
        (b" \n\n", "is empty"),
        (b"PK\x03\x04rest", "export the log as CSV"),
        (b"\x1f\x8brest", "gunzip"),
        (b"\x89HDF\r\n\x1a\n", "is truncated or damaged, or in an unsupported format"),
        (b"MATLAB 7.3 MAT-file", "is truncated or damaged, or in an unsupported format"),
        (b"PAR1", "is truncated or damaged"),
        (b"\x93NUMPY", "is truncated or damaged"),
        (b"MATLAB 5.0 MAT-file", "is truncated"),
    ],
)
def test_files_that_are_no_logs_are_refused_with_advice(tmp_path, here, content, said):
    path = tmp_path / "log.mat"
    path.write_bytes(content)
    with pytest.raises(InputError, match=said) as caught:
        read_table(path)
    assert caught.value.path == str(path)


def test_a_file_that_is_not_there_is_refused_with_a_similar_name(tmp_path):
    (tmp_path / "axis_log.csv").write_text("t\n")
    with pytest.raises(InputError, match=r"there is no such file\. Did you mean 'axis_log\.csv'"):
        read_table(tmp_path / "axislog.csv")


def test_a_time_channel_of_tdms_is_in_seconds(tmp_path, here):
    nptdms = pytest.importorskip("nptdms")
    start = np.datetime64("2026-03-14T09:31:12.000000", "us")
    stamps = start + np.arange(0, 2000, 20).astype("timedelta64[ms]")
    with nptdms.TdmsWriter(tmp_path / "log.tdms") as writer:
        writer.write_segment(
            [
                nptdms.ChannelObject("a", "Zeit", stamps),
                nptdms.ChannelObject("a", "Weg", np.arange(100.0)),
            ]
        )
    table = read_table(tmp_path / "log.tdms")
    assert table.units["Zeit"] == "s"
    assert table.columns["Zeit"] == pytest.approx(0.02 * np.arange(100), abs=1e-9)
