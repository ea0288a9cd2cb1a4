"""`compare`: two logs of one axis, before and after a change, as a result with table, report and files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from bristle.core import (
    SIZE_LIMIT,
    Amount,
    Axis,
    Card,
    InputError,
    Variable,
    amount,
    cached_property,
    guarded,
    library,
    optional,
)
from bristle.files import axes_for, logs_and_axes, provenance
from bristle.logs import Log
from bristle.prediction.comparison import Comparison, compare as sides_compared
from bristle.report.results import Result

if TYPE_CHECKING:
    from bristle.report.figures.report_figure import ReportFigure


@dataclass(frozen=True, eq=False)
class Compared(Result, Comparison):
    """The comparison of two logs of one axis.

    Parameters
    ----------
    axis_name : str
        Name of the axis.
    call : str
        Python call that repeats the comparison.
    read : mapping
        Further files that bristle read, by their role.
    figures : tuple of ReportFigure
        User-defined figures for the report.
    """

    command: ClassVar[str] = "compare"
    axis_name: str
    call: str
    read: Mapping[str, Any]
    figures: tuple[ReportFigure, ...] = ()

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The numbers of ``summary.json``."""
        from bristle.report.comparison import comparison_summary

        return comparison_summary(self, name=self.axis_name, provenance=self.provenance)

    @cached_property
    def page(self) -> str:
        """The report, an HTML page."""
        from bristle.report.comparison import comparison_report

        return comparison_report(
            self,
            name=self.axis_name,
            command=self.call,
            provenance=self.provenance,
            figures=self.figures,
        )

    @property
    def provenance(self) -> dict[str, str]:
        """Versions of the software, and input files with their checksums."""
        return provenance(self.call, before=self.logs_before, after=self.logs_after, **self.read)

    @property
    def sentences(self) -> list[str]:
        """The verdict, then each quantity with its numbers."""
        return self.summary["sentences"]

    def to_dataframe(self) -> Any:
        """Return the changes as a data frame of pandas, one row a quantity, in SI.

        Returns
        -------
        pandas.DataFrame
            With the columns ``quantity``, ``before``, ``after``, ``change``, ``low``, ``high``, ``unit``, ``verdict``.

        Raises
        ------
        MissingExtraError
            If pandas is not installed.
        """
        pandas = library("pandas", "to_dataframe()")
        rows = [
            (name, change.before, change.after, change.change, *ends, change.unit, change.verdict)
            for name, change in self.changes.items()
            for ends in (change.interval or (None, None),)
        ]
        return pandas.DataFrame(
            rows,
            columns=["quantity", "before", "after", "change", "low", "high", "unit", "verdict"],
        )

    def _summary(self) -> dict[str, Any]:
        return self.summary

    def _page(self, figures: tuple[ReportFigure, ...]) -> str:
        return (replace(self, figures=figures) if figures else self).page

    def plot(self) -> Any:
        """Return following error over a cycle and at reversals, friction, and the changes, as a figure."""
        from bristle.report.figures.comparison import comparison

        return comparison(self)

    def _card(self) -> Card:
        from bristle.report.comparison import HEADS, change_rows, remarks_of

        return Card(
            f"{self.axis_name}: {self.sentences[0]}",
            HEADS,
            tuple(change_rows(self)),
            tuple(remarks_of(self)),
        )


@guarded(
    window=optional(amount(Variable("time", "time after a reversal", min=0.0), exclusive=True))
)
def compare(before: Any, after: Any, *, axis: Any = None, window: Amount | None = None) -> Compared:
    """Compare two logs of one axis, before and after a change, to measure the effect of the change.

    Parameters
    ----------
    before, after : Log, path-like, or table of columns; or list of these
        The log before the change and the log after it, or several of each: a file, or columns ``time``, ``position``, and
        ``reference`` or ``effort`` or both, in SI.
    axis : Axis or path-like, or list of either, optional
        One axis for all logs, or an axis for each log, the logs before the change first.
    window : float or str, optional
        Window after a reversal for the peak of the following error [s]; by default a tenth of the median time between two
        reversals.

    Returns
    -------
    Compared
        Following error, its peaks at reversals, effort and friction, each with the 95 % interval of its change.

    Raises
    ------
    InputError
        If a log or the axis is unsuitable, both sides are the same log, or they share no motion.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(20000) * 1e-3
    >>> reference = 0.02 * np.sin(6.0 * t)
    >>> noise = np.random.default_rng(1).normal(0.0, 1e-6, (2, t.size))
    >>> before, after = (
    ...     {"time": t, "reference": reference, "position": reference - 1e-5 * size * np.cos(6.0 * t) + own}
    ...     for size, own in zip((2.0, 1.0), noise)
    ... )
    >>> found = compare(before, after)
    >>> found.helped, round(found.changes["following_error.rms"].change_percent)
    (True, -50)
    """
    return compared_as(before, after, axis=axis, window=window)


def compared_as(
    before: Any,
    after: Any,
    *,
    axis: Any = None,
    window: float | None = None,
    call: str = "",
    name: str = "",
    read: Mapping[str, Any] | None = None,
    figures: Sequence[ReportFigure] = (),
    size_limit: int = SIZE_LIMIT,
) -> Compared:
    """Return the result of `compare`, with a given call and names."""
    sides = {
        path: list(side) if isinstance(side, (list, tuple)) else [side]
        for path, side in (("before", before), ("after", after))
    }
    axes = iter(axes_for(axis, sum(map(len, sides.values()))))
    pairs = {
        path: _read(side, [next(axes) for _ in side], path, size_limit)
        for path, side in sides.items()
    }
    comparison = sides_compared(pairs["before"], pairs["after"], window)
    first, described = pairs["before"][0]
    # The call that repeats the comparison with the same logs and axis.
    names = [
        [log.origin.name or log.source.name.strip("<>") or path for log, _ in side]
        for path, side in pairs.items()
    ]
    words = [repr(side[0] if len(side) == 1 else side) for side in names]
    words += ["axis=axis"] * any(own is not None for side in pairs.values() for _, own in side)
    words += [f"window={window!r}"] * (window is not None)
    return Compared(
        **{field: getattr(comparison, field) for field in Comparison.__dataclass_fields__},
        axis_name=name
        or (
            described.name
            if described is not None
            else Path(first.source.name.strip("<>")).stem or "axis"
        ),
        call=call or f"bristle.compare({', '.join(words)})",
        read=read or {},
        figures=tuple(figures),
    )


def _read(
    logs: list[Any], axes: list[Any], path: str, size_limit: int
) -> list[tuple[Log, Axis | None]]:
    """Return the logs of a side with their axes; errors name the argument."""
    try:
        return logs_and_axes(logs, axes, size_limit=size_limit)
    except InputError as error:
        raise error.at(path=path if error.path == "log" else error.path) from None
