"""Expressions of kernels, with their types."""

import ast
import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

from bristle.core.dispatch import is_dispatch
from bristle.core.exponent import exponent, mantissa, power_of_two
from bristle.core.packing import unowned
from bristle.engine.translation import tree
from bristle.engine.translation.scope import (
    NotExportableError,
    global_value,
    is_kernel,
    is_named_tuple,
)
from bristle.engine.translation.tree import (
    INTEGER,
    REAL,
    TRUTH,
    Array,
    Scalar,
    Struct,
    Type,
    struct_of,
    tuple_of,
)

OF_REALS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
OF_WHOLES = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.FloorDiv: "//",
    ast.Mod: "%",
    ast.BitAnd: "&",
    ast.BitXor: "^",
    ast.RShift: ">>",
}
COMPUTED: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "//": operator.floordiv,
    "%": operator.mod,
    "&": operator.and_,
    "^": operator.xor,
    ">>": operator.rshift,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}
COMPARED = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
# Functions of the module math that every target computes exactly, with the types of their results.
OF_MATH = {
    "copysign": REAL,
    "fabs": REAL,
    "isinf": TRUTH,
    "isnan": TRUTH,
    "floor": INTEGER,
    "sqrt": REAL,
}
CALLED = {"fabs": "abs"}
# Kernels that the compiler replaces by another form have that form on every target.
IN_BITS = {power_of_two: "power_of_two", mantissa: "mantissa", exponent: "exponent"}
NUMBERS = (REAL, INTEGER, TRUTH)


class Expressions:
    """Translates expressions of one kernel; `types` are those of its variables as far as they are parts_unified."""

    def __init__(
        self,
        constants: Mapping[tuple[str, float], float],
        function: Callable[..., tree.Function],
        kernel: Callable[..., Any],
    ) -> None:
        self.constants = constants
        self.function_of = function
        self.kernel = kernel
        self.types: dict[str, Type] = {}

    def refuse(self, node: ast.AST | None, reason: str) -> NotExportableError:
        """Return the error with the reason why the kernel cannot be translated."""
        return NotExportableError(self.kernel, node, reason)

    def value(self, node: ast.expr) -> tree.Expression:
        """Return an expression with its type."""
        translate = getattr(self, f"_{type(node).__name__.lower()}", None)
        if translate is None:
            raise self.refuse(
                node, f"{type(node).__name__} is outside the exportable subset of Python"
            )
        return translate(node)

    def truth(self, node: ast.expr) -> tree.Expression:
        """Return an expression as a truth for ``if``: whether it is not zero."""
        return self._as_truth(self.value(node), node)

    def coerced(
        self, value: tree.Expression, target: Type, node: ast.AST | None
    ) -> tree.Expression:
        """Return an expression, converted to another type."""
        if value.type == target:
            return value
        if (
            isinstance(value, tree.Make)
            and isinstance(target, Struct)
            and len(value.parts) == len(target.fields)
        ):
            parts = [
                self.coerced(part, kind, node)
                for part, (_, kind) in zip(value.parts, target.fields, strict=True)
            ]
            return tree.Make(target, parts)
        if (
            target in NUMBERS
            and value.type in NUMBERS
            and NUMBERS.index(value.type) > NUMBERS.index(target)
        ):
            return _converted(value, target)
        if (
            isinstance(value.type, Array)
            and isinstance(target, Array)
            and value.type.size == target.size
        ):
            return value
        raise self.refuse(
            node, f"a value is {_in_words(value.type)}, but must be {_in_words(target)}"
        )

    def _name(self, node: ast.Name) -> tree.Expression:
        if node.id in self.types:
            return tree.Variable(self.types[node.id], node.id)
        value = global_value(self.kernel, node.id)
        if isinstance(value, float):
            value = self.constants.get((node.id, value), value)
        return self._constant_of(value, node, node.id)

    def _constant(self, node: ast.Constant) -> tree.Expression:
        return self._constant_of(node.value, node, repr(node.value))

    def _constant_of(self, value: Any, node: ast.expr, name: str) -> tree.Expression:
        for cls, kind in ((bool, TRUTH), (int, INTEGER), (float, REAL)):
            if isinstance(value, cls):
                return tree.Constant(kind, value)
        changes = isinstance(value, (list, dict, set, bytearray))
        reason = (
            "a mutable global" if changes else "not a number, an argument, or an assigned variable"
        )
        raise self.refuse(node, f"{name} is {reason}")

    def _attribute(self, node: ast.Attribute) -> tree.Expression:
        if isinstance(node.value, ast.Name) and node.value.id not in self.types:
            module = global_value(self.kernel, node.value.id)
            if module is math:
                return self._constant_of(getattr(math, node.attr, None), node, f"math.{node.attr}")
        of = self.value(node.value)
        if isinstance(of.type, Array) and node.attr == "size":
            return _size_of(of, of.type)
        return self._field(of, node.attr, node)

    def _field(self, of: tree.Expression, name: str, node: ast.expr) -> tree.Expression:
        place = of.type.place(name) if isinstance(of.type, Struct) else -1
        if place < 0 or not isinstance(of.type, Struct):
            raise self.refuse(node, f"{_in_words(of.type)} has no field {name!r}")
        return tree.Field(of.type.fields[place][1], of, name)

    def _subscript(self, node: ast.Subscript) -> tree.Expression:
        of = self.value(node.value)
        if isinstance(node.slice, ast.Slice):
            raise self.refuse(
                node, "slices of an array are outside the subset: pass the array and a start index"
            )
        at = self.value(node.slice)
        if isinstance(of.type, Struct):
            if not isinstance(at, tree.Constant) or not -len(of.type.fields) <= at.value < len(
                of.type.fields
            ):
                raise self.refuse(node, "the index of a tuple must be a literal number")
            return self._field(of, of.type.fields[int(at.value)][0], node)
        if not isinstance(of.type, Array) or at.type != INTEGER:
            raise self.refuse(node, "an index needs an array and a whole number")
        if isinstance(at, tree.Constant) and at.value < 0:
            at = self.combined(ast.Add(), _size_of(of, of.type), at, node)
        return tree.Index(REAL, of, at)

    def _binop(self, node: ast.BinOp) -> tree.Expression:
        return self.combined(node.op, self.value(node.left), self.value(node.right), node)

    def combined(
        self, by: ast.operator, left: tree.Expression, right: tree.Expression, node: ast.AST
    ) -> tree.Expression:
        """Return two numbers combined by an operator."""
        if isinstance(by, ast.Pow):
            raise self.refuse(
                node, "the result of ** differs between targets: write a * a, or power(x, y)"
            )
        for side in (left, right):
            if side.type not in NUMBERS:
                raise self.refuse(node, f"arithmetic with {_in_words(side.type)} is not possible")
        real = isinstance(by, ast.Div) or REAL in (left.type, right.type)
        symbol = (OF_REALS if real else OF_WHOLES).get(type(by))
        if symbol is None:
            kind = "real" if real else "whole"
            raise self.refuse(node, f"{type(by).__name__} of {kind} numbers is outside the subset")
        kind = REAL if real else INTEGER
        left, right = _converted(left, kind), _converted(right, kind)
        if not real and isinstance(left, tree.Constant) and isinstance(right, tree.Constant):
            return tree.Constant(INTEGER, COMPUTED[symbol](int(left.value), int(right.value)))
        return tree.Binary(kind, symbol, left, right)

    def _unaryop(self, node: ast.UnaryOp) -> tree.Expression:
        of = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            return tree.Not(TRUTH, self._as_truth(of, node))
        if of.type not in NUMBERS or isinstance(node.op, ast.Invert):
            raise self.refuse(
                node, f"{type(node.op).__name__} of {_in_words(of.type)} is outside the subset"
            )
        of = _converted(of, INTEGER) if of.type == TRUTH else of
        if isinstance(node.op, ast.UAdd):
            return of
        return (
            tree.Constant(of.type, -of.value)
            if isinstance(of, tree.Constant)
            else tree.Negative(of.type, of)
        )

    def _compare(self, node: ast.Compare) -> tree.Expression:
        values = [self.value(part) for part in (node.left, *node.comparators)]
        if any(not _is_plain(value) for value in values[1:-1]):
            raise self.refuse(node, "assign the middle of a chained comparison to a variable first")
        tests: list[tree.Expression] = []
        for by, left, right in zip(node.ops, values, values[1:], strict=False):
            if type(by) not in COMPARED or left.type not in NUMBERS or right.type not in NUMBERS:
                raise self.refuse(
                    node,
                    f"{type(by).__name__} of {_in_words(left.type)} and {_in_words(right.type)} is outside the subset",
                )
            kind = REAL if REAL in (left.type, right.type) else INTEGER
            tests.append(
                tree.Compare(
                    TRUTH, COMPARED[type(by)], _converted(left, kind), _converted(right, kind)
                )
            )
        return tests[0] if len(tests) == 1 else tree.Logic(TRUTH, "and", tests)

    def _boolop(self, node: ast.BoolOp) -> tree.Expression:
        parts = [self.value(part) for part in node.values]
        if any(part.type != TRUTH for part in parts):
            raise self.refuse(
                node, "the operands of and, or must be true or false: write a comparison"
            )
        return tree.Logic(TRUTH, "and" if isinstance(node.op, ast.And) else "or", parts)

    def _ifexp(self, node: ast.IfExp) -> tree.Expression:
        first, second = self.value(node.body), self.value(node.orelse)
        kind = self.unified(first.type, second.type, node)
        return tree.Select(
            kind,
            self.truth(node.test),
            self.coerced(first, kind, node),
            self.coerced(second, kind, node),
        )

    def _tuple(self, node: ast.Tuple) -> tree.Expression:
        parts = [self.value(part) for part in node.elts]
        return tree.Make(tuple_of([part.type for part in parts]), parts)

    def unified(self, first: Type, second: Type, node: ast.AST | None) -> Type:
        """Return the common type of two types."""
        kind = unified(first, second)
        if kind is None:
            raise self.refuse(
                node,
                f"two values must have the same type, but are {_in_words(first)} and {_in_words(second)}",
            )
        return kind

    def _as_truth(self, value: tree.Expression, node: ast.AST) -> tree.Expression:
        if value.type == TRUTH:
            return value
        if value.type not in NUMBERS:
            raise self.refuse(node, f"{_in_words(value.type)} is neither true nor false")
        return tree.Compare(TRUTH, "!=", value, _converted(tree.Constant(INTEGER, 0), value.type))

    def _call(self, node: ast.Call) -> tree.Expression:
        if node.keywords or any(isinstance(argument, ast.Starred) for argument in node.args):
            raise self.refuse(node, "arguments must be passed by position, without unpacking")
        if isinstance(node.func, ast.Attribute):
            return self._math(node.func, node)
        if not isinstance(node.func, ast.Name):
            raise self.refuse(node, "only functions with a name can be called")
        name = node.func.id
        called: Any = None if name in self.types else global_value(self.kernel, name)
        arguments = [self.value(argument) for argument in node.args]
        if called in BUILTINS:
            return self._builtin(name, arguments, node)
        if called is unowned:
            return arguments[0]
        if called in IN_BITS:
            return tree.Intrinsic(REAL, IN_BITS[called], [self.coerced(arguments[0], REAL, node)])
        if is_named_tuple(called):
            return self._tuple_made(called, arguments, node)
        if not is_kernel(called) and not (callable(called) and is_dispatch(called)):
            raise self.refuse(node, f"{name} is not a kernel")
        function = self.function_of(called, [argument.type for argument in arguments])
        return tree.Call(function.result, function, arguments)

    def _tuple_made(
        self, cls: Any, arguments: list[tree.Expression], node: ast.AST
    ) -> tree.Expression:
        missing = cls._fields[len(arguments) :]
        if len(arguments) > len(cls._fields) or any(
            name not in cls._field_defaults for name in missing
        ):
            raise self.refuse(
                node,
                f"{cls.__name__} needs values for {len(cls._fields)} fields: {', '.join(cls._fields)}",
            )
        for name in missing:
            default = cls._field_defaults[name]
            if not isinstance(default, (bool, int, float)):
                raise self.refuse(
                    node,
                    f"{cls.__name__}.{name} has a default that is not a number: pass it explicitly",
                )
            arguments = [*arguments, self._constant_of(default, ast.Constant(default), name)]
        kind = struct_of(cls, [argument.type for argument in arguments])
        parts = [
            self.coerced(part, target, node)
            for part, (_, target) in zip(arguments, kind.fields, strict=True)
        ]
        return tree.Make(kind, parts)

    def _math(self, function: ast.Attribute, node: ast.Call) -> tree.Expression:
        owner = function.value
        module = (
            isinstance(owner, ast.Name)
            and owner.id not in self.types
            and global_value(self.kernel, owner.id)
        )
        if module is not math:
            raise self.refuse(node, f"calls of the method .{function.attr} are outside the subset")
        if function.attr not in OF_MATH:
            raise self.refuse(
                node,
                f"math.{function.attr} may raise an error, or round differently on other targets: use bristle.core.mathematics",
            )
        arguments = [self.coerced(self.value(argument), REAL, node) for argument in node.args]
        return tree.Intrinsic(
            OF_MATH[function.attr], CALLED.get(function.attr, function.attr), arguments
        )

    def _builtin(
        self, name: str, arguments: list[tree.Expression], node: ast.Call
    ) -> tree.Expression:
        if name == "len" and len(arguments) == 1 and isinstance(arguments[0].type, Array):
            return _size_of(arguments[0], arguments[0].type)
        if not arguments or any(argument.type not in NUMBERS for argument in arguments):
            raise self.refuse(node, f"the arguments of {name} must be numbers")
        if name in ("int", "float"):
            return _converted(arguments[0], INTEGER if name == "int" else REAL)
        kind = REAL if any(argument.type == REAL for argument in arguments) else INTEGER
        values = [_converted(argument, kind) for argument in arguments]
        if name == "abs":
            return tree.Intrinsic(kind, "abs", values[:1])
        if name not in ("min", "max") or len(values) < 2:
            raise self.refuse(node, f"{name} is outside the subset, or has too few arguments")
        least = values[0]
        for value in values[1:]:
            least = tree.Intrinsic(kind, name, [least, value])
        return least


BUILTINS = (abs, min, max, float, int, len, range, bool)


def unified(first: Type, second: Type) -> Type | None:
    """Return the common type of two types; None if there is no such type."""
    if first == second:
        return first
    if first in NUMBERS and second in NUMBERS:
        return min(first, second, key=NUMBERS.index)  # type: ignore[arg-type]
    if (
        isinstance(first, Struct)
        and isinstance(second, Struct)
        and first.is_plain
        and second.is_plain
    ):
        parts = [
            unified(left[1], right[1])
            for left, right in zip(first.fields, second.fields, strict=False)
        ]
        common = [part for part in parts if part is not None]
        return tuple_of(common) if len(common) == len(first.fields) == len(second.fields) else None
    return None


def _converted(value: tree.Expression, target: Scalar) -> tree.Expression:
    if value.type == target:
        return value
    if isinstance(value, tree.Constant):
        return tree.Constant(target, float(value.value) if target == REAL else int(value.value))
    return tree.Convert(target, value)


def _size_of(array: tree.Expression, kind: Array) -> tree.Expression:
    return (
        tree.Constant(INTEGER, kind.size)
        if kind.size >= 0
        else tree.Intrinsic(INTEGER, "size", [array])
    )


def _is_plain(value: tree.Expression) -> bool:
    """Return whether an expression can be evaluated twice without cost."""
    of = value.of if isinstance(value, (tree.Field, tree.Negative)) else value
    return isinstance(of, (tree.Variable, tree.Constant)) or (of is not value and _is_plain(of))


def _in_words(kind: Type) -> str:
    if isinstance(kind, Array):
        return f"an array of {kind.size} numbers"
    if isinstance(kind, Struct):
        return f"a tuple of {len(kind.fields)}" if kind.is_plain else f"a {kind.cls.__name__}"
    return {
        "real": "a number",
        "whole": "a whole number",
        "truth": "a truth",
        "nothing": "nothing",
    }[kind.name]
