"""Figures of a user's own on a report: each under its title; one that fails costs nothing but itself, and is told."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from bristle.core.errors import InputWarning, place_in_own_code, told_by
from bristle.report.page import Picture, picture

if TYPE_CHECKING:
    from bristle.figures.report_figure import Facts, ReportFigure

__all__ = ["FurtherFigure", "further_figures"]


class FurtherFigure(NamedTuple):
    """A figure of a user's own as a page has it: its title, and the picture, or why there is none."""

    title: str
    picture: Picture | None
    remark: str = ""


def further_figures(figures: Sequence[ReportFigure], facts: Facts) -> list[FurtherFigure]:
    """Return figures of a user's own, drawn; what fails is told by a warning and on the page."""
    return [_further(figure, facts) for figure in figures]


def _further(figure: ReportFigure, facts: Facts) -> FurtherFigure:
    from bristle.figures.own import draw_own

    if missing := figure.missing(facts):
        return _not_drawn(figure, f"this report has no {' and no '.join(missing)}")
    try:
        drawing = picture(
            f"own-{figure.name.replace('_', '-')}",
            lambda: draw_own(figure, facts),
            str(figure.alternative),
            str(figure.caption),
            file=figure.name,
            own=True,
        )
    # What a user's code may raise has no common type, and exit() in it is no reason to lose the results.
    except (Exception, SystemExit) as error:  # noqa: BLE001
        return _not_drawn(figure, f"{type(error).__name__}: {told_by(error)}".rstrip(": "), place_in_own_code(error))
    return FurtherFigure(figure.title, drawing)


def _not_drawn(figure: ReportFigure, reason: str, place: str = "") -> FurtherFigure:
    remark = f"{place or figure.name}: the figure {figure.name} is not drawn: {reason}"
    warnings.warn(f"{remark}. The results are whole without it", InputWarning, stacklevel=2)
    return FurtherFigure(figure.title, None, f"{remark}.")
