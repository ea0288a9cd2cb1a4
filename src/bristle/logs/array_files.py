"""Logs as arrays and tables: HDF5 and MATLAB 7.3, NPZ and NPY of NumPy, MAT up to version 7.2, Parquet."""

import io
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import IO, Any, Literal

import numpy as np

from bristle.core.content import refuse_larger
from bristle.core.errors import InputError
from bristle.logs.table import NUMBER_BYTES, Request, Table
from bristle.logs.tables import Series, Stored, flattened, table_from, table_of_series, tall
from bristle.logs.words import distinct

UNIT_ATTRIBUTES = ("unit", "units")


def read_hdf5(data: bytes, request: Request) -> Table:
    """Return the columns of a group, or of a matrix, of an HDF5 file."""
    import h5py

    separator = "." if data.startswith(b"MATLAB 7.3") else "/"
    values: dict[str, Stored] = {}
    notes: list[str] = []
    with h5py.File(io.BytesIO(data), "r") as content:
        for path, node in _data_sets(content, request.source):
            name = path.replace("/", separator)
            stored = Stored(
                (0,) if node.shape is None else node.shape, node.dtype, lambda node=node: node[()]
            )
            if not stored.holds_columns or _text(node, "MATLAB_class") in (
                "char",
                "cell",
                "function_handle",
            ):
                notes.append(f"bristle ignores {name}, because it holds no column of numbers")
                continue
            unit = next((text for key in UNIT_ATTRIBUTES if (text := _text(node, key))), "")
            values[name] = stored._replace(unit=unit)
            if not unit and any(key in node.attrs for key in UNIT_ATTRIBUTES):
                notes.append(f"bristle ignores the unit of {name}, because it is not text")
        return table_from(values, request, "HDF5", separator=separator, notes=notes)


ONE_FILE = "Copy all signals into one file, for example with h5repack"


def _data_sets(content: Any, source: Path) -> Iterator[tuple[str, Any]]:
    """Yield the name of each data set stored in the file, and the data set; do not follow links to other files."""
    import h5py
    from h5py import h5o  # pyright: ignore[reportAttributeAccessIssue]

    waiting, visited, count = [("", content)], set(), 0
    while waiting:
        before, group = waiting.pop(0)
        for name in group:
            count += 1
            path = f"{before}{name}"
            link = group.get(name, getlink=True)
            elsewhere = (
                f"{path} is a link to another file" if isinstance(link, h5py.ExternalLink) else ""
            )
            if not elsewhere and (name.startswith("#") or not isinstance(link, h5py.HardLink)):
                continue
            node: Any = None if elsewhere else group[name]
            if isinstance(node, h5py.Dataset) and (node.is_virtual or node.external):
                elsewhere = f"the numbers of {path} are in other files"
            if elsewhere:
                raise InputError(
                    f"{elsewhere}, but bristle reads only this file",
                    path=str(source),
                    mend=ONE_FILE,
                )
            address = h5o.get_info(node.id).addr
            if address in visited or count > 100_000:
                continue
            visited.add(address)
            if isinstance(node, h5py.Group):
                waiting.append((f"{path}/", node))
            elif isinstance(node, h5py.Dataset):
                yield path, node


def _text(node: Any, key: str) -> str:
    if key not in node.attrs or node.attrs.get_id(key).get_storage_size() > 200:  # [byte]
        return ""
    value = node.attrs[key]
    value = value[0] if isinstance(value, np.ndarray) and value.shape == (1,) else value
    return (
        value.decode("utf-8", "replace")
        if isinstance(value, bytes)
        else value
        if isinstance(value, str)
        else ""
    )


MOST_ARRAYS = 100_000


def read_npz(data: bytes, request: Request) -> Table:
    """Return the columns of an NPY file with a table, or of an NPZ archive with one array per column."""
    if data.startswith(b"\x93NUMPY"):
        return _table(
            {request.source.stem: _stored(lambda: io.BytesIO(data), len(data), request.source)},
            [],
            request,
        )
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = [member for member in archive.infolist() if member.filename.endswith(".npy")]
        if len(members) > MOST_ARRAYS:
            raise InputError(
                "holds too many arrays",
                path=str(request.source),
                value=len(members),
                allowed=f"up to {MOST_ARRAYS}",
            )
        names, notes = distinct(member.filename.removesuffix(".npy") for member in members)
        stored = {}
        for name, member in zip(names, members, strict=True):
            refuse_larger(member.file_size, request.limit, f"{request.source}: {name}")
            stored[name] = _stored(
                lambda member=member: archive.open(member), member.file_size, request.source
            )
        return _table(stored, notes, request)


def _table(stored: dict[str, Stored], notes: list[str], request: Request) -> Table:
    columns = {name: array for name, array in stored.items() if array.holds_columns}
    remarks = (
        f"bristle ignores {name}, because it holds no column of numbers"
        for name in stored
        if name not in columns
    )
    return table_from(columns, request, "NPZ", notes=(*notes, *remarks))


def _stored(opened: Callable[[], IO[bytes]], size: int, source: Path) -> Stored:
    """Return the array that its head describes; refuse a file that is too short for it."""
    with opened() as file:
        version = np.lib.format.read_magic(file)
        header: Any = (
            np.lib.format.read_array_header_1_0
            if version == (1, 0)
            else np.lib.format.read_array_header_2_0
        )
        # [byte] at most, before the numbers of an array
        shape, _, dtype = header(file, max_header_size=10_000)
    if dtype.hasobject:
        raise InputError(
            "holds Python objects, which bristle does not read",
            path=str(source),
            mend="Save arrays of numbers",
        )

    def read() -> np.ndarray:
        with opened() as file:
            return np.lib.format.read_array(file, allow_pickle=False)

    stored = Stored(tuple(shape), dtype, read)
    if stored.size * dtype.itemsize > size:
        raise ValueError(
            f"the header of an array announces {stored.size} numbers, but the file is shorter"
        )
    return stored


MAT = b"MATLAB 5.0"
HEADER_BYTES, TAG_BYTES = 128, 8
DEEPEST = 64


def read_mat(data: bytes, request: Request) -> Table:
    """Return the columns of a MAT file; fields of structures are named ``structure.field``."""
    if data.startswith(MAT):
        _examine(data, request.source, request.limit)
    import scipy.io

    series, constants, notes = [], {}, []
    variables = scipy.io.loadmat(io.BytesIO(data), simplify_cells=True)
    for full, value in flattened(_with_lists(variables), depth=2 * DEEPEST):
        values = np.asarray(value)
        if values.dtype.kind not in "fiub" or not values.size or full.startswith("__"):
            continue
        if values.size == 1:
            constants[full] = float(values.reshape(()))
        elif values.ndim > 2 and 1 not in values.shape:
            notes.append(f"bristle ignores {full}, because it has {values.ndim} dimensions")
        else:  # time runs along the longer side of a matrix
            vector = values.ndim == 1 or 1 in values.shape
            columns = (
                {full: values.reshape(-1)}
                if vector
                else {f"{full}[{k}]": column for k, column in enumerate(tall(values).T)}
            )
            series += [Series(name, numbers) for name, numbers in columns.items()]
    return table_of_series(series, request, "MAT", constants=constants, notes=notes)


def _with_lists(value: Any) -> Any:
    """Return structures and cells as tables and lists."""
    if isinstance(value, dict):
        return {name: _with_lists(inner) for name, inner in value.items()}
    cells = isinstance(value, np.ndarray) and value.dtype == object and value.ndim == 1
    return list(map(_with_lists, value)) if cells or isinstance(value, list) else value


def _examine(data: bytes, source: Path, limit: int) -> None:
    """Walk over the elements by their lengths: the last must end with the file, and all must fit."""
    order = "little" if data[126:128] == b"IM" else "big"
    at, unpacked = HEADER_BYTES, 0
    while at < len(data):
        kind, length = _tag(data, at, order)
        begin, at = at + TAG_BYTES, at + TAG_BYTES + length
        if at > len(data):
            break
        element = data[begin - TAG_BYTES : at]
        if kind == 15:
            with suppress(zlib.error):  # the reader reports the damage
                element = zlib.decompressobj().decompress(data[begin:at], limit - unpacked + 1)
                unpacked += len(element)
            refuse_larger(unpacked, limit, source)
        _refuse_deep(element, order, source)
    if at != len(data) or at == HEADER_BYTES:
        announced = max(at, HEADER_BYTES + TAG_BYTES)
        raise InputError(
            f"is truncated: it has {len(data)} bytes, but its content announces {announced} bytes",
            path=str(source),
            mend="Copy or save it again",
        )


def _tag(data: bytes, at: int, order: Literal["little", "big"]) -> tuple[int, int]:
    """Return the kind of the element at this byte, and its length [byte]."""
    kind, length = (int.from_bytes(data[at + i : at + i + 4], order) for i in (0, 4))
    # A small element has its length in the upper half of the kind, and its data in place of the length.
    return (kind & 0xFFFF, 0) if kind >> 16 else (kind, length)


def _refuse_deep(element: bytes, order: Literal["little", "big"], source: Path) -> None:
    """Refuse deeply nested cells: the native reader recurses into each until its stack overflows."""
    at, ends = 0, []
    while at + TAG_BYTES <= len(element):
        while ends and at >= ends[-1]:
            ends.pop()
        kind, length = _tag(element, at, order)
        at += TAG_BYTES
        if kind == 14:
            ends.append(at + length)
        else:
            at += -(-length // TAG_BYTES) * TAG_BYTES
        if len(ends) > DEEPEST:
            raise InputError(
                "holds too deeply nested cells",
                path=str(source),
                allowed=f"up to {DEEPEST} levels of cells",
                mend="Save the signals as vectors",
            )


SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


def read_parquet(data: bytes, request: Request) -> Table:
    """Return the columns of a Parquet file; time stamps become seconds from the first time stamp."""
    import pyarrow.parquet
    from pyarrow import types

    file = pyarrow.parquet.ParquetFile(io.BytesIO(data))
    names, notes = distinct(file.schema_arrow.names)
    # Columns of the same name can only be read together.
    selection = None if notes else [name for name in names if request.choice(name)]
    count = len(names if selection is None else selection)
    refuse_larger(file.metadata.num_rows * NUMBER_BYTES * count, request.limit, request.source)
    content = file.read(columns=selection, use_threads=False)
    columns = dict(
        zip(names if selection is None else content.schema.names, content.columns, strict=True)
    )
    series = []
    for name, part in zip(names, file.schema_arrow, strict=True):
        may_be_numbers = types.is_primitive(part.type) or types.is_decimal(part.type)
        values = _numbers(columns[name]) if may_be_numbers and request.choice(name) else None
        if request.choice(name) and values is None:
            notes.append(f"bristle ignores column {name!r}, because it holds no numbers")
        elif may_be_numbers:
            metadata, is_time = (
                part.metadata or {},
                types.is_timestamp(part.type) or types.is_time(part.type),
            )
            unit = next(
                (
                    metadata[key].decode("utf-8", "replace")
                    for key in (b"unit", b"units")
                    if key in metadata
                ),
                "",
            )
            series.append(Series(name, values, unit=unit or ("s" if is_time else "")))
    return table_of_series(series, request, "Parquet", notes=notes)


def _numbers(column: Any) -> np.ndarray | None:
    """Return a column as numbers, with NaN for missing values; None if it holds anything else."""
    import pyarrow

    if pyarrow.types.is_time(column.type):
        counts = column.cast(
            pyarrow.int32() if pyarrow.types.is_time32(column.type) else pyarrow.int64()
        )
        return counts.to_numpy().astype(float) * SECONDS[column.type.unit]
    # pandas would return integers and booleans with gaps as objects.
    may_lack = (pyarrow.types.is_decimal, pyarrow.types.is_integer, pyarrow.types.is_boolean)
    values = (
        column.cast(pyarrow.float64(), safe=False)
        if any(is_so(column.type) for is_so in may_lack)
        else column
    ).to_numpy()
    if values.dtype.kind == "M":
        return (values - values[:1]) / np.timedelta64(1, "s")
    if values.dtype.kind == "m":
        return values / np.timedelta64(1, "s")
    return values.astype(float) if values.dtype.kind in "fiub" else None
