"""Parameters of a block that may be changed at run time: inputs that have a value where nobody gives another."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from bristle.exports.described import plain, told
from bristle.exports.st_code import Printer
from bristle.exports.st_names import LREAL, REAL, Names
from bristle.exports.st_parts import Variable
from bristle.exports.tunable import Tunable, bounds_of
from bristle.exports.types import Array, Struct

__all__ = ["Tuned"]

Key = tuple[str, int | None]


@dataclass(frozen=True)
class Tuned:
    """The inputs of a block that are its parameters; each number of an array is an input of its own."""

    tunable: Tunable
    names: dict[Key, str]

    @classmethod
    def of(cls, tunable: Tunable, names: Names) -> Tuned:
        """Return the inputs, whose names nothing else of the block has."""
        return cls(
            tunable,
            {
                (name, place): names.of(("parameter", name, place), name if place is None else f"{name}_{place + 1}")
                for name, place, _ in tunable.numbers()
            },
        )

    def inputs(self, printer: Printer) -> list[Variable]:
        """Return the declarations."""
        declared = []
        for name, place, value in self.tunable.numbers():
            variable, kind = self.tunable.variables[name], self.tunable.kind
            allowed = plain(variable.allowed(kind))
            meaning = told(variable, kind) + (f", {allowed}" if allowed else "")
            declared.append(Variable(self.names[name, place], printer.scalar, meaning, "VAR_INPUT", printer.real(value)))
        return declared

    def ranges(self, printer: Printer) -> Iterator[str]:
        """Give a condition for each number: that it is in its range."""
        farthest = {LREAL: 1e30, REAL: 1e15}[printer.scalar]
        for name, place, compared in bounds_of(self.tunable):
            tests = [
                f"({self.names[name, place]} {operator} {printer.real(min(max(bound, -farthest), farthest))})"
                for operator, bound in compared
            ]
            yield " AND ".join(tests)

    def lines(self, place: str, kind: Struct, printer: Printer, path: tuple[str, ...] = ()) -> Iterator[str]:
        """Give the lines that hand the inputs on to where kernels look for them."""
        for name, part in kind.fields:
            at, inner = f"{place}.{printer.field(kind, name)}", (*path, name)
            if isinstance(part, Struct):
                yield from self.lines(at, part, printer, inner)
            elif inner in self.tunable.places:
                parameter = self.tunable.places[inner]
                numbers = range(part.size) if isinstance(part, Array) else (None,)
                yield from (f"{at}{'' if i is None else f'[{i}]'} := {self.names[parameter, i]};" for i in numbers)
