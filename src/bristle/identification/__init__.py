"""From a log to friction models with honest uncertainty."""

from bristle.identification.drive_table import drive_table
from bristle.identification.inverse_dynamics import identify
from bristle.identification.prediction import predict, unexplained_force
from bristle.identification.result import Estimate, Fit, HeldOut, Identification, Traces

__all__ = [
    "Estimate",
    "Fit",
    "HeldOut",
    "Identification",
    "Traces",
    "drive_table",
    "identify",
    "predict",
    "unexplained_force",
]
