"""Define a format of logs: your own file with a `LogFormat`, tried first in `reading`, or a module in `catalogue.py`."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, NamedTuple

from bristle.logs.table import Request

START = 4096  # bytes that identify a format


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
        """Module and name of a reader of this package."""
        return f"bristle.logs.{self.module}:read_{self.name}"


OWN_FORMATS: ContextVar[tuple[LogFormat, ...]] = ContextVar(
    "formats of logs of a person's own", default=()
)


@contextmanager
def reading(*formats: LogFormat) -> Iterator[None]:
    """Return a context in which bristle tries the user's formats of logs first."""
    token = OWN_FORMATS.set((*formats, *OWN_FORMATS.get()))
    try:
        yield
    finally:
        OWN_FORMATS.reset(token)
