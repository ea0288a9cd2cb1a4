"""What takes the files of results: a folder that appears whole, or another that is added to."""

from __future__ import annotations

from typing import Protocol

__all__ = ["ResultsFolder"]


class ResultsFolder(Protocol):
    """What takes the files of results."""

    def write(self, name: str, content: str | bytes, /) -> object:
        """Write a file by its name in the folder, text in UTF-8."""
        ...
