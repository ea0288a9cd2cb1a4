r"""A chirp: a sine whose frequency rises by the same factor in equal times; it begins and ends at rest.

.. math:: x(t) = A\,w(t) \sin\varphi(t), \qquad \dot\varphi = 2\pi f_0 (f_1/f_0)^{t/T}

where `w` rises smoothly from 0 to 1 over `ramp` seconds, and falls in the same way at the end.
"""

import math
from typing import Annotated, NamedTuple

import numpy as np

from bristle.core import Relation, Variable
from bristle.models.references.fade import fade
from bristle.models.references.passing import Passing


class Parameters(NamedTuple):
    """Parameters of the chirp."""

    amplitude: Annotated[float, Variable("length", "amplitude")]
    f_0: Annotated[float, Variable("frequency", "frequency at the beginning", min=1e-9)]
    f_1: Annotated[float, Variable("frequency", "frequency at the end", min=1e-9)]
    duration: Annotated[float, Variable("time", "duration of the sweep", min=1e-9)]
    ramp: Annotated[
        float,
        Variable(
            "time",
            "time in which the amplitude rises at the beginning and falls at the end",
            min=0.0,
        ),
    ] = 0.0


class State(NamedTuple):
    """A chirp has no state."""


def sample(t: np.ndarray, p: Parameters) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position [m or rad], velocity and acceleration at the times `t` [s], each of the shape of `t`."""
    inside = (t > 0.0) & (t < p.duration)
    tau = np.clip(t, 0.0, p.duration)
    rate = math.log(p.f_1 / p.f_0) / p.duration
    omega = 2.0 * np.pi * p.f_0 * np.exp(rate * tau)
    phase = (omega - 2.0 * np.pi * p.f_0) / rate if rate != 0.0 else omega * tau
    s, s_dot = np.sin(phase), omega * np.cos(phase)
    s_ddot = rate * s_dot - omega**2 * s
    (up, up_dot, up_ddot), (down, down_dot, down_ddot) = (
        fade(tau, p.ramp),
        fade(p.duration - tau, p.ramp),
    )
    w, w_dot = up * down, up_dot * down - up * down_dot
    w_ddot = up_ddot * down - 2.0 * up_dot * down_dot + up * down_ddot
    position = p.amplitude * w * s
    velocity = p.amplitude * (w_dot * s + w * s_dot)
    acceleration = p.amplitude * (w_ddot * s + 2.0 * w_dot * s_dot + w * s_ddot)
    return position, np.where(inside, velocity, 0.0), np.where(inside, acceleration, 0.0)


def duration(p: Parameters) -> float:
    """Return how long the chirp lasts [s]."""
    return p.duration


MODEL = chirp = Passing(
    name="chirp",
    description="a sine of rising frequency, from rest to rest",
    Parameters=Parameters,
    State=State,
    sample=sample,
    duration=duration,
    relations=(
        Relation("2 ramp <= duration", lambda p: 2.0 * p.ramp <= p.duration, "Shorten the ramp"),
    ),
    example={"amplitude": 1e-6, "f_0": 5.0, "f_1": 100.0, "duration": 5.0, "ramp": 0.5},
)
