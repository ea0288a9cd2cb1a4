"""C of a friction model along walks of many axes, with forward and reverse derivatives.

The reverse mode evaluates the derived step of `bristle.exports.c_derivatives` with an index in place of each tangent. A
linear operation on tangents then records its slopes on a tape, and a pass backward over the tape adds up the adjoints (S.
Linnainmaa, BIT 16(2), 1976, doi:10.1007/BF01931367). The tape contains only those numbers of the memory that a step reads.
"""

from typing import Any

from bristle.engine.translation.directional import (
    tangent_combined,
    tangent_difference,
    tangent_scaled,
    tangent_sum,
)
from bristle.engine.translation.tree import Function
from bristle.exports.c import CFiles, written_files
from bristle.exports.c_code import Printer
from bristle.exports.c_derivatives import DerivedStep
from bristle.exports.described import Request, rendered

RECORDED = {
    tangent_sum: "tape_sum(a, b)",
    tangent_difference: "tape_recorded(1.0, a, -1.0, b)",
    tangent_scaled: "tape_scaled(a, b)",
    tangent_combined: "tape_recorded(a, b, c, d)",
}
D_VELOCITY = "tape_recorded(1.0, tape_recorded(1.0 / dt, d_x_k, -1.0 / dt, at->position), -velocity / dt, d_dt_k)"
TEMPLATES = {"{}.h": "c/header.h", "{}.c": "c/source.c"}


class TapePrinter(Printer):
    """Prints functions whose linear operations on tangents record on a tape."""

    def definitions(self) -> str:
        """Return the tape, structures and functions."""
        return f'#include "tape.h"\n\n{super().definitions()}'

    def _function(self, function: Function) -> str:
        recorded = RECORDED.get(function.source)
        if recorded is None:
            return super()._function(function)
        arguments = ", ".join(f"double {argument.name}" for argument in function.parameters)
        return (
            f"{self.inline} double {function.name}({arguments})\n{{\n    return {recorded};\n}}\n"
        )


class TapeFiles(CFiles):
    """Files of a friction model whose derived step records on a tape."""

    printer = TapePrinter

    def facts(self) -> dict[str, Any]:
        """Return the facts of the templates."""
        return super().facts() | {"d_velocity": D_VELOCITY}


def walk_files(derived: DerivedStep) -> dict[str, str]:
    """Return the text of the C files by name."""
    subject = derived.subject
    files = dict[str, str]()
    for name, kind in (("friction", CFiles), ("taped", TapeFiles)):
        request = Request(subject.model, name, 1e-3, tunable=True)
        files |= written_files(
            TEMPLATES, name, kind(subject, request, derived=derived).facts(), {}, request.source
        )
    facts = {
        "fields": derived.fields(Printer(subject.unit)),
        "memory": subject.memory_size,
        "signals": list(subject.signals),
    }
    return files | {"tape.h": rendered("c/tape.h", {}), "walk.c": rendered("c/walk.c", facts)}
