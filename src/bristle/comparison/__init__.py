"""Two logs of one axis held against each other: what changed, and how sure that is."""

from bristle.comparison.compare import compare
from bristle.comparison.result import Change, Comparison, Course, Shared, Turn

__all__ = ["Change", "Comparison", "Course", "Shared", "Turn", "compare"]
