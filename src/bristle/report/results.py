"""A result with card, report and folder: numbers, signals, and figures with their captions."""

from __future__ import annotations

import re
import warnings
from abc import abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from bristle.core import (
    Axis,
    InputError,
    InputWarning,
    WithCard,
    error_text,
    guarded,
    place_in_own_code,
)
from bristle.files import SUMMARY, Results, as_json, log_text, plain, results_folder, write_whole
from bristle.report.page import FaultWarning, Plate, plates, typeset_sentence

if TYPE_CHECKING:
    from bristle.report.figures.report_figure import ReportFigure
    from bristle.simulation import SimulationResult


REPORT = "report.html"


def write_report(folder: Any, report: str, summary: Mapping[str, Any]) -> None:
    """Write a report and its numbers into a folder of results."""
    folder.write(REPORT, report)
    folder.write(SUMMARY, as_json(summary))


class Result(WithCard):
    """A result with a report and a folder."""

    command: ClassVar[str]
    """The command of its report."""

    @abstractmethod
    def _summary(self) -> dict[str, Any]:
        """Return the numbers of ``summary.json``."""

    @abstractmethod
    def _page(self, figures: tuple[ReportFigure, ...]) -> str:
        """Return the report, with these figures of the user at its end."""

    def write(self, folder: Results) -> None:
        """Write the result into an open folder."""
        write_report(folder, self._page(()), self._summary())

    @guarded()
    def report(
        self,
        path: str | PathLike[str],
        *,
        figures: Sequence[ReportFigure | str | PathLike[str]] = (),
    ) -> Path:
        """Write the report, one self-contained HTML file.

        Parameters
        ----------
        path : path-like
            The file; an existing file is replaced.
        figures : sequence of ReportFigure or path-like
            Your figures for the end of the report, or the files that define them. bristle executes these files.

        Returns
        -------
        Path
            The file.
        """
        named: tuple[ReportFigure, ...] = ()
        if figures:
            from bristle.report.figures.own import figures_named

            named = figures_named(figures, self.command)
        return write_whole(path, self._page(named))

    @guarded()
    def save(self, folder: str | PathLike[str], *, force: bool = False) -> Path:
        """Write the result into a folder; `bristle.load` reads the folder of an identification.

        Parameters
        ----------
        folder : path-like
            A new folder for ``summary.json`` and ``report.html``. An identification adds ``model.toml``, ``axis.toml`` as
            used, ``drive_table.csv`` and ``friction_curve.csv``. It also adds, as Parquet or as NPZ without pyarrow, ``draws``
            (the parameters, one row for each simulated log) and ``traces`` (measured and predicted effort).
        force : bool
            Whether to replace existing results.

        Returns
        -------
        Path
            The folder.

        Raises
        ------
        InputError
            If the folder exists already, or is not writable.
        """
        with results_folder(folder, force=force) as results:
            self.write(results)
        return Path(folder)

    def to_dict(self) -> dict[str, Any]:
        """Return the numbers of ``summary.json`` as plain data.

        Returns
        -------
        dict
            Text, numbers and lists. For an identification with a controller, the first call simulates the loop.
        """
        return plain(self._summary())


def log_names(variants: Sequence[str]) -> dict[str, str]:
    """Return the file name of the log of each variant: ``log.csv`` for a single variant.

    Names that are too long, or equal without case, are replaced with numbers.
    """
    if len(variants) == 1:
        return {variants[0]: "log.csv"}
    labels = [re.sub(r"[^\w.-]", "_", name) for name in variants]
    # Some file systems ignore case, and names have at most 255 bytes.
    if (
        len({label.casefold() for label in labels}) < len(labels)
        or max(len(label.encode()) for label in labels) > 200
    ):
        labels = [str(number) for number in range(1, len(labels) + 1)]
    return {name: f"log_{label}.csv" for name, label in zip(variants, labels, strict=True)}


def write_logs(folder: Results, result: SimulationResult) -> dict[str, str]:
    """Write the log that the drive of each variant would record; return the files by variant.

    The position is the encoder reading, the effort the command of the controller, both at the instant of a sample.
    """
    names = log_names(tuple(result.variants))
    for variant in result.experiment.variants:
        if variant.name not in names:
            continue
        outcome = result.variants[variant.name]
        signals = {
            "time": outcome.time,
            "position": outcome.measured,
            "effort": outcome.command,
        } | ({} if outcome.is_open else {"reference": outcome.reference})
        write_whole(
            folder / names[variant.name],
            log_text(variant.axis or Axis(kind=variant.plant.kind), signals),
        )
    return names


FOLDER = "figures"
CAPTIONS = "captions.txt"
NUMBERS = "csv"


@contextmanager
def figure_files(folder: Any, formats: Iterable[str] | None) -> Iterator[None]:
    """Write each figure of a report drawn in this block into a folder of results; csv files have its numbers."""
    endings = tuple(dict.fromkeys(str(ending) for ending in formats or ()))
    if folder is None and endings:
        raise InputError("needs a folder to write into", path="--format", mend="Add --out DIR")
    with plates() as collected:
        yield
    if folder is None:
        return
    written = [plate for plate in collected if _is_written(folder, plate, endings)]
    if written and set(endings) - {NUMBERS}:
        folder.write(f"{FOLDER}/{CAPTIONS}", captions(written))


def _is_written(folder: Any, plate: Plate, endings: Sequence[str]) -> bool:
    """Write a figure as files; return False if its code raises an error."""
    from bristle.report.figures import as_csv, figure_file, numbers_of

    try:
        for ending in endings:
            if ending == NUMBERS:
                panels = numbers_of(plate.figure)
                for number, panel in enumerate(panels, 1):
                    behind = f"-panel-{number}" if len(panels) > 1 else ""
                    folder.write(f"{FOLDER}/{plate.name}{behind}.csv", as_csv(panel))
                continue
            folder.write(
                f"{FOLDER}/{plate.name}.{ending}",
                figure_file(plate.figure, ending, plate.alternative),
            )
    except OSError:
        raise  # no room on the disk, and no fault of the figure
    except (Exception, SystemExit) as error:  # noqa: BLE001  (code of the user may raise any exception)
        reason = f"{type(error).__name__}: {error_text(error)}".rstrip(": ")
        remark = f"{place_in_own_code(error) or plate.name}: the figure {plate.name} is not written as a file: {reason}"
        warnings.warn(
            InputWarning(remark) if plate.own else FaultWarning(remark, error), stacklevel=2
        )
        return False
    return True


def captions(collected: Sequence[Plate]) -> str:
    """Return the file names of the figures, each with its caption."""
    return "\n".join(
        f"{plate.name}\n  {typeset_sentence(' '.join(plate.caption.split()))}\n"
        for plate in collected
    )
