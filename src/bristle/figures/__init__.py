"""Figures, one a file: each a function from results to a `matplotlib.figure.Figure`; the only importers of matplotlib.

Every figure is readable in grey: lines differ in lightness and dashes and markers in shape, besides their colour.
"""

from bristle.figures import loading  # noqa: F401  (before all others: with it matplotlib is imported)

# isort: split

from bristle.figures.circles import circles
from bristle.figures.comparison import comparison, comparison_in_short
from bristle.figures.correlation import correlation
from bristle.figures.effort_over_time import effort_over_time, fitted
from bristle.figures.files import figure_file, fits_as_png, inline_svg
from bristle.figures.first_page import first_page
from bristle.figures.fleet_parameters import fleet_parameters
from bristle.figures.following_error import following_error, has_completed, loops_at_reversal
from bristle.figures.loops_proposed import loops_proposed
from bristle.figures.margins import margins
from bristle.figures.motion import expected, motion
from bristle.figures.numbers import as_csv, numbers_of
from bristle.figures.open_loop import open_loop
from bristle.figures.own import load_figure_file
from bristle.figures.passages import passages
from bristle.figures.prediction import prediction
from bristle.figures.preisach import preisach_plane
from bristle.figures.recorded_curves import recorded_curves
from bristle.figures.report_figure import ReportFigure
from bristle.figures.residuals import residuals
from bristle.figures.small_multiples import closure, drift, minor_loops
from bristle.figures.study import study_spread

__all__ = [
    "ReportFigure",
    "as_csv",
    "circles",
    "closure",
    "comparison",
    "comparison_in_short",
    "correlation",
    "drift",
    "effort_over_time",
    "expected",
    "figure_file",
    "first_page",
    "fits_as_png",
    "fitted",
    "fleet_parameters",
    "following_error",
    "has_completed",
    "inline_svg",
    "load_figure_file",
    "loops_at_reversal",
    "loops_proposed",
    "margins",
    "minor_loops",
    "motion",
    "numbers_of",
    "open_loop",
    "passages",
    "prediction",
    "preisach_plane",
    "recorded_curves",
    "residuals",
    "study_spread",
]
