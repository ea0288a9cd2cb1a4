"""Bridges to python-control, scikit-learn and Drake, imported on first use; `jax` is a module of its own."""

from typing import TYPE_CHECKING

from bristle.loading import loaded_from

if TYPE_CHECKING:
    from bristle.bridges.drake import DrakeFriction
    from bristle.bridges.regressor import FrictionRegressor
    from bristle.bridges.system import DescribingFunction, FrictionSystem, to_control

__getattr__ = loaded_from(__name__)

__all__ = ["DescribingFunction", "DrakeFriction", "FrictionRegressor", "FrictionSystem", "to_control"]
