"""What was identified, out of Python: the same kernels in other languages, to the bit, and tables for drives."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bristle.exports.face import Exported, export
    from bristle.exports.targets import TARGETS, Product, Request, Target
    from bristle.exports.writing import load_target_file

__all__ = ["TARGETS", "Exported", "Product", "Request", "Target", "export", "load_target_file"]

_FROM = {"Exported": "face", "export": "face", "load_target_file": "writing"}
_FROM |= dict.fromkeys(("TARGETS", "Product", "Request", "Target"), "targets")


def __getattr__(name: str) -> Any:
    # Not by `loaded_from` of the core, which loads numpy: help lists the targets, and waits for no library.
    if name in _FROM:
        return getattr(importlib.import_module(f"{__name__}.{_FROM[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
