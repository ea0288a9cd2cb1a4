"""What was identified, out of Python: the same kernels in other languages, to the bit, and tables for drives."""

from bristle.exports.face import Exported, export
from bristle.exports.own import load_target_file
from bristle.exports.target import Product, Request, Target
from bristle.exports.targets import TARGETS

__all__ = ["TARGETS", "Exported", "Product", "Request", "Target", "export", "load_target_file"]
