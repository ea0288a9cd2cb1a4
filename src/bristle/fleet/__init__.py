"""Fleets: many logs identified each by itself into one store, and their parameters watched over time."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bristle.fleet.identify import identify_each
    from bristle.fleet.watched import watch

__all__ = ["identify_each", "watch"]

_FROM = {"identify_each": "identify", "watch": "watched"}


def __getattr__(name: str) -> Any:
    if name in _FROM:
        return getattr(importlib.import_module(f"bristle.fleet.{_FROM[name]}"), name)
    raise AttributeError(f"module 'bristle.fleet' has no attribute {name!r}")
