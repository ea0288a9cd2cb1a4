"""A reader of a person's own for logs of another format: one Python file, the package unchanged."""

from __future__ import annotations

from bristle.core.content import Readable
from bristle.core.errors import InputError
from bristle.files.declared import declared_in
from bristle.files.permission import code_at
from bristle.logs.formats import LogFormat

__all__ = ["load_reader_file"]

MEND = "End the file with FORMAT = LogFormat(name=..., title=..., recognises=recognises, read=read)"


def load_reader_file(path: Readable) -> LogFormat:
    """Return the format that a Python file defines as ``FORMAT``."""
    content = code_at(path)
    log_format = declared_in(content, "FORMAT", LogFormat, title="reader of logs", mend=MEND)
    if not callable(log_format.recognises) or not callable(log_format.read):
        raise InputError("defines no reader of logs", path=str(content.source), mend=MEND)
    return log_format
