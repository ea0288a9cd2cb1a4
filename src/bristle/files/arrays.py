"""Named arrays as a file in a folder of results: Parquet if pyarrow is installed, otherwise NPZ."""

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core import InputError, MissingExtraError, library
from bristle.files.results import Results

WANTED_BY = "the columns of a Parquet file"


def write_arrays(folder: Results, stem: str, arrays: Mapping[str, np.ndarray]) -> str:
    """Write arrays of one length into a folder of results; return the name of the file."""
    out, plain = (
        io.BytesIO(),
        {name: np.asarray(values, dtype=float) for name, values in arrays.items()},
    )
    try:
        pyarrow, parquet = library("pyarrow", WANTED_BY), library("pyarrow.parquet", WANTED_BY)
    except MissingExtraError:
        np.savez_compressed(out, **plain)  # type: ignore[arg-type]
        name = f"{stem}.npz"
    else:
        columns = []
        for values in plain.values():  # one or two dimensions; avoids the slow import of pandas
            flat = np.ascontiguousarray(values).reshape(-1)
            cells = pyarrow.Array.from_buffers(
                pyarrow.float64(), flat.size, [None, pyarrow.py_buffer(flat)]
            )
            columns.append(
                cells
                if values.ndim == 1
                else pyarrow.FixedSizeListArray.from_arrays(cells, values.shape[1])
            )
        parquet.write_table(pyarrow.Table.from_arrays(columns, list(plain)), out)
        name = f"{stem}.parquet"
    folder.write(name, out.getvalue())
    return name


def read_arrays(folder: Path, stem: str) -> dict[str, np.ndarray]:
    """Return the arrays of a file from `write_arrays` by name; an empty dict if the file is missing."""
    path = folder / f"{stem}.parquet"
    path = path if path.is_file() else folder / f"{stem}.npz"
    parquet = library("pyarrow.parquet", str(path)) if path.suffix == ".parquet" else None
    try:
        if parquet is not None:
            table: Any = parquet.read_table(path)
            return {
                name: np.array(table[name].to_pylist(), dtype=float) for name in table.column_names
            }
        return dict(np.load(path)) if path.is_file() else {}
    except Exception as error:  # noqa: BLE001  (libraries raise many kinds of errors for a broken file)
        raise InputError(
            f"cannot be read ({error})", path=str(path), mend="Save the results again"
        ) from None
