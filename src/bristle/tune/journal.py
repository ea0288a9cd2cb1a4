"""The journal of a run: JSON lines that are only appended, each on the disk before the run acts, and chained by their hashes."""

import hashlib
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from bristle.core import InputError

NAME = "journal.jsonl"


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
        self.path = folder / NAME
        self.entries, self._last, self._is_cut = _read(self.path)

    def write(self, step: str, event: str, **facts: Any) -> dict[str, Any]:
        """Append an entry: `event` of a step (begun, write, file, done, stopped, restored, kept, saving, saved, removed)."""
        entry = {"n": len(self.entries), "step": step, "event": event, **facts, "previous": self._last}
        line = json.dumps(entry, ensure_ascii=False).encode()
        try:
            with self.path.open("ab") as file:
                file.write((b"\n" if self._is_cut else b"") + line + b"\n")
                file.flush()
                os.fsync(file.fileno())
        finally:  # an interrupted write may have written the entry
            self.entries, self._last, self._is_cut = _read(self.path)
        return entry

    def with_events(self, *events: str, step: str | None = None) -> Iterator[dict[str, Any]]:
        """Return the entries with these events, last first."""
        return (entry for entry in reversed(self.entries) if entry["event"] in events and step in (None, entry["step"]))

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


def _read(path: Path) -> tuple[list[dict[str, Any]], str, bool]:
    """Return the entries of a journal, the hash of its last line, and whether a killed or a writing process left a line incomplete."""
    if not path.exists():
        return [], "", False
    data = path.read_bytes()
    entries: list[dict[str, Any]] = []
    last = ""
    for number, line in enumerate(data.splitlines(), 1):
        try:
            entry = json.loads(line)
        except ValueError:
            continue
        if not isinstance(entry, dict) or entry.get("previous") != last:
            mend = "Restore the journal from a copy. The backup of the machine is in its entry `backup`"
            raise InputError("was changed after it was written", path=f"{path}, line {number}", mend=mend)
        entries.append(entry)
        last = hashlib.sha256(line).hexdigest()[:16]
    return entries, last, bool(data) and not data.endswith(b"\n")
