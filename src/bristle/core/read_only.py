"""Read-only mappings of the values of a model or a component."""

from collections.abc import Iterable, Mapping
from typing import Any, NoReturn, TypeVar

import numpy as np

K = TypeVar("K")
V = TypeVar("V")


def _refuse(*_: Any, **__: Any) -> NoReturn:
    raise TypeError(
        "this is read-only: copy it with dict(...), or use model.with_values(...) for a model with other values"
    )


_refused: Any = _refuse


class ReadOnly(dict[K, V]):
    """A read-only dictionary of read-only copies.

    Unlike a proxy, it is a dictionary and can be pickled. ``|`` or ``dict`` give an ordinary dictionary.

    Examples
    --------
    >>> values = ReadOnly({"F_C": 20.0})
    >>> values | {"F_C": 22.0}
    {'F_C': 22.0}
    >>> values["F_C"] = 22.0
    Traceback (most recent call last):
    ...
    TypeError: this is read-only: copy it with dict(...), or use model.with_values(...) for a model with other values
    """

    def __init__(self, content: Mapping[K, V] | Iterable[tuple[K, V]] = ()) -> None:
        super().__init__({key: _held(value) for key, value in dict(content).items()})

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (dict(self),)

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refused


def _held(value: Any) -> Any:
    """Return a read-only copy of an array, or a tuple for a list."""
    if isinstance(value, list):
        return tuple(value)
    if not isinstance(value, np.ndarray):
        return value
    copy = value.copy()
    copy.flags.writeable = False
    return copy
