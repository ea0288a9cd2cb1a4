"""Figures, one a file: each a function from results to a `matplotlib.figure.Figure`; the only importers of matplotlib.

Every figure is readable in grey: lines differ in lightness and dashes and markers in shape, besides their colour.
"""

from typing import Any

from bristle.figures import loading  # noqa: F401  (before all others: with it matplotlib is imported)

# isort: split

from bristle.figures.circles import circles
from bristle.figures.comparison import comparison, comparison_in_short
from bristle.figures.correlation import correlation
from bristle.figures.drive_table import drive_table
from bristle.figures.effort_over_time import effort_over_time, fitted
from bristle.figures.error_budget import error_budget
from bristle.figures.files import figure_file, fits_as_png, inline_svg
from bristle.figures.first_page import first_page
from bristle.figures.fleet_parameters import fleet_parameters
from bristle.figures.following_error import following_error, has_completed, loops_at_reversal
from bristle.figures.friction_over_velocity import friction_over_velocity
from bristle.figures.loops_proposed import loops_proposed
from bristle.figures.margins import margins
from bristle.figures.model_comparison import model_comparison
from bristle.figures.motion import expected, motion
from bristle.figures.numbers import as_csv, numbers_of
from bristle.figures.open_loop import open_loop
from bristle.figures.own import load_figure_file
from bristle.figures.parameters import parameters
from bristle.figures.passages import passages
from bristle.figures.prediction import prediction
from bristle.figures.preisach import everett_surface, preisach_plane, transition_curves
from bristle.figures.recorded_curves import recorded_curves
from bristle.figures.report_figure import ReportFigure
from bristle.figures.residuals import residuals
from bristle.figures.small_multiples import closure, drift, minor_loops
from bristle.figures.study import study_influence, study_spread

__all__ = [
    "ReportFigure",
    "as_csv",
    "circles",
    "closure",
    "comparison",
    "comparison_in_short",
    "correlation",
    "drift",
    "drive_table",
    "effort_over_time",
    "error_budget",
    "everett_surface",
    "expected",
    "figure_file",
    "first_page",
    "fits_as_png",
    "fitted",
    "fleet_parameters",
    "following_error",
    "friction_over_velocity",
    "has_completed",
    "inline_svg",
    "load_figure_file",
    "loops_at_reversal",
    "loops_proposed",
    "margins",
    "minor_loops",
    "model_comparison",
    "motion",
    "numbers_of",
    "open_loop",
    "parameters",
    "passages",
    "prediction",
    "preisach_plane",
    "recorded_curves",
    "residuals",
    "study_influence",
    "study_spread",
    "transition_curves",
]

_ELSEWHERE = {
    "errors": ("Spread", "error_over", "errors_by_loop", "errors_by_truth"),
    "errors.error_over": ("error_over_count", "error_over_level"),
    "loop_family": ("break_away", "loop_family", "ripple"),
    "loop_rows": ("control_effort", "error_distribution", "tracking", "tracking_error"),
    "preisach": ("preisach_stages",),
    "rig_layout": ("Mechanics", "rig_layout"),
    "small_multiples": ("marked_path",),
}
"""Where figures of the source paper are that were offered here until this release."""


def __getattr__(name: str) -> Any:
    place = next((place for place, names in _ELSEWHERE.items() if name in names), None)
    raise AttributeError(f"bristle.figures has no {name}" + (f" any more; it is in bristle.figures.{place}" if place else ""))
