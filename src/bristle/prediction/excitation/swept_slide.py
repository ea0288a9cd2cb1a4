r"""Slides back and forth at constant speed, each with a sine of rising frequency on top: friction stays almost constant.

On each leg of length :math:`T` the velocity is :math:`\pm v` plus that of the sine

.. math:: x(t) = A(\omega)\,w(t)\,\sin\varphi(t), \qquad \dot\varphi = \omega = 2\pi f_0 (f_1/f_0)^{t/T}, \qquad
   A = \frac{c}{\omega \sqrt{1 + (\omega c / a)^2 + (\omega^2 c / j)^2}}

Its velocity is at most `c`, smaller than `v`, so that the motion does not reverse on a leg; its acceleration is at most
`a` and its jerk `j`. `w` fades the sine in and out over a tenth of the leg.
"""

import math
from typing import Annotated, NamedTuple

import numpy as np

from bristle.core.variable import Variable
from bristle.models.references.fade import fade
from bristle.models.references.legs import Legs, legs_through
from bristle.models.references.passing import Passing

FADED = 0.1  # of a leg, at each end


class Parameters(NamedTuple):
    """Parameters of slides with a sine on top."""

    amplitude: Annotated[float, Variable("length", "first turning point, from the start")]
    velocity: Annotated[float, Variable("length/time", "speed of the slides", min=1e-12)]
    acceleration: Annotated[float, Variable("length/time^2", "largest acceleration", min=1e-12)]
    shaking: Annotated[float, Variable("length/time", "largest velocity of the sine", min=1e-12)]
    f_0: Annotated[float, Variable("frequency", "frequency at the beginning of a leg", min=1e-9)]
    f_1: Annotated[float, Variable("frequency", "frequency at the end of a leg", min=1e-9)]
    jerk: Annotated[float, Variable("length/time^3", "largest jerk", min=1e-12)] = math.inf
    leg_count: Annotated[
        int, Variable("1", "legs from one turning point to the other", min=1.0, max=1e6)
    ] = 4


class State(NamedTuple):
    """The slides have no state."""


def _legs(p: Parameters) -> Legs:
    turning = [p.amplitude * (-1.0) ** k for k in range(p.leg_count + 1)]
    return legs_through([*turning, 0.0], p.velocity, p.acceleration, p.jerk)


def sample(t: np.ndarray, p: Parameters) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position [m or rad], velocity and acceleration at the times `t` [s], each of the shape of `t`."""
    legs = _legs(p)
    position, velocity, acceleration = legs.sample(t)
    for begin, time in cruises_of(legs):
        inside = (t > begin) & (t < begin + time)
        sine = _sine(t[inside] - begin, time, p)
        position[inside] += sine[0]
        velocity[inside] += sine[1]
        acceleration[inside] += sine[2]
    return position, velocity, acceleration


def cruises_of(legs: Legs) -> list[tuple[float, float]]:
    """Return begin and duration [s] of constant speed on each leg, without the half legs at both ends of the motion."""
    steady = (legs.acceleration[:-1] == 0.0) & (legs.jerk[:-1] == 0.0)
    begins = legs.time[:-1][steady]
    times = np.diff(legs.time)[steady]
    return [
        (begin, time)
        for begin, time in zip(begins.tolist(), times.tolist(), strict=True)
        if time > 0.75 * np.max(times)
    ]


def _sine(t: np.ndarray, time: float, p: Parameters) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position, velocity and acceleration of the sine on a leg of some time [s]."""
    rate = math.log(p.f_1 / p.f_0) / time
    omega = 2.0 * np.pi * p.f_0 * np.exp(rate * t)
    slow = (omega * p.shaking / p.acceleration) ** 2
    fast = (omega**2 * p.shaking / p.jerk) ** 2
    size = p.shaking / (omega * np.sqrt(1.0 + slow + fast))
    # With u = 1 + slow + fast, the rates of slow and fast are 2 and 4 times that of the frequency.
    u = 1.0 + slow + fast
    first = slow + 2.0 * fast
    second = 2.0 * slow + 8.0 * fast
    size_dot = -rate * size * (1.0 + first / u)
    size_ddot = -rate * (
        size_dot * (1.0 + first / u) + rate * size * (second / u - 2.0 * (first / u) ** 2)
    )
    up, up_dot, up_ddot = fade(t, FADED * time)
    down, down_dot, down_ddot = fade(time - t, FADED * time)
    w = up * down
    w_dot = up_dot * down - up * down_dot
    w_ddot = up_ddot * down - 2.0 * up_dot * down_dot + up * down_ddot
    a = size * w
    a_dot = size_dot * w + size * w_dot
    a_ddot = size_ddot * w + 2.0 * size_dot * w_dot + size * w_ddot
    phase = (omega - 2.0 * np.pi * p.f_0) / rate
    s = np.sin(phase)
    s_dot = omega * np.cos(phase)
    return (
        a * s,
        a_dot * s + a * s_dot,
        a_ddot * s + 2.0 * a_dot * s_dot + a * (rate * s_dot - omega**2 * s),
    )


def duration(p: Parameters) -> float:
    """Return how long all legs take [s]."""
    return _legs(p).end


swept_slide = Passing(
    name="swept_slide",
    description="back and forth at one speed, with a sine of rising frequency on each leg",
    Parameters=Parameters,
    State=State,
    sample=sample,
    duration=duration,
    example={
        "amplitude": 0.05,
        "velocity": 0.02,
        "acceleration": 2.0,
        "shaking": 0.01,
        "f_0": 3.0,
        "f_1": 200.0,
    },
)
