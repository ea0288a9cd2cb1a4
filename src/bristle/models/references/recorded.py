"""A recorded motion: positions at equal time steps, as in a log.

Between samples the position is linear in time. Velocity and acceleration are central differences, one-sided at the ends.
After the last sample the motion rests.
"""

from typing import Annotated, NamedTuple

import numpy as np

from bristle.core import Relation, Trajectory, Variable


class Parameters(NamedTuple):
    """Parameters of a recorded motion."""

    position: Annotated[np.ndarray, Variable("length", "position at each sample")]
    sample_time: Annotated[float, Variable("time", "time between samples", min=1e-9)]


class State(NamedTuple):
    """A recorded motion has no state."""


def sample(t: np.ndarray, p: Parameters) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position [m or rad], velocity and acceleration at the times `t` [s], each of the shape of `t`."""
    times = p.sample_time * np.arange(len(p.position))
    velocity = np.gradient(p.position, p.sample_time)
    acceleration = np.gradient(velocity, p.sample_time)
    beyond = t > times[-1]
    return (
        np.interp(t, times, p.position),
        np.where(beyond, 0.0, np.interp(t, times, velocity)),
        np.where(beyond, 0.0, np.interp(t, times, acceleration)),
    )


MODEL = recorded = Trajectory(
    name="recorded",
    description="a recorded motion, as in a log",
    Parameters=Parameters,
    State=State,
    sample=sample,
    relations=(
        Relation("at least 3 positions", lambda p: len(p.position) >= 3, "Give a longer record"),
    ),
)
