"""A fingerprint of code: what the compiler would see of a function, so that a change is never overlooked.

The compiler freezes into its product not only the body of a function but every global that the body reads: other
functions, constants, classes, and what the dispatch calls for a class. The fingerprint follows the same references. It
is taken of the code that is loaded, not of the files that it was loaded from: these may have changed since.
"""

from __future__ import annotations

import hashlib
import types
from collections.abc import Callable, Sequence
from typing import Any

from bristle.core.dispatch import functions_of

__all__ = ["fingerprint"]


def fingerprint(*functions: Callable[..., Any]) -> str:
    """Return the SHA-256 over some functions and everything that they refer to."""
    digest = hashlib.sha256()
    seen: set[int] = set()
    for function in functions:
        _follow(function, digest, seen, ())
    return digest.hexdigest()


def _follow(value: Any, digest: Any, seen: set[int], names: Sequence[str]) -> None:
    if isinstance(value, (bool, int, float, complex, str, bytes, type(None))):
        digest.update(repr(value).encode())
    elif isinstance(value, (tuple, list)):
        for one in value:
            _follow(one, digest, seen, names)
    elif hasattr(value, "tobytes"):
        digest.update(value.tobytes())
    elif id(value) in seen:
        return
    elif isinstance(value, types.FunctionType):
        seen.add(id(value))
        digest.update(value.__qualname__.encode())
        _follow_code(value.__code__, value.__globals__, digest, seen)
        for cell in value.__closure__ or ():
            _follow(cell.cell_contents, digest, seen, ())
    elif isinstance(value, types.ModuleType):
        # Of a module only what the code may have asked of it.
        for name in names:
            if hasattr(value, name):
                _follow(getattr(value, name), digest, seen, ())
    else:
        # Classes and built-ins: their name and, for a NamedTuple, the order of its fields.
        digest.update(f"{getattr(value, '__module__', '')}.{getattr(value, '__qualname__', type(value))}".encode())
        digest.update(repr(getattr(value, "_fields", "")).encode())
        if id(value) not in seen:
            seen.add(id(value))
            for function in functions_of(value):
                _follow(function, digest, seen, ())


def _follow_code(code: types.CodeType, scope: dict[str, Any], digest: Any, seen: set[int]) -> None:
    digest.update(code.co_code)
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            _follow_code(constant, scope, digest, seen)
        else:
            digest.update(repr(constant).encode())
    for name in code.co_names:
        digest.update(name.encode())
        if name in scope:
            _follow(scope[name], digest, seen, code.co_names)
