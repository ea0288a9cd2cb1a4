"""Factories that make one thing for the same arguments, however many threads ask for it."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar

from bristle.core.locks import MAKING

__all__ = ["once"]

F = TypeVar("F", bound=Callable[..., Any])


def once(factory: F) -> F:
    """Let a factory be called once for the same positional arguments, and return what it made then ever after.

    Components are told apart by identity. A cache of the standard library calls a slow factory twice where two threads
    ask at once, and hands out two of them.
    """
    values: dict[tuple[Any, ...], Any] = {}

    @wraps(factory)
    def only(*arguments: Any) -> Any:
        if arguments not in values:
            with MAKING:
                if arguments not in values:
                    values[arguments] = factory(*arguments)
        return values[arguments]

    return only  # type: ignore[return-value]
