"""Which reader reads a file: by its first bytes, for the ending of a name may lie."""

from __future__ import annotations

import dataclasses
import hashlib
import os
from collections.abc import Callable
from pathlib import Path

from bristle.core.errors import InputError
from bristle.logs.table import Table, close_matches

__all__ = ["read_table"]

_MAT_73 = "It is of MATLAB's version 7.3 (HDF5), not read here: save it again in MATLAB with save(..., '-v7')"

# First bytes -> why the file is not read, and what to do.
REFUSED = {
    b"MATLAB 7.3": _MAT_73,
    b"\x89HDF": _MAT_73,
    b"PK\x03\x04": "It is a spreadsheet or an archive: export the log as CSV, or unpack it",
    b"\xd0\xcf\x11\xe0": "It is an old spreadsheet: export the log as CSV",
    b"\x1f\x8b": "It is compressed: unpack it first (gunzip)",
    b"PAR1": "It is a Parquet file: write the log as CSV",
    b"%PDF": "It is a document: export the log as CSV",
    b"MDF ": "It is a measurement data file (MDF): export the log as CSV",
}


def read_table(path: str | os.PathLike[str]) -> Table:
    """Return the columns of a log, whatever the file is.

    Parameters
    ----------
    path : path-like
        CSV and other text, MAT (version 5 to 7.2), or TDMS.

    Raises
    ------
    InputError
        If there is no such file, or it is empty, truncated, or of a kind that is not read.
    """
    source = Path(path)
    data = _bytes_of(source)
    for magic, mend in REFUSED.items():
        if data.startswith(magic):
            raise InputError("is not a log that can be read", path=str(source), mend=mend)
    table = _reader(data, source)(data, source)
    return dataclasses.replace(table, source=source, checksum=hashlib.sha256(data).hexdigest())


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
