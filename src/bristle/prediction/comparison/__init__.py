"""Comparison of two logs of an axis: the changes, with their uncertainty."""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from
from bristle.prediction.comparison.compare import compare

if TYPE_CHECKING:
    from bristle.prediction.comparison.result import Change, Comparison, Course, Shared, Turn

__getattr__ = loaded_from(__name__)
