"""The figures of a report: those that its list names, as far as it has what they are drawn from."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bristle.report.page import Picture, picture

if TYPE_CHECKING:
    from bristle.figures.report_figure import Facts, ReportFigure

__all__ = ["pictures_on"]


def pictures_on(report: str, facts: Facts) -> dict[str, list[Picture]]:
    """Return the figures of a report, by section, in the order of the page."""
    from bristle.figures.on_reports import REPORTS

    places = REPORTS[report]
    pictures: dict[str, list[Picture]] = {place.section: [] for place in places}
    for place in places:
        if place.is_taken(facts):
            pictures[place.section].append(_drawn(place.figure, facts))
    return pictures


def _drawn(figure: ReportFigure, facts: Facts) -> Picture:
    arguments = figure.arguments(facts)
    alternative, caption = (text if isinstance(text, str) else text(*arguments) for text in (figure.alternative, figure.caption))
    return picture(figure.name, lambda: figure.draw(*arguments), alternative, caption)
