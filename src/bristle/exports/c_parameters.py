"""Parameters in C: constants of the source, or fields that may be changed and what kernels receive of them."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from bristle.exports.c_code import Printer, number, wrapped
from bristle.exports.described import plain, told
from bristle.exports.tunable import Tunable, bounds_of
from bristle.exports.types import REAL, Array, Struct, Type

__all__ = ["CONSTANT", "array_text", "assembled", "declared", "initial_value", "literal", "parameters_text", "started"]

CONSTANT = "parameters"
"""What the constant is called that kernels receive where no parameter may be changed."""


def parameters_text(p: Any, kind: Struct, printer: Printer, name: str, tuned: Tunable | None) -> str:
    """Return what kernels receive: a constant; or, where parameters may be changed, the function that makes it."""
    if tuned is not None:
        structure = f"{name}_parameters"
        return f"{assembled(tuned, printer, kind, structure)}\n{within_ranges(tuned, printer, structure)}"
    arrays: list[str] = []
    text = initial_value(p, kind, printer, arrays)
    declared_text = f"{printer.constant} {printer.named(kind, CONSTANT)} = {text};"
    return "\n".join([*arrays, *wrapped(declared_text, ""), ""])


# --- constants --------------------------------------------------------------------------------------------------------


def initial_value(value: Any, kind: Struct, printer: Printer, arrays: list[str], path: str = "") -> str:
    """Return the initial value of a structure; arrays of it become constants of their own."""
    parts: list[str] = []
    for (name, part), field in zip(kind.fields, value, strict=True):
        if isinstance(part, Struct):
            parts.append(initial_value(field, part, printer, arrays, f"{path}{name}_"))
        elif isinstance(part, Array):
            parts.append(f"fixed_{path}{name}")
            arrays.append(array_text(parts[-1], field, printer))
        else:
            parts.append(literal(field, part, printer.scalar))
    return "{" + (", ".join(parts) or "0") + "}"


def array_text(name: str, values: np.ndarray, printer: Printer) -> str:
    """Return the constant that an array becomes."""
    numbers = [number(float(value), printer.scalar) for value in values]
    lines = [", ".join(numbers[at : at + 6]) for at in range(0, len(numbers), 6)]
    size = max(len(numbers), 1)
    return f"{printer.constant} {printer.scalar} {name}[{size}] = {{\n    " + ",\n    ".join(lines or ["0"]) + "\n};"


def literal(value: Any, kind: Type, scalar: str) -> str:
    """Return a number of this type as C reads it."""
    return number(float(value), scalar) if kind == REAL else str(int(value))


# --- fields that may be changed ---------------------------------------------------------------------------------------


def declared(tuned: Tunable, printer: Printer) -> list[str]:
    """Return the fields of the structure of the parameters."""
    lines = []
    for name, value in tuned.values.items():
        variable = tuned.variables[name]
        size = f"[{value.size}]" if isinstance(value, np.ndarray) else ""
        allowed = plain(variable.allowed(tuned.kind))
        field = f"{printer.scalar} {printer.names.variable(name)}{size}"
        lines.append(f"{field}; /* {told(variable, tuned.kind)}{f', {allowed}' if allowed else ''} */")
    return lines


def started(tuned: Tunable, printer: Printer) -> list[str]:
    """Return the lines that set the values that were exported."""
    return [f"axis->parameters.{_at(name, place, printer)} = {number(value, printer.scalar)};" for name, place, value in tuned.numbers()]


def _at(name: str, place: int | None, printer: Printer) -> str:
    return printer.names.variable(name) + ("" if place is None else f"[{place}]")


class _Assembly(NamedTuple):
    tuned: Tunable
    printer: Printer
    arrays: list[str]

    def structure(self, kind: Struct, path: tuple[str, ...]) -> str:
        parts = []
        for name, part in kind.fields:
            inner = (*path, name)
            if isinstance(part, Struct):
                parts.append(self.structure(part, inner))
            elif inner in self.tuned.places:
                parts.append(f"given->{self.printer.names.variable(self.tuned.places[inner])}")
            elif isinstance(part, Array):
                constant = f"fixed_{'_'.join(inner)}"
                self.arrays.append(array_text(constant, self.tuned.fixed[inner], self.printer))
                parts.append(constant)
            else:
                parts.append(literal(self.tuned.fixed[inner], part, self.printer.scalar))
        return self.printer.structure_text(kind, ", ".join(parts) or "0")


def within_ranges(tuned: Tunable, printer: Printer, structure: str) -> str:
    """Return the function that tells whether each parameter of a structure is in its range."""
    largest = {"double": "DBL_MAX", "float": "FLT_MAX"}[printer.scalar]
    tests = []
    for name, place, compared in bounds_of(tuned):
        field = f"given->{_at(name, place, printer)}"
        for operator, bound in compared:
            text = number(bound, printer.scalar) if math.isfinite(bound) else f"{'-' * (bound < 0.0)}{largest}"
            tests.append(f"{field} {operator} {text}")
    head = f"{printer.inline} bool within_ranges(const {structure} *given)"
    return "\n".join([head, "{", *wrapped(f"    return {' && '.join(tests) or 'true'};", "    "), "}", ""])


def assembled(tuned: Tunable, printer: Printer, kind: Struct, given: str, called: str = "assembled") -> str:
    """Return the function that makes what kernels receive of the structure `given`."""
    arrays: list[str] = []
    returned = f"    return {_Assembly(tuned, printer, arrays).structure(kind, ())};"
    head = f"{printer.inline} {printer.named(kind, called)}(const {given} *given)"
    return "\n".join([*arrays, head, "{", *wrapped(returned, "    "), "}", ""])
