"""Properties and factories that compute their value once, at first use."""

import functools
from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar

from bristle.core.locks import MAKING

T = TypeVar("T")


class cached_property(functools.cached_property[T]):  # noqa: N801, TID251  (stands in for the one that it is)
    """A property that is computed once and stored, without a lock."""

    def __get__(self, instance: Any, owner: type | None = None) -> Any:
        """Compute the value and store it in the instance."""
        if instance is None or self.attrname is None:
            return self
        return instance.__dict__.setdefault(self.attrname, self.func(instance))


F = TypeVar("F", bound=Callable[..., Any])


def once(factory: F) -> F:
    """Call a factory once for the same positional arguments, and return its first result from then on."""
    values: dict[tuple[Any, ...], Any] = {}

    @wraps(factory)
    def only(*arguments: Any) -> Any:
        if arguments not in values:
            with MAKING:
                if arguments not in values:
                    values[arguments] = factory(*arguments)
        return values[arguments]

    return only  # type: ignore[return-value]
