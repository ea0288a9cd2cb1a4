"""C99 of a control law: a header, a source that compiles alone, a self-test, an example and what builds them.

The functions are those of the tree. What is between them and the caller, what lasts, the inputs and those that are no
numbers, is written here.
"""

from __future__ import annotations

import typing
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from bristle.core.variable import Variable
from bristle.exports.c import FLAGS, selftest_facts, written_files
from bristle.exports.c_code import Printer, number
from bristle.exports.c_parts import CONSTANT, array_text, declared, helpers_text, literal, parameters_text, saved_facts, started
from bristle.exports.described import Source, meaning_of
from bristle.exports.law import Law
from bristle.exports.law_described import PER_VELOCITY, law_facts, law_walk
from bristle.exports.printing import wrapped
from bristle.exports.subject import COUNT
from bristle.exports.tree import Struct, Type
from bristle.exports.tunable import TOLERANCE, settled_law, tunable_law


class Leaf(NamedTuple):
    """A number that a law keeps: where it stands, what it is where the law begins, its type, and what it means."""

    path: tuple[str, ...]
    value: Any
    type: Type
    variable: Variable


FILES = {
    "{}.h": "c/law.h",
    "{}.c": "c/law.c",
    "{}_selftest.c": "c/law_selftest.c",
    "CMakeLists.txt": "c/CMakeLists.txt",
    "example_main.c": "c/law_main.c",
    "README.md": "c/law_README.md",
}


def law_files(law: Law, name: str, source: Source) -> dict[str, str]:
    """Return the files of a control law in C, text by name."""
    law = settled_law(law)
    walk, positions, efforts = law_walk(law, COUNT)
    walked = selftest_facts(walk, efforts, single=law.single) | {"positions": positions, "per_velocity": repr(PER_VELOCITY)}
    return written_files(FILES, name, _facts(law, name, source), walked, source)


def _facts(law: Law, name: str, source: Source) -> dict[str, Any]:
    variant, scalar, (lasting, p) = law.variant, "float" if law.single else "double", law.types
    printer = Printer(law.unit, scalar, [lasting, p])
    definitions, leaves = printer.definitions(), list(_leaves(law.lasting, lasting, ()))
    tuned = tunable_law(law) if law.tunable else None
    fields = [("_".join(leaf.path), leaf.type) for leaf in leaves]
    friction = variant.feedforward.friction
    law_name = f"{variant.controller.name} {friction and friction.name}"
    layout = f"{law_name} {law.dt!r} {fields} {law.memory_size}{' float' if law.single else ''}"
    remembered = array_text("remembered", law.memory, printer) + "\n" if np.any(law.memory) else ""
    start = [f"axis->state.{field} = {literal(leaf.value, leaf.type, scalar)};" for (field, _), leaf in zip(fields, leaves, strict=True)]
    return law_facts(law, name, source) | {
        "guard": name.upper(),
        "flags": FLAGS,
        "steps": COUNT,
        "result": "effort",
        "allowed": f"{TOLERANCE:g}",
        "several_places": True,
        "state": [
            f"{printer.named(kind, field)}; /* {meaning_of(leaf.variable, variant.controller.kind)} */"
            for (field, kind), leaf in zip(fields, leaves, strict=True)
        ],
        "memory": law.memory_size,
        "definitions": definitions,
        "helpers": helpers_text(printer.helpers, scalar, printer.integer),
        "data": remembered + parameters_text(law.p, p, printer, name, tuned),
        "remembered": "remembered[i]" if np.any(law.memory) else number(0.0, scalar),
        "parameters": declared(tuned, printer) if tuned else [],
        "scalar": scalar,
        "start": start + (started(tuned, printer) if tuned else []),
        "step": _step(law, printer, tunable=tuned is not None),
        "after": [
            f"axis->state.{field} = now.part_1.{'.'.join(printer.names.variable(part) for part in leaf.path)};"
            for (field, _), leaf in zip(fields, leaves, strict=True)
        ],
        **saved_facts(printer, ("effort",), fields, law.memory_size, layout),
    }


def _step(law: Law, printer: Printer, *, tunable: bool) -> list[str]:
    lasting, p = law.types
    several = {name: name.endswith("_ahead") for name in law.inputs}
    handed = {
        "lasting": "lasting",
        "memory": "axis->memory",
        "begun": "axis->begun != 0",
        "dt": number(law.dt, printer.scalar),
        "p": "p" if tunable else CONSTANT,
    } | {name: name if is_array else f"(float)inputs->{name}" for name, is_array in several.items() if law.single}
    needed = [argument.name for argument in law.entry.parameters]
    arguments = ", ".join(handed.get(name, f"inputs->{name}") for name in needed)
    assert isinstance(law.entry.result, Struct)
    lines = [f"const {printer.named(p, 'p')} = assembled(&axis->parameters);"] if tunable else []
    arrays = [name for name in needed if several.get(name)] if law.single else []
    if arrays:
        lines += [f"float {name}[{law.samples_ahead}];" for name in arrays]
        lines.append(f"for (int32_t i = 0; i < {law.samples_ahead}; ++i) {{")
        lines += [*(f"    {name}[i] = (float)inputs->{name}[i];" for name in arrays), "}"]
    if "lasting" in needed:
        lines.append(f"const {printer.named(lasting, 'lasting')} = {_gathered(lasting, ())};")
    lines.append(f"const {printer.named(law.entry.result, 'now')} = {law.entry.name}({arguments});")
    return [part for line in lines for part in wrapped(line, "")]


def _leaves(value: Any, kind: Struct, path: tuple[str, ...]) -> Iterator[Leaf]:
    """Give the numbers of a structure in turn."""
    hints = typing.get_type_hints(kind.cls, include_extras=True)
    for (name, part), field in zip(kind.fields, value, strict=True):
        if isinstance(part, Struct):
            yield from _leaves(field, part, (*path, name))
        else:
            marks = getattr(hints[name], "__metadata__", ())
            variable = next(mark for mark in marks if isinstance(mark, Variable))
            yield Leaf((*path, name), field, part, variable)


def _gathered(kind: Struct, path: tuple[str, ...]) -> str:
    parts = [
        _gathered(part, (*path, name)) if isinstance(part, Struct) else f"axis->state.{'_'.join((*path, name))}"
        for name, part in kind.fields
    ]
    return "{" + (", ".join(parts) or "0") + "}"
