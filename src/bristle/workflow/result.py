"""A result that is shown as a card, told in a report, and kept in a folder."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from bristle.core.tabular import WithCard
from bristle.files.results import Results, results_folder
from bristle.files.single import write_whole
from bristle.files.summary import plain

if TYPE_CHECKING:
    from bristle.figures.report_figure import ReportFigure


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
        from bristle.report.results import write_report

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
