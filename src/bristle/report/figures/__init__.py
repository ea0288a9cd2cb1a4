"""Figures: functions from results to a `matplotlib.figure.Figure`; the only importers of matplotlib.

Every figure is readable in grey: lines differ in lightness and dashes, markers in shape. This module does not export figures
that only reports use.
"""

from bristle.report.figures import loading  # first of all: imports matplotlib

# isort: split

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.report.figures.files import figure_file, inline_svg
    from bristle.report.figures.first_screen import (
        friction_after_reversals,
        friction_over_velocity,
        gain_at_reversal,
    )
    from bristle.report.figures.following_error import following_error
    from bristle.report.figures.numbers import as_csv, numbers_of
    from bristle.report.figures.own import load_figure_file
    from bristle.report.figures.preisach import preisach_plane
    from bristle.report.figures.recorded import log_over_time
    from bristle.report.figures.report_figure import ReportFigure
    from bristle.report.figures.small_multiples import closure, drift, minor_loops

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
