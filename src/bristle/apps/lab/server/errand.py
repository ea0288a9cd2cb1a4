"""`Errand`: the input of a job, as bytes and labels. A browser chooses no path on this machine, except those of `TunedMachine`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.core import TEXT, Axis, Content, InputError, whole

if TYPE_CHECKING:
    from bristle.report.table import Table

# The state for the page, and the data that it requests later.
Answer = tuple[dict[str, Any], dict[str, Any]]
COUNT = whole(0)
BUCKETS = 1500  # of a curve: pairs of points on a screen
DATA = "data.json"  # the data of a job for the page, in its folder


@dataclass(frozen=True)
class LabelledLog:
    """A dropped log."""

    place: Path
    label: str
    role: str

    @property
    def content(self) -> Content:
        """The bytes, with the label."""
        return Content(Path(self.label), self.place.read_bytes())


@dataclass(frozen=True)
class Errand:
    """The input of a job."""

    folder: Path
    logs: tuple[LabelledLog, ...]
    axis_text: str
    axis_label: str
    options: Mapping[str, Any]
    size_limit: int
    results: Path | None
    report: Callable[[float, str], None]
    interruptible: Callable[[], AbstractContextManager[None]]
    is_cancelled: Callable[[], bool] = lambda: False

    @classmethod
    def of(
        cls,
        request: Mapping[str, Any],
        report: Callable[[float, str], None],
        interruptible: Callable[[], AbstractContextManager[None]],
        is_cancelled: Callable[[], bool] = lambda: False,
    ) -> Errand:
        """Return the errand of a request from the server."""
        own = {name: request[name] for name in ("axis_text", "axis_label", "options", "size_limit")}
        logs = tuple(
            LabelledLog(Path(place), label, role) for place, label, role in request["logs"]
        )
        results = None if request["results"] is None else Path(request["results"])
        own |= {"report": report, "interruptible": interruptible, "is_cancelled": is_cancelled}
        return cls(Path(request["folder"]), logs, results=results, **own)

    @property
    def fitted(self) -> list[LabelledLog]:
        """The logs of the fit."""
        logs = [log for log in self.logs if log.role == "fit"]
        if not logs:
            raise InputError("is missing", path="log", mend="Drop a log to fit")
        return logs

    @property
    def model(self) -> Path:
        """The folder of the results of an identification."""
        if self.results is None:
            raise InputError("is missing", path="model", mend="Identify a model first")
        return self.results

    @property
    def axis_file(self) -> Content:
        """The axis file with its label."""
        return Content(Path(self.axis_label), self.axis_text.encode())

    def axis(self) -> Axis:
        """Return the axis."""
        import bristle

        return bristle.read_axis(self.axis_file)

    def text(self, name: str, default: str = "") -> str:
        """Return a text option."""
        return TEXT(self.options.get(name, default), name, None).strip()

    def count(self, name: str, default: int) -> int:
        """Return an option that is an integer."""
        return COUNT(self.options.get(name, default), name, None)


def zipped(folder: Path) -> None:
    """Write the files of a folder into an archive next to it, without the marker of bristle's own folders."""
    import zipfile

    from bristle.files import NOTE

    with zipfile.ZipFile(folder.with_suffix(".zip"), "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(folder.rglob("*")):
            if file.is_file() and file.name != NOTE:
                # Without a time, so that equal results give equal archives.
                entry = zipfile.ZipInfo(str(file.relative_to(folder)))
                entry.compress_type = zipfile.ZIP_DEFLATED
                archive.writestr(entry, file.read_bytes())


def as_table(table: Table) -> dict[str, Any]:
    """Return a table for the page, without its empty columns, with its columns of numbers marked."""
    trimmed = table.without_empty_columns()
    return trimmed._asdict() | {
        "numbers": [trimmed.is_number(column) for column in range(len(trimmed.heads))]
    }


def thinned(time: np.ndarray, *signals: np.ndarray) -> list[list[Any]]:
    """Return a time and its signals, each reduced to the minimum and maximum of every group of samples."""
    count = time.size
    places = np.arange(count)
    if count > 2 * BUCKETS:
        edges = np.linspace(0, count, BUCKETS + 1).astype(int)
        first = np.nan_to_num(signals[0])
        ends = [
            begin + np.array([np.argmin(first[begin:end]), np.argmax(first[begin:end])])
            for begin, end in pairwise(edges)
        ]
        places = np.unique(np.concatenate([*ends, [0, count - 1]]))
    rows = (np.asarray(values, float)[places] for values in (time, *signals))
    return [
        [float(f"{value:.8g}") if np.isfinite(value) else None for value in row] for row in rows
    ]
