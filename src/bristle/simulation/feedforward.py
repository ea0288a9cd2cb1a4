"""What is fed forward: inertia, gravity and cogging along the desired motion, a compensator along either."""

from typing import Any

import numpy as np

from bristle.controllers.feedforward import Shape
from bristle.core.contracts import Model
from bristle.core.edge import Amount, among, amount, array, guarded, instance
from bristle.core.errors import InputError
from bristle.core.experiment import FEEDFORWARD, RESTS, Feedforward
from bristle.engine import Compensator, conditioned
from bristle.engine.checks import FRICTION, PERIOD, check_run
from bristle.engine.motion import compensation_along
from bristle.engine.path import effort_along
from bristle.friction.resting import with_rest
from bristle.plants.terms import Termed, place_of, terms_of


@guarded(model=FRICTION, velocity=array(least=1), dt=PERIOD, conditioning=amount(FEEDFORWARD["conditioning"]), rest=among(*RESTS))
def friction_along(model: Model, velocity: Any, dt: Amount, *, conditioning: Amount = 0.0, rest: str = RESTS[0]) -> np.ndarray:
    """Return the friction force that a compensator expects along a desired motion.

    Parameters
    ----------
    model : Model
        The compensator.
    velocity : ndarray, shape (step,)
        Mean desired velocity of each step [m/s or rad/s].
    dt : float
        Length of a step [s].
    conditioning : float
        Amplitude of the decaying sweep that its memory goes through first [m or rad]; 0 for a virgin one.
    rest : {"held", "middle"}
        Force of a memoryless model where the velocity is zero (`bristle.friction.resting`).

    Returns
    -------
    ndarray, shape (step,)
        Force [N or N*m].
    """
    model = with_rest(model, rest)
    state, memory = conditioned(model, conditioning)
    return compensation_along(model, Shape(), velocity, dt, dt * np.cumsum(velocity), state=state, memory=memory)


@guarded(feedforward=instance(Feedforward, "a Feedforward"), position=array(least=2), acceleration=array(least=2), dt=PERIOD)
def feedforward_effort(feedforward: Feedforward, position: Any, acceleration: Any, dt: Amount) -> np.ndarray:
    """Return the effort fed forward along a desired trajectory, for the step that begins at each sample.

    Parameters
    ----------
    feedforward : Feedforward
        Mass, gravity, cogging and compensator; one along the measured motion is left to the loop (`compensator_of`).
    position, acceleration : ndarray, shape (sample,)
        Desired motion.
    dt : float
        Sample time [s].

    Returns
    -------
    ndarray, shape (sample,)
        Effort [N or N*m].
    """
    check_run(position.size, acceleration=acceleration)
    effort = _planned(feedforward, position, acceleration)
    if feedforward.friction is None or feedforward.along == "measured":
        return effort
    carried = carried_effort(feedforward, position, acceleration, dt)
    steps = np.diff(position) / dt
    friction = with_rest(feedforward.friction, feedforward.rest)
    state, memory = conditioned(friction, feedforward.conditioning)
    return effort + compensation_along(
        friction,
        _shape(feedforward),
        np.append(steps, steps[-1:]),
        dt,
        np.append(position[1:], position[-1] + dt * steps[-1]),
        transmitted=carried,
        state=state,
        memory=memory,
    )


def carried_effort(feedforward: Feedforward, position: np.ndarray, acceleration: np.ndarray, dt: float) -> np.ndarray:
    """Return the effort [N or N*m] that a desired trajectory passes on to the load, for the step from each sample on.

    It is that of the plant which the feedforward carries; where it tells none, what it feeds forward beside friction.
    """
    plant = feedforward.carries
    if plant is None:
        return _planned(feedforward, position, acceleration)
    middle, steps = 0.5 * (position + _next(position)), np.diff(position) / dt
    inner, p = plant.component, plant.parameters
    if isinstance(p, Termed):
        inner, p = inner.inner, p.inner
    if inner.inverse is None:
        known, mend = "inertia, oscillator", "Leave it out"
        raise InputError("has no inverse", path="feedforward.carries", value=plant.name, allowed=known, mend=mend)
    effort = inner.inverse(middle, np.append(steps, steps[-1:]), 0.5 * (acceleration + _next(acceleration)), p)
    return effort if terms_of(plant) is None else effort + effort_along(middle, place_of(plant))


def compensator_of(feedforward: Feedforward, carried: np.ndarray | None = None) -> Compensator | None:
    """Return the compensator that a loop runs along the measured motion; None where there is none.

    `carried` is what `carried_effort` returns at each sample of the loop; none where not given.
    """
    if feedforward.friction is None or feedforward.along == "desired":
        return None
    friction = with_rest(feedforward.friction, feedforward.rest)
    state, memory = conditioned(friction, feedforward.conditioning)
    return Compensator(friction, _shape(feedforward), state, memory, carried)


def _planned(feedforward: Feedforward, position: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
    """Return inertia, gravity and cogging that are fed forward, half way from each sample to the next one."""
    effort = feedforward.mass * 0.5 * (acceleration + _next(acceleration))
    if feedforward.plant is None or terms_of(feedforward.plant) is None:
        return effort
    return effort + effort_along(0.5 * (position + _next(position)), place_of(feedforward.plant))


def _next(signal: np.ndarray) -> np.ndarray:
    return np.append(signal[1:], signal[-1:])


def _shape(feedforward: Feedforward) -> Shape:
    return Shape(**{name: getattr(feedforward, name) for name in Shape._fields})
