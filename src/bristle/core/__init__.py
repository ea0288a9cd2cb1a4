"""Contracts, kernels, variables, units, errors: what every part of bristle speaks."""

from bristle.core.axis import Axis, Column, Injected
from bristle.core.contracts import (
    Component,
    Controller,
    FrictionModel,
    HysteresisOperator,
    Model,
    Motion,
    Plant,
    Reference,
    Relation,
    Sensor,
    Trajectory,
)
from bristle.core.errors import BristleError, InputError, InputWarning, MissingExtraError
from bristle.core.experiment import Experiment, Feedforward, Run, Variant
from bristle.core.kernel import kernel
from bristle.core.slot import Slot
from bristle.core.status import Status
from bristle.core.surroundings import Surrounding
from bristle.core.variable import Variable, unit_of, variables_of

__all__ = [
    "Axis",
    "BristleError",
    "Column",
    "Component",
    "Controller",
    "Experiment",
    "Feedforward",
    "FrictionModel",
    "HysteresisOperator",
    "Injected",
    "InputError",
    "InputWarning",
    "MissingExtraError",
    "Model",
    "Motion",
    "Plant",
    "Reference",
    "Relation",
    "Run",
    "Sensor",
    "Slot",
    "Status",
    "Surrounding",
    "Trajectory",
    "Variable",
    "Variant",
    "kernel",
    "unit_of",
    "variables_of",
]
