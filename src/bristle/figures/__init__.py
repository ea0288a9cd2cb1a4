"""Figures, one a file: each a function from results to a `matplotlib.figure.Figure`; the only importers of matplotlib.

Every figure is readable in grey: lines differ in lightness and dashes and markers in shape, besides their colour.
"""

from bristle.figures.closure import closure
from bristle.figures.correlation import correlation
from bristle.figures.drift import drift
from bristle.figures.drive_table import drive_table
from bristle.figures.effort_over_time import effort_over_time
from bristle.figures.everett_surface import everett_surface
from bristle.figures.following_error import following_error, has_completed
from bristle.figures.friction_over_velocity import friction_over_velocity
from bristle.figures.minor_loops import minor_loops
from bristle.figures.model_comparison import model_comparison
from bristle.figures.motion import expected, motion
from bristle.figures.parameters import parameters
from bristle.figures.passages import passages
from bristle.figures.prediction import prediction
from bristle.figures.preisach_plane import preisach_plane
from bristle.figures.residuals import residuals
from bristle.figures.svg import inline_svg
from bristle.figures.transition_curves import transition_curves

__all__ = [
    "closure",
    "correlation",
    "drift",
    "drive_table",
    "effort_over_time",
    "everett_surface",
    "expected",
    "following_error",
    "friction_over_velocity",
    "has_completed",
    "inline_svg",
    "minor_loops",
    "model_comparison",
    "motion",
    "parameters",
    "passages",
    "prediction",
    "preisach_plane",
    "residuals",
    "transition_curves",
]
