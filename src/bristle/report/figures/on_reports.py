"""The figures of each report and their places, in the order of the page.

A figure is a function with the decorator `shown` in a module of this folder, and a line below. The section is the `id` of a
section of the report. For other uses, such as notebooks, its function is also named in ``__init__``.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial
from importlib import import_module
from typing import NamedTuple

from bristle.report.figures.report_figure import FIGURES, Facts, ReportFigure


def _has_curve(facts: Facts) -> bool:
    """Return whether there is friction over velocity; for a plant on a spring the motion is shown instead."""
    return bool(facts["curve"]) or not Place("front", "fit.prediction").figure.applies_to(facts)


def _is_elastic(facts: Facts) -> bool:
    """Return whether the picture of one mass would hide the second mass."""
    return facts["both_sides"] is not None or facts["elastic"] is not None


def _is_alone(facts: Facts) -> bool:
    """Return whether the friction of the axis is not that of motor and load apart."""
    return facts["both_sides"] is None


def _has_no_gain(facts: Facts) -> bool:
    """Return whether neither a gain nor a second mass takes the large picture."""
    return facts["gain_pair"] is None and not _is_elastic(facts)


def _is_presliding(facts: Facts) -> bool:
    """Return whether a log without a gain is about pre-sliding: then force over displacement is its large picture."""
    if (
        facts["gain_pair"] is not None
        or _is_elastic(facts)
        or not Place("front", "first_screen.reversals").figure.applies_to(facts)
    ):
        return False
    from bristle.report.figures.first_screen import is_presliding

    return is_presliding(facts["at_samples"], facts["distance"])


# Modules of figures that apps draw.
OF_APPS = {
    "joints": "bristle.apps.arm.joints",
    "loop_design": "bristle.apps.design.loop_design",
    "many_runs": "bristle.apps.study.many_runs",
}


class Place(NamedTuple):
    """Place of a figure, named by its module and its name, with options of its function."""

    section: str
    name: str
    condition: Callable[[Facts], bool] = lambda facts: True
    options: Mapping[str, bool] = {}

    @property
    def figure(self) -> ReportFigure:
        """The figure."""
        module = self.name.partition(".")[0]
        import_module(OF_APPS.get(module, f"bristle.report.figures.{module}"))
        figure = FIGURES[self.name]
        return (
            replace(figure, draw=partial(figure.draw, **self.options)) if self.options else figure
        )

    def is_taken(self, facts: Facts) -> bool:
        """Return whether the figure appears on a report with these facts."""
        return self.condition(facts) and self.figure.applies_to(facts)


# The figures of a kind of report, by section.
REPORTS: dict[str, tuple[Place, ...]] = {
    "identification": (
        Place("front", "two_masses.sides", _is_elastic),
        Place("front", "two_masses.response", _is_elastic),
        Place("front", "first_screen.gain", lambda facts: not _is_elastic(facts)),
        Place("front", "first_screen.reversals", _is_presliding, {"large": True}),
        Place(
            "front",
            "first_screen.effort",
            lambda facts: _has_no_gain(facts) and _has_curve(facts) and not _is_presliding(facts),
        ),
        Place(
            "front", "fit.prediction", lambda facts: _has_no_gain(facts) and not _has_curve(facts)
        ),
        Place("beside", "two_masses.frictions", _is_elastic),
        Place("beside", "two_masses.lost_motion", _is_elastic),
        Place("beside", "first_screen.effort", _is_presliding, {"small": True}),
        Place(
            "beside",
            "first_screen.velocity",
            lambda facts: bool(facts["curve"]) and _is_alone(facts) and not _is_presliding(facts),
        ),
        Place(
            "beside",
            "first_screen.reversals",
            lambda facts: _is_alone(facts) and not _is_presliding(facts),
        ),
        Place("following", "first_screen.gain", _is_elastic),
        Place("following", "following_error.following"),
        Place(
            "position",
            "fit.prediction",
            lambda facts: _has_curve(facts) and facts["fit"].position_rmse is not None,
        ),
        Place("fit", "fit.time"),
        Place("fit", "fit.residuals"),
        Place(
            "fit",
            "fit.prediction",
            lambda facts: _has_curve(facts) and facts["fit"].position_rmse is None,
        ),
        Place("fit", "fit.error"),
        Place("explanation", "explained.forces"),
        Place("log", "recorded.passages"),
        Place("log", "recorded.loops"),
    ),
    "prediction": (Place("front", "fit.prediction"), Place("beside", "fit.error")),
    "simulation": (
        Place("front", "following_error.motion"),
        Place("front", "first_screen.gain"),
        Place("front", "first_screen.reversal", lambda facts: facts["gain_pair"] is None),
        Place("beside", "bars.variants"),
        Place("variants", "following_error.following"),
    ),
    "log": (
        Place("front", "recorded.passages"),
        Place("beside", "recorded.loops"),
        Place("beside", "recorded.velocities"),
        Place("explanation", "explained.forces"),
    ),
    "design": (
        Place("front", "loop_design.loops"),
        Place("beside", "bars.causes"),
        Place("margins", "loop_design.margins"),
        Place("circle", "loop_design.circles"),
    ),
    "comparison": (
        Place("front", "comparison.worst"),
        Place("beside", "comparison.changes"),
        Place("beside", "comparison.friction"),
        Place("courses", "comparison.comparison"),
    ),
    "excitation": (Place("front", "motion.motion"), Place("beside", "motion.expected")),
    "study": (
        Place("front", "many_runs.distribution"),
        Place("beside", "bars.influence"),
        Place("spread", "many_runs.spread"),
    ),
    "fleet": (
        Place("front", "joints.joints"),
        Place("front", "many_runs.parameter", lambda facts: facts["joints"] is None),
        Place("beside", "many_runs.parameter_2", lambda facts: facts["joints"] is None),
        Place("beside", "many_runs.parameter_3", lambda facts: facts["joints"] is None),
        Place("parameters", "many_runs.fleet", lambda facts: len(facts["names"] or ()) > 3),
    ),
    "arm": (Place("front", "joints.joints"),),
    "operator": (Place("front", "recorded.curves"), Place("beside", "recorded.errors")),
}


@cache
def names_on_reports() -> frozenset[str]:
    """Return the file names of the figures of reports."""
    return frozenset(place.figure.name for places in REPORTS.values() for place in places)
