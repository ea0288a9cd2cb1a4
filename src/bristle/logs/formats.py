"""What a format of logs is: one file with a `LogFormat`, a person's own or a module of this folder that `catalogue.py` lists.

Formats of a person's own are asked first, while `reading` lasts.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, NamedTuple

from bristle.logs.table import Request

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


OWN_FORMATS: ContextVar[tuple[LogFormat, ...]] = ContextVar("formats of logs of a person's own", default=())


@contextmanager
def reading(*formats: LogFormat) -> Iterator[None]:
    """Read logs of formats of a person's own, too, before all others."""
    token = OWN_FORMATS.set((*formats, *OWN_FORMATS.get()))
    try:
        yield
    finally:
        OWN_FORMATS.reset(token)
