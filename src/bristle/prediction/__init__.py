"""What an identified model says of a log: predictions with their bands, tables for a drive."""

from bristle.prediction.drive_table import drive_table
from bristle.prediction.predict import predict, unexplained_force

__all__ = ["drive_table", "predict", "unexplained_force"]
