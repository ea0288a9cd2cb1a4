r"""Triangles: back and forth at one speed, around the start, with corners rounded by acceleration and jerk limits.

The turning points are :math:`A, -qA, q^2A, \dots`: with a `ratio` `q` of 1 all loops are equal; below 1 each loop lies
inside the previous loop. After the last turning point the motion returns to its start and stays there.
"""

import math
from typing import Annotated, NamedTuple

import numpy as np

from bristle.core.variable import Variable
from bristle.models.references.legs import Legs, legs_through
from bristle.models.references.passing import Passing


class Parameters(NamedTuple):
    """Parameters of the triangles."""

    amplitude: Annotated[float, Variable("length", "first turning point, from the start")]
    velocity: Annotated[float, Variable("length/time", "speed", min=1e-12)]
    acceleration: Annotated[
        float, Variable("length/time^2", "largest acceleration, at the corners", min=1e-12)
    ]
    jerk: Annotated[float, Variable("length/time^3", "largest jerk, at the corners", min=1e-12)] = (
        math.inf
    )
    cycle_count: Annotated[
        int, Variable("1", "cycles, each with two turning points", min=1.0, max=1e6)
    ] = 1
    ratio: Annotated[
        float,
        Variable(
            "1",
            "distance of each turning point from the start, over that of the previous turning point",
            min=1e-3,
            max=1e3,
        ),
    ] = 1.0


class State(NamedTuple):
    """Triangles have no state."""


def _legs(p: Parameters) -> Legs:
    turning = [p.amplitude * (-p.ratio) ** k for k in range(2 * p.cycle_count)]
    return legs_through([*turning, 0.0], p.velocity, p.acceleration, p.jerk)


def sample(t: np.ndarray, p: Parameters) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position [m or rad], velocity and acceleration at the times `t` [s], each of the shape of `t`."""
    return _legs(p).sample(t)


def duration(p: Parameters) -> float:
    """Return how long all cycles take [s]."""
    return _legs(p).end


MODEL = triangle = Passing(
    name="triangle",
    description="back and forth at one speed, in equal loops or in loops inside each other",
    Parameters=Parameters,
    State=State,
    sample=sample,
    duration=duration,
    example={"amplitude": 7e-6, "velocity": 1e-5, "acceleration": 1e-3, "cycle_count": 2},
)
