"""The main job from start to end: identify, look at the result, tell it, keep it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bristle.core.lazy import loaded_from

if TYPE_CHECKING:
    from bristle.workflow.compared import Compared, compare
    from bristle.workflow.identified import Identified, identify
    from bristle.workflow.model_in_hand import Loaded, load
    from bristle.workflow.pipeline import Prepared, prepare

__all__ = ["Compared", "Identified", "Loaded", "Prepared", "compare", "identify", "load", "prepare"]

__getattr__ = loaded_from(
    __name__,
    {
        "Compared": "compared",
        "compare": "compared",
        "Identified": "identified",
        "identify": "identified",
        "Loaded": "model_in_hand",
        "load": "model_in_hand",
        "Prepared": "pipeline",
        "prepare": "pipeline",
    },
)
