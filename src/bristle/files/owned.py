"""Track the files that bristle wrote into a folder: exactly the unchanged files in the list of its note.

The note ``.bristle-results`` has one JSON object per line. The first line names the author. Each further line names a file,
before it is written and again with its SHA-256 when all files are complete. All other files, and changed files, belong to
the user. A file may be in a subfolder: ``figures/time.svg``. Links are never followed.
"""

import contextlib
import errno
import json
import os
import re
import time
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from bristle.files.folder import Folder

NOTE = ".bristle-results"  # the note in a folder of results: the files that bristle wrote
UNFINISHED = re.compile(r"(?:[^/]+/)?bristle-[0-9a-f]{32}\.partial")
"""Temporary names of files, which are renamed when they are complete."""
NAMES_SHOWN = 5
LARGEST_NOTE = 2**26  # [byte]
DEEPEST = 2  # names in the path of a file
_CHECK = "check"  # CRC-32 of the rest of a line
_BEGIN = '{"'  # of every line, even of an incomplete line of a killed process
_LOCKED_BYTE = 2**30  # far after the end of a note, so that a mandatory lock does not block reading


@dataclass(frozen=True)
class Note:
    """Content of the note of a folder."""

    token: str
    target: str
    began: int
    files: Mapping[str, str]
    sums: Mapping[str, frozenset[str]]
    kind: str = ""
    aside: str = ""
    process: str = ""
    is_intact: bool = True

    @property
    def folders(self) -> list[str]:
        """Subfolders with files of the note."""
        return sorted({name.partition("/")[0] for name in self.files if "/" in name})


def new_note(folder: Path, token: str, target: str, kind: str = "") -> int:
    """Write the note into a new folder; return it opened and locked."""
    with Folder(folder) as inside:
        opened = inside.open(NOTE, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_APPEND)
    try:
        # Locked while it is still empty: a readable note without a lock belongs to a dead process.
        lock(opened)
        head = {
            "bristle": version("bristle"),
            "folder": token,
            "target": target,
            "began": str(time.time_ns()),
        }
        write_line(opened, head | ({"kind": kind} if kind else {}))
    except BaseException:
        os.close(opened)
        raise
    return opened


def _check(line: Mapping[str, object]) -> str:
    return f"{zlib.crc32(json.dumps(dict(line)).encode()):08x}"


def line_of(line: Mapping[str, object]) -> str:
    """Return a line of a note, with its check sum."""
    return json.dumps(dict(line) | {_CHECK: _check(line)}) + "\n"


def write_line(opened: int, line: Mapping[str, str]) -> None:
    """Append a line to a note."""
    text = line_of(line).encode()
    while text:
        text = text[os.write(opened, text) :]


def note_aside(path: Path, token: str) -> None:
    """Note in a folder that the folder with this token replaces it; ignore a failure to write."""
    with contextlib.suppress(OSError), Folder(path) as folder:
        opened = folder.open(NOTE, os.O_WRONLY | os.O_APPEND)
        try:
            write_line(opened, {"aside": token})
        finally:
            os.close(opened)


def lock(opened: int) -> bool:
    """Lock the note of a folder of results, without waiting, until the process ends; return False if locks are not supported."""
    try:
        import fcntl
    except ImportError:
        return _lock_byte(opened)
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise
    except OSError:  # a network file system may not support locks
        return False
    return True


def _lock_byte(opened: int) -> bool:
    import msvcrt

    at = os.lseek(opened, 0, os.SEEK_CUR)
    try:
        os.lseek(opened, _LOCKED_BYTE, os.SEEK_SET)
        msvcrt.locking(opened, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
    except OSError as error:
        raise BlockingIOError(errno.EAGAIN, "locked") from error
    finally:
        os.lseek(opened, at, os.SEEK_SET)
    return True


def note_in(folder: Folder) -> Note | None:
    """Return the note of a folder; None if bristle did not write it."""
    try:
        if not folder.is_file(NOTE):
            return None
        with os.fdopen(folder.open(NOTE), "rb") as file:
            text = file.read(LARGEST_NOTE + 1)
    except OSError:
        return None
    return _note_of(text) if len(text) <= LARGEST_NOTE else None


def _note_of(text: bytes) -> Note | None:
    (head, *lines), is_intact = _objects_in(text)
    token, target, began = (head.get(key) for key in ("folder", "target", "began"))
    if "bristle" not in head or not (
        isinstance(token, str) and isinstance(target, str) and isinstance(began, str)
    ):
        return None
    if not re.fullmatch(r"\d{1,20}", began):
        return None
    files: dict[str, str] = {}
    sums: dict[str, set[str]] = {}
    beside, partial = {"aside": "", "process": ""}, ""
    for line in lines:
        if keys := beside.keys() & line.keys():
            beside |= {key: str(line[key]) for key in keys}
            continue
        name, checksum = line.get("file"), line.get("sha256", "")
        if not isinstance(name, str) or not isinstance(checksum, str) or not is_own_name(name):
            return None
        files[name] = checksum
        sums.setdefault(name, set()).add(checksum)
        if partial and checksum:  # of the temporary file that was renamed to this name
            sums[partial].add(checksum)
        partial = name if UNFINISHED.fullmatch(name) and not checksum else ""
    held = {name: frozenset(all_sums - {""}) for name, all_sums in sums.items()}
    kind = head.get("kind", "")
    return Note(
        token,
        target,
        int(began),
        files,
        held,
        kind if isinstance(kind, str) else "",
        **beside,
        is_intact=is_intact,
    )


def _objects_in(text: bytes) -> tuple[list[dict[str, object]], bool]:
    """Return the objects of the valid lines and always of the first line, and whether all lines are unchanged."""
    *complete, last = text.decode("utf-8", "replace").split("\n")
    objects = [_object_in(line) for line in complete or [""]]
    return [line for line in (objects[0] or {}, *objects[1:]) if line is not None], (
        None not in objects[1:] and last[: len(_BEGIN)] == _BEGIN[: len(last)]
    )


def _object_in(line: str) -> dict[str, object] | None:
    """Return the object in a line; None if the line was changed."""
    try:
        parsed = json.loads(line)
    except (ValueError, RecursionError):
        return None
    if not isinstance(parsed, dict):
        return None
    return parsed if parsed.pop(_CHECK, "") == _check(parsed) else None


def complete(opened: int) -> None:
    """Remove the incomplete last line of a killed process from a note."""
    with os.fdopen(os.dup(opened), "rb") as note:
        note.seek(0)
        text = note.read(LARGEST_NOTE)
    end = text.rfind(b"\n") + 1
    if end < len(text) and text[end:].startswith(_BEGIN.encode()[: len(text) - end]):
        os.ftruncate(opened, end)


def sync_folder(folder: Path) -> None:
    """Flush the entries of a folder to the disk."""
    if os.name != "posix":
        return
    opened = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)


def listed(names: list[str]) -> str:
    """Return the first names and the number of further names."""
    more = f" and {len(names) - NAMES_SHOWN} more" if len(names) > NAMES_SHOWN else ""
    return f"{', '.join(names[:NAMES_SHOWN])}{more}"


def is_plain(name: str) -> bool:
    """Return whether this is a plain name in a folder, not a path to another place."""
    return name not in ("", ".", "..", NOTE) and not set(name) & {"/", "\\", "\0"}


def is_own_name(name: str) -> bool:
    """Return whether this is a name in a folder or its subfolder, not a path to another place."""
    parts = name.split("/")
    return len(parts) <= DEEPEST and all(map(is_plain, parts))


def strangers_in(folder: Folder, note: Note) -> tuple[list[str], list[str]]:
    """Return the user files in a folder, and the files of bristle that the user changed."""
    if not note.is_intact:
        return [], [NOTE]
    present = list(_names_in(folder, note.folders))
    foreign = [name for name in present if name not in note.files]
    own = [name for name in present if name in note.files]
    changed = [
        name
        for name in own
        if not folder.is_file(name) or folder.checksum(name) not in note.sums[name]
    ]
    return foreign, changed


def _names_in(folder: Folder, opened: list[str]) -> Iterator[str]:
    """Yield the names in a folder except its note; subfolders of bristle are expanded."""
    for name in folder.names():
        if name == NOTE:
            continue
        try:
            inside = folder.below(name) if name in opened else None
            with inside or contextlib.nullcontext():
                yield from (
                    [name] if inside is None else [f"{name}/{child}" for child in inside.names()]
                )
        except OSError:  # replaced by a file or a link
            yield name


def remove_own(path: Path, *, half_written: bool = False) -> bool:
    """Remove the files of bristle in a folder, and the folder if it is then empty."""
    try:
        with Folder(path) as folder:
            note = note_in(folder)
            if note is None or not note.is_intact:
                return False
            for name, checksum in note.files.items():
                with contextlib.suppress(OSError):
                    is_own = folder.is_file(name) and (
                        folder.checksum(name) in note.sums[name] if checksum else half_written
                    )
                    if is_own:
                        folder.remove(name)
            for name in note.folders:
                with contextlib.suppress(OSError):
                    folder.remove_empty(name)
            if folder.names() == [NOTE]:
                folder.remove(NOTE)
        os.rmdir(path)
    except OSError:
        return False
    return True
