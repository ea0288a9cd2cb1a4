"""What was identified, out of Python: the same kernels in other languages, to the bit, and tables for drives."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bristle.core.lazy import loaded_from

if TYPE_CHECKING:
    from bristle.exports.face import Exported, export
    from bristle.exports.targets import TARGETS, Product, Request, Target
    from bristle.exports.writing import load_target_file

__all__ = ["TARGETS", "Exported", "Product", "Request", "Target", "export", "load_target_file"]

# What serves other rooms loads numpy, and help that lists the targets waits for nothing that computes.
_FROM = {"Exported": "face", "export": "face", "load_target_file": "writing"}
__getattr__ = loaded_from(__name__, _FROM | dict.fromkeys(("TARGETS", "Product", "Request", "Target"), "targets"))
