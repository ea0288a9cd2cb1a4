"""The figures of each report and their places, in the order of the page.

A figure is a `ReportFigure` in a module of this folder, ``FIGURE`` or the attribute named after a dot, and a line below. The
section is the `id` of a section of the report. For other uses, such as notebooks, its function is also named in ``__init__``.
"""

from collections.abc import Callable
from functools import cache
from importlib import import_module
from typing import NamedTuple

from bristle.figures.report_figure import Facts, ReportFigure


def _by_position(facts: Facts) -> bool:
    """Return whether a model was fitted to the position: then its prediction shows the quality of the fit."""
    return facts["fit"].position_rmse is not None


def _has_curve(facts: Facts) -> bool:
    """Return whether there is friction over velocity; for a plant on a spring the motion is shown instead."""
    return bool(facts["curve"]) or not Place("front", "fit.PREDICTION").figure.applies_to(facts)


def _is_presliding(facts: Facts) -> bool:
    """Return whether a log without a gain is about pre-sliding: then force over displacement is its large picture."""
    if facts["gain_pair"] is not None or not Place("front", "first_screen.AFTER_REVERSALS").figure.applies_to(facts):
        return False
    from bristle.figures.first_screen import is_presliding

    return is_presliding(facts["at_samples"], facts["distance"])


def _shows_effort(facts: Facts) -> bool:
    return facts["gain_pair"] is None and _has_curve(facts) and not _is_presliding(facts)


def _slides(facts: Facts) -> bool:
    return bool(facts["curve"]) and not _is_presliding(facts)


class Place(NamedTuple):
    """Place of a figure."""

    section: str
    name: str
    condition: Callable[[Facts], bool] = lambda facts: True

    @property
    def figure(self) -> ReportFigure:
        """The figure: ``FIGURE`` of a module, or the attribute after a dot."""
        module, _, attribute = self.name.partition(".")
        return getattr(import_module(f"bristle.figures.{module}"), attribute or "FIGURE")

    def is_taken(self, facts: Facts) -> bool:
        """Return whether the figure appears on a report with these facts."""
        return self.condition(facts) and self.figure.applies_to(facts)


# The figures of a kind of report, by section.
REPORTS: dict[str, tuple[Place, ...]] = {
    "identification": (
        Place("front", "first_screen.GAIN"),
        Place("front", "first_screen.PRESLIDING", _is_presliding),
        Place("front", "first_screen.EFFORT", _shows_effort),
        Place("front", "fit.PREDICTION", lambda facts: facts["gain_pair"] is None and not _has_curve(facts)),
        Place("beside", "first_screen.SMALL_EFFORT", _is_presliding),
        Place("beside", "first_screen.VELOCITY", _slides),
        Place("beside", "first_screen.AFTER_REVERSALS", lambda facts: not _is_presliding(facts)),
        Place("following", "following_error"),
        Place("position", "fit.PREDICTION", lambda facts: _has_curve(facts) and _by_position(facts)),
        Place("fit", "fit.TIME"),
        Place("fit", "fit.RESIDUALS"),
        Place("fit", "fit.PREDICTION", lambda facts: _has_curve(facts) and not _by_position(facts)),
        Place("fit", "fit.ERROR"),
        Place("log", "recorded.PASSAGES"),
        Place("log", "recorded.NESTED"),
    ),
    "prediction": (Place("front", "fit.PREDICTION"), Place("beside", "fit.ERROR")),
    "simulation": (
        Place("front", "following_error.OPEN"),
        Place("front", "first_screen.GAIN"),
        Place("front", "first_screen.AT_REVERSAL", lambda facts: facts["gain_pair"] is None),
        Place("beside", "bars.VARIANTS"),
        Place("variants", "following_error"),
    ),
    "log": (Place("front", "recorded.PASSAGES"), Place("beside", "recorded.NESTED"), Place("beside", "recorded.OVER_VELOCITY")),
    "design": (
        Place("front", "loop_design.PROPOSED"),
        Place("beside", "bars.CAUSES"),
        Place("margins", "loop_design.MARGINS"),
        Place("circle", "loop_design.CIRCLES"),
    ),
    "comparison": (
        Place("front", "comparison.WORST"),
        Place("beside", "comparison.CHANGED"),
        Place("beside", "comparison.FRICTION"),
        Place("courses", "comparison"),
    ),
    "tune": (),
    "excitation": (Place("front", "motion"), Place("beside", "motion.EXPECTED")),
    "study": (Place("front", "many_runs.FIRST_SPREAD"), Place("beside", "bars.INFLUENCE"), Place("spread", "many_runs.SPREAD")),
    "fleet": (
        Place("front", "many_runs.FLEET_FIRST"),
        Place("beside", "many_runs.FLEET_SECOND"),
        Place("beside", "many_runs.FLEET_THIRD"),
        Place("parameters", "many_runs.FLEET", lambda facts: len(facts["names"] or ()) > 3),
    ),
    "operator": (Place("front", "recorded.CURVES"), Place("beside", "recorded.CURVE_ERRORS")),
}


@cache
def names_on_reports() -> frozenset[str]:
    """Return the file names of the figures of reports."""
    return frozenset(place.figure.name for places in REPORTS.values() for place in places)
