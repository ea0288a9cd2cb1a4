"""The folder of a trial: each part a file, whole or not there, with what it was made from, for a second start."""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from bristle.core.errors import InputError
from bristle.files.owned import lock

__all__ = ["Store", "opened"]

MARK, PARTS, LOCK, PARTIAL = "robust.json", "parts", ".lock", ".partial"
CONTENT = json.dumps({"schema": 1, "written by": "bristle paper --robust"}) + "\n"


class Store:
    """The folder while this process writes into it.

    Parameters
    ----------
    path : Path
        The folder.
    """

    def __init__(self, path: Path) -> None:
        self.path, self._lock = path, threading.Lock()

    def __truediv__(self, name: str) -> Path:
        """Return where a file of the results is to be written."""
        target = self.path / name
        target.parent.mkdir(exist_ok=True)
        return target

    def write(self, name: str, content: str | bytes) -> Path:
        """Write a file; it appears whole under its name, in the place of an earlier one.

        Raises
        ------
        InputError
            If the disk does not take it: what is there stays.
        """
        target, partial = self / name, self.path / PARTIAL
        try:
            with self._lock:
                partial.write_bytes(
                    content if isinstance(content, bytes) else content.encode("utf-8", "backslashreplace")
                )
                os.replace(partial, target)
        except OSError as error:
            raise InputError(f"cannot be written: {error.strerror}", path=str(target),
                             mend="What is there stays. Give the same command again") from error  # fmt: skip
        return target

    def take(self, name: str, source: Mapping[str, Any]) -> Any:
        """Return what a part holds; None where it is not there, or was made from something else.

        Parameters
        ----------
        name : str
            Of the part.
        source : mapping
            What it is to be made from.
        """
        try:
            part = json.loads((self.path / PARTS / f"{name}.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return part["content"] if isinstance(part, dict) and part.get("made_from") == dict(source) else None

    def keep(self, name: str, source: Mapping[str, Any], content: Any) -> None:
        """Write a part.

        Parameters
        ----------
        name : str
            Of the part.
        source : mapping
            What it was made from.
        content : object
            What JSON knows, numbers that are not finite among them.
        """
        self.write(f"{PARTS}/{name}.json", json.dumps({"made_from": dict(source), "content": content}) + "\n")


@contextmanager
def opened(path: Path) -> Iterator[Store]:
    """Give a folder to write into, new or begun by an earlier trial, to this process alone.

    Parameters
    ----------
    path : Path
        The folder. Its parent must exist.

    Raises
    ------
    InputError
        If another process writes there, or it holds something else.
    """
    if not path.parent.is_dir():
        raise InputError("the folder that is to hold it does not exist", path=str(path),
                         mend=f"Make {path.parent} first")  # fmt: skip
    if os.path.lexists(path) and not (path.is_dir() and (path / MARK).is_file()):
        raise InputError("is there already, and holds no trial of bristle paper --robust", path=str(path),
                         mend="Name another folder")  # fmt: skip
    try:
        path.mkdir(exist_ok=True)
        descriptor = os.open(path / LOCK, os.O_RDWR | os.O_CREAT, 0o644)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", path=str(path)) from error
    try:
        _lock(descriptor, path)
        store = Store(path)
        store.write(MARK, CONTENT)
        yield store
    finally:
        os.close(descriptor)
        with suppress(OSError):
            (path / PARTIAL).unlink()


def _lock(descriptor: int, path: Path) -> None:
    try:
        lock(descriptor)
    except BlockingIOError:
        raise InputError("another process writes there", path=str(path),
                         mend="Wait for it to end, or name another folder") from None  # fmt: skip
