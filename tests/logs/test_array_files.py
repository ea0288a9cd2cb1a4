"""Arrays in files: what is a column, where time runs, what lies elsewhere, what is announced and not there."""

import decimal
import io
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from bristle.core.errors import InputError
from bristle.logs.array_files import read_hdf5, read_mat, read_npz, read_parquet
from bristle.logs.table import ALL, Choice, Request

h5py = pytest.importorskip("h5py")
TIME, X = np.arange(30.0), np.linspace(0.0, 2.0, 30)


def request_of(table=None, choice=ALL, limit=2**20):
    return Request(Path("run.bin"), table, choice, limit)


def hdf5(fill):
    stream = io.BytesIO()
    with h5py.File(stream, "w") as file:
        fill(file)
    return stream.getvalue()


def npz(**arrays):
    stream = io.BytesIO()
    np.savez(stream, **arrays)
    return stream.getvalue()


def mat(**variables):
    stream = io.BytesIO()
    scipy.io.savemat(stream, variables, do_compression=True)
    return stream.getvalue()


def test_data_sets_of_hdf5_are_columns_with_units_from_their_attributes():
    def fill(file):
        file["t"], file["x"], file["name"] = TIME, X, "a text"
        file["x"].attrs["unit"] = np.bytes_(b"mm")
        file["t"].attrs["units"] = 3.0

    table = read_hdf5(hdf5(fill), request_of())
    assert (list(table.columns), table.units, table.format) == (["t", "x"], {"x": "mm"}, "HDF5")
    assert set(table.notes) == {
        "bristle ignores name, because it holds no column of numbers",
        "bristle ignores the unit of t, because it is not text",
    }


@pytest.mark.parametrize("link", [lambda file: file["t"], lambda file: h5py.SoftLink("/t")])
def test_a_data_set_that_is_linked_twice_is_read_once(link):
    def twice(file):
        file["t"] = TIME
        file["same"] = link(file)

    assert len(read_hdf5(hdf5(twice), request_of()).columns) == 1


@pytest.mark.parametrize("matrix", [np.stack([TIME, X]), np.stack([TIME, X], axis=1)])
@pytest.mark.parametrize(("read", "write"), [(read_npz, npz), (read_mat, mat)])
def test_time_runs_along_the_longer_side_of_a_matrix(read, write, matrix):
    columns = read(write(log=matrix), request_of()).columns
    assert [values.tolist() for values in columns.values()] == [TIME.tolist(), X.tolist()]


def test_arrays_of_one_number_are_constants_and_texts_are_left_out():
    table = read_npz(
        npz(t=TIME, x=X, rated=np.array(2.5), words=np.array(["a", "b"])), request_of()
    )
    assert (list(table.columns), table.constants) == (["t", "x"], {"rated": 2.5})
    assert "bristle ignores words, because it holds no column of numbers" in table.notes
    table = read_mat(mat(t=TIME, rated=2.5, axis={"x": X}, cube=np.zeros((3, 4, 5))), request_of())
    assert (set(table.columns), table.constants) == ({"t", "axis.x"}, {"rated": 2.5})
    assert "bristle ignores cube, because it has 3 dimensions" in table.notes


def npy(array):
    stream = io.BytesIO()
    np.save(stream, array, allow_pickle=True)
    return stream.getvalue()


ALONE = npy(np.stack([TIME, X], axis=1))


def test_one_array_alone_is_a_table_and_other_members_of_an_archive_are_left_out():
    assert list(read_npz(ALONE, request_of()).columns) == ["column_1", "column_2"]
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("note.txt", "no array")
        archive.writestr("t.npy", npy(TIME))
    assert list(read_npz(stream.getvalue(), request_of()).columns) == ["t"]


def cells(depth):
    """Cells within cells."""
    element = struct.pack("<II", 14, 0)
    for _ in range(depth - 1):
        element = struct.pack("<II", 14, len(element)) + element
    return mat(t=TIME)[:128] + element


@pytest.mark.parametrize(
    ("read", "data", "limit", "words"),
    [
        (read_npz, ALONE[:-200], 2**20, "announces 60 numbers, but the file is shorter"),
        (read_npz, npy(np.array([{"a": 1}])), 2**20, "holds Python objects"),
        (read_npz, npz(t=TIME, x=X), 367, r"run\.bin: t: has 368 B, more than the limit"),
        (read_mat, mat(t=np.zeros(9000)), 1000, "more than the limit"),
        (read_mat, mat(t=TIME)[:-8], 2**20, "is truncated"),
        (read_mat, mat(t=TIME)[:128], 2**20, "is truncated"),
        (read_mat, cells(65), 2**20, "holds too deeply nested cells"),
    ],
)
def test_content_that_is_not_there_too_large_or_too_deep_is_refused(read, data, limit, words):
    with pytest.raises((InputError, ValueError), match=words):
        read(data, request_of(limit=limit))


def test_content_within_the_limit_is_read():
    assert read_mat(mat(t=np.zeros(9000)), request_of(limit=80_000)).columns["t"].size == 9000


def parquet(table):
    parquet_library = pytest.importorskip("pyarrow.parquet")
    stream = io.BytesIO()
    parquet_library.write_table(table, stream)
    return stream.getvalue()


def test_columns_of_parquet_are_numbers_with_gaps_and_seconds_from_the_first_stamp():
    pyarrow = pytest.importorskip("pyarrow")
    exact = [decimal.Decimal("0.25"), None, decimal.Decimal("-1.50")]
    columns = {
        "at": (pyarrow.array([1_000, 1_500, 4_000], pyarrow.timestamp("ms")), [0.0, 0.5, 3.0]),
        "day": (pyarrow.array([2_000, 3_000, 5_000], pyarrow.time32("ms")), [2.0, 3.0, 5.0]),
        "clock": (
            pyarrow.array([2_000_000, 3_000_000, 5_000_000], pyarrow.time64("us")),
            [2.0, 3.0, 5.0],
        ),
        "lasts": (pyarrow.array([2_000, 3_000, 5_000], pyarrow.duration("ms")), [2.0, 3.0, 5.0]),
        "count": (pyarrow.array([1, None, 3]), [1.0, np.nan, 3.0]),
        "exact": (pyarrow.array(exact, pyarrow.decimal128(5, 2)), [0.25, np.nan, -1.5]),
        "on": (pyarrow.array([True, False, True]), [1.0, 0.0, 1.0]),
    }
    arrays = {name: array for name, (array, _) in columns.items()} | {
        "word": pyarrow.array(["a", "b", "c"])
    }
    fields = [
        pyarrow.field(name, array.type, metadata={"unit": "mm"} if name == "count" else None)
        for name, array in arrays.items()
    ]
    data = parquet(pyarrow.table(arrays, schema=pyarrow.schema(fields)))
    table = read_parquet(data, request_of())
    for name, (_, values) in columns.items():
        np.testing.assert_array_equal(table.columns[name], values)
    assert table.units == {"at": "s", "day": "s", "clock": "s", "count": "mm"}
    assert table.notes == ("bristle ignores column 'word', because it holds no numbers",)
    chosen = read_parquet(data, request_of(choice=Choice(frozenset({"at"})), limit=24))
    assert (list(chosen.columns), chosen.notes) == (["at"], ())
    assert "count" in chosen.names
    with pytest.raises(InputError, match="more than the limit"):
        read_parquet(data, request_of(limit=100))
