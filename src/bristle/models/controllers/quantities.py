"""Quantities that control laws share, each described once."""

from typing import Annotated

from bristle.core.variable import Variable
from bristle.models.controllers.velocity import ESTIMATORS

KnownInertia = Annotated[float, Variable("mass", "mass or inertia that the law assumes", min=0.0)]
SurfaceSlope = Annotated[float, Variable("1/time", "slope of the surface", min=0.0, nominal=300.0)]
ApproachRate = Annotated[
    float,
    Variable("1/time", "rate at which the law approaches the surface", min=0.0, nominal=300.0),
]
EffortLimit = Annotated[float, Variable("force", "largest effort", min=0.0)]
Estimator = Annotated[
    int, Variable("1", "estimator of the velocity from the measured position", choices=ESTIMATORS)
]
Cutoff = Annotated[
    float,
    Variable("frequency", "cut-off of the velocity estimate; infinite for no filter", min=1e-3),
]
PositionBefore = Annotated[float, Variable("length", "position one sample ago")]
VelocityBefore = Annotated[float, Variable("length/time", "velocity one sample ago")]
