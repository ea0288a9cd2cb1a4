"""The main job from start to end: identify, look at the result, tell it, keep it."""

from bristle.workflow.identified import Identified, identify
from bristle.workflow.loaded import Loaded, load
from bristle.workflow.outcome import Outcome, outcome_of

__all__ = ["Identified", "Loaded", "Outcome", "identify", "load", "outcome_of"]
