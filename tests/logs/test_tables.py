"""HDF5, NPZ and Parquet: several tables in one file, and how one of them is named."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from tests.logs.conftest import WRITERS, write_hdf5

from bristle.core.errors import InputError
from bristle.files import read_axis
from bristle.logs import read_log
from bristle.logs.readers import read_table

h5py = pytest.importorskip("h5py")


@pytest.fixture
def two_groups(tmp_path, recording):
    """Two tests of an axis in one HDF5 file, the second one turned, with a unit and a single number."""
    path = write_hdf5(tmp_path / "tests.h5", recording, "bench/first")
    with h5py.File(path, "a") as file:
        for name, values in recording.items():
            file[f"bench/second/{name}"] = -values
        file["bench/second/q"].attrs["units"] = "mm"
        file["bench/second/fs"] = np.array([[750.0]])
        file["bench/second/remark"] = "a text"
        file["bench/second/cube"] = np.zeros((2, 3, 4))
    return path


def test_a_group_of_an_hdf5_file_is_a_table(two_groups, recording):
    table = read_table(two_groups, "bench/second")
    assert set(table.columns) == set(recording)
    np.testing.assert_array_equal(table.columns["q"], -recording["q"])
    assert (dict(table.units), dict(table.constants), table.tables) == (
        {"q": "mm"},
        {"fs": 750.0},
        (),
    )
    assert {note.split()[2].strip(",") for note in table.notes} == {
        "bench/second/remark",
        "bench/second/cube",
    }


def test_without_a_name_every_column_of_every_table_has_its_full_name(
    request, two_groups, recording, axis
):
    table = read_table(two_groups)
    assert (table.tables, table.units) == (
        ("bench/first", "bench/second"),
        {"bench/second/q": "mm"},
    )
    assert set(table.columns) == {
        f"bench/{test}/{name}" for test in ("first", "second") for name in recording
    }
    request.getfixturevalue("here")
    with pytest.raises(InputError, match=r"holds 2 tables.*FILE::TABLE") as caught:
        read_log(two_groups, axis)
    assert caught.value.allowed == "tables: bench/first, bench/second"


def test_the_path_names_a_table_before_the_axis_does(here, two_groups, recording, axis):
    chosen = dataclasses.replace(axis, table="bench/second")
    log = read_log(f"{two_groups}::bench/first", chosen)
    np.testing.assert_allclose(log.position.values, recording["q"])
    assert (log.source, log.origin.name) == (two_groups, "tests.h5::bench/first")


@pytest.mark.parametrize(
    ("named", "words"),
    [
        ("tests.h5::bench/fist", r"holds no table 'bench/fist'.*Did you mean 'bench/first'"),
        ("log.csv::sweep", "is not a file with several tables"),
    ],
)
def test_a_table_that_is_not_there_is_refused(here, two_groups, tmp_path, recording, named, words):
    WRITERS["csv"](tmp_path / "log.csv", recording)
    with pytest.raises(InputError, match=words):
        read_table(f"{tmp_path}/{named}")


def test_a_name_is_ignored_with_a_note_where_there_is_only_one_table(here, tmp_path, recording):
    table = read_table(write_hdf5(tmp_path / "one.h5", recording, "sweep"), "multisine")
    assert set(table.columns) == set(recording)
    assert table.notes == (
        "this log has no table 'multisine': bristle read its only table, 'sweep'",
    )


def test_columns_without_names_and_with_names_in_an_npz_file(tmp_path, recording):
    matrix = np.stack(list(recording.values()), axis=1)
    named = np.zeros(5, dtype=[("t", float), ("q", "<f4"), ("remark", "U3")])
    named["q"] = 2.5
    np.savez(
        tmp_path / "tests.npz",
        first=matrix,
        wide=matrix[:5].T,
        named=named,
        fs=np.array(1000.0),
        text=["a"],
    )
    table = read_table(tmp_path / "tests.npz", "first")
    assert list(table.columns) == ["column_1", "column_2", "column_3", "column_4"]
    np.testing.assert_array_equal(table.columns["column_2"], recording["q"])
    assert read_table(tmp_path / "tests.npz", "wide").columns["column_4"].shape == (5,)
    assert {
        name: values[0]
        for name, values in read_table(f"{tmp_path}/tests.npz::named").columns.items()
    } == {"t": 0.0, "q": 2.5}
    assert any(
        note.startswith("bristle ignores text, because it holds no column") for note in table.notes
    )
    np.save(tmp_path / "single.npy", matrix)
    np.testing.assert_array_equal(
        read_table(tmp_path / "single.npy").columns["column_2"], recording["q"]
    )


@pytest.mark.parametrize("write", ["csv", "parquet"])
def test_a_table_name_for_a_single_table_is_noted_or_refused(here, tmp_path, recording, write):
    path = WRITERS[write](tmp_path / f"log.{write}", recording)
    assert (
        "the file is a single table: bristle ignores the table name 'x'"
        in read_table(path, "x").notes
    )
    with pytest.raises(InputError, match="is not a file with several tables"):
        read_table(f"{path}::x")


def test_a_file_that_matlab_saved_as_version_7_3(here, tmp_path, recording):
    path = tmp_path / "log.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in recording.items():
            file[f"log/{name}"] = values.reshape(1, -1)
        file["remark"] = np.array([[104, 105]], dtype=np.uint16)
        file["remark"].attrs["MATLAB_class"] = np.bytes_(b"char")
        file["#refs#/a"] = np.arange(3.0)
    path.write_bytes(
        b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512, b" ") + path.read_bytes()[512:]
    )
    table = read_table(path)
    assert set(table.columns) == set(recording)
    np.testing.assert_array_equal(table.columns["u"], recording["u"])


@pytest.mark.parametrize("count", [4, pytest.param(10, marks=pytest.mark.slow)])
@pytest.mark.parametrize("kind", ["h5", "npz", "parquet"])
def test_a_file_cut_anywhere_is_refused(here, tmp_path, recording, kind, count):
    data = WRITERS[kind](tmp_path / f"whole.{kind}", recording).read_bytes()
    part = tmp_path / f"part.{kind}"
    for cut in {*np.random.default_rng(3).integers(8, len(data), count).tolist(), len(data) - 1}:
        part.write_bytes(data[:cut])
        with pytest.raises(InputError, match=r"truncated|damaged|archive"):
            read_table(part)


def test_the_axis_file_names_the_table_and_the_rate(here, tmp_path, two_groups, recording):
    text = """schema = 1
kind = "translational"
[log]
table = "bench/first"
[columns]
position = { column = "q", unit = "m" }
effort = { column = "u", unit = "N" }
[timing]
sample_rate = "1000 Hz"
"""
    (tmp_path / "axis.toml").write_text(text)
    log = read_log(two_groups, read_axis(tmp_path / "axis.toml"))
    assert log.sample_time == pytest.approx(1e-3)
    np.testing.assert_allclose(log.effort.values, recording["u"])
