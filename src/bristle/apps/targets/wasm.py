"""WebAssembly of a friction model: a module of the binary format, written without a compiler, and a script around it.

The module has no imports and at least one page of memory. Parameters are numbers in the memory, so that a script can
change them between two calls. With a plant, a second function makes a step of the plant with this friction under an
effort. It has a separate contact and the same friction parameters.
"""

import json
import math
import struct
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import reduce
from typing import Any, NamedTuple

import numpy as np

from bristle.apps.targets.wasm_code import OP, Code, Types, emitted, flat, leb, signed_leb, vector
from bristle.core import InputError, Model
from bristle.engine.translation.build import Builder
from bristle.engine.translation.tree import (
    REAL,
    Array,
    Call,
    Function,
    Struct,
    Unit,
    struct_type,
    walk,
)
from bristle.exports.cycle import (
    BEGUN,
    FORCE,
    OVERFLOW,
    POSITION,
    REFUSED,
    STATE,
    core_of,
    cycle_of,
)
from bristle.exports.described import Request, parameter_table, rendered, version, with_rights
from bristle.exports.printing import needs_wide_integers
from bristle.exports.settled import pruned
from bristle.exports.subject import (
    FNV_OFFSET,
    FNV_PRIME,
    Subject,
    digest_of,
    layout_of,
    most_of,
    subject_of,
)
from bristle.exports.targets import Product
from bristle.exports.tunable import tunable_of
from bristle.models.friction import unvaried
from bristle.models.friction.resting import rest_rule

PAGE = 65536
FIRST = 8
# Limits on parts of the tree that inlining a function may add.
ALONE = 500
PACKED = 60
# Fields of the parameters that make friction vary.
VARYING = frozenset({"place", "rise", "slot", "around"})


@dataclass(frozen=True)
class Module:
    """A model as a module."""

    binary: bytes
    lasting: int
    places: dict[str, list[list[int]]]
    contact: int
    body: int
    parameters: int
    still: list[tuple[int, float]]


class _Memory:
    """The memory layout of a module under construction, and the parameters of its entries in it."""

    def __init__(self, unit: Unit, roots: list[Function], added: int) -> None:
        self.functions = _called(unit, roots, added)
        self.integer = "i32"
        if needs_wide_integers(unit):
            self.integer = "i64"
        self.numbers: list[float] = [0.0] * (FIRST // 8)
        self.pushed: dict[str, bytes] = {}
        self.addresses: dict[str, dict[tuple[str, ...], int]] = {}

    def add(self, values: Any) -> int:
        """Put numbers into the memory, and return their address."""
        address = 8 * len(self.numbers)
        self.numbers += [float(value) for value in np.atleast_1d(values)]
        return address

    def place(
        self, argument: str, model: Model, kind: Struct, *, choices: bool = False
    ) -> dict[str, list[list[int]]]:
        """Lay out the parameters of a model, store the instructions that pass them to an entry, and return their addresses."""
        named = {
            name
            for name, variable in model.component.variables.items()
            if variable.choices and choices
        }
        self.addresses[argument] = {}
        self.pushed[argument] = self._pushed(
            model.parameters, kind, self.addresses[argument], (), named
        )
        return _places(model, self.addresses[argument], choices=choices)

    def _pushed(
        self,
        value: Any,
        kind: Struct,
        addresses: dict[tuple[str, ...], int],
        path: tuple[str, ...],
        named: set[str],
    ) -> bytes:
        """Return the instructions that push parameters: fixed whole numbers by value, arrays by address."""
        code = b""
        for (name, part), leaf in zip(kind.fields, value, strict=True):
            if isinstance(part, Struct):
                code += self._pushed(leaf, part, addresses, (*path, name), named)
            elif part == REAL or isinstance(part, Array) or name in named:
                addresses[*path, name] = self.add(leaf)
                code += emitted("i32.const", signed_leb(addresses[*path, name]))
                if not isinstance(part, Array):
                    code += OP["load"]
                    if part != REAL:
                        code += OP[f"{self.integer}.truncate"]
            else:
                code += emitted(f"{self.integer}.const", signed_leb(int(leaf)))
        return code


def module_of(
    subject: Subject,
    plant: Model | None = None,
    *,
    choices: bool = False,
    added: int = PACKED,
    others: Mapping[str, Callable[[Builder], Function]] | None = None,
) -> Module:
    """Return a friction model as a module of WebAssembly."""
    builder = Builder()
    entry, begin = cycle_of(subject, builder)
    core = None
    roots = {"advance": entry}
    if plant is not None:
        core = core_of(subject, plant, builder)
        roots["step"] = core.entry
    roots |= {name: build(builder) for name, build in (others or {}).items()}
    unit = pruned(builder.unit, list(roots.values()))
    layout = _Memory(unit, list(roots.values()), added)
    size = max(subject.memory_size, 1)
    places = {"lasting": layout.add(begin), "memory": layout.add(np.zeros(size))}
    begins = dict.fromkeys(roots, places)
    if core is not None:
        begins["step"] = {"lasting": layout.add(core.begin), "memory": layout.add([0] * size)}
    parameters = 8 * len(layout.numbers)
    addresses = layout.place("p", subject.model, subject.parameters, choices=choices)
    if plant is not None and core is not None:
        addresses |= layout.place("q", plant, core.parameters["q"][1])
    binary = _binary(
        {name: _entry(root, layout, begins[name]) for name, root in roots.items()}, layout
    )
    body = 0
    if core is not None:
        body = begins["step"]["lasting"]
    # Addresses of the coefficients of variations, and their neutral values.
    values = unvaried(subject.model).parameters
    still = [
        (at, float(reduce(getattr, path, values)))
        for path, at in layout.addresses["p"].items()
        if not VARYING.isdisjoint(path)
    ]
    return Module(binary, places["lasting"], addresses, places["memory"], body, parameters, still)


class Part(NamedTuple):
    """A function of a module with several: its function of the tree, its initial state, and its model."""

    entry: Function
    begin: np.ndarray
    model: Model


def module_of_parts(
    builder: Builder, parts: Mapping[str, Part]
) -> tuple[bytes, dict[str, dict[str, Any]]]:
    """Return a module with an exported function for each part, and the addresses of state and parameters."""
    roots = [part.entry for part in parts.values()]
    layout = _Memory(pruned(builder.unit, roots), roots, PACKED)
    begins = {name: {"lasting": layout.add(part.begin)} for name, part in parts.items()}
    entries = {}
    addresses = {}
    for name, part in parts.items():
        places = layout.place("p", part.model, struct_type(part.model.parameters))
        entries[name] = _entry(part.entry, layout, begins[name])
        addresses[name] = begins[name] | {"places": places}
    return _binary(entries, layout), addresses


def _called(unit: Unit, roots: list[Function], added: int) -> list[Function]:
    """Return the functions that stay functions; the others are inlined, because this adds few parts."""
    calls = Counter(
        id(part.function) for f in unit.functions for part in walk(f.body) if isinstance(part, Call)
    )
    functions = []
    sizes = dict[int, int]()
    for function in unit.functions:
        parts = list(walk(function.body))
        size = len(parts) + sum(
            sizes.get(id(part.function), 0) for part in parts if isinstance(part, Call)
        )
        if function in roots or (calls[id(function)] - 1) * size > added:
            functions.append(function)
        else:
            sizes[id(function)] = size
    return functions


def _binary(entries: dict[str, bytes], layout: _Memory) -> bytes:
    """Return the module of some functions, with an exported function for each entry."""
    types = Types()
    integer = layout.integer
    functions = layout.functions
    numbers = {id(function): number for number, function in enumerate(functions)}
    bodies = [Code(function, numbers, types, integer).body() for function in functions]
    bodies += entries.values()
    kinds = [
        types.index(
            [n for p in f.parameters for n in flat(p.type, integer)], flat(f.result, integer)
        )
        for f in functions
    ] + [types.index(["f64", "f64"], ["f64"])] * len(entries)
    image = struct.pack(f"<{len(layout.numbers)}d", *layout.numbers)
    pages = (len(image) + PAGE - 1) // PAGE
    exported = [
        ("memory", b"\2", 0),
        *((name, b"\0", number) for number, name in enumerate(entries, len(functions))),
    ]
    sections = {
        "types": [
            b"\x60" + vector([OP[n] for n in t]) + vector([OP[n] for n in g])
            for t, g in types.listed
        ],
        "functions": [leb(kind) for kind in kinds],
        "memories": [b"\0" + leb(pages)],
        "exports": [
            leb(len(name)) + name.encode() + kind + leb(index) for name, kind, index in exported
        ],
        "code": bodies,
        "data": [b"\0" + emitted("i32.const", signed_leb(0), "end") + leb(len(image)) + image],
    }
    contents = {name: vector(parts) for name, parts in sections.items()}
    return b"\0asm\1\0\0\0" + b"".join(
        OP[name] + leb(len(content)) + content for name, content in contents.items()
    )


def _finite(value: float) -> float | None:
    """Return a finite bound; None, which JSON can write, for an infinite one."""
    if math.isfinite(value):
        return value
    return None


def write(request: Request) -> Product:
    """Return the module of a friction model, and the script that loads it."""
    subject = subject_of(request.sampled)
    name = request.name
    source = request.source
    module = module_of(subject, added=ALONE)
    state = subject.state.fields
    ranges = {
        name: [_finite(variable.min), _finite(variable.max)]
        for name, variable in subject.model.component.variables.items()
    }
    facts = (
        {
            "name": name,
            "model": subject.model.name,
            "version": version(),
            "facts": source.lines,
            "rest": rest_rule(subject.model),
        }
        | {
            "lasting": module.lasting,
            "contact": module.contact,
            "memory": subject.memory_size,
            "places": json.dumps(module.places),
        }
        | {
            "POSITION": POSITION,
            "FORCE": FORCE,
            "BEGUN": BEGUN,
            "REFUSED": REFUSED,
            "OVERFLOW": OVERFLOW,
            "STATE": STATE,
        }
        | {"table": parameter_table(subject.model, source), "ranges": json.dumps(ranges)}
        | {"values": [most_of(name, kind, subject.memory_size) for name, kind in state]}
        | {
            "layout": f"0x{digest_of(layout_of(subject, 'double').encode()):016X}",
            "FNV_OFFSET": FNV_OFFSET,
            "FNV_PRIME": FNV_PRIME,
        }
    )
    script = with_rights({f"{name}.mjs": rendered("wasm/module.mjs", facts)}, source)
    return Product({f"{name}.wasm": module.binary, **script})


def _entry(root: Function, layout: _Memory, begin: dict[str, int]) -> bytes:
    """Return the code of an exported function: position, or effort, and time step in, force out."""
    pushed = layout.pushed | {
        name: emitted("i32.const", signed_leb(place)) for name, place in begin.items()
    }
    pushed |= {
        "x": emitted("get", leb(0)),
        "effort": emitted("get", leb(0)),
        "dt": emitted("get", leb(1)),
    }
    number = next(number for number, function in enumerate(layout.functions) if function is root)
    content = b"\0" + b"".join(pushed[parameter.name] for parameter in root.parameters)
    content += emitted("call", leb(number), "end")
    return leb(len(content)) + content


def _places(
    model: Model, addresses: dict[tuple[str, ...], int], *, choices: bool = False
) -> dict[str, list[list[int]]]:
    try:
        tuned = tunable_of(model)
    except InputError:
        return {}
    places: dict[str, list[list[int]]] = {name: [] for name in tuned.values}
    for path, name in tuned.places.items():
        size = np.size(tuned.values[name])
        places[name].append([addresses[path] + 8 * i for i in range(size)])
    if choices:
        for path, address in addresses.items():
            variable = model.component.variables.get(path[-1])
            if path not in tuned.places and variable and variable.choices:
                places.setdefault(path[-1], []).append([address])
    return places
