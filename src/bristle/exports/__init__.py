"""What was identified, out of Python: the same kernels in other languages, to the bit, and tables for drives."""

from typing import TYPE_CHECKING

from bristle.loading import loaded_from

if TYPE_CHECKING:
    from bristle.exports.described import Source, version
    from bristle.exports.face import NAME, Exported, export, files_from_text
    from bristle.exports.page.described import body_described, model_described, values_of, variables_of
    from bristle.exports.page.loop import loop_described, parts_described, trace_described
    from bristle.exports.page.packing import as_json, packed, plain
    from bristle.exports.page.rows import fitted_rows
    from bristle.exports.page.switches import common_described, example_described, slots_described, switched
    from bristle.exports.targets import TARGETS, Product, Request, Target
    from bristle.exports.writing import law_for, load_target_file, name_for, target_named

__getattr__ = loaded_from(__name__)

__all__ = ["TARGETS", "Exported", "Product", "Request", "Target", "export", "load_target_file"]
