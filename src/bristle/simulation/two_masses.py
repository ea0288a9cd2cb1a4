r"""Feedforward for a table behind an elastic screw: both masses, the friction of the table, and the wind-up of the screw.

A desired motion :math:`x_r` of the table needs the force :math:`f_s` of the screw. The motor must lead by the wind-up
:math:`w` and by the half gap :math:`g`, on the flank that the force selects

.. math::
    f_s = M \ddot x_r + F_t(x_r), \qquad w = S\left[f_s / k + g \operatorname{sgn} f_s\right], \qquad
    \theta_r = \left(x_r + w - \frac{d}{k}\,\dot w\right) / r

and its effort is :math:`J \ddot\theta_r + r\,k\,D_g(w)`, in addition to its own friction along :math:`\theta_r`.
:math:`D_g` is the dead zone of the backlash. The damper `d` carries a part of the force, to first order
:math:`d\,\dot w`.

:math:`F_t` jumps at a reversal. Without the smoothing :math:`S` the motor would need an infinite effort there. :math:`S`
is a mean over a time :math:`T` around each sample, with the weights of a raised cosine. It has no phase lag, because the
reference is known in advance. A jump :math:`\Delta w` needs the effort :math:`2 \pi J \Delta w / (r T^2)`. By default
:math:`T` is the time in which this effort equals the largest effort of the rest of the motion. The table sticks during
half of that time before and after a reversal. The resulting error is of the order of :math:`\ddot x_r T^2 / 8`.
"""

import math
from typing import NamedTuple

import numpy as np

from bristle.controllers.feedforward import Shape
from bristle.core.contracts import Model, Reference, Screw
from bristle.core.errors import InputError
from bristle.core.experiment import Feedforward
from bristle.engine import conditioned
from bristle.engine.motion import compensation_along
from bristle.friction.resting import with_rest

SIDED = 0.02  # of the largest force of the screw: smaller forces do not change the flank


class WoundUp(NamedTuple):
    """Angle by which the motor leads its table at each sample [rad], and its effort in the step after each sample [N*m]."""

    twist: np.ndarray
    effort: np.ndarray


def screw_of(feedforward: Feedforward) -> Screw | None:
    """Return the screw between motor and table; None for one mass."""
    plant = feedforward.plant
    return None if plant is None or plant.component.screw is None else plant.component.screw(plant.parameters)


def plant_of_one_mass(feedforward: Feedforward) -> Model | None:
    """Return the plant of a feedforward; refuse a screw, whose wind-up an exported law cannot know in advance."""
    if screw_of(feedforward) is None:
        return feedforward.plant
    raise InputError(
        "winds a screw up, which needs the reference over half of the wind-up time before and after each sample, "
        "so bristle cannot export the law",
        path="feedforward.plant",
        value=feedforward.plant and feedforward.plant.name,
        mend="Add motor_reference and feedforward_effort to the trajectory of the drive, or omit the plant of the feedforward",
    )


def feeds_inertia(controller: Model, dt: float) -> bool:
    """Return whether a control law already responds to the acceleration of its reference."""
    component, p = controller.component, controller.parameters
    efforts = []
    for acceleration in (1e-6, 0.0):
        rest = component.start(0.0, 0.0, 0.0, dt, p)
        efforts.append(component.step(rest, Reference(0.0, 0.0, acceleration, 0.0), 0.0, dt, p)[0])
    return efforts[0] != efforts[1]


def wound_up(feedforward: Feedforward, screw: Screw, position: np.ndarray, acceleration: np.ndarray, dt: float) -> WoundUp:
    """Return the lead of the motor and its effort without its friction, for a desired motion of the table converted to the motor [rad]."""
    plant, mean = feedforward.plant, 0.5 * (acceleration + following(acceleration))
    assert plant is not None
    inertia = _inertia_of(plant, dt)
    force = screw.M * screw.arm * mean + _table_friction(feedforward, screw, position, mean, dt)
    twist = _lead(screw, force) / screw.arm
    largest = float(np.max(np.abs(inertia * mean + screw.arm * force)))
    twist = smoothed(twist, feedforward.wind_up_time or _time_for(inertia * float(np.ptp(twist)), largest), dt)
    stretched = 0.5 * screw.arm * (twist + following(twist))
    pull = screw.k * (stretched - np.clip(stretched, -screw.gap, screw.gap))
    # The damper of the screw takes its share of the force, so that the spring follows later by d / k.
    twist = twist - screw.d / screw.k * np.gradient(twist, dt)
    rate = np.gradient(twist, dt)
    return WoundUp(twist, inertia * (mean + (following(rate) - rate) / dt) + screw.arm * pull)


def whole_inertia(feedforward: Feedforward, dt: float) -> float:
    """Return the inertia of motor and table at the motor [kg*m^2], for a plant with a screw."""
    plant, screw = feedforward.plant, screw_of(feedforward)
    assert plant is not None
    assert screw is not None
    return _inertia_of(plant, dt) + screw.M * screw.arm**2


def _inertia_of(plant: Model, dt: float) -> float:
    """Return the inertia of a motor: the mean velocity at its port falls by dt / (2 J) per effort."""
    return -0.5 * dt / plant.component.port(plant.component.initial_state(plant.parameters), 0.0, dt, plant.parameters)[1]


def _table_friction(feedforward: Feedforward, screw: Screw, position: np.ndarray, mean: np.ndarray, dt: float) -> np.ndarray:
    """Return the friction of the table along a desired motion [N], in the step after each sample."""
    if feedforward.table is None:
        return np.zeros(position.size)
    friction = with_rest(feedforward.table, feedforward.rest)
    state, memory = conditioned(friction, feedforward.conditioning * screw.arm)
    steps = np.diff(position) / dt
    return compensation_along(
        friction,
        Shape(gain=feedforward.gain, asymmetry=feedforward.asymmetry),
        screw.arm * np.append(steps, steps[-1:]),
        dt,
        screw.arm * np.append(position[1:], position[-1] + dt * steps[-1]),
        transmitted=screw.M * screw.arm * mean,
        state=state,
        memory=memory,
    )


def _lead(screw: Screw, force: np.ndarray) -> np.ndarray:
    """Return the travel by which the motor leads the table at each sample [m], for the force of the screw in each step."""
    lead = force / screw.k
    if screw.gap > 0.0:
        # The nut stays on its flank until a clear force of the opposite sign, and starts in the middle of the gap.
        clear = np.abs(force) > SIDED * np.max(np.abs(force), initial=0.0)
        latest = np.maximum.accumulate(np.where(clear, np.arange(force.size), -1))
        lead = lead + screw.gap * np.where(latest >= 0, np.sign(force[latest]), 0.0)
    return 0.5 * (lead + np.concatenate((lead[:1], lead[:-1])))


def _time_for(jump: float, effort: float) -> float:
    """Return the time of the smoothing [s] in which a jump of inertia times angle [N*m*s^2] needs no more than an effort."""
    return math.sqrt(2.0 * math.pi * jump / effort) if effort > 0.0 else 0.0


def smoothed(signal: np.ndarray, time: float, dt: float) -> np.ndarray:
    """Return the mean of a signal over a time around each sample, with the weights of a raised cosine."""
    half = math.floor(0.5 * time / dt)
    if half < 1 or half >= signal.size:
        return signal
    weights = 1.0 + np.cos(2.0 * np.pi * dt * np.arange(-half, half + 1) / time)
    return np.convolve(np.pad(signal, half, mode="edge"), weights / np.sum(weights), "valid")


def following(signal: np.ndarray) -> np.ndarray:
    """Return the values one sample later; the last value stays."""
    return np.append(signal[1:], signal[-1:])
