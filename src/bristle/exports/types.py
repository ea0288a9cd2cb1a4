"""Types of the tree: numbers, truths, arrays of a fixed length, and tuples of these, with names or without."""

from __future__ import annotations

import typing
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from bristle.core.errors import InputError

__all__ = ["INTEGER", "REAL", "TRUTH", "VOID", "Array", "Scalar", "Struct", "Type", "struct_of", "tuple_of", "type_of"]


@dataclass(frozen=True)
class Scalar:
    """A number, a whole number or a truth; or nothing, which a function returns that returns nothing."""

    name: str


REAL, INTEGER, TRUTH, VOID = Scalar("real"), Scalar("whole"), Scalar("truth"), Scalar("nothing")


@dataclass(frozen=True)
class Array:
    """So many real numbers, which a kernel may write or only read."""

    size: int
    writable: bool = False


@dataclass(frozen=True)
class Struct:
    """A NamedTuple with its fields, or a plain tuple, whose fields are called ``_0``, ``_1`` and so on."""

    cls: type
    fields: tuple[tuple[str, Type], ...]

    @property
    def is_plain(self) -> bool:
        """Whether it is a plain tuple."""
        return self.cls is tuple

    def place(self, name: str) -> int:
        """Return the place of a field; -1 where there is none of this name."""
        return next((place for place, field in enumerate(self.fields) if field[0] == name), -1)


Type = Scalar | Array | Struct


def tuple_of(parts: typing.Sequence[Type]) -> Struct:
    """Return the type of a plain tuple."""
    return Struct(tuple, tuple((f"_{place}", part) for place, part in enumerate(parts)))


def struct_of(cls: type, parts: typing.Sequence[Type]) -> Struct:
    """Return the type of a NamedTuple made of values of these types.

    A field that is annotated as a number is one, whatever is put there; what another field is, its value says.
    """
    declared = _annotations(cls)
    fields: typing.Any = cls
    return Struct(cls, tuple((name, declared.get(name) or part) for name, part in zip(fields._fields, parts, strict=True)))


def type_of(value: Any, *, writable: bool = False) -> Type:
    """Return the type of a value that a component has: a number, an array, a NamedTuple of such."""
    if hasattr(value, "_fields"):
        return struct_of(type(value), [type_of(field) for field in value])
    if isinstance(value, np.ndarray) and value.ndim == 1:
        return Array(value.size, writable)
    if isinstance(value, (bool, np.bool_)):
        return TRUTH
    if isinstance(value, (int, np.integer)):
        return INTEGER
    if isinstance(value, (float, np.floating)):
        return REAL
    raise InputError(
        "cannot be exported", path="model", value=type(value).__name__, allowed="numbers, 1-D arrays of numbers and NamedTuples of them"
    )


@cache
def _annotations(cls: type) -> dict[str, Scalar]:
    """Return which fields of a NamedTuple are numbers by their annotations."""
    try:
        hints = typing.get_type_hints(cls)
    except Exception:  # noqa: BLE001  (annotations of a user's own may hold anything)
        hints = {}
    kinds = {float: REAL, int: INTEGER, bool: TRUTH}
    return {name: kinds[hint] for name, hint in hints.items() if isinstance(hint, type) and hint in kinds}
