"""A reader of a person's own for logs of another format: one Python file, the package unchanged."""

from __future__ import annotations

from bristle.core.content import Readable, content_of
from bristle.core.errors import InputError
from bristle.files.permission import CODE_LIMIT
from bristle.files.user_model import SourceText
from bristle.logs.formats import LogFormat

__all__ = ["load_reader_file"]


def load_reader_file(path: Readable) -> LogFormat:
    """Return the format that a Python file defines as ``FORMAT``.

    Parameters
    ----------
    path : path-like, bytes, file object or Content
        A Python file with ``FORMAT = LogFormat(name=..., title=..., recognises=recognises, read=read)``; executed.

    Returns
    -------
    LogFormat
        The format, for `bristle.logs.formats.reading`.

    Raises
    ------
    InputError
        If the file cannot be read or run, or defines no format with a reader.
    """
    content = content_of(path, limit=CODE_LIMIT, what="a file of Python")
    found = getattr(SourceText(content).module(), "FORMAT", None)
    if not isinstance(found, LogFormat) or not callable(found.recognises) or not callable(found.read):
        raise InputError(
            "defines no reader of logs", path=str(content.source),
            mend="End the file with FORMAT = LogFormat(name=..., title=..., recognises=recognises, read=read)",
        )  # fmt: skip
    return found
