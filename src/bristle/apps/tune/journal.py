"""The journal of a run: JSON lines that are only appended, each on the disk before the run acts, and chained by their hashes."""

import errno
import hashlib
import json
import os
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from bristle.core import InputError

NAME = "journal.jsonl"
BEGIN = b'{"n": '  # of each line
NO_LINKS = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)


class Journal:
    """The journal in a folder.

    Parameters
    ----------
    folder : Path
        Folder of the run.

    Raises
    ------
    InputError
        If an earlier entry was changed or removed.
    """

    def __init__(self, folder: Path) -> None:
        self.path, self._is_known = folder / NAME, True
        self.entries, self._last, self._is_cut = _read(self.path)

    def write(self, step: str, event: str, **facts: Any) -> dict[str, Any]:
        """Append an entry, and return it as it is read back.

        `event` of a step is begun, write, file, done, stopped, restored, kept, saving, saved or removed.
        """
        if not self._is_known:  # an interrupted write may have written an entry, or a part of it
            self.entries, self._last, self._is_cut = _read(self.path)
        entry = {
            "n": len(self.entries),
            "step": step,
            "event": event,
            **facts,
            "previous": self._last,
        }
        line = json.dumps(entry, ensure_ascii=False).encode()
        self._is_known = False
        _append(self.path, (b"\n" if self._is_cut else b"") + line + b"\n")
        self.entries.append(json.loads(line))
        self._last, self._is_cut, self._is_known = _hash(line), False, True
        return self.entries[-1]

    def with_events(self, *events: str, step: str | None = None) -> Iterator[dict[str, Any]]:
        """Return the entries with these events, last first."""
        return (
            entry
            for entry in reversed(self.entries)
            if entry["event"] in events and step in (None, entry["step"])
        )

    def last(self, *events: str, step: str | None = None) -> dict[str, Any] | None:
        """Return the last entry with these events."""
        return next(self.with_events(*events, step=step), None)

    @property
    def has_written(self) -> bool:
        """Whether the machine may differ from its state before the run."""
        return self._last_of("write", "restored", "kept") == "write"

    @property
    def is_kept(self) -> bool:
        """Whether the machine, or its non-volatile memory, keeps the feedforward of this run."""
        return self._last_of("write", "restored", "kept") == "kept" or self.is_saved

    @property
    def is_saved(self) -> bool:
        """Whether the non-volatile memory of the machine may contain the feedforward of this run."""
        return self._last_of("saving", "removed") == "saving"

    def _last_of(self, *events: str) -> str:
        last = self.last(*events)
        return "" if last is None else last["event"]


def _append(path: Path, data: bytes) -> None:
    """Append to a file and wait for the disk; refuse a link, behind which the file of a person may be."""
    mend = "Move it to another place, or name another folder"
    try:
        opened = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | NO_LINKS, 0o666)
    except OSError as error:
        if error.errno != errno.ELOOP:
            raise
        raise InputError("is a link", path=str(path), mend=mend) from None
    try:
        if os.fstat(opened).st_nlink > 1:
            raise InputError(
                "has a second name, under which it is the file of a person",
                path=str(path),
                mend=mend,
            )
        while data:
            data = data[os.write(opened, data) :]
        os.fsync(opened)
    finally:
        os.close(opened)


def _hash(line: bytes) -> str:
    return hashlib.sha256(line).hexdigest()[:16]


def _read(path: Path) -> tuple[list[dict[str, Any]], str, bool]:
    """Return the entries of a journal, the hash of its last line, and whether a killed or a writing process left a line incomplete."""
    if not os.path.lexists(path):
        return [], "", False
    if not stat.S_ISREG(os.lstat(path).st_mode):
        raise InputError(
            "is not a file, but a link, a folder or a pipe",
            path=str(path),
            mend="Name another folder",
        )
    data = path.read_bytes()
    entries: list[dict[str, Any]] = []
    last = ""
    for number, line in enumerate(data.splitlines(), 1):
        try:
            entry = json.loads(line)
        except ValueError:
            if BEGIN.startswith(line[: len(BEGIN)]):  # a line that a killed process left incomplete
                continue
            entry = None
        if not isinstance(entry, dict) or entry.get("previous") != last:
            raise InputError(
                "was changed after it was written",
                path=f"{path}, line {number}",
                mend="Restore the journal from a copy. The backup of the machine is in its entry `backup`",
            )
        entries.append(entry)
        last = _hash(line)
    return entries, last, bool(data) and not data.endswith(b"\n")
