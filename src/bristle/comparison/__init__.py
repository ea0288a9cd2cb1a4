"""Comparison of two logs of an axis: the changes, with their uncertainty."""

from typing import TYPE_CHECKING

from bristle.comparison.compare import compare
from bristle.loading import loaded_from

if TYPE_CHECKING:
    from bristle.comparison.result import Change, Comparison, Course, Shared, Turn

__getattr__ = loaded_from(__name__)
