"""Kernels that are linked into an entry, and get no machine code of their own.

The compiler makes every function that an entry calls ready to be called from Python: optimised, translated and given an
address, each by itself. Then it links all of them into the entry, and optimises and translates that as a whole. Nobody
calls a kernel but an entry, so the first half is left out: an entry is compiled in about half the time.
"""

from __future__ import annotations

import contextlib
import ctypes
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

from bristle.core.kernel import kernels

__all__ = ["linked_into"]


@contextlib.contextmanager
def linked_into(entry: Callable[..., Any]) -> Iterator[None]:
    """Compile `entry` inside this block, and link into it what it calls; the compiler's lock is held."""
    from numba.core.compiler_lock import global_compiler_lock
    from numba.core.registry import cpu_target

    with global_compiler_lock:
        context: Any = cpu_target.target_context
        codegen: Any = context.codegen()
        library = _library_class_but_for(entry.__qualname__, codegen._library_class)
        executable = _executable_but_for(entry, context.get_executable)
        with _replaced(codegen, "_library_class", library), _replaced(context, "get_executable", executable):
            yield


@contextlib.contextmanager
def _replaced(target: Any, name: str, value: Any) -> Iterator[None]:
    """Give one object, and not its class, something else by this name inside the block."""
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
    """Return libraries that are made ready where somebody asks for an address; the one named `entry`, at once."""

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


def _executable_but_for(entry: Callable[..., Any], executable: Callable[..., Any]) -> Callable[..., Any]:
    """Return what makes functions of Python of compiled ones, but for kernels, which get one that fails."""
    from numba import _dynfunc  # pyright: ignore[reportAttributeAccessIssue]

    known = {(one.__module__, one.__qualname__) for one in kernels()} - {(entry.__module__, entry.__qualname__)}
    failing = ctypes.cast(ctypes.pythonapi.PyErr_BadInternalCall, ctypes.c_void_p).value

    def make(library: Any, described: Any, environment: Any) -> Any:
        if (described.modname, described.qualname) not in known:
            return executable(library, described, environment)
        name = described.qualname.rpartition(".")[2]
        return _dynfunc.make_function(described.lookup_module(), name, "", failing, environment, (library,))

    return make
