"""Which reader reads a file: by its first bytes, for the ending of a name may lie."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from bristle.core.content import SIZE_LIMIT, Content, Readable
from bristle.core.errors import InputError, MissingExtraError, said_by_library
from bristle.logs.choice import ALL, Choice
from bristle.logs.json_records import looks_like_json
from bristle.logs.names import with_plain_names
from bristle.logs.request import Request
from bristle.logs.stamped_text import period_told
from bristle.logs.table import Table
from bristle.logs.tables import content_of_log
from bristle.logs.words import is_time

__all__ = ["read_table"]

HDF5, PARQUET, ARCHIVE = b"\x89HDF", b"PAR1", b"PK\x03\x04"
ARRAY = b"\x93NUMPY"
MAT, MAT_73, TDMS = b"MATLAB 5.0", b"MATLAB 7.3", b"TDSm"
MDF, MCAP = b"MDF ", b"\x89MCAP"

# First bytes -> why the file is not read, and what to do.
REFUSED = {
    ARCHIVE: "It is a spreadsheet or an archive: export the log as CSV, or unpack it",
    b"\xd0\xcf\x11\xe0": "It is an old spreadsheet: export the log as CSV",
    b"\x1f\x8b": "It is compressed: unpack it first (gunzip)",
    b"%PDF": "It is a document: export the log as CSV",
}
# Kinds of files that native libraries read, or that ask for a package: module, what they are called, the package, and
# the extra that it comes with.
APART = {
    "hdf5": ("HDF5", "h5py", "io"), "parquet": ("Parquet", "pyarrow", "io"), "tdms": ("TDMS", "nptdms", "io"),
    "mf4": ("MF4", "asammdf", "mf4"), "mcap": ("MCAP", "mcap_ros2", "mcap"),
}  # fmt: skip
HOLD_TABLES = ("hdf5", "npz", "json_records", "mcap")


def read_table(
    given: Readable, table: str | None = None, *, choice: Choice = ALL, size_limit: int = SIZE_LIMIT
) -> Table:
    """Return the columns of a log, whatever the file is.

    Parameters
    ----------
    given : path-like, bytes, file object or Content
        Text, traces of TwinCAT and SINUMERIK, JSON, MAT, TDMS, Parquet, HDF5, NPZ, MF4 or MCAP; ``FILE::TABLE`` names a
        table in it.
    table : str, optional
        Name of the table, group or array in a file that holds several; where the path names none.
    choice : Choice
        Which columns are read; all by default.
    size_limit : int
        Largest file, and largest content that a file announces [byte].

    Raises
    ------
    InputError
        If there is no such file, or it is empty, truncated, too large, or of a kind that is not read.
    """
    content = content_of_log(given, limit=size_limit)
    if not content.data[:1024].strip() and not content.data.strip():
        raise InputError("is empty", path=str(content.source), mend="Record or export the log again")
    kind = _kind_of(content)
    if content.part is not None and kind not in HOLD_TABLES:
        raise InputError("is no file with several tables", path=str(content.source), value=content.part,
                         mend="Leave out what follows the name of the file")  # fmt: skip
    read = _read(kind, content, Request(content.source, content.part or table, choice, size_limit))
    if table is not None and kind not in HOLD_TABLES:
        read = dataclasses.replace(read, notes=(*read.notes, f"the file is one table: {table!r} is not looked for"))
    read = _with_period(read)
    return with_plain_names(dataclasses.replace(read, source=content.source, origin=content.origin))


def _with_period(table: Table) -> Table:
    """Return the table with the time between samples that stands in it as a single number, where it has no times."""
    if table.sample_time is not None or table.stamps or any(map(is_time, table.names)):
        return table
    constants = {re.split(r"[./]", name)[-1]: f"{value!r}" for name, value in table.constants.items()}
    return dataclasses.replace(table, sample_time=period_told(constants))


def _read(kind: str, content: Content, request: Request) -> Table:
    """Read a file; whatever its reader does not foresee is damage of the file."""
    if kind in APART:
        from bristle.logs.apart import read_apart

        _refuse_without(kind, content.source)
        return read_apart(kind, content.data, request)
    read: Callable[..., Table] = import_module(f"bristle.logs.{kind}").read
    try:
        return read(content.data, request)
    except InputError:
        raise
    except MemoryError:
        raise InputError("takes more memory than there is", path=str(content.source), mend="Cut the log") from None
    except Exception as error:  # noqa: BLE001  (a damaged file makes a reader raise anything)
        raise InputError(
            f"is truncated or damaged, or of a kind that is not read{said_by_library(error)}",
            path=str(content.source),
            mend="Copy or save it again",
        ) from None


def _refuse_without(kind: str, source: Path) -> None:
    subject, package, extra = APART[kind]
    if find_spec(package) is None:
        raise MissingExtraError.of(f"{source}: reading {subject}", extra)


def _kind_of(content: Content) -> str:
    data, suffix = content.data, content.source.suffix.lower()
    if data.startswith((HDF5, MAT_73)):
        return "hdf5"
    if data.startswith(PARQUET):
        return "parquet"
    if data.startswith(ARRAY) or (data.startswith(ARCHIVE) and b".npy" in data[26:4096]):
        return "npz"  # each file of an archive of arrays is named so, the first one at its very start
    for magic, mend in REFUSED.items():
        if data.startswith(magic):
            raise InputError("is not a log that can be read", path=str(content.source), mend=mend)
    if data.startswith(MDF):
        return "mf4"
    if data.startswith(MCAP):
        return "mcap"
    if data.startswith(TDMS) or suffix == ".tdms":
        return "tdms"
    if data.startswith(MAT) or suffix == ".mat":
        return "mat"
    if data[:256].lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<"):
        return "sinumerik"
    return "json_records" if looks_like_json(data[:4096]) else "csv"
