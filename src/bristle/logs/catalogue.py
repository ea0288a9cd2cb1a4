"""List the formats of logs; the first bytes of a file decide, because file endings can be wrong.

A format is a module of this folder that ends with ``FORMAT = NAME = LogFormat(...)``, plus an import below. A format that
needs a library or shares a module is a line of `FORMATS` and a function ``read_NAME(data, request)``, imported on first use.
"""

from collections.abc import Callable

from bristle.logs.formats import OWN_FORMATS, START, LogFormat
from bristle.logs.halsampler import halsampler as halsampler
from bristle.logs.json_records import json_records as json_records

ARCHIVE = b"PK\x03\x04"


def _begins(*starts: bytes, suffix: str = "") -> Callable[[bytes, str], bool]:
    return lambda head, ending: head.startswith(starts) or (suffix != "" and ending == suffix)


def is_archive_of_arrays(head: bytes, suffix: str) -> bool:
    """Return whether a file is an NPY array, or an archive whose first member is an NPY array."""
    return head.startswith(b"\x93NUMPY") or (head.startswith(ARCHIVE) and b".npy" in head[26:])


def _is_markup(head: bytes, suffix: str) -> bool:
    return head[:256].lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<")


FORMATS: tuple[LogFormat, ...] = (
    LogFormat(
        "hdf5",
        "HDF5",
        _begins(b"\x89HDF", b"MATLAB 7.3"),
        holds_tables=True,
        package="h5py",
        extra="io",
        module="array_files",
    ),
    LogFormat(
        "parquet", "Parquet", _begins(b"PAR1"), package="pyarrow", extra="io", module="array_files"
    ),
    LogFormat("npz", "NPZ", is_archive_of_arrays, holds_tables=True, module="array_files"),
    LogFormat("mf4", "MF4", _begins(b"MDF "), package="asammdf", extra="mf4", module="recorders"),
    LogFormat(
        "mcap",
        "MCAP",
        _begins(b"\x89MCAP"),
        holds_tables=True,
        package="mcap_ros2",
        extra="mcap",
        module="recorders",
    ),
    LogFormat(
        "tdms",
        "TDMS",
        _begins(b"TDSm", suffix=".tdms"),
        package="nptdms",
        extra="io",
        module="recorders",
    ),
    LogFormat("mat", "MAT", _begins(b"MATLAB 5.0", suffix=".mat"), module="array_files"),
    LogFormat("sinumerik", "traces of SINUMERIK", _is_markup, module="recorders"),
    # Formats with a separate module.
    *(known for known in tuple(vars().values()) if isinstance(known, LogFormat)),
    LogFormat("csv", "text", lambda head, suffix: True, module="csv"),
)
"""Every format of logs, in the order in which they are tried."""


def format_of(data: bytes, suffix: str) -> LogFormat:
    """Return the format of a file; plain text if no other format matches."""
    head, formats = data[:START], (*OWN_FORMATS.get(), *FORMATS)
    return next(candidate for candidate in formats if candidate.recognises(head, suffix.lower()))
