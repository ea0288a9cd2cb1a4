"""Fingerprint of loaded code: everything that the compiler sees of a function and its references."""

import dis
import enum
import hashlib
import types
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

from bristle.core.contracts import Model
from bristle.core.dispatch import functions_of


def fingerprint(*functions: Callable[..., Any]) -> str:
    """Return the SHA-256 of functions and all their references."""
    reader = _Reader()
    for function in functions:
        reader.follow(function)
    return reader.digest.hexdigest()


class _Reader:
    """Feed code to a digest, each piece with its kind and length, so that different sequences differ."""

    def __init__(self) -> None:
        self.digest = hashlib.sha256()
        self._order: dict[int, int] = {}
        self._alive: list[Any] = []  # so that no identity is used twice

    def _feed(self, kind: str, content: bytes | str) -> None:
        data = content.encode() if isinstance(content, str) else content
        self.digest.update(f"{kind} {len(data)} ".encode() + data)

    def follow(self, value: Any, names: Sequence[str] = ()) -> None:
        """Feed a value; for a module, feed only the `names` that the code may use."""
        if isinstance(
            value, (bool, int, float, complex, str, bytes, type(None))
        ) and not isinstance(value, enum.Enum):
            self._feed(type(value).__name__, repr(value))
            return
        if id(value) in self._order:
            self._feed("again", str(self._order[id(value)]))
            return
        self._order[id(value)] = len(self._order)
        self._alive.append(value)
        if isinstance(value, types.FunctionType):
            self._feed("function", value.__qualname__)
            self._code(value.__code__, value.__globals__)
            self.follow(value.__defaults__)
            self.follow(tuple(sorted((value.__kwdefaults__ or {}).items())))
            for cell in value.__closure__ or ():
                self.follow(cell.cell_contents)
        elif isinstance(value, types.CodeType):
            self._code(value, {})
        elif isinstance(value, types.ModuleType):
            self._feed("module", value.__name__)
            for name in names:
                if hasattr(value, name):
                    self._feed("name", name)
                    self.follow(getattr(value, name))
        elif isinstance(value, type):
            self._feed("class", f"{value.__module__}.{value.__qualname__}")
            self.follow(tuple(getattr(value, "_fields", ())))
            self.follow(tuple(sorted(getattr(value, "_field_defaults", {}).items())))
            if issubclass(value, enum.Enum):
                for member in value:
                    self.follow(member)
            for function in functions_of(value):
                self.follow(function)
        elif isinstance(value, dict):
            # Dispatching functions: their implementations are fed separately.
            self._feed("dict", "")
        elif isinstance(value, (tuple, list, frozenset, set)):
            items = sorted(value, key=repr) if isinstance(value, (frozenset, set)) else value
            self._feed(type(value).__name__, str(len(items)))
            for item in items:
                self.follow(item)
        elif isinstance(value, enum.Enum):
            self._feed("enum", f"{type(value).__qualname__}.{value.name}")
            self.follow(value.value)
        elif hasattr(value, "tobytes"):
            self._feed("array", f"{getattr(value, 'dtype', '')} {getattr(value, 'shape', '')}")
            self._feed("bytes", value.tobytes())
        else:
            kind = type(value)
            name = getattr(value, "__qualname__", kind.__qualname__)
            self._feed("other", f"{getattr(value, '__module__', kind.__module__)}.{name}")

    def _code(self, code: types.CodeType, scope: dict[str, Any]) -> None:
        self._feed("code", code.co_code)
        self._feed(
            "arguments",
            f"{code.co_argcount} {code.co_kwonlyargcount} {code.co_flags} {code.co_varnames}",
        )
        for constant in code.co_consts:
            if isinstance(constant, types.CodeType):
                self._code(constant, scope)
            else:
                self.follow(constant)
        globals_read = _globals_read(code)
        for name in code.co_names:
            self._feed("name", name)
            if name in scope and name in globals_read:
                self.follow(scope[name], code.co_names)


@lru_cache(maxsize=1024)
def _globals_read(code: types.CodeType) -> frozenset[str]:
    """Return the names that a code object reads from its module; all other names are attributes."""
    # Match instructions by parts of their names, because versions of Python differ. A superfluous name only costs time,
    # but a missing name returns an outdated number.
    return frozenset(
        one.argval
        for one in dis.get_instructions(code)
        if "GLOBAL" in one.opname or one.opname == "LOAD_NAME"
    )


LETTERS = 16
CHANCE = ("seed",)  # parameters that differ between repeated runs


def digest(model: Model) -> str:
    """Return a short checksum of name and values of a model, without the seed of its scatter."""
    values = sorted(
        (name, value.tolist() if hasattr(value, "tolist") else value)
        for name, value in model.values.items()
        if name not in CHANCE
    )
    return hashlib.sha256(repr((model.name, model.kind, values)).encode()).hexdigest()[:LETTERS]
