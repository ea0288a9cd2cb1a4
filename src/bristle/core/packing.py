"""Parameters and states as flat vectors of numbers, and back.

Compiled entry points take flat vectors only: their signature does not depend on the model, so that a driver is
compiled once for all models, nothing of a user's classes is stored in the cache, and identification
and batches work on the same vectors.

A NamedTuple is laid out field by field: a scalar takes one number, a 1-D array its length and then its numbers,
a nested NamedTuple its own layout.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from bristle.core.kernel import kernel

__all__ = ["Structure", "pack", "packer", "structure_of", "unpacker"]

Structure = tuple[type, tuple[Any, ...]]


def structure_of(value: Any) -> Structure:
    """Return the type of a NamedTuple and, field by field, what it holds: all that its layout depends on."""
    parts = tuple(_part(one) for one in value)
    return type(value), parts


def _part(one: Any) -> Any:
    if hasattr(one, "_fields"):
        return structure_of(one)
    if isinstance(one, np.ndarray):
        return "array"
    return "integer" if isinstance(one, (int, np.integer)) and not isinstance(one, bool) else "number"


def pack(value: Any) -> np.ndarray:
    """Return a NamedTuple of scalars, 1-D arrays and nested NamedTuples as one flat vector.

    Examples
    --------
    >>> from typing import NamedTuple
    >>> class Two(NamedTuple):
    ...     a: float
    ...     k: np.ndarray
    >>> pack(Two(1.0, np.array([5.0, 6.0])))
    array([1., 2., 5., 6.])
    """
    numbers: list[float] = []
    _extend(value, numbers)
    return np.array(numbers, dtype=float)


def _extend(value: Any, numbers: list[float]) -> None:
    for one in value:
        if hasattr(one, "_fields"):
            _extend(one, numbers)
        elif isinstance(one, np.ndarray):
            numbers.append(float(one.size))
            numbers.extend(one.tolist())
        else:
            numbers.append(float(one))


@cache
def unpacker(structure: Structure) -> Callable[[Any], Any]:
    """Return the kernel ``unpack(vector) -> NamedTuple`` for this structure.

    It is generated as text, as NamedTuple itself is, because the compiler must see one plain expression for
    each field; arrays are views of the vector.
    """
    names: dict[str, Any] = {"np": np}
    lines: list[str] = []
    expression = _unpack_expression(structure, names, lines)
    return _define("unpack(vector)", [*lines, f"return {expression}"], names)


def _unpack_expression(structure: Structure, names: dict[str, Any], lines: list[str]) -> str:
    cls, parts = structure
    key = f"Class{len(names)}"
    names[key] = cls
    if not lines:
        lines.append("at = 0")
    arguments = []
    for part in parts:
        if isinstance(part, tuple):
            arguments.append(_unpack_expression(part, names, lines))
            continue
        name = f"field_{len(lines)}"
        if part == "array":
            lines += [f"size_{name} = int(vector[at])", f"{name} = vector[at + 1 : at + 1 + size_{name}]"]
            lines.append(f"at += 1 + size_{name}")
        else:
            cast = "int" if part == "integer" else "float"
            lines += [f"{name} = {cast}(vector[at])", "at += 1"]
        arguments.append(name)
    return f"{key}({', '.join(arguments)})"


@cache
def packer(structure: Structure) -> Callable[[Any, Any], None]:
    """Return the kernel ``store(value, vector)`` that writes a NamedTuple of scalars into a vector."""
    lines = [f"vector[{i}] = value[{i}]" for i, _ in enumerate(structure[1])]
    return _define("store(value, vector)", lines or ["return"], {})


def _define(head: str, lines: list[str], names: dict[str, Any]) -> Callable[..., Any]:
    text = f"def {head}:\n" + "".join(f"    {line}\n" for line in lines)
    scope: dict[str, Any] = {"__name__": __name__} | names
    exec(compile(text, f"<{head}>", "exec"), scope)
    function = scope[head.partition("(")[0]]
    function.source = text
    return kernel(function)
