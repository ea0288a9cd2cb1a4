"""List the logs that a command names: files, tables in them, and folders with all their subfolders."""

import os
import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from fnmatch import fnmatchcase
from pathlib import Path

from bristle.core import SIZE_LIMIT, Content, InputError, escaped, guarded
from bristle.logs.readers import read_table
from bristle.logs.table import NONE
from bristle.logs.tables import WITHIN, content_of_log

NO_LOGS = (".toml", ".md")  # other files among logs: axis files, notes
_DATE = re.compile(
    r"(?<!\d)((?:19|20)\d\d)([-_.]?)(\d\d)\2(\d\d)(?:[T _-]+(\d\d)([-:._h]?)(\d\d)(?:\6(\d\d))?(?:[.,]\d+)?(?!-?\d))?(?!\d)"
)


@dataclass(frozen=True)
class LogFile:
    """A log of a fleet."""

    place: str
    folder: str
    name: str
    checksum: str
    time: float | None = None
    axis: int = 0

    @property
    def identity(self) -> tuple[str, str, str]:
        """Folder, name and checksum, which identify a log."""
        return self.folder, self.name, self.checksum


@guarded()
def listed_logs(named: Sequence[str | Path], *, size_limit: int = SIZE_LIMIT) -> list[LogFile]:
    """Return the logs that a command names, in its order, each once."""
    logs: dict[tuple[str, str, str], LogFile] = {}
    for place in (place for name in named for place in _places(os.fspath(name))):
        for log in _logs_at(place, size_limit):
            if log.identity in logs:
                raise InputError("is named twice", path=log.place, mend="Name each log once")
            logs[log.identity] = log
    return list(logs.values())


def recorded_at(*names: str) -> float | None:
    """Return the time of a recording [s since 1970, as if its clock were UTC], from the only date in the first dated name.

    Examples
    --------
    >>> recorded_at("axis_2026-03-01T06-30-00.csv") == datetime(2026, 3, 1, 6, 30, tzinfo=UTC).timestamp()
    True
    """
    for name in names:
        dates = []
        for year, _, month, day, hour, _, minute, second in _DATE.findall(name):
            with suppress(ValueError):  # digits that form no date
                dates.append(
                    datetime(
                        *(int(part or 0) for part in (year, month, day, hour, minute, second)),
                        tzinfo=UTC,
                    )
                )
        if dates:
            return dates[0].timestamp() if len(dates) == 1 else None
    return None


def _places(name: str) -> Iterator[str]:
    if not os.path.isdir(name):
        yield name
        return
    is_empty = True
    for folder, below, files in os.walk(name):
        below[:] = sorted(child for child in below if not child.startswith("."))
        for file in sorted(files):
            if not file.startswith(".") and not file.lower().endswith(NO_LOGS):
                is_empty = False
                yield os.path.join(folder, file)
    if is_empty:
        raise InputError("holds no log", path=name, mend="Name the folder that contains the logs")


def _logs_at(place: str, size_limit: int) -> Iterator[LogFile]:
    """Yield the logs in a file; list an unreadable log, too: its row gives the reason."""
    file = place if os.path.lexists(place) else place.rpartition(WITHIN)[0] or place
    if not os.path.lexists(file):
        raise InputError("there is no such file", path=file, mend="Check the name and the folder")
    source = Path(os.path.abspath(file))
    folder = escaped(source.parent.name)
    try:
        content = content_of_log(place, limit=size_limit)
    except InputError:
        yield LogFile(place, folder, escaped(source.name), "")
        return
    for part in _parts(content, size_limit):
        within = f"{WITHIN}{part}" if part else ""
        name = source.name + within
        yield LogFile(
            file + within,
            folder,
            escaped(name),
            content.checksum,
            recorded_at(name, source.parent.name),
        )


def _parts(content: Content, size_limit: int) -> list[str | None]:
    """Return the tables of a file that match a pattern; without a match, report the tables of the file."""
    if content.part is None or "*" not in content.part:
        return [content.part]
    tables = read_table(
        Content(content.source, content.data), choice=NONE, size_limit=size_limit
    ).tables
    matching = [name for name in tables if fnmatchcase(name, content.part)]
    if not matching:
        allowed = f"tables: {', '.join(tables[:20])}" if tables else "a file with several tables"
        raise InputError(
            "contains no table with such a name",
            path=str(content.source),
            value=content.part,
            allowed=allowed,
        )
    return [*matching]
