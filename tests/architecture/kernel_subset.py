"""Keeps kernels in the subset of Python that can be exported: what a translator to C must understand, and no more.

Scalars, tuples, 1-D arrays; ``if``, ``while``, ``for`` over a range; calls to other kernels, to the dispatch, to
NamedTuples, and to those functions of the mathematics that every target computes exactly.
"""

from __future__ import annotations

import ast
import inspect
import math
import textwrap
from collections.abc import Callable
from typing import Any

from bristle.core.dispatch import is_dispatch
from bristle.core.kernel import kernels

__all__ = ["reachable_kernels", "violations_of"]

STATEMENTS = (
    ast.FunctionDef,
    ast.Return,
    ast.Assign,
    ast.AugAssign,
    ast.AnnAssign,
    ast.If,
    ast.While,
    ast.For,
    ast.Expr,
    ast.Break,
    ast.Continue,
    ast.Pass,
)
EXPRESSIONS = (
    ast.BinOp,
    ast.UnaryOp,
    ast.BoolOp,
    ast.Compare,
    ast.IfExp,
    ast.Call,
    ast.Attribute,
    ast.Subscript,
    ast.Name,
    ast.Constant,
    ast.Tuple,
)
OPERATORS = (
    ast.Add,
    ast.Sub,
    ast.Mult,
    ast.Div,
    ast.Mod,
    ast.FloorDiv,
    ast.USub,
    ast.UAdd,
    ast.Not,
    ast.And,
    ast.Or,
    ast.Lt,
    ast.LtE,
    ast.Gt,
    ast.GtE,
    ast.Eq,
    ast.NotEq,
    ast.BitAnd,
    ast.BitXor,
    ast.RShift,
)
GRAMMAR = (ast.arguments, ast.arg, ast.expr_context, ast.Slice)
BUILTINS = frozenset({"abs", "min", "max", "range", "float", "int", "len"})
MATHEMATICS = frozenset({"copysign", "fabs", "isinf", "isnan", "floor", "sqrt"})
# What may raise or overflow is allowed in one place only, where it is guarded.
GUARDED = frozenset({"frexp", "ldexp"})
GUARDED_IN = ("bristle.core.exponent",)


def violations_of(function: Callable[..., Any]) -> list[str]:
    """Return what in the source of a kernel lies outside the exportable subset, one sentence each.

    Parameters
    ----------
    function : callable
        A plain Python function.

    Returns
    -------
    list of str
        Line and reason; empty if the kernel can be exported.
    """
    source = getattr(function, "source", None) or textwrap.dedent(inspect.getsource(function))
    tree = ast.parse(source)
    definition = tree.body[0]
    if not isinstance(definition, ast.FunctionDef):
        return [
            f"{function.__module__}.{function.__name__}: a kernel is a function with a name, defined by def"
        ]
    definition.decorator_list.clear()
    return [
        f"{function.__module__}.{function.__name__}, line {getattr(node, 'lineno', 1)}: {reason}"
        for node in ast.walk(definition)
        if (reason := _reason(node, function))
    ]


def reachable_kernels(*functions: Callable[..., Any]) -> list[Callable[..., Any]]:
    """Return some kernels and every kernel that they call, directly or not."""
    reached: list[Callable[..., Any]] = []
    waiting = list(functions)
    while waiting:
        function = waiting.pop()
        if function in reached:
            continue
        reached.append(function)
        waiting += [
            value
            for value in inspect.getclosurevars(function).globals.values()
            if value in kernels()
        ]
    return reached


def _reason(node: ast.AST, function: Callable[..., Any]) -> str:
    if isinstance(node, ast.Call):
        return _call_reason(node, function)
    if isinstance(node, ast.For) and not _is_range(node.iter):
        return "a for loop must run over range(...)"
    if isinstance(node, (ast.For, ast.While)) and node.orelse:
        return "a loop has no else in C"
    if isinstance(node, ast.FunctionDef) and node.name != function.__name__:
        return "a function inside a function"
    if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
        return _name_reason(node, function)
    if isinstance(node, ast.Pow):
        return "** differs between targets: write a * a, or power(x, y)"
    if isinstance(node, ast.keyword):
        return "arguments are passed by position"
    if not isinstance(node, (*STATEMENTS, *EXPRESSIONS, *OPERATORS, *GRAMMAR)):
        return f"{type(node).__name__} is outside the subset"
    return ""


def _is_range(node: ast.expr) -> bool:
    return (
        isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "range"
    )


def _call_reason(node: ast.Call, function: Callable[..., Any]) -> str:
    target = node.func
    if isinstance(target, ast.Attribute):
        owner = target.value
        if not (isinstance(owner, ast.Name) and _value(owner.id, function) is math):
            return f"a call to the method .{target.attr}"
        allowed = MATHEMATICS | (GUARDED if function.__module__ in GUARDED_IN else frozenset())
        if target.attr not in allowed:
            return f"math.{target.attr} may raise, or round otherwise on another target: use bristle.core.mathematics"
        return ""
    if not isinstance(target, ast.Name):
        return "a call to something that is not a name"
    if (
        target.id in BUILTINS
        or target.id in function.__code__.co_varnames[: function.__code__.co_argcount]
    ):
        return ""  # what is handed in is a kernel too: the caller is looked at as well
    value = _value(target.id, function)
    is_tuple = isinstance(value, type) and issubclass(value, tuple) and hasattr(value, "_fields")
    if is_tuple or value in kernels() or (callable(value) and is_dispatch(value)):
        return ""
    return f"{target.id} is not a kernel"


def _name_reason(node: ast.Name, function: Callable[..., Any]) -> str:
    value = _value(node.id, function)
    if isinstance(value, (list, dict, set, bytearray)):
        return f"{node.id} is a global that can change"
    return ""


def _value(name: str, function: Callable[..., Any]) -> Any:
    around = inspect.getclosurevars(function)
    return around.nonlocals.get(name, around.globals.get(name, function.__globals__.get(name)))
