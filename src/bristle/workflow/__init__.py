"""The main job from start to end: identify, look at the result, tell it, keep it."""

from bristle.workflow.compared import Compared, compare
from bristle.workflow.identified import Identified, identify
from bristle.workflow.loaded import Loaded, load
from bristle.workflow.outcome import Outcome
from bristle.workflow.pipeline import Prepared, prepare

__all__ = ["Compared", "Identified", "Loaded", "Outcome", "Prepared", "compare", "identify", "load", "prepare"]
