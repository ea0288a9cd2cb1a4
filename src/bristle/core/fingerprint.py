"""A fingerprint of code: what the compiler would see of a function, so that a change is never overlooked.

The compiler freezes into its product not only the body of a function but every global that the body reads: other
functions, constants, classes. The fingerprint follows the same references.
"""

from __future__ import annotations

import hashlib
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any

__all__ = ["fingerprint_of_code", "fingerprint_of_sources"]


def fingerprint_of_sources(folder: Path) -> str:
    """Return the SHA-256 over every Python source below a folder, names included."""
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        digest.update(str(path.relative_to(folder)).encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


def fingerprint_of_code(*functions: Callable[..., Any]) -> str:
    """Return the SHA-256 over some functions and everything that they refer to."""
    digest = hashlib.sha256()
    seen: set[int] = set()
    for function in functions:
        _follow(function, digest, seen)
    return digest.hexdigest()


def _follow(value: Any, digest: Any, seen: set[int]) -> None:
    if id(value) in seen:
        return
    if isinstance(value, types.FunctionType):
        seen.add(id(value))
        digest.update(value.__qualname__.encode())
        _follow_code(value.__code__, value, digest, seen)
        for cell in value.__closure__ or ():
            _follow(cell.cell_contents, digest, seen)
    elif isinstance(value, (bool, int, float, complex, str, bytes, type(None))):
        digest.update(repr(value).encode())
    elif isinstance(value, (tuple, list)):
        for one in value:
            _follow(one, digest, seen)
    elif hasattr(value, "tobytes"):
        digest.update(value.tobytes())
    else:
        # Classes, modules and built-ins: their name and, for a NamedTuple, the order of its fields.
        digest.update(f"{getattr(value, '__module__', '')}.{getattr(value, '__qualname__', type(value))}".encode())
        digest.update(repr(getattr(value, "_fields", "")).encode())


def _follow_code(code: types.CodeType, function: Any, digest: Any, seen: set[int]) -> None:
    digest.update(code.co_code)
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            _follow_code(constant, function, digest, seen)
        else:
            digest.update(repr(constant).encode())
    for name in code.co_names:
        digest.update(name.encode())
        if name in function.__globals__:
            _follow(function.__globals__[name], digest, seen)
