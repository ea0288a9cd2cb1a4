r"""One of the two axes that together run a circle, the standard test of machine tools (ISO 230-4).

.. math:: x(t) = c + R \cos(v t / R), \qquad y(t) = c + R \sin(v t / R)

The motion has full speed from the first sample. At the reversal of an axis the friction of this axis changes its sign,
and the path bulges: the quadrant glitch.
"""

from typing import Annotated, NamedTuple

import numpy as np

from bristle.core import Trajectory, Variable

AXES = ("x", "y")


class Parameters(NamedTuple):
    """Parameters of one axis of a circle."""

    radius: Annotated[float, Variable("length", "radius", min=1e-12)]
    feed: Annotated[float, Variable("length/time", "speed along the circle", min=1e-12)]
    axis: Annotated[
        int, Variable("1", "axis of the circle: x follows the cosine, y the sine", choices=AXES)
    ] = 0
    offset: Annotated[float, Variable("length", "centre of the circle")] = 0.0


class State(NamedTuple):
    """A circle has no state."""


def sample(t: np.ndarray, p: Parameters) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position [m or rad], velocity and acceleration at the times `t` [s], each of the shape of `t`."""
    omega = p.feed / p.radius
    angle = omega * t - (0.5 * np.pi if AXES[p.axis] == "y" else 0.0)
    along, across = p.radius * np.cos(angle), p.radius * np.sin(angle)
    return p.offset + along, -omega * across, -(omega**2) * along


MODEL = circle = Trajectory(
    name="circle",
    description="one axis of a circle at constant speed",
    Parameters=Parameters,
    State=State,
    sample=sample,
)
