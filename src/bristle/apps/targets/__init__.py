"""Bridges to python-control, scikit-learn and Drake, imported on first use; `jax` is a module of its own."""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.apps.targets.drake import DrakeFriction
    from bristle.apps.targets.regressor import FrictionRegressor
    from bristle.apps.targets.system import DescribingFunction, FrictionSystem, to_control

__getattr__ = loaded_from(__name__)

__all__ = [
    "DescribingFunction",
    "DrakeFriction",
    "FrictionRegressor",
    "FrictionSystem",
    "to_control",
]
