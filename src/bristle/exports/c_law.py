"""C99 of a control law: a header, a source that compiles alone, a self-test, an example and what builds them.

The functions are those of the tree. What is between them and the caller, what lasts, the inputs and those that are no
numbers, is written here.
"""

from __future__ import annotations

import typing
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from bristle.core.variable import Variable
from bristle.exports.c import FLAGS
from bristle.exports.c_code import Printer, number, wrapped
from bristle.exports.c_helpers import helpers_text
from bristle.exports.c_parameters import CONSTANT, array_text, declared, literal, parameters_text, started
from bristle.exports.c_saved import saved_facts
from bristle.exports.described import Source, told
from bristle.exports.identity import with_rights
from bristle.exports.law import Law
from bristle.exports.law_described import PER_VELOCITY, law_facts, law_walk
from bristle.exports.rendering import rendered
from bristle.exports.single import TOLERANCE, checkpoints
from bristle.exports.tunable import Tunable, settled_law, tunable_law
from bristle.exports.types import Struct, Type
from bristle.exports.walk import COUNT, FACTOR, PART, RESTS, SEED, TERM, hash_of

__all__ = ["law_files"]


class Leaf(NamedTuple):
    """A number that a law keeps: its name, what it is where the law begins, its type, and what it means."""

    name: str
    value: Any
    type: Type
    variable: Variable


@dataclass(frozen=True)
class LawFiles:
    """How a control law is written in C."""

    law: Law
    name: str
    source: Source
    steps: int = COUNT

    def files(self) -> dict[str, str]:
        """Return the text of each file by its name."""
        facts = self._facts()
        files = {
            f"{self.name}.h": rendered("c/law.h", facts),
            f"{self.name}.c": rendered("c/law.c", facts),
            f"{self.name}_selftest.c": rendered("c/law_selftest.c", facts | self._walked()),
            "CMakeLists.txt": rendered("c/CMakeLists.txt", facts),
            "example_main.c": rendered("c/law_main.c", facts),
            "README.md": rendered("c/law_README.md", facts),
        }
        return with_rights(files, self.source)

    @property
    def _scalar(self) -> str:
        return "float" if self.law.single else "double"

    def _facts(self) -> dict[str, Any]:
        law, scalar = self.law, self._scalar
        lasting, p = law.types
        printer = Printer(law.unit, scalar, [lasting, p])
        definitions = printer.definitions()
        tuned = tunable_law(law) if law.tunable else None
        return law_facts(law, self.name, self.source) | {
            "guard": self.name.upper(),
            "flags": FLAGS,
            "steps": self.steps,
            "result": "effort",
            "allowed": f"{TOLERANCE:g}",
            "several_places": True,
            "state": self._state_lines(printer),
            "memory": law.memory_size,
            "definitions": definitions,
            "helpers": helpers_text(printer.helpers, scalar, printer.integer),
            "data": self._data(printer, p, tuned),
            "remembered": "remembered[i]" if np.any(law.memory) else number(0.0, scalar),
            "parameters": declared(tuned, printer) if tuned else [],
            "scalar": scalar,
            "start": self._start(printer, tuned),
            "step": self._step(printer, lasting, p, tuned),
            "after": self._after(printer),
            **self._saved(printer),
        }

    # --- what the structure of the axis holds ---------------------------------------------------------------------

    def _state_lines(self, printer: Printer) -> list[str]:
        kind = self.law.variant.controller.kind
        return [f"{printer.named(leaf.type, leaf.name)}; /* {told(leaf.variable, kind)} */" for leaf in self._leaves()]

    def _leaves(self) -> list[Leaf]:
        return list(_leaves(self.law.lasting, self.law.types[0], ()))

    def _saved(self, printer: Printer) -> dict[str, Any]:
        law, friction = self.law, self.law.variant.feedforward.friction
        fields = [(leaf.name, leaf.type) for leaf in self._leaves()]
        law_name = f"{law.variant.controller.name} {friction and friction.name}"
        layout = f"{law_name} {law.dt!r} {fields} {law.memory_size}{' float' if law.single else ''}"
        return saved_facts(printer, ("effort",), fields, law.memory_size, layout)

    def _start(self, printer: Printer, tuned: Tunable | None) -> list[str]:
        leaves = self._leaves()
        lines = [f"axis->state.{leaf.name} = {literal(leaf.value, leaf.type, printer.scalar)};" for leaf in leaves]
        return lines + (started(tuned, printer) if tuned else [])

    def _step(self, printer: Printer, lasting: Struct, p: Struct, tuned: Tunable | None) -> list[str]:
        single = self.law.single
        handed = {
            "lasting": "lasting",
            "memory": "axis->memory",
            "begun": "axis->begun != 0",
            "dt": number(self.law.dt, self._scalar),
            "p": "p" if tuned else CONSTANT,
        } | {name: name if is_array else f"(float)inputs->{name}" for name, is_array in self._inputs().items() if single}
        needed = [argument.name for argument in self.law.entry.parameters]
        arguments = ", ".join(handed.get(name, f"inputs->{name}") for name in needed)
        assert isinstance(self.law.entry.result, Struct)
        lines = [f"const {printer.named(p, 'p')} = assembled(&axis->parameters);"] if tuned else []
        lines += self._narrowed(needed) if single else []
        if "lasting" in needed:
            lines.append(f"const {printer.named(lasting, 'lasting')} = {_gathered(lasting, ())};")
        lines.append(f"const {printer.named(self.law.entry.result, 'now')} = {self.law.entry.name}({arguments});")
        return [part for line in lines for part in wrapped(line, "")]

    def _inputs(self) -> dict[str, bool]:
        """Return the inputs, and which of them are several numbers."""
        return {name: name.endswith("_ahead") for name in self.law.inputs}

    def _narrowed(self, needed: Sequence[str]) -> list[str]:
        """Return the lines that make single precision of the inputs that are several numbers."""
        count, arrays = self.law.samples_ahead, [name for name in needed if self._inputs().get(name)]
        copies = [f"    {name}[i] = (float)inputs->{name}[i];" for name in arrays]
        loop = [f"for (int32_t i = 0; i < {count}; ++i) {{", *copies, "}"] if arrays else []
        return [*(f"float {name}[{count}];" for name in arrays), *loop]

    def _after(self, printer: Printer) -> list[str]:
        return [
            f"axis->state.{'_'.join(path)} = now.part_1.{'.'.join(printer.names.variable(name) for name in path)};"
            for path in _paths(self.law.types[0], ())
        ]

    def _data(self, printer: Printer, p: Struct, tuned: Tunable | None) -> str:
        memory = self.law.memory
        remembered = array_text("remembered", memory, printer) + "\n" if np.any(memory) else ""
        return remembered + parameters_text(self.law.p, p, printer, self.name, tuned)

    # --- the self-test --------------------------------------------------------------------------------------------

    def _walked(self) -> dict[str, Any]:
        walk, positions, efforts = law_walk(self.law, self.steps)
        digest = hash_of(efforts)
        return {
            "count": self.steps,
            "positions": positions,
            "scales": [repr(scale) for scale in walk.scales],
            "seed": SEED,
            "factor": FACTOR,
            "term": TERM,
            "rests": RESTS,
            "part": PART,
            "hash": f"0x{digest:016X}",
            "hash_text": f"{digest:016x}",
            "last": repr(float(efforts[-1])),
            "per_velocity": repr(PER_VELOCITY),
            **checkpoints(efforts, single=self.law.single),
        }


def law_files(law: Law, name: str, source: Source) -> dict[str, str]:
    """Return the files of a control law in C, text by name."""
    return LawFiles(settled_law(law), name, source).files()


def _leaves(value: Any, kind: Struct, path: tuple[str, ...]) -> Iterator[Leaf]:
    """Give the numbers of a structure in turn."""
    hints = typing.get_type_hints(kind.cls, include_extras=True)
    for (name, part), field in zip(kind.fields, value, strict=True):
        if isinstance(part, Struct):
            yield from _leaves(field, part, (*path, name))
        else:
            marks = getattr(hints[name], "__metadata__", ())
            variable = next(mark for mark in marks if isinstance(mark, Variable))
            yield Leaf("_".join((*path, name)), field, part, variable)


def _paths(kind: Struct, path: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    for name, part in kind.fields:
        if isinstance(part, Struct):
            yield from _paths(part, (*path, name))
        else:
            yield (*path, name)


def _gathered(kind: Struct, path: tuple[str, ...]) -> str:
    parts = [
        _gathered(part, (*path, name)) if isinstance(part, Struct) else f"axis->state.{'_'.join((*path, name))}"
        for name, part in kind.fields
    ]
    return "{" + (", ".join(parts) or "0") + "}"
