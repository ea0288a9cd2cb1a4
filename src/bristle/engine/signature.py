"""Signatures of compiled functions, from their annotations, and the forms for the compiler.

The arguments of an entry are numbers, vectors, and NamedTuples of these; a kind of entry is a type, ``Callable[[...],
float]``. A driver is called only from Python, and its NamedTuples may also contain entries. The compiler accepts such a
mixture only from compiled code. Therefore a driver is compiled with a flat list of numbers, vectors and entries, and
assembles the tuples.
"""

import contextlib
import ctypes
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any, NamedTuple, get_args, get_origin, get_type_hints

import numpy as np

from bristle.core.kernel import kernels
from bristle.core.packing import unowned

Vector = np.ndarray


class Signature(NamedTuple):
    """Types of the arguments and the result of a compiled function."""

    takes: tuple[Any, ...]
    gives: type


@cache
def signature_of(kind: Any) -> Signature:
    """Return the signature of a kind of entry, or of a driver by its annotations."""
    if is_entry(kind):
        takes, gives = get_args(kind)
        return Signature(tuple(takes), gives)
    hints = get_type_hints(kind)
    gives = hints.pop("return")
    return Signature(tuple(hints.values()), gives)


def is_entry(kind: Any) -> bool:
    """Return whether a type is a kind of entry."""
    return get_origin(kind) is Callable


def type_of(annotation: Any) -> Any:
    """Return a type of the compiler."""
    from numba import types

    if is_entry(annotation):
        return types.FunctionType(compiled_signature(annotation))
    if _is_tuple(annotation):
        return types.BaseTuple.from_types(
            [type_of(field) for field in _fields(annotation)], annotation
        )
    plain: dict[Any, Any] = {
        Vector: types.Array(types.float64, 1, "C"),
        float: types.float64,
        int: types.int64,
    }
    return plain[annotation]


def compiled_signature(kind: Any) -> Any:
    """Return the compiler's signature of an entry, or of a driver with flat arguments."""
    takes, gives = signature_of(kind)
    if not is_entry(kind):
        takes = tuple(leaf for annotation in takes for leaf in _leaves(annotation))
    return type_of(gives)(*map(type_of, takes))


def flat(arguments: Sequence[Any]) -> list[Any]:
    """Return the flat contents of nested tuples."""
    row: list[Any] = []
    for argument in arguments:
        if isinstance(argument, tuple):
            row += flat(argument)
        else:
            row.append(argument)
    return row


def handed_over(
    function: Callable[..., Any], kind: Any, body: Callable[..., Any] | None = None
) -> Callable[..., Any]:
    """Return the function to compile in place of another: it assembles the arguments, with all vectors unowned."""
    scope: dict[str, Any] = {"__name__": __name__, "body": body or function, "unowned": unowned}
    arguments: list[str] = []
    place = None if is_entry(kind) else ""
    gathered = [
        _gathered(annotation, scope, arguments, place) for annotation in signature_of(kind).takes
    ]
    name = function.__name__
    exec(f"def {name}({', '.join(arguments)}):\n    return body({', '.join(gathered)})", scope)
    return scope[name]


def _gathered(
    annotation: Any, scope: dict[str, Any], arguments: list[str], place: str | None
) -> str:
    """Return the expression of an argument: a part of `place`, a separate name if `place` is None, assembled if it is empty."""
    if place is None or not (place or _is_tuple(annotation)):
        arguments.append(f"argument_{len(arguments)}")
        place = arguments[-1]
    if _is_tuple(annotation):
        scope[annotation.__name__] = annotation
        fields = [
            _gathered(field, scope, arguments, f"{place}[{i}]" if place else "")
            for i, field in enumerate(_fields(annotation))
        ]
        return f"{annotation.__name__}({', '.join(fields)})"
    return f"unowned({place})" if annotation is Vector else place


def _is_tuple(annotation: Any) -> bool:
    return isinstance(annotation, type) and issubclass(annotation, tuple)


def _fields(annotation: Any) -> tuple[Any, ...]:
    return tuple(get_type_hints(annotation).values())


def _leaves(annotation: Any) -> Iterator[Any]:
    if _is_tuple(annotation):
        for field in _fields(annotation):
            yield from _leaves(field)
    else:
        yield annotation


@contextlib.contextmanager
def linked_into(entry: Callable[..., Any]) -> Iterator[None]:
    """Compile `entry` inside this block and link its callees into it, under the lock of the compiler."""
    from numba.core.compiler_lock import global_compiler_lock
    from numba.core.registry import cpu_target

    with global_compiler_lock:
        context: Any = cpu_target.target_context
        codegen: Any = context.codegen()
        library = _library_class_but_for(entry.__qualname__, codegen._library_class)
        executable = _executable_but_for(entry, context.get_executable)
        with (
            _replaced(codegen, "_library_class", library),
            _replaced(context, "get_executable", executable),
        ):
            yield


@contextlib.contextmanager
def _replaced(target: Any, name: str, value: Any) -> Iterator[None]:
    """Replace an attribute of one object, not of its class, inside the block."""
    held = vars(target).get(name)
    setattr(target, name, value)
    try:
        yield
    finally:
        if held is None:
            delattr(target, name)
        else:
            setattr(target, name, held)


@cache
def _library_class_but_for(entry: str, base: Any) -> Any:
    """Return a class of libraries that are finalized when an address is requested, or at once for the library `entry`."""

    class Linked(base):
        is_postponed = False

        def _optimize_final_module(self) -> None:
            if self.name == entry:
                super()._optimize_final_module()

        def _finalize_final_module(self) -> None:
            if self.name == entry:
                super()._finalize_final_module()
            else:
                self.is_postponed = self._finalized = True

        def get_pointer_to_function(self, name: str) -> int:
            self._ensure_finalized()
            if self.is_postponed:
                self.is_postponed = False
                super()._optimize_final_module()
                super()._finalize_final_module()
            return super().get_pointer_to_function(name)

    return Linked


def _executable_but_for(
    entry: Callable[..., Any], executable: Callable[..., Any]
) -> Callable[..., Any]:
    """Return the factory of Python wrappers for compiled functions; a kernel gets a wrapper that fails."""
    from numba import _dynfunc  # pyright: ignore[reportAttributeAccessIssue]

    absorbed = {
        (function.__module__, function.__qualname__) for function in kernels(portable=False)
    }
    absorbed.discard((entry.__module__, entry.__qualname__))
    failing = ctypes.cast(ctypes.pythonapi.PyErr_BadInternalCall, ctypes.c_void_p).value

    def make(library: Any, described: Any, environment: Any) -> Any:
        if (described.modname, described.qualname) not in absorbed:
            return executable(library, described, environment)
        name = described.qualname.rpartition(".")[2]
        return _dynfunc.make_function(
            described.lookup_module(), name, "", failing, environment, (library,)
        )

    return make
