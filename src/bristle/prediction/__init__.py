"""Predictions of a log by an identified model, with their bands, and tables for a drive."""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from
from bristle.prediction.drive_table import drive_table
from bristle.prediction.drive_units import drive_units
from bristle.prediction.predict import predict

if TYPE_CHECKING:
    from bristle.prediction.claims import Claim, Compensation, compensation_of
    from bristle.prediction.drive_table import (
        largest_deviation,
        level_values,
        reversal_distance,
        steady_curve,
    )
    from bristle.prediction.following import Following, following_of, loop_of
    from bristle.prediction.kept import fit_of
    from bristle.prediction.predict import effort_of_motion, fit_at_samples, unexplained_force
    from bristle.prediction.proposals import first_gain, proposals_of

__getattr__ = loaded_from(__name__)

__all__ = ["drive_table", "predict", "unexplained_force"]
