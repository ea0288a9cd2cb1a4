"""`Content`: a file that is read once and completely, so that the checksum belongs to exactly the bytes in use."""

import errno
import hashlib
import os
import re
import stat
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bristle.core.errors import InputError, did_you_mean, error_text
from bristle.core.lazy import cached_property
from bristle.core.typography import escaped

SIZE_LIMIT = 512 * 2**20  # Default limit for a file and for the content that it announces [byte]


class FixedLimit(int):
    """A size limit for hand-written files that options cannot raise [byte]."""


SILENCE = 10.0  # [s] timeout of a silent pipe
HELD_BACK = 1.0  # [s] timeout of a silent file: some files of the kernel wait for the next message
CHUNK = 2**20  # [byte]

Readable = Any  # A path, bytes, an open file, or an earlier `Content`


_read: ContextVar[set[str] | None] = ContextVar("_read", default=None)


@contextmanager
def noting_what_is_read(named: Iterable[Readable | None] = ()) -> Iterator[None]:
    """Track the files that are read inside this block, so that results do not replace their own inputs."""
    paths = [
        str(item.source if isinstance(item, Content) else item)
        for item in named
        if item is not None
    ]
    token = _read.set(
        {
            os.path.realpath(file_path.partition("::")[0])
            for file_path in paths
            if "\0" not in file_path
        }
    )
    try:
        yield
    finally:
        _read.reset(token)


def read_in(folder: Path) -> list[str]:
    """Return the names of files in a folder that were or will be read."""
    inside = os.path.join(os.path.realpath(folder), "")
    return sorted(
        file_path.removeprefix(inside)
        for file_path in _read.get() or ()
        if file_path.startswith(inside)
    )


@dataclass(frozen=True)
class Origin:
    """Origin of data: the name of a file without its folder, and the SHA-256 of its content."""

    name: str
    checksum: str

    @property
    def mark(self) -> str:
        """SHA-256 of the file, and the selected table of it."""
        return self.checksum + "".join(self.name.partition("::")[1:])


NOWHERE = Origin("", "")  # of data that were not read from a file


@dataclass(frozen=True, eq=False)
class Content:
    """Content of a file when it was read."""

    source: Path
    data: bytes
    part: str | None = None

    @cached_property
    def checksum(self) -> str:
        """SHA-256 of the data, in hexadecimal."""
        return hashlib.sha256(self.data).hexdigest()

    @property
    def origin(self) -> Origin:
        """Name and checksum."""
        return Origin(
            escaped(self.source.name + (f"::{self.part}" if self.part else "")), self.checksum
        )


def content_of(
    readable: Readable, *, limit: int = SIZE_LIMIT, path: str = "file", what: str = "a file"
) -> Content:
    """Read a file once and return its content."""
    if isinstance(readable, Content):
        return readable
    if isinstance(readable, (bytes, bytearray, memoryview)):
        return Content(
            Path("<bytes>"), bytes(refuse_larger(len(readable), limit, "<bytes>") and readable)
        )
    if not isinstance(readable, (str, os.PathLike)):
        try:
            read = getattr(readable, "read", None)
            if not callable(read):
                value = "None" if readable is None else readable
                raise InputError(
                    f"must be {what}",
                    path=path,
                    value=value,
                    allowed="a path, bytes, or an open file",
                )
            data: Any = read(limit + 1)
            data = data.encode() if isinstance(data, str) else bytes(data)
        except InputError:
            raise
        except Exception as error:  # noqa: BLE001  (an open file may be any object with a `read`)
            raise InputError(
                f"cannot be read ({error_text(error)})", path=path, value=readable
            ) from None
        refuse_larger(len(data), limit, "<file>")
        name = getattr(readable, "name", None)
        return Content(Path(name) if isinstance(name, str) and name else Path("<file>"), data)
    source = Path(readable)
    if "\0" in os.fspath(source):
        raise InputError("contains a NUL character", path=path, value=os.fspath(source))
    if (noted := _read.get()) is not None:
        noted.add(os.path.realpath(source))
    try:
        return Content(Path("<stdin>") if str(source) == "-" else source, _bytes_of(source, limit))
    except OSError as error:
        raise _refusal(source, error) from None


def refuse_larger(size: float, limit: int, place: object) -> bool:
    """Refuse a size above the limit; the size may be only announced [byte]."""
    if size > limit:
        fixed, words = isinstance(limit, FixedLimit), size_in_words(size)
        words = f"more than {words}" if words == size_in_words(limit) else words
        message, mend = f"has {words}, more than the limit", "Check that this is the right file"
        if not fixed:
            mend = f'Cut the log, or raise the limit: BRISTLE_SIZE_LIMIT="{size_in_words(2 * size)}" in the environment'
            mend += " (size_limit in Python). Reading needs several times this size as memory"
        raise InputError(
            message, path=str(place), allowed=f"up to {size_in_words(limit)}", mend=mend
        )
    return True


def size_of(text: int | str, path: str = "size_limit") -> int:
    """Convert a number, or text such as ``"2 GB"``, to a size in bytes."""
    spelt = text.strip() if isinstance(text, str) and len(text) < 32 else ""
    match = re.fullmatch(r"(\d{1,9}(?:\.\d{1,3})?)\s?([kMGT]?)(i?)B", spelt)
    if match is not None:
        number, prefix, binary = match.groups()
        size = float(number) * (1024 if binary else 1000) ** " kMGT".index(prefix or " ")
    elif isinstance(text, int) and not isinstance(text, bool):
        size = text
    else:
        raise InputError(
            "is not a size", path=path, value=text, mend='Write a number and a unit, such as "2 GB"'
        )
    if not 1 <= size <= 2**62:
        raise InputError("is out of range", path=path, value=text, allowed="1 B to 4000000 TB")
    return int(size)


def size_in_words(size: float) -> str:
    """Format a size with a suitable unit."""
    for unit, power in (("TB", 12), ("GB", 9), ("MB", 6), ("kB", 3)):
        if size >= 10**power:
            return f"{size / 10**power:.{max(0, 2 - len(str(int(size / 10**power))))}f} {unit}".replace(
                ".0 ", " "
            )
    return f"{int(size)} B"


def _bytes_of(source: Path, limit: int) -> bytes:
    if str(source) == "-":
        try:
            opened = sys.stdin.fileno()
        except (AttributeError, ValueError):  # missing, closed, or the standard input of a notebook
            raise InputError(
                "has no input",
                path="<stdin>",
                mend="Name a file, or pipe it: cat log.csv | bristle log -",
            ) from None
        return _within(_pieces(opened, source), limit, "<stdin>")
    mode = os.stat(source).st_mode
    for is_kind, kind, mend in (
        (stat.S_ISDIR, "a folder", "Name a file in it"),
        (stat.S_ISCHR, "a device", "Name a file: a device has no end"),
        (stat.S_ISBLK, "a device", "Name a file: a device is not a log"),
        (stat.S_ISSOCK, "a socket", "Write its data to a file first"),
    ):
        if is_kind(mode):
            raise InputError(f"is {kind}, not a file", path=str(source), mend=mend)
    # Open without blocking, because a pipe may have no writer; this does not matter for a regular file.
    opened = os.open(
        source, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    )
    try:
        status = os.fstat(opened)
        if stat.S_ISREG(status.st_mode):
            refuse_larger(status.st_size, limit, source)
        return _within(_pieces(opened, source), limit, str(source))
    finally:
        os.close(opened)


def _within(pieces: Iterator[bytes], limit: int, place: str) -> bytes:
    contents, size = [], 0
    for piece in pieces:
        size += len(piece)
        refuse_larger(size, limit, place)
        contents.append(piece)
    return b"".join(contents)


def _pieces(opened: int, source: Path) -> Iterator[bytes]:
    last, patience = (
        time.monotonic(),
        HELD_BACK if stat.S_ISREG(os.fstat(opened).st_mode) else SILENCE,
    )
    while (left := last + patience - time.monotonic()) > 0.0:
        if not _says_something(opened, left):
            continue
        try:
            piece = os.read(opened, CHUNK)
        # Another reader was faster, or a file of the kernel waits for its next line.
        except BlockingIOError:
            time.sleep(0.01)
            continue
        if not piece:
            return
        yield piece
        last = time.monotonic()
    raise InputError(
        f"sent no data for {patience:g} s",
        path=str(source),
        mend="Check that a program writes to it",
    )


def _says_something(opened: int, seconds: float) -> bool:
    """Wait for data or the end; without support for waiting, read immediately."""
    import select

    if not hasattr(select, "poll"):
        return True
    pipe = select.poll()
    pipe.register(opened, select.POLLIN)
    return bool(pipe.poll(1000.0 * seconds))


def _refusal(source: Path, error: OSError) -> InputError:
    if isinstance(error, FileNotFoundError):
        if os.path.islink(source):
            return InputError(
                f"is a link to {os.readlink(source)}, which does not exist", path=str(source)
            )
        names: list[str] = []
        with suppress(OSError):
            names = os.listdir(source.parent)
        return InputError(
            "there is no such file",
            path=str(source),
            mend=did_you_mean(source.name, names, 0.75) or "Check the path",
        )
    if error.errno == errno.ENAMETOOLONG:
        return InputError("is too long for a file name", path=str(source))
    return InputError(
        f"cannot be read ({(error.strerror or str(error)).lower()})", path=str(source)
    )
