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

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.core.contracts import Model, Reference, Screw
from bristle.core.experiment import Feedforward
from bristle.engine import conditioned
from bristle.engine.motion import compensation_along
from bristle.models.controllers.feedforward import Shape
from bristle.models.friction import viscous
from bristle.models.friction.resting import with_rest
from bristle.models.friction.slots import whole_parts

if TYPE_CHECKING:
    from bristle.engine.path import Lead
    from bristle.models.controllers.wind_up import WindUp

SIDED = 0.02  # of the largest force of the screw: smaller forces do not change the flank


def screw_of(feedforward: Feedforward) -> Screw | None:
    """Return the screw between motor and table; None for one mass."""
    plant = feedforward.plant
    if plant is None or plant.component.screw is None:
        return None
    return plant.component.screw(plant.parameters)


def feeds_inertia(controller: Model, dt: float) -> bool:
    """Return whether a control law already responds to the acceleration of its reference."""
    component = controller.component
    p = controller.parameters
    efforts = []
    for acceleration in (1e-6, 0.0):
        rest = component.start(0.0, 0.0, 0.0, dt, p)
        efforts.append(component.step(rest, Reference(0.0, 0.0, acceleration, 0.0), 0.0, dt, p)[0])
    return efforts[0] != efforts[1]


def wound_up(
    feedforward: Feedforward,
    screw: Screw,
    position: np.ndarray,
    acceleration: np.ndarray,
    dt: float,
) -> Lead:
    """Return the lead of the motor and its effort without its friction, for a desired motion of the table converted to the motor [rad]."""
    from bristle.engine.wind_up import wind_up_along

    mean, force = _loads(feedforward, screw, position, acceleration, dt)
    return wind_up_along(_parameters(feedforward, screw, mean, force, dt), force, mean, dt)


def wind_up_of(
    feedforward: Feedforward,
    screw: Screw,
    position: np.ndarray,
    acceleration: np.ndarray,
    dt: float,
) -> WindUp:
    """Return the parameters of the wind-up along a desired motion of the table converted to the motor [rad]."""
    return _parameters(
        feedforward, screw, *_loads(feedforward, screw, position, acceleration, dt), dt
    )


def _loads(
    feedforward: Feedforward,
    screw: Screw,
    position: np.ndarray,
    acceleration: np.ndarray,
    dt: float,
) -> tuple[Any, Any]:
    """Return the mean desired acceleration [rad/s^2] and the force of the screw [N] in each step."""
    mean = 0.5 * (acceleration + following(acceleration))
    passed = screw.M * screw.arm * mean
    return mean, passed + _table_friction(feedforward, screw, position, passed, dt)


def _parameters(
    feedforward: Feedforward, screw: Screw, mean: np.ndarray, force: np.ndarray, dt: float
) -> WindUp:
    from bristle.engine.wind_up import wind_up_along
    from bristle.models.controllers.wind_up import WindUp

    assert feedforward.plant is not None
    inertia = _inertia_of(feedforward.plant, dt)
    # The nut stays on its flank until a clear force of the opposite sign, and starts in the middle of the gap.
    clear = SIDED * float(np.max(np.abs(force), initial=0.0))
    p = WindUp(screw.M, screw.k, 0.0, screw.gap, screw.arm, inertia, clear, np.ones(1))
    time = feedforward.wind_up_time
    if time == 0.0:
        largest = float(np.max(np.abs(inertia * mean + screw.arm * force)))
        time = _time_for(
            inertia * float(np.ptp(wind_up_along(p, force, mean, dt).position)), largest
        )
    return p._replace(d=screw.d, weights=_weights(time, dt, force.size))


def whole_inertia(plant: Model, screw: Screw, dt: float) -> float:
    """Return the inertia of motor and table at the motor [kg*m^2]."""
    return _inertia_of(plant, dt) + screw.M * screw.arm**2


def _inertia_of(plant: Model, dt: float) -> float:
    """Return the inertia of a motor: the mean velocity at its port falls by dt / (2 J) per effort."""
    return (
        -0.5
        * dt
        / plant.component.port(
            plant.component.initial_state(plant.parameters), 0.0, dt, plant.parameters
        )[1]
    )


def table_of(feedforward: Feedforward) -> Model:
    """Return the compensator of the table; without friction, a compensator with the force 0."""
    return with_rest(feedforward.table or viscous(F_v=0.0), feedforward.rest)


def table_shape(feedforward: Feedforward) -> Shape:
    """Return the shape of the feedforward of the friction of a table."""
    shape = Shape(gain=feedforward.gain, asymmetry=feedforward.asymmetry)
    if feedforward.scaled == "contact" and feedforward.table is not None:
        shape = shape._replace(**whole_parts(feedforward.table))
    return shape


def _table_friction(
    feedforward: Feedforward, screw: Screw, position: np.ndarray, passed: np.ndarray, dt: float
) -> np.ndarray:
    """Return the friction of the table along a desired motion [N], in the step after each sample."""
    friction = table_of(feedforward)
    travel = screw.arm * position
    state, memory = conditioned(friction, feedforward.conditioning * screw.arm)
    steps = np.diff(travel) / dt
    return compensation_along(
        friction,
        table_shape(feedforward),
        np.append(steps, steps[-1:]),
        dt,
        np.append(travel[1:], travel[-1] + dt * steps[-1]),
        transmitted=passed,
        state=state,
        memory=memory,
    )


def _time_for(jump: float, effort: float) -> float:
    """Return the time of the smoothing [s] in which a jump of inertia times angle [N*m*s^2] needs no more than an effort."""
    if effort > 0.0:
        return math.sqrt(2.0 * math.pi * jump / effort)
    return 0.0


def _weights(time: float, dt: float, count: int) -> np.ndarray:
    """Return the weights of a raised cosine over a time around a sample; a single weight if the motion is shorter."""
    half = math.floor(0.5 * time / dt)
    if half < 1 or half >= count:
        return np.ones(1)
    weights = 1.0 + np.cos(2.0 * np.pi * dt * np.arange(-half, half + 1) / time)
    return weights / np.sum(weights)


def following(signal: np.ndarray) -> np.ndarray:
    """Return the values one sample later; the last value stays."""
    return np.append(signal[1:], signal[-1:])
