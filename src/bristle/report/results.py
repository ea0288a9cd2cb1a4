"""A result that is shown as a card, told in a report, and kept in a folder: numbers, report, signals, and figures with their captions."""

from __future__ import annotations

import re
import warnings
from abc import abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from bristle.core import Axis, InputError, InputWarning, WithCard, place_in_own_code, told_by
from bristle.files import SUMMARY, Results, as_json, plain, results_folder, write_log, write_whole
from bristle.report.page import FaultWarning, Plate, plates, typeset_sentence

if TYPE_CHECKING:
    from bristle.figures.report_figure import ReportFigure
    from bristle.simulation import SimulationResult


REPORT = "report.html"


def write_report(folder: Any, report: str, summary: Mapping[str, Any]) -> None:
    """Write a report and the numbers that it rests on into a folder of results."""
    folder.write(REPORT, report)
    folder.write(SUMMARY, as_json(summary))


class Result(WithCard):
    """A result that is told and kept."""

    command: ClassVar[str]
    """The command whose report it has."""

    @abstractmethod
    def _summary(self) -> dict[str, Any]:
        """Return the numbers, as ``summary.json`` holds them."""

    @abstractmethod
    def _page(self, figures: tuple[ReportFigure, ...]) -> str:
        """Return the report, with these figures of a person's own behind all else; without any, as it is kept."""

    def write(self, folder: Results) -> None:
        """Write all of it into a folder of results that is open."""
        write_report(folder, self._page(()), self._summary())

    def report(self, path: str | PathLike[str], *, figures: Sequence[ReportFigure | str | PathLike[str]] = ()) -> Path:
        """Write the report, one HTML file that needs nothing else.

        Parameters
        ----------
        path : path-like
            The file; one that is there is replaced.
        figures : sequence of ReportFigure or path-like
            Your own, or the files that define them, which are executed: they stand behind all else.

        Returns
        -------
        Path
            The file.
        """
        named: tuple[ReportFigure, ...] = ()
        if figures:
            from bristle.figures.own import figures_named

            named = figures_named(figures, self.command)
        return write_whole(path, self._page(named))

    def save(self, folder: str | PathLike[str], *, force: bool = False) -> Path:
        """Write everything into a folder, that of an identification for `bristle.load`.

        Parameters
        ----------
        folder : path-like
            A new folder: ``summary.json`` and ``report.html``. Of an identification also ``model.toml``, ``axis.toml``
            as used, ``drive_table.csv``, ``friction_curve.csv``, and as Parquet, or NPZ without pyarrow, ``draws`` (the
            parameters as that the log allows, one row a simulated log) and ``traces`` (measured and predicted effort).
        force : bool
            Whether results that are there already are replaced.

        Returns
        -------
        Path
            The folder.

        Raises
        ------
        InputError
            If it is there already, or cannot be written.
        """
        with results_folder(folder, force=force) as results:
            self.write(results)
        return Path(folder)

    def to_dict(self) -> dict[str, Any]:
        """Return the numbers as plain data, as ``summary.json`` holds them.

        Returns
        -------
        dict
            Of text, numbers and lists. Of an identification with a controller, the loop is simulated for it, once.
        """
        return plain(self._summary())


def log_names(variants: Sequence[str]) -> dict[str, str]:
    """Return the name of the log of each variant, by variant: ``log.csv`` of one alone.

    Where names of variants make no names of files, too long or alike without case, they are numbered.
    """
    if len(variants) == 1:
        return {variants[0]: "log.csv"}
    labels = [re.sub(r"[^\w.-]", "_", name) for name in variants]
    # Some systems tell no capital letters from small ones.
    # File systems take names of 255 bytes.
    if len({label.casefold() for label in labels}) < len(labels) or max(len(label.encode()) for label in labels) > 200:
        labels = [str(number) for number in range(1, len(labels) + 1)]
    return {name: f"log_{label}.csv" for name, label in zip(variants, labels, strict=True)}


def write_logs(folder: Results, result: SimulationResult) -> dict[str, str]:
    """Write what the drive of each variant would record; return the files by variant.

    The position is what the encoder reads, the effort what the controller commands, both at the instant of a sample.
    """
    names = log_names(tuple(result.variants))
    for variant in result.experiment.variants:
        if variant.name not in names:
            continue
        outcome = result.variants[variant.name]
        signals = {"time": outcome.time, "position": outcome.measured, "effort": outcome.command} | (
            {} if outcome.is_open else {"reference": outcome.reference}
        )
        write_log(folder / names[variant.name], variant.axis or Axis(kind=variant.plant.kind), signals)
    return names


FOLDER = "figures"
CAPTIONS = "captions.txt"
NUMBERS = "csv"


@contextmanager
def figure_files(folder: Any, formats: Iterable[str] | None) -> Iterator[None]:
    """Write each figure that is drawn for a report in this block into a folder of results; as csv the numbers that it draws."""
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
    """Write a figure as files; return whether that was done, which an error in its code may prevent."""
    from bristle.figures import as_csv, figure_file, numbers_of

    try:
        for ending in endings:
            if ending == NUMBERS:
                panels = numbers_of(plate.figure)
                for number, panel in enumerate(panels, 1):
                    behind = f"-panel-{number}" if len(panels) > 1 else ""
                    folder.write(f"{FOLDER}/{plate.name}{behind}.csv", as_csv(panel))
                continue
            folder.write(f"{FOLDER}/{plate.name}.{ending}", figure_file(plate.figure, ending, plate.alternative))
    except OSError:
        raise  # no room on the disk, and no fault of the figure
    except (Exception, SystemExit) as error:  # noqa: BLE001  (what a user's code may raise has no common type)
        reason = f"{type(error).__name__}: {told_by(error)}".rstrip(": ")
        remark = f"{place_in_own_code(error) or plate.name}: the figure {plate.name} is not written as a file: {reason}"
        warnings.warn(InputWarning(remark) if plate.own else FaultWarning(remark, error), stacklevel=2)
        return False
    return True


def captions(collected: Sequence[Plate]) -> str:
    """Return the figures by the names of their files, each with its caption below it."""
    return "\n".join(f"{plate.name}\n  {typeset_sentence(' '.join(plate.caption.split()))}\n" for plate in collected)
