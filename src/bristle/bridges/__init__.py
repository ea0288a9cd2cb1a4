"""Bridges to python-control, scikit-learn, Drake and Gymnasium, imported on first use; `jax` and `torch` are modules of their own."""

from typing import TYPE_CHECKING

from bristle.loading import loaded_from

if TYPE_CHECKING:
    from bristle.bridges.drake import DrakeFriction
    from bristle.bridges.gymnasium import AxisEnv
    from bristle.bridges.regressor import FrictionRegressor
    from bristle.bridges.system import DescribingFunction, FrictionSystem, to_control

__getattr__ = loaded_from(__name__)

__all__ = ["AxisEnv", "DescribingFunction", "DrakeFriction", "FrictionRegressor", "FrictionSystem", "to_control"]
