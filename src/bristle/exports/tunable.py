"""Parameters that may be changed at run time: a structure of what a person sets, and what kernels receive from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.exports.c_code import Printer, number
from bristle.exports.described import plain, told
from bristle.exports.types import REAL, Struct

__all__ = ["Tunable", "tunable_of"]

MARK = 1024.0  # numbers that stand for parameters, to be leaves again in what kernels receive


@dataclass(frozen=True)
class Tunable:
    """Which parameters may be changed, with their values, and where each of them goes.

    Parameters
    ----------
    values : dict
        A number or an array for each parameter.
    places : dict
        For a path inside what kernels receive, the parameter that stands there.
    fixed : dict
        What stands at the other paths.
    """

    values: dict[str, Any]
    places: dict[tuple[str, ...], str]
    fixed: dict[tuple[str, ...], Any]

    def declared(self, scalar: str, model: Model) -> list[str]:
        """Return the fields of the structure."""
        lines = []
        for name, value in self.values.items():
            variable = model.component.variables[name]
            size = f"[{value.size}]" if isinstance(value, np.ndarray) else ""
            allowed = plain(variable.allowed(model.kind))
            lines.append(
                f"{scalar} {name}{size}; /* {told(variable, model.kind)}{f', {allowed}' if allowed else ''} */"
            )
        return lines

    def started(self, scalar: str) -> list[str]:
        """Return the lines that set the values that were exported."""
        lines = []
        for name, value in self.values.items():
            if isinstance(value, np.ndarray):
                lines += [f"axis->parameters.{name}[{i}] = {number(v, scalar)};" for i, v in enumerate(value.tolist())]
            else:
                lines.append(f"axis->parameters.{name} = {number(value, scalar)};")
        return lines

    def assembled(self, printer: Printer, kind: Struct, name: str, called: str = "assembled") -> str:
        """Return the function that makes what kernels receive."""
        text = self._structure(printer, kind, ())
        head = f"{printer.inline} {printer.named(kind, called)}(const {name}_parameters *given)"
        return "\n".join([head, "{", f"    return {text};", "}", ""])

    def _structure(self, printer: Printer, kind: Struct, path: tuple[str, ...]) -> str:
        parts = []
        for name, part in kind.fields:
            inner = (*path, name)
            if isinstance(part, Struct):
                parts.append(self._structure(printer, part, inner))
            elif inner in self.places:
                parts.append(f"given->{self.places[inner]}")
            else:
                fixed = self.fixed[inner]
                parts.append(number(float(fixed), printer.scalar) if part == REAL else str(int(fixed)))
        return printer.structure_text(kind, ", ".join(parts) or "0")


def tunable_of(model: Model) -> Tunable:
    """Return the parameters of a model that may be changed: its real numbers; whole numbers and choices are fixed.

    Raises
    ------
    InputError
        If a model makes something else of its parameters before its kernels see them.
    """
    component = model.component
    values = {
        name: value for name, value in model.values.items()
        if not component.is_integer(name) and not component.variables[name].choices
    }  # fmt: skip
    marked: dict[str, Any] = {}
    names: dict[Any, str] = {}
    count = MARK
    for name, value in values.items():
        size = value.size if isinstance(value, np.ndarray) else 1
        numbers = count + np.arange(size, dtype=float)
        count += size
        marked[name] = numbers if isinstance(value, np.ndarray) else float(numbers[0])
        names[_key(marked[name])] = name
    leaves = dict(_leaves(component.assemble(dict(model.values) | marked), ()))
    places = {path: names[_key(value)] for path, value in leaves.items() if _key(value) in names}
    if set(places.values()) != set(values):
        lost = ", ".join(sorted(set(values) - set(places.values())))
        raise InputError("makes something else of a parameter, so that it cannot be changed at run time",
                         path=model.name, value=lost, mend="Leave --tunable out")  # fmt: skip
    fixed = {path: value for path, value in _leaves(model.parameters, ()) if path not in places}
    if any(isinstance(value, np.ndarray) for value in fixed.values()):
        raise InputError("keeps an array that is no parameter", path=model.name, mend="Leave --tunable out")
    return Tunable({name: v if isinstance(v, np.ndarray) else float(v) for name, v in values.items()}, places, fixed)


def _key(value: Any) -> Any:
    return value.tobytes() if isinstance(value, np.ndarray) else value


def _leaves(value: Any, path: tuple[str, ...]) -> list[tuple[tuple[str, ...], Any]]:
    leaves: list[tuple[tuple[str, ...], Any]] = []
    for name, part in zip(value._fields, value, strict=True):
        leaves += _leaves(part, (*path, name)) if hasattr(part, "_fields") else [((*path, name), part)]
    return leaves
