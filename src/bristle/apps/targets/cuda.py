"""CUDA C++ of a friction model or an operator: thousands of axes in parallel, one thread each.

The functions are those of the export to C, as functions of the device. The state of an axis is the same structure, and
the caller owns an array of it. NVRTC compiles the file without further headers.
"""

import ctypes
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

from bristle.core.errors import InputError
from bristle.engine.translation.tree import INTEGER, REAL, TRUTH, Struct, Type
from bristle.exports.c import CFiles
from bristle.exports.c_code import Printer
from bristle.exports.described import Request, rendered, with_rights
from bristle.exports.subject import settled_subject, subject_of
from bristle.exports.targets import Product
from bristle.exports.tunable import tunable_of
from bristle.models.friction.resting import HELD

HEAD = [
    ("position", ctypes.c_double),
    ("begun", ctypes.c_int32),
    ("force", ctypes.c_double),
    ("flags", ctypes.c_int32),
]


class CudaPrinter(Printer):
    """Prints functions of the device; C++ constructs a structure by its plain name."""

    inline = absorbed = "static __device__ inline"
    constant = "static __device__ const"
    cleared = "{}"

    def structure_text(self, kind: Type, parts: str) -> str:
        """Return the expression that constructs a structure from its parts."""
        return f"{self.type_name(kind)}{{{parts}}}"


class CudaFiles(CFiles):
    """Files of a model in CUDA C++."""

    printer = CudaPrinter
    fixed = (HELD,)
    device: ClassVar[str] = "__device__ "
    templates: ClassVar[Mapping[str, str]] = {
        "{}.cu": "cuda/source.cu",
        "README.md": "cuda/README.md",
    }

    def files(self) -> dict[str, str]:
        """Return the text of each file by its name."""
        facts = self.lane_facts()
        files = {
            file.format(self.request.name): rendered(template, facts)
            for file, template in self.templates.items()
        }
        return with_rights(files, self.request.source)

    def lane_facts(self) -> dict[str, Any]:
        """Return the facts of the templates, with the layout of a lane."""
        subject = self.subject
        output = "force"
        if subject.is_operator:
            output = "output"
        columns = []
        if self.request.tunable:
            numbers = tunable_of(subject.model, self.fixed).numbers()
            columns = [name if place is None else f"{name}[{place}]" for name, place, _ in numbers]
        # The layout of a lane in C.
        integer = {"int32_t": ctypes.c_int32, "int64_t": ctypes.c_int64}[
            self.printer(subject.unit).integer
        ]
        lane = [*HEAD]
        if subject.state.fields:
            lane.append(("state", _layout(subject.state, integer)))
        counts = {"memory": subject.memory_size, "parameters": len(columns)}
        lane += [(name, ctypes.c_double * count) for name, count in counts.items() if count]
        return self.facts() | {
            "device": self.device,
            "inline": self.printer.inline,
            "output": output,
            "columns": len(columns),
            "columns_named": [f"`{name}`" for name in columns],
            "bytes": ctypes.sizeof(_structure(lane)),
        }


def write(request: Request) -> Product:
    """Return the source, with notes on differences from C."""
    subject = subject_of(request.sampled)
    request = replace(request, axis=None, tunable=True)
    notes = ["compile with --fmad=false: fused multiply-add changes the last bits"]
    try:
        places = tunable_of(subject.model, CudaFiles.fixed).places
    except InputError:
        files = CudaFiles(settled_subject(subject), replace(request, tunable=False))
        notes.append("all lanes share the parameters of the model")
    else:
        files = CudaFiles(settled_subject(subject, places), request)
    return Product(dict(files.files()), tuple(notes))


def _layout(kind: Type, integer: type) -> Any:
    if isinstance(kind, Struct):
        return _structure([(name, _layout(part, integer)) for name, part in kind.fields])
    return {REAL: ctypes.c_double, INTEGER: integer, TRUTH: ctypes.c_bool}[kind]  # type: ignore[index]


def _structure(fields: list[tuple[str, Any]]) -> type[ctypes.Structure]:
    return type("Lane", (ctypes.Structure,), {"_fields_": fields})
