"""WebAssembly of a friction model: a module of the binary format, written without a compiler, and a script around it.

The module is alone: it imports nothing, and has one page of memory or more. Parameters lie in the memory as numbers, so
that a script may change them between two calls.
"""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.exports.c_code import needs_wide_integers
from bristle.exports.cycle import BEGUN, FORCE, OVERFLOW, POSITION, REFUSED, Cycle, cycle_of
from bristle.exports.described import Source, parameter_table
from bristle.exports.rendering import rendered, version
from bristle.exports.subject import Subject
from bristle.exports.tunable import tunable_of
from bristle.exports.types import REAL, Array, Struct, Type
from bristle.exports.wasm_binary import CALL, END, F64, GET, I32, I64, LOAD, Types, flat, leb, signed_leb, vector
from bristle.exports.wasm_code import Code

__all__ = ["Module", "module_of", "wasm_files"]

PAGE, FIRST = 65536, 8
TYPE, FUNCTION, MEMORY, EXPORT, CODE, DATA = 1, 3, 5, 7, 10, 11


@dataclass(frozen=True)
class Module:
    """A model as a module.

    Parameters
    ----------
    binary : bytes
        The module.
    lasting : int
        Address of what lasts from call to call.
    places : dict
        For each parameter that may be changed, the addresses of its numbers; one list for each place it stands at.
    """

    binary: bytes
    lasting: int
    places: dict[str, list[list[int]]]


class _Memory:
    """The memory of a module while it is laid out."""

    def __init__(self) -> None:
        self.numbers: list[float] = [0.0] * (FIRST // 8)

    def add(self, values: Any) -> int:
        """Put numbers into the memory, and return their address."""
        address = 8 * len(self.numbers)
        self.numbers += [float(value) for value in np.atleast_1d(values)]
        return address


def module_of(subject: Subject) -> Module:
    """Return a friction model as a module of WebAssembly."""
    cycle, memory, types = cycle_of(subject), _Memory(), Types()
    integer = I64 if needs_wide_integers(cycle.unit) else I32
    lasting = memory.add(cycle.begin)
    contact = memory.add(np.zeros(max(subject.memory_size, 1)))
    addresses: dict[tuple[str, ...], int] = {}
    arguments = _parameters(subject.model.parameters, subject.parameters, memory, addresses, ())
    numbers = {id(function): number for number, function in enumerate(cycle.unit.functions)}
    bodies = [Code(function, numbers, types, integer).body() for function in cycle.unit.functions]
    kinds = [
        types.index([n for p in f.parameters for n in flat(p.type, integer)], flat(f.result, integer))
        for f in cycle.unit.functions
    ]
    bodies.append(_entry(cycle, numbers, lasting, contact, arguments, integer))
    kinds.append(types.index([F64, F64], [F64]))
    image = struct.pack(f"<{len(memory.numbers)}d", *memory.numbers)
    pages = (len(image) + PAGE - 1) // PAGE
    exports = [_export("memory", 2, 0), _export("advance", 0, len(kinds) - 1)]
    binary = b"".join([
        b"\0asm\1\0\0\0",
        _section(TYPE, [b"\x60" + vector([bytes([n]) for n in t]) + vector([bytes([n]) for n in g])
                        for t, g in types.listed]),
        _section(FUNCTION, [leb(kind) for kind in kinds]),
        _section(MEMORY, [b"\0" + leb(pages)]),
        _section(EXPORT, exports),
        _section(CODE, bodies),
        _section(DATA, [b"\0\x41" + signed_leb(0) + bytes([END]) + leb(len(image)) + image]),
    ])  # fmt: skip
    return Module(binary, lasting, _places(subject.model, addresses))


def wasm_files(subject: Subject, name: str, source: Source) -> dict[str, str | bytes]:
    """Return the module of a friction model, and the script that loads it."""
    module = module_of(subject)
    facts = {
        "name": name, "model": subject.model.name, "version": version(), "lasting": module.lasting,
        "places": json.dumps(module.places), "table": parameter_table(subject.model, source), "POSITION": POSITION,
        "FORCE": FORCE, "BEGUN": BEGUN, "REFUSED": REFUSED, "OVERFLOW": OVERFLOW,
        "facts": source.lines,
    }  # fmt: skip
    return {f"{name}.wasm": module.binary, f"{name}.mjs": rendered("wasm/module.mjs", facts)}


def _parameters(
    value: Any, kind: Struct, memory: _Memory, addresses: dict[tuple[str, ...], int], path: tuple[str, ...]
) -> list[tuple[Type, Any]]:
    """Lay out parameters, and return each number or array with its address, or itself where it is whole."""
    leaves: list[tuple[Type, Any]] = []
    for (name, part), leaf in zip(kind.fields, value, strict=True):
        if isinstance(part, Struct):
            leaves += _parameters(leaf, part, memory, addresses, (*path, name))
        elif part == REAL or isinstance(part, Array):
            addresses[*path, name] = memory.add(leaf)
            leaves.append((part, addresses[*path, name]))
        else:
            leaves.append((part, int(leaf)))
    return leaves


def _entry(
    cycle: Cycle, numbers: dict[int, int], lasting: int, contact: int, arguments: list[tuple[Type, Any]], integer: int
) -> bytes:
    """Return the code of the exported function: position and time step in, force out."""
    pushed = {
        "lasting": b"\x41" + signed_leb(lasting), "memory": b"\x41" + signed_leb(contact),
        "x": bytes([GET, 0]), "dt": bytes([GET, 1]), "p": b"".join(_loaded(*leaf, integer) for leaf in arguments),
    }  # fmt: skip
    content = b"\0" + b"".join(pushed[parameter.name] for parameter in cycle.entry.parameters)
    content += bytes([CALL]) + leb(numbers[id(cycle.entry)]) + bytes([END])
    return leb(len(content)) + content


def _loaded(kind: Type, place: int, integer: int) -> bytes:
    if kind == REAL:
        return b"\x41" + signed_leb(place) + bytes([LOAD, 3, 0])
    return (b"\x41" if isinstance(kind, Array) or integer == I32 else b"\x42") + signed_leb(place)


def _places(model: Model, addresses: dict[tuple[str, ...], int]) -> dict[str, list[list[int]]]:
    try:
        tuned = tunable_of(model)
    except InputError:
        return {}
    places: dict[str, list[list[int]]] = {name: [] for name in tuned.values}
    for path, name in tuned.places.items():
        size = np.size(tuned.values[name])
        places[name].append([addresses[path] + 8 * i for i in range(size)])
    return places


def _section(number: int, parts: list[bytes]) -> bytes:
    content = vector(parts)
    return bytes([number]) + leb(len(content)) + content


def _export(name: str, kind: int, index: int) -> bytes:
    text = name.encode()
    return leb(len(text)) + text + bytes([kind]) + leb(index)
