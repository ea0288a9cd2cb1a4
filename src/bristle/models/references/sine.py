r"""A sine that begins and ends at rest.

.. math:: x(t) = A \sin(2\pi f t)\,w(t)

where `w` rises smoothly from 0 to 1 over `ramp` seconds, so that the motion starts from rest. With ``ramp = 0`` it
starts at full speed.
"""

from typing import Annotated, NamedTuple

import numpy as np

from bristle.core import Trajectory, Variable
from bristle.models.references.fade import fade


class Parameters(NamedTuple):
    """Parameters of the sine."""

    amplitude: Annotated[float, Variable("length", "amplitude")]
    frequency: Annotated[float, Variable("frequency", "frequency", min=1e-9)]
    offset: Annotated[float, Variable("length", "centre of the motion")] = 0.0
    ramp: Annotated[
        float, Variable("time", "time in which the amplitude grows from zero", min=0.0)
    ] = 0.0


class State(NamedTuple):
    """A sine has no state."""


def sample(t: np.ndarray, p: Parameters) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position [m or rad], velocity and acceleration at the times `t` [s], each of the shape of `t`."""
    omega = 2.0 * np.pi * p.frequency
    s, s_dot, s_ddot = np.sin(omega * t), omega * np.cos(omega * t), -(omega**2) * np.sin(omega * t)
    w, w_dot, w_ddot = fade(t, p.ramp)
    position = p.offset + p.amplitude * s * w
    velocity = p.amplitude * (s_dot * w + s * w_dot)
    acceleration = p.amplitude * (s_ddot * w + 2.0 * s_dot * w_dot + s * w_ddot)
    return position, velocity, acceleration


MODEL = sine = Trajectory(
    name="sine",
    description="a sine of constant amplitude and frequency",
    Parameters=Parameters,
    State=State,
    sample=sample,
)
