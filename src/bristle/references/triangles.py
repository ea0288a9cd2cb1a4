r"""Triangles of one period and of several amplitudes: loops of every size at constant speed, to identify a contact.

.. math:: x(t) = c + A_i\,\Lambda(t/T), \qquad
          \Lambda(\tau) = 1 - 4\left|\left(\tau + \tfrac14\right) \bmod 1 - \tfrac12\right|

Each amplitude :math:`A_i` is gone through a number of times before the next one; after the last the motion rests at
the centre. The speed of each is :math:`4A_i/T`, without a jump of the position.
"""

from typing import Annotated, NamedTuple

import numpy as np

from bristle.core.contracts import Relation, Trajectory
from bristle.core.variable import Variable


class Parameters(NamedTuple):
    """Parameters of the triangles."""

    amplitudes: Annotated[np.ndarray, Variable("length", "amplitudes, one after the other")]
    period: Annotated[float, Variable("time", "time of one triangle, up and down", min=1e-9)]
    repeats: Annotated[int, Variable("1", "triangles of each amplitude", min=1, max=10_000)] = 1
    offset: Annotated[float, Variable("length", "centre of the motion")] = 0.0


class State(NamedTuple):
    """Triangles have no state."""


def sample(t: np.ndarray, p: Parameters) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position [m or rad], velocity and acceleration at the times `t` [s], each of the shape of `t`."""
    turns = t / p.period
    place = np.floor(turns / p.repeats).astype(int)
    A = np.where(place < p.amplitudes.size, p.amplitudes[np.minimum(place, p.amplitudes.size - 1)], 0.0)
    phase = (turns + 0.25) % 1.0
    position = p.offset + A * (1.0 - 4.0 * np.abs(phase - 0.5))
    velocity = np.where(phase < 0.5, 4.0, -4.0) * A / p.period
    return position, velocity, np.zeros_like(position)


MODEL = Trajectory(
    name="triangles",
    description="triangles of one period, one amplitude after the other",
    Parameters=Parameters,
    State=State,
    sample=sample,
    relations=(Relation("at least 1 amplitude", lambda p: len(p.amplitudes) >= 1, "Give one"),),
)
