"""Bridges to the tools that people have already, python-control and scikit-learn: loaded when they are used."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bristle.core.lazy import loaded_from

if TYPE_CHECKING:
    from bristle.bridges.regressor import FrictionRegressor
    from bristle.bridges.system import DescribingFunction, FrictionSystem, to_control

__all__ = ["DescribingFunction", "FrictionRegressor", "FrictionSystem", "to_control"]

__getattr__ = loaded_from(
    __name__, {"DescribingFunction": "system", "FrictionRegressor": "regressor", "FrictionSystem": "system", "to_control": "system"}
)
