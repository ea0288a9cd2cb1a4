"""Which reader reads a file: by its first bytes, for the ending of a name may lie."""

from __future__ import annotations

import dataclasses
import hashlib
import os
from collections.abc import Callable
from pathlib import Path

from bristle.core.errors import InputError
from bristle.logs.table import Table, close_matches
from bristle.logs.tables import located

__all__ = ["read_table"]

HDF5, PARQUET, ARCHIVE = b"\x89HDF", b"PAR1", b"PK\x03\x04"

# First bytes -> why the file is not read, and what to do.
REFUSED = {
    ARCHIVE: "It is a spreadsheet or an archive: export the log as CSV, or unpack it",
    b"\xd0\xcf\x11\xe0": "It is an old spreadsheet: export the log as CSV",
    b"\x1f\x8b": "It is compressed: unpack it first (gunzip)",
    b"%PDF": "It is a document: export the log as CSV",
    b"MDF ": "It is a measurement data file (MDF): export the log as CSV",
}


def read_table(path: str | os.PathLike[str], table: str | None = None) -> Table:
    """Return the columns of a log, whatever the file is.

    Parameters
    ----------
    path : path-like
        CSV and other text, MAT, TDMS, Parquet, HDF5, or NPZ; ``FILE::TABLE`` names a table in it.
    table : str, optional
        Name of the table, group or array in a file that holds several; where the path names none.

    Raises
    ------
    InputError
        If there is no such file, or it is empty, truncated, or of a kind that is not read.
    """
    source, named = located(path)
    data = _bytes_of(source)
    container = _container(data)
    if container is not None:
        found = container(data, source, named or table)
    else:
        for magic, mend in REFUSED.items():
            if data.startswith(magic):
                raise InputError("is not a log that can be read", path=str(source), mend=mend)
        if named is not None:
            raise InputError("is no file with several tables", path=str(source), value=named,
                             mend="Leave out what follows the name of the file")  # fmt: skip
        found = _reader(data, source)(data, source)
    return dataclasses.replace(found, source=source, checksum=hashlib.sha256(data).hexdigest())


def _container(data: bytes) -> Callable[[bytes, Path, str | None], Table] | None:
    """Return the reader of a file that may hold several tables; None for any other file."""
    from bristle.logs.hdf5 import MAT_73

    if data.startswith((HDF5, MAT_73)):
        from bristle.logs.hdf5 import read_hdf5

        return read_hdf5
    if data.startswith(PARQUET):
        from bristle.logs.parquet import read_parquet

        return read_parquet
    from bristle.logs.npz import ARRAY, holds_arrays, read_npz

    if data.startswith(ARRAY) or (data.startswith(ARCHIVE) and holds_arrays(data)):
        return read_npz
    return None


def _reader(data: bytes, source: Path) -> Callable[[bytes, Path], Table]:
    suffix = source.suffix.lower()
    if data.startswith(b"TDSm") or suffix == ".tdms":
        from bristle.logs.tdms import read_tdms

        return read_tdms
    if data.startswith(b"MATLAB 5.0") or suffix == ".mat":
        from bristle.logs.mat import read_mat

        return read_mat
    from bristle.logs.csv import read_csv

    return read_csv


def _bytes_of(source: Path) -> bytes:
    try:
        data = source.read_bytes()
    except FileNotFoundError:
        there = [one.name for one in source.parent.iterdir()] if source.parent.is_dir() else []
        close = close_matches(source.name, there)
        mend = f"Did you mean {close[0]!r}?" if close else "Check the path"
        raise InputError("there is no such file", path=str(source), mend=mend) from None
    except IsADirectoryError:
        raise InputError("is a folder, not a log", path=str(source), mend="Name a file in it") from None
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", path=str(source)) from None
    if not data.strip():
        raise InputError("is empty", path=str(source), mend="Record or export the log again")
    return data
