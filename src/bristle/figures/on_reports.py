"""Which figure stands on which report, and where: a line each, in the order of the page.

A figure is a module of this folder with a `FIGURE`, and its line below; the section is the `id` of one of the report. To be
drawn elsewhere too, as from a notebook, its function is named in ``__init__``.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib import import_module
from typing import NamedTuple

from bristle.figures.report_figure import Facts, ReportFigure


def _by_position(facts: Facts) -> bool:
    """Return whether a model was fitted to the position: then its prediction is what tells how well."""
    return facts["fit"].position_rmse is not None


def _has_curve(facts: Facts) -> bool:
    """Return whether there is friction over velocity: of a plant on a spring its motion is shown instead."""
    return bool(facts["curve"]) or not Place("front", "prediction").figure.applies_to(facts)


class Place(NamedTuple):
    """Where a figure stands."""

    section: str
    module: str
    condition: Callable[[Facts], bool] = lambda facts: True
    attribute: str = "FIGURE"

    @property
    def figure(self) -> ReportFigure:
        """The figure."""
        return getattr(import_module(f"bristle.figures.{self.module}"), self.attribute)

    def is_taken(self, facts: Facts) -> bool:
        """Return whether the figure stands there on a report that rests on these facts."""
        return self.condition(facts) and self.figure.applies_to(facts)


# The figures of a kind of report, by section.
REPORTS: dict[str, tuple[Place, ...]] = {
    "identification": (
        Place("front", "first_page", _has_curve),
        Place("front", "prediction", lambda facts: not _has_curve(facts)),
        Place("following", "following_error"),
        Place("position", "prediction", lambda facts: _has_curve(facts) and _by_position(facts)),
        Place("fit", "effort_over_time"),
        Place("fit", "residuals"),
        Place("fit", "correlation"),
        Place("fit", "prediction", lambda facts: _has_curve(facts) and not _by_position(facts)),
        Place("log", "passages"),
    ),
    "prediction": (Place("front", "prediction"),),
    "simulation": (
        Place("front", "open_loop"),
        Place("front", "following_error", attribute="AT_REVERSAL"),
        Place("variants", "following_error"),
    ),
    "log": (Place("front", "passages"),),
    "design": (Place("front", "loops_proposed"), Place("margins", "margins"), Place("circle", "circles")),
    "comparison": (Place("front", "comparison", attribute="SHORT"), Place("courses", "comparison")),
    "excitation": (Place("front", "motion"), Place("outlook", "motion", attribute="EXPECTED")),
    "study": (Place("spread", "study"),),
    "fleet": (Place("parameters", "fleet_parameters"),),
    "operator": (Place("front", "recorded_curves"),),
}


@cache
def names_on_reports() -> frozenset[str]:
    """Return what the figures of reports are called as files."""
    return frozenset(place.figure.name for places in REPORTS.values() for place in places)
