"""CUDA C++ of a friction model or an operator: thousands of axes in parallel, one thread each.

The functions are those of the export to C, as functions of the device. The state of an axis is the same structure, and
the caller owns an array of it. NVRTC compiles the file without further headers.
"""

import ctypes
from dataclasses import replace
from typing import Any

from bristle.core.errors import InputError
from bristle.exports.c import CFiles
from bristle.exports.c_code import Printer
from bristle.exports.described import rendered, with_rights
from bristle.exports.subject import settled_subject, subject_of
from bristle.exports.targets import Product, Request
from bristle.exports.tunable import tunable_of
from bristle.friction.resting import HELD
from bristle.translation.tree import INTEGER, REAL, TRUTH, Struct, Type

HEAD = [("position", ctypes.c_double), ("begun", ctypes.c_int32), ("force", ctypes.c_double), ("flags", ctypes.c_int32)]


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

    def files(self) -> dict[str, str]:
        """Return the text of each file by its name."""
        subject, request, columns = self.subject, self.request, []
        if request.tunable:
            numbers = tunable_of(subject.model, self.fixed).numbers()
            columns = [name if place is None else f"{name}[{place}]" for name, place, _ in numbers]
        # The layout of a lane in C.
        integer = {"int32_t": ctypes.c_int32, "int64_t": ctypes.c_int64}[CudaPrinter(subject.unit).integer]
        lane = [*HEAD, *([("state", _layout(subject.state, integer))] if subject.state.fields else [])]
        for name, count in (("memory", subject.memory_size), ("parameters", len(columns))):
            lane += [(name, ctypes.c_double * count)] if count else []
        facts = self.facts() | {
            "device": "__device__ ",
            "inline": CudaPrinter.inline,
            "output": "output" if subject.is_operator else "force",
            "columns": len(columns),
            "columns_named": [f"`{name}`" for name in columns],
            "bytes": ctypes.sizeof(_structure(lane)),
        }
        files = {f"{request.name}.cu": rendered("cuda/source.cu", facts), "README.md": rendered("cuda/README.md", facts)}
        return with_rights(files, request.source)


def write(request: Request) -> Product:
    """Return the source, with notes on differences from C."""
    subject, request = subject_of(request.sampled), replace(request, axis=None, tunable=True)
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
