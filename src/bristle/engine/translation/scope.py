"""Names in kernels, and the error for a kernel that cannot be translated."""

import ast
import builtins
import inspect
import re
import textwrap
from collections.abc import Callable, Container
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any

from bristle.core.errors import InputError
from bristle.core.kernel import kernels


class NotExportableError(InputError):
    """A kernel is outside the subset of Python that every target supports; the message contains place and reason."""

    def __init__(self, function: Callable[..., Any], node: ast.AST | None, reason: str) -> None:
        code = getattr(function, "__code__", None)
        line = getattr(node, "lineno", None)  # counted from the first line of the kernel
        place = function.__module__ if code is None else Path(code.co_filename).name
        at = f"line {code.co_firstlineno + line - 1}" if code and line else function.__name__
        super().__init__(reason, path=f"{place}, {at}")


def defined(name: str, text: str, scope: dict[str, Any]) -> Callable[..., Any]:
    """Return the kernel of this name in a text, with `scope` as its globals; the text is stored for the tree."""
    exec(compile(text, f"<{name}>", "exec"), scope)
    function = scope[name]
    function.source = text
    return function


@cache
def definition_of(function: Callable[..., Any]) -> ast.FunctionDef:
    """Return the definition of a kernel as a syntax tree of Python."""
    source = getattr(function, "source", None)
    try:
        tree = ast.parse(source or textwrap.dedent(inspect.getsource(function)))
    except (OSError, TypeError, SyntaxError):
        raise NotExportableError(function, None, "its source cannot be found") from None
    definition = tree.body[0]
    if not isinstance(definition, ast.FunctionDef):
        raise NotExportableError(function, None, "a kernel must be a function defined by def")
    arguments = definition.args
    if arguments.vararg or arguments.kwarg or arguments.kwonlyargs or arguments.defaults:
        raise NotExportableError(
            function, definition, "all arguments of a kernel must be positional, without defaults"
        )
    return definition


def global_value(function: Callable[..., Any], name: str) -> Any:
    """Return the value of a name that is not local to a kernel."""
    around = dict(zip(function.__code__.co_freevars, function.__closure__ or (), strict=True))
    if name in around:
        return around[name].cell_contents
    if name in function.__globals__:
        return function.__globals__[name]
    if hasattr(builtins, name):
        return getattr(builtins, name)
    raise NotExportableError(function, None, f"{name} is not defined")


def is_kernel(value: Any) -> bool:
    """Return whether this is a kernel, or derived from one for other targets."""
    return inspect.isfunction(value) and (
        value in _kernel_set(len(kernels())) or hasattr(value, "is_portable")
    )


@cache
def _kernel_set(count: int) -> frozenset[Any]:
    return frozenset(kernels())


def is_named_tuple(value: Any) -> bool:
    """Return whether this is the class of NamedTuples."""
    return isinstance(value, type) and issubclass(value, tuple) and hasattr(value, "_fields")


def free_name(first: str, used: Container[str]) -> str:
    """Return this name, or this name with the first unused number from 2."""
    if first not in used:
        return first
    return next(name for n in count(2) if (name := f"{first}_{n}") not in used)


def ascii_name(name: str) -> str:
    """Return a name of Python in ASCII, with other letters as numbers."""
    return re.sub(r"\W", lambda letter: f"u{ord(letter[0]):04X}", name, flags=re.ASCII)
