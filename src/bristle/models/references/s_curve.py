"""A move from rest to rest with limited velocity, acceleration and jerk: an S-curve, or a trapezoid of velocity.

The move begins at 0 and rests at its end. A distance below zero is a move backward.
"""

import math
from typing import Annotated, NamedTuple

import numpy as np

from bristle.core.variable import Variable
from bristle.models.references.legs import legs_through
from bristle.models.references.passing import Passing


class Parameters(NamedTuple):
    """Parameters of the move."""

    distance: Annotated[float, Variable("length", "distance from start to end of the move")]
    velocity: Annotated[float, Variable("length/time", "largest speed", min=1e-12)]
    acceleration: Annotated[float, Variable("length/time^2", "largest acceleration", min=1e-12)]
    jerk: Annotated[float, Variable("length/time^3", "largest jerk", min=1e-12)] = math.inf


class State(NamedTuple):
    """A move has no state."""


def sample(t: np.ndarray, p: Parameters) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position [m or rad], velocity and acceleration at the times `t` [s], each of the shape of `t`."""
    return legs_through((p.distance,), p.velocity, p.acceleration, p.jerk).sample(t)


def duration(p: Parameters) -> float:
    """Return how long the move takes [s]."""
    return legs_through((p.distance,), p.velocity, p.acceleration, p.jerk).end


MODEL = s_curve = Passing(
    name="s_curve",
    description="a move from rest to rest with limited velocity, acceleration and jerk",
    Parameters=Parameters,
    State=State,
    sample=sample,
    duration=duration,
    example={"distance": 0.1, "velocity": 0.2, "acceleration": 2.0, "jerk": 50.0},
)
