"""Bridges to the tools that people have already, python-control and scikit-learn: loaded when they are used."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bristle.bridges.describing_function import DescribingFunction
    from bristle.bridges.regressor import FrictionRegressor
    from bristle.bridges.system import FrictionSystem, to_control

_FROM = {
    "DescribingFunction": "bristle.bridges.describing_function",
    "FrictionRegressor": "bristle.bridges.regressor",
    "FrictionSystem": "bristle.bridges.system",
    "to_control": "bristle.bridges.system",
}

__all__ = ["DescribingFunction", "FrictionRegressor", "FrictionSystem", "to_control"]


def __getattr__(name: str) -> Any:
    if name not in _FROM:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(_FROM[name]), name)
