"""The formats of logs that are read, a line each: by their first bytes, for the ending of a name may lie.

A format is a function ``read_NAME(data, request)`` in a module of this folder, and its line below. One of a person's own is a file
with a `LogFormat` that has a `read` of its own; it is asked first, while `reading` lasts.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, NamedTuple

from bristle.logs.json_records import looks_like_json
from bristle.logs.table import Request

ARCHIVE = b"PK\x03\x04"
START = 4096  # bytes by which a format is recognised


class LogFormat(NamedTuple):
    """A format of logs."""

    name: str
    title: str
    recognises: Callable[[bytes, str], bool]
    holds_tables: bool = False
    package: str = ""
    extra: str = ""
    read: Callable[[bytes, Request], Any] | None = None
    example: bytes = b""
    module: str = ""

    @property
    def place(self) -> str:
        """The module and the name of a reader of bristle's own."""
        return f"bristle.logs.{self.module}:read_{self.name}"


def _begins(*starts: bytes, suffix: str = "") -> Callable[[bytes, str], bool]:
    return lambda head, ending: head.startswith(starts) or (suffix != "" and ending == suffix)


def is_archive_of_arrays(head: bytes, suffix: str) -> bool:
    """Return whether a file is an array of NumPy or an archive of them: each file of it is named so."""
    return head.startswith(b"\x93NUMPY") or (head.startswith(ARCHIVE) and b".npy" in head[26:])


def _is_markup(head: bytes, suffix: str) -> bool:
    return head[:256].lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<")


FORMATS = (
    LogFormat("hdf5", "HDF5", _begins(b"\x89HDF", b"MATLAB 7.3"), holds_tables=True, package="h5py", extra="io", module="array_files"),
    LogFormat("parquet", "Parquet", _begins(b"PAR1"), package="pyarrow", extra="io", module="array_files"),
    LogFormat("npz", "NPZ", is_archive_of_arrays, holds_tables=True, module="array_files"),
    LogFormat("mf4", "MF4", _begins(b"MDF "), package="asammdf", extra="mf4", module="recorders"),
    LogFormat("mcap", "MCAP", _begins(b"\x89MCAP"), holds_tables=True, package="mcap_ros2", extra="mcap", module="recorders"),
    LogFormat("tdms", "TDMS", _begins(b"TDSm", suffix=".tdms"), package="nptdms", extra="io", module="recorders"),
    LogFormat("mat", "MAT", _begins(b"MATLAB 5.0", suffix=".mat"), module="array_files"),
    LogFormat("sinumerik", "traces of SINUMERIK", _is_markup, module="recorders"),
    LogFormat("json_records", "JSON", lambda head, suffix: looks_like_json(head), holds_tables=True, module="json_records"),
    LogFormat("csv", "text", lambda head, suffix: True, module="csv"),
)

_OWN: ContextVar[tuple[LogFormat, ...]] = ContextVar("formats of logs of a person's own", default=())


@contextmanager
def reading(*formats: LogFormat) -> Iterator[None]:
    """Read logs of formats of a person's own, too, before all others."""
    token = _OWN.set((*formats, *_OWN.get()))
    try:
        yield
    finally:
        _OWN.reset(token)


def format_of(data: bytes, suffix: str) -> LogFormat:
    """Return the format of a file; text where it is no other one."""
    head, formats = data[:START], (*_OWN.get(), *FORMATS)
    return next(candidate for candidate in formats if candidate.recognises(head, suffix.lower()))
