"""Figures: functions from results to a `matplotlib.figure.Figure`; the only importers of matplotlib.

Every figure is readable in grey: lines differ in lightness and dashes, markers in shape. This module does not export figures
that only reports use.
"""

from bristle.figures import loading  # first of all: imports matplotlib

# isort: split

from bristle.figures.files import figure_file, inline_svg
from bristle.figures.first_screen import friction_after_reversals, friction_over_velocity, gain_at_reversal
from bristle.figures.following_error import following_error
from bristle.figures.numbers import as_csv, numbers_of
from bristle.figures.own import load_figure_file
from bristle.figures.preisach import preisach_plane
from bristle.figures.recorded import log_over_time
from bristle.figures.report_figure import ReportFigure
from bristle.figures.small_multiples import closure, drift, minor_loops
from bristle.loading import loaded_from

__getattr__ = loaded_from(__name__)
__all__ = [
    "ReportFigure",
    "as_csv",
    "closure",
    "drift",
    "figure_file",
    "following_error",
    "friction_after_reversals",
    "friction_over_velocity",
    "gain_at_reversal",
    "inline_svg",
    "load_figure_file",
    "log_over_time",
    "minor_loops",
    "numbers_of",
    "preisach_plane",
]
