"""Two logs of one axis held against each other: what changed, and how sure that is."""

from typing import TYPE_CHECKING

from bristle.comparison.compare import compare
from bristle.loading import loaded_from

if TYPE_CHECKING:
    from bristle.comparison.result import Change, Comparison, Course, Shared, Turn

__getattr__ = loaded_from(__name__)
