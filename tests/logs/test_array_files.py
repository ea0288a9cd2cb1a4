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
        file["t"], file["x"] = TIME, X
        file["x"].attrs["unit"] = np.bytes_(b"mm")
        file["name"] = "a text"
        file["t"].attrs["units"] = 3.0

    table = read_hdf5(hdf5(fill), request_of())
    assert list(table.columns) == ["t", "x"]
    assert table.units == {"x": "mm"}
    assert table.format == "HDF5"
    assert set(table.notes) == {
        "bristle ignores name, because it holds no column of numbers",
        "bristle ignores the unit of t, because it is not text",
    }


def test_a_data_set_that_is_linked_twice_is_read_once_and_one_elsewhere_is_refused():
    def twice(file):
        file["run/t"] = TIME
        file["run/same"] = file["run/t"]
        file["run/soft"] = h5py.SoftLink("/run/t")

    assert len(read_hdf5(hdf5(twice), request_of()).columns) == 1

    def elsewhere(file):
        file["t"] = TIME
        file["x"] = h5py.ExternalLink("other.h5", "x")

    with pytest.raises(InputError, match="x is a link to another file, but bristle reads only this file"):
        read_hdf5(hdf5(elsewhere), request_of())


def test_time_runs_along_the_longer_side_of_a_matrix():
    for matrix in (np.stack([TIME, X]), np.stack([TIME, X], axis=1)):
        table = read_npz(npz(log=matrix), request_of())
        assert table.columns["column_1"].tolist() == TIME.tolist()
        assert table.columns["column_2"].tolist() == X.tolist()
        columns = read_mat(mat(log=matrix), request_of()).columns
        assert [values.tolist() for values in columns.values()] == [TIME.tolist(), X.tolist()]


def test_arrays_of_one_number_are_constants_and_texts_are_left_out():
    table = read_npz(npz(t=TIME, x=X, rated=np.array(2.5), words=np.array(["a", "b"])), request_of())
    assert list(table.columns) == ["t", "x"]
    assert table.constants == {} or table.constants == {"rated": 2.5}
    assert "bristle ignores words, because it holds no column of numbers" in table.notes
    table = read_mat(mat(t=TIME, rated=2.5, axis={"x": X}, cube=np.zeros((3, 4, 5))), request_of())
    assert table.constants == {"rated": 2.5}
    assert set(table.columns) == {"t", "axis.x"}
    assert "bristle ignores cube, because it has 3 dimensions" in table.notes


def test_one_array_alone_is_a_table_of_the_name_of_its_file():
    stream = io.BytesIO()
    np.save(stream, np.stack([TIME, X], axis=1))
    assert list(read_npz(stream.getvalue(), request_of()).columns) == ["column_1", "column_2"]
    cut = stream.getvalue()[:-200]
    with pytest.raises(ValueError, match="announces 60 numbers, but the file is shorter"):
        read_npz(cut, request_of())
    objects = io.BytesIO()
    np.save(objects, np.array([{"a": 1}]), allow_pickle=True)
    with pytest.raises(InputError, match="holds Python objects"):
        read_npz(objects.getvalue(), request_of())


def test_content_above_the_size_limit_is_refused_before_it_is_read():
    data = npz(t=TIME, x=X)
    with pytest.raises(InputError, match=r"run\.bin: t: has 368 B, more than the limit"):
        read_npz(data, request_of(limit=367))
    with pytest.raises(InputError, match="more than the limit"):
        read_mat(mat(t=np.zeros(9000)), request_of(limit=1000))
    assert read_mat(mat(t=np.zeros(9000)), request_of(limit=80_000)).columns["t"].size == 9000
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("note.txt", "no array")
        archive.writestr("t.npy", zipfile.ZipFile(io.BytesIO(data)).read("t.npy"))
    assert list(read_npz(stream.getvalue(), request_of()).columns) == ["t"]


def test_a_mat_file_ends_with_its_last_element():
    data = mat(t=TIME)
    assert list(read_mat(data, request_of()).columns) == ["t"]
    for wrong in (data[:-8], data[:128]):
        with pytest.raises(InputError, match="is truncated"):
            read_mat(wrong, request_of())


def test_cells_within_cells_are_read_to_sixty_four_deep():
    def nested(depth):
        element = struct.pack("<II", 14, 0)
        for _ in range(depth - 1):
            element = struct.pack("<II", 14, len(element)) + element
        return mat(t=TIME)[:128] + element

    with pytest.raises(InputError, match="holds too deeply nested cells"):
        read_mat(nested(65), request_of())


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
        "clock": (pyarrow.array([2_000_000, 3_000_000, 5_000_000], pyarrow.time64("us")), [2.0, 3.0, 5.0]),
        "lasts": (pyarrow.array([2_000, 3_000, 5_000], pyarrow.duration("ms")), [2.0, 3.0, 5.0]),
        "count": (pyarrow.array([1, None, 3]), [1.0, np.nan, 3.0]),
        "exact": (pyarrow.array(exact, pyarrow.decimal128(5, 2)), [0.25, np.nan, -1.5]),
        "on": (pyarrow.array([True, False, True]), [1.0, 0.0, 1.0]),
    }
    arrays = {name: array for name, (array, _) in columns.items()} | {"word": pyarrow.array(["a", "b", "c"])}
    fields = [pyarrow.field(name, array.type, metadata={"unit": "mm"} if name == "count" else None) for name, array in arrays.items()]
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
