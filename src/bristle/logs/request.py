"""What is read of a file: the words that every reader takes beside the bytes."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from bristle.logs.choice import Choice

__all__ = ["Request"]


class Request(NamedTuple):
    """What is read of a file; its reader takes it beside the bytes, ``read(data, request)``.

    Parameters
    ----------
    source : Path
        The file.
    table : str or None
        A table in it. Files of most kinds are one table, and do not use it.
    choice : Choice
        Which columns are read.
    limit : int
        Largest size of what is read, unpacked [byte].
    """

    source: Path
    table: str | None
    choice: Choice
    limit: int
