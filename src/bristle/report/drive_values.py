"""Identified parameters in the units of the log and of the motor: what a drive may want them in."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from bristle.prediction.drive_units import units_of

if TYPE_CHECKING:
    from bristle.core.axis import Axis
    from bristle.identification.result import Fit

__all__ = ["drive_values"]


def drive_values(fit: Fit, axis: Axis | None) -> dict[str, dict[str, float]]:
    """Return for each parameter that has other units than SI its value in each of them, by name."""
    variables = fit.plant.component.variables | fit.friction.component.variables
    values = {}
    for estimate in fit.estimates:
        variable = variables.get(estimate.name)
        if variable is None or not math.isfinite(estimate.value):
            continue
        units = units_of(variable.quantity, axis, fit.plant.kind)
        if units:
            values[estimate.name] = {unit.name: unit.of(estimate.value) for unit in units}
    return values
