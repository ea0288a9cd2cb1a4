"""Properties that are computed when they are first asked for."""

from __future__ import annotations

import functools
from typing import Any, TypeVar

__all__ = ["cached_property"]

T = TypeVar("T")


class cached_property(functools.cached_property[T]):  # noqa: N801, TID251  (stands in for the one that it is)
    """A property that is computed once and kept, without a lock.

    Up to Python 3.11 the one of the standard library holds a lock while it computes, one for all instances: a process
    forked meanwhile by another thread waits for it forever. Without it two threads that ask at once both compute.
    """

    def __get__(self, instance: Any, owner: type | None = None) -> Any:
        """Return the value, and leave it where it is found from then on."""
        if instance is None or self.attrname is None:
            return self
        return instance.__dict__.setdefault(self.attrname, self.func(instance))
