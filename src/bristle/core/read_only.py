"""Mappings that are told, not changed: what a model or a component holds, by name."""

from collections.abc import Iterable, Mapping
from typing import Any, NoReturn, TypeVar

import numpy as np

K = TypeVar("K")
V = TypeVar("V")


def _refuse(*_: Any, **__: Any) -> NoReturn:
    raise TypeError("this is read-only: take dict(...) of it, or model.with_values(...) for a model with other values")


_refused: Any = _refuse


class ReadOnly(dict[K, V]):
    """A dictionary that refuses to be changed, of copies that cannot be changed either.

    It stays a dictionary to everything that reads one, and travels to other processes, which a proxy does not. What is
    put together from it with ``|`` or ``dict`` is one's own.

    Examples
    --------
    >>> told = ReadOnly({"F_C": 20.0})
    >>> told | {"F_C": 22.0}
    {'F_C': 22.0}
    >>> told["F_C"] = 22.0
    Traceback (most recent call last):
    ...
    TypeError: this is read-only: take dict(...) of it, or model.with_values(...) for a model with other values
    """

    def __init__(self, content: Mapping[K, V] | Iterable[tuple[K, V]] = ()) -> None:
        super().__init__({key: _held(value) for key, value in dict(content).items()})

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (dict(self),)

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refused


def _held(value: Any) -> Any:
    """Return a value as nobody can change it: a copy of an array, a tuple for a list."""
    if isinstance(value, list):
        return tuple(value)
    if not isinstance(value, np.ndarray):
        return value
    copy = value.copy()
    copy.flags.writeable = False
    return copy
