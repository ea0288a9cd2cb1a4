"""The typed tree of kernels and its types: the common subset of all targets, from which they are printed."""

from __future__ import annotations

import typing
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, fields
from functools import cache
from operator import attrgetter
from typing import Any

import numpy as np

from bristle.core.errors import InputError


@dataclass(frozen=True)
class Scalar:
    """A number, a whole number, a truth, or the result of a function without a result."""

    name: str


REAL, INTEGER, TRUTH, VOID = Scalar("real"), Scalar("whole"), Scalar("truth"), Scalar("nothing")


@dataclass(frozen=True)
class Array:
    """An array of real numbers, read-only or writable by a kernel; size -1 if it is known only at run time."""

    size: int
    writable: bool = False


@dataclass(frozen=True)
class Struct:
    """A NamedTuple with its fields, or a plain tuple with the fields ``_0``, ``_1`` and so on."""

    cls: type
    fields: tuple[tuple[str, Type], ...]

    @property
    def is_plain(self) -> bool:
        """Whether it is a plain tuple."""
        return self.cls is tuple

    def place(self, name: str) -> int:
        """Return the index of a field; -1 if there is no field of this name."""
        return next((place for place, field in enumerate(self.fields) if field[0] == name), -1)


Type = Scalar | Array | Struct


def tuple_of(parts: typing.Sequence[Type]) -> Struct:
    """Return the type of a plain tuple."""
    return Struct(tuple, tuple((f"_{place}", part) for place, part in enumerate(parts)))


def struct_of(cls: type, parts: typing.Sequence[Type]) -> Struct:
    """Return the type of a NamedTuple of values of these types; a field with the annotation of a number becomes a number."""
    declared = _annotations(cls)
    fields: typing.Any = cls
    return Struct(
        cls,
        tuple(
            (name, declared.get(name) or part)
            for name, part in zip(fields._fields, parts, strict=True)
        ),
    )


def type_of(value: Any, *, writable: bool = False) -> Type:
    """Return the type of a value of a component: a number, an array, or a NamedTuple of these."""
    if hasattr(value, "_fields"):
        return struct_type(value)
    if isinstance(value, np.ndarray) and value.ndim == 1:
        return Array(value.size, writable)
    if isinstance(value, (bool, np.bool_)):
        return TRUTH
    if isinstance(value, (int, np.integer)):
        return INTEGER
    if isinstance(value, (float, np.floating)):
        return REAL
    raise InputError(
        "cannot be exported",
        path="model",
        value=type(value).__name__,
        allowed="numbers, 1-D arrays of numbers and NamedTuples of these",
    )


def struct_type(value: Any) -> Struct:
    """Return the type of a NamedTuple."""
    return struct_of(type(value), [type_of(field) for field in value])


@cache
def _annotations(cls: type) -> dict[str, Scalar]:
    """Return the fields of a NamedTuple that are numbers by their annotations."""
    try:
        hints = typing.get_type_hints(cls)
    except Exception:  # noqa: BLE001  (a user's annotations may raise anything)
        hints = {}
    kinds = {float: REAL, int: INTEGER, bool: TRUTH}
    return {
        name: kinds[hint]
        for name, hint in hints.items()
        if isinstance(hint, type) and hint in kinds
    }


@dataclass
class Node:
    """A part of the tree."""


@dataclass
class Expression(Node):
    """A node with a value and a type."""

    type: Type


@dataclass
class Constant(Expression):
    """A number or a truth."""

    value: float | int | bool


@dataclass
class Variable(Expression):
    """A variable or an argument of the function."""

    name: str


@dataclass
class Field(Expression):
    """A field of a tuple."""

    of: Expression
    name: str


@dataclass
class Index(Expression):
    """A number in an array."""

    array: Expression
    at: Expression


@dataclass
class Negative(Expression):
    """Minus a number."""

    of: Expression


@dataclass
class Not(Expression):
    """The negation of a truth."""

    of: Expression


@dataclass
class Binary(Expression):
    """``+ - * /`` of reals; ``+ - * // % & ^ >>`` of whole numbers. Both sides have the type of the result."""

    operator: str
    left: Expression
    right: Expression


@dataclass
class Compare(Expression):
    """A comparison of two numbers of one type."""

    operator: str
    left: Expression
    right: Expression


@dataclass
class Logic(Expression):
    """``and`` or ``or``; evaluation stops once the result is known."""

    operator: str
    parts: list[Expression]


@dataclass
class Select(Expression):
    """One of two values of the same type; the other value is not computed."""

    test: Expression
    first: Expression
    second: Expression


@dataclass
class Convert(Expression):
    """A number or a truth, converted to another type; a real number is truncated to a whole number."""

    of: Expression


@dataclass
class Call(Expression):
    """A call of another function of the unit."""

    function: Function
    arguments: list[Expression]


@dataclass
class Intrinsic(Expression):
    """An operation that every target computes exactly: ``sqrt copysign abs floor isinf isnan min max``, and parts of a real."""

    name: str
    arguments: list[Expression]


@dataclass
class Make(Expression):
    """A new tuple with values for its fields."""

    parts: list[Expression]


@dataclass
class Statement(Node):
    """A statement of a function."""


@dataclass
class Assign(Statement):
    """An assignment to a variable."""

    variable: Variable
    value: Expression


@dataclass
class Store(Statement):
    """An assignment to an element of an array."""

    array: Expression
    at: Expression
    value: Expression


@dataclass
class Evaluate(Statement):
    """A call for its side effect."""

    call: Expression


@dataclass
class If(Statement):
    """One of two blocks."""

    test: Expression
    body: list[Statement]
    otherwise: list[Statement]


@dataclass
class For(Statement):
    """A block for each whole number of a range."""

    variable: Variable
    start: Expression
    stop: Expression
    body: list[Statement]


@dataclass
class While(Statement):
    """A block, repeated while a condition is true."""

    test: Expression
    body: list[Statement]


@dataclass
class Return(Statement):
    """The end of the function."""

    value: Expression | None


@dataclass
class Break(Statement):
    """The end of a loop."""


@dataclass
class Continue(Statement):
    """The end of a round of a loop."""


@dataclass(eq=False)
class Function:
    """A kernel for arguments of certain types."""

    name: str
    source: Callable[..., Any]
    parameters: list[Variable]
    result: Type
    body: list[Statement]
    description: str = ""
    writes: bool = False


@dataclass
class Unit:
    """Functions, each after its callees."""

    functions: list[Function] = field(default_factory=list)


def walk(*nodes: Any) -> Iterator[Node]:
    """Yield every part of some nodes of a tree, without entering called functions."""
    waiting = list(reversed(nodes))
    while waiting:
        node = waiting.pop()
        if type(node) is list:
            waiting += reversed(node)
        elif isinstance(node, Node):
            yield node
            waiting += _parts(type(node))(node)


@cache
def _parts(kind: type[Node]) -> Callable[[Node], tuple[Any, ...]]:
    """Return a getter of the fields of a node type that can contain nodes, the last field first."""
    plain = {"type", "name", "operator"} | (
        {"function", "value"} if issubclass(kind, (Constant, Call)) else set()
    )
    names = [part.name for part in reversed(fields(kind)) if part.name not in plain]
    if len(names) > 1:
        return attrgetter(*names)
    return lambda node: tuple(getattr(node, name) for name in names)


def blocks_of(statement: Statement) -> list[list[Statement]]:
    """Return the blocks inside a statement."""
    if isinstance(statement, If):
        return [statement.body, statement.otherwise]
    return [statement.body] if isinstance(statement, (For, While)) else []
