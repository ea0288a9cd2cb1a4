"""Quantities that friction models share, each described once, under its usual name."""

from typing import Annotated

import numpy as np

from bristle.core.variable import Variable

LEAST_FORCE = 1e-12  # models with a state divide by it

CoulombForce = Annotated[
    float,
    Variable("force", "Coulomb friction force", min=0.0, directional=True, excitation="sliding"),
]
CoulombForceAboveZero = Annotated[
    float,
    Variable(
        "force", "Coulomb friction force", min=LEAST_FORCE, directional=True, excitation="sliding"
    ),
]
StaticForce = Annotated[
    float,
    Variable(
        "force",
        "static (break-away) friction force",
        min=0.0,
        directional=True,
        excitation="stribeck",
    ),
]
StaticForceAboveZero = Annotated[
    float,
    Variable(
        "force",
        "static (break-away) friction force",
        min=LEAST_FORCE,
        directional=True,
        excitation="stribeck",
    ),
]
StribeckVelocity = Annotated[
    float,
    Variable("length/time", "Stribeck velocity", min=1e-9, nominal=1e-2, excitation="stribeck"),
]
ViscousCoefficient = Annotated[
    float,
    Variable(
        "force*time/length",
        "viscous friction coefficient",
        min=0.0,
        directional=True,
        excitation="speed",
    ),
]
BristleStiffness = Annotated[
    float,
    Variable("force/length", "bristle stiffness", min=1e-9, nominal=1e6, excitation="presliding"),
]
ReversalStiffness = Annotated[
    float,
    Variable(
        "force/length", "stiffness at a reversal", min=1e-9, nominal=1e6, excitation="presliding"
    ),
]
ElementStiffness = Annotated[
    np.ndarray,
    Variable(
        "force/length", "stiffness of each element", min=1e-9, nominal=1e6, excitation="presliding"
    ),
]
MicroDamping = Annotated[
    float,
    Variable(
        "force*time/length",
        "micro-damping of the bristles",
        min=0.0,
        nominal=1e2,
        excitation="presliding",
    ),
]
FadingVelocity = Annotated[
    float, Variable("length/time", "velocity at which micro-damping fades", min=1e-12)
]
