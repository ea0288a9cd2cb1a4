"""Export of identified models: the same kernels in other languages, bit by bit, and tables for drives."""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.exports.described import Request, Source
    from bristle.exports.effect import compensated_loop, promise_of_law
    from bristle.exports.face import Exported, export, files_from_text
    from bristle.exports.targets import NAME, TARGETS, Product, Target
    from bristle.exports.walk import CompiledWalk
    from bristle.exports.writing import law_for, load_target_file, name_for, target_named

__getattr__ = loaded_from(__name__)

__all__ = ["TARGETS", "Exported", "Product", "Request", "Target", "export", "load_target_file"]
