"""C99 of a control law: a header, a source that compiles alone, a self-test, an example and what builds them.

The functions are those of the tree. What is between them and the caller, what lasts, the inputs and those that are no
numbers, is written here.
"""

from functools import reduce
from typing import get_type_hints

import numpy as np

from bristle.core.variable import Variable
from bristle.exports.c import block_facts, selftest_facts, written_files
from bristle.exports.c_code import Printer, number
from bristle.exports.c_parts import CONSTANT, array_text, parameters_text, saved_facts
from bristle.exports.described import Source, meaning_of
from bristle.exports.law import Law
from bristle.exports.law_described import PER_VELOCITY, law_facts, law_walk
from bristle.exports.printing import wrapped
from bristle.exports.subject import COUNT
from bristle.exports.tree import Struct
from bristle.exports.tunable import settled_law, tunable_law

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
    variant, (lasting, p), tuned = law.variant, law.types, tunable_law(law) if law.tunable else None
    printer = Printer(law.unit, "float" if law.single else "double", [lasting, p])
    fields, after = [], []
    for path, kind in law.leaves:
        hints = get_type_hints(type(reduce(getattr, path[:-1], law.lasting)), include_extras=True)
        variable = next(mark for mark in hints[path[-1]].__metadata__ if isinstance(mark, Variable))
        fields.append(("_".join(path), kind, meaning_of(variable, variant.controller.kind), reduce(getattr, path, law.lasting)))
        after.append(f"axis->state.{fields[-1][0]} = now.part_1.{'.'.join(printer.names.variable(part) for part in path)};")
    friction = variant.feedforward.friction
    law_name = f"{variant.controller.name} {friction and friction.name}"
    layout = f"{law_name} {law.dt!r} {[field[:2] for field in fields]} {law.memory_size}{' float' if law.single else ''}"
    remembered = array_text("remembered", law.memory, printer) + "\n" if np.any(law.memory) else ""
    facts = (
        law_facts(law, name, source)
        | block_facts(printer, name, fields, law.memory_size, tuned)
        | saved_facts(printer, ("effort",), fields, law.memory_size, layout)
        | {"data": remembered + parameters_text(law.p, p, printer, name, tuned), "step": _step(law, printer), "after": after}
        | {"remembered": "remembered[i]" if remembered else number(0.0, printer.scalar), "steps": COUNT}
    )
    return written_files(FILES, name, facts, walked, source)


def _step(law: Law, printer: Printer) -> list[str]:
    lasting, p = law.types
    needed = [argument.name for argument in law.entry.parameters]
    arrays = [name for name in needed if name.endswith("_ahead")] if law.single else []
    handed = {name: name if name in arrays else f"{'(float)' * law.single}inputs->{name}" for name in law.inputs} | {
        "lasting": "lasting",
        "memory": "axis->memory",
        "begun": "axis->begun != 0",
        "dt": number(law.dt, printer.scalar),
        "p": "p" if law.tunable else CONSTANT,
    }
    assert isinstance(law.entry.result, Struct)
    lines = [f"const {printer.named(p, 'p')} = assembled(&axis->parameters);"] if law.tunable else []
    if arrays:
        lines += [f"float {name}[{law.samples_ahead}];" for name in arrays]
        lines.append(f"for (int32_t i = 0; i < {law.samples_ahead}; ++i) {{")
        lines += [*(f"    {name}[i] = (float)inputs->{name}[i];" for name in arrays), "}"]
    if "lasting" in needed:
        lines.append(f"const {printer.named(lasting, 'lasting')} = {_gathered(lasting, ())};")
    call = f"{law.entry.name}({', '.join(handed[name] for name in needed)})"
    lines.append(f"const {printer.named(law.entry.result, 'now')} = {call};")
    return [part for line in lines for part in wrapped(line, "")]


def _gathered(kind: Struct, path: tuple[str, ...]) -> str:
    parts = [
        _gathered(part, (*path, name)) if isinstance(part, Struct) else f"axis->state.{'_'.join((*path, name))}"
        for name, part in kind.fields
    ]
    return "{" + (", ".join(parts) or "0") + "}"
