"""The main job from start to end: identify, look at the result, tell it, keep it."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bristle.workflow.compared import Compared, compare
    from bristle.workflow.identified import Identified, identify
    from bristle.workflow.model_in_hand import Loaded, load
    from bristle.workflow.outcome import Outcome
    from bristle.workflow.pipeline import Prepared, prepare

__all__ = ["Compared", "Identified", "Loaded", "Outcome", "Prepared", "compare", "identify", "load", "prepare"]

_FROM = {
    "Compared": "compared",
    "compare": "compared",
    "Identified": "identified",
    "identify": "identified",
    "Loaded": "model_in_hand",
    "load": "model_in_hand",
    "Outcome": "outcome",
    "Prepared": "pipeline",
    "prepare": "pipeline",
}


def __getattr__(name: str) -> Any:
    if name in _FROM:
        return getattr(importlib.import_module(f"bristle.workflow.{_FROM[name]}"), name)
    raise AttributeError(f"module 'bristle.workflow' has no attribute {name!r}")
