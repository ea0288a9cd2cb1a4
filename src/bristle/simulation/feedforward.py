"""What is fed forward: inertia, gravity and cogging along the desired motion, a compensator along either."""

from __future__ import annotations

from typing import Any

import numpy as np

from bristle.controllers.feedforward import Shape
from bristle.core.contracts import Model
from bristle.core.edge import Amount, amount, array, guarded, instance
from bristle.core.experiment import FEEDFORWARD, Feedforward
from bristle.engine import Compensator, conditioned
from bristle.engine.checks import FRICTION, PERIOD, check_run
from bristle.engine.motion import compensation_along
from bristle.plants.terms import effort_of_place, terms_of

__all__ = ["compensator_of", "feedforward_effort", "friction_along"]


@guarded(model=FRICTION, velocity=array(least=1), dt=PERIOD, conditioning=amount(FEEDFORWARD["conditioning"]))
def friction_along(model: Model, velocity: Any, dt: Amount, *, conditioning: Amount = 0.0) -> np.ndarray:
    """Return the friction force that a compensator expects along a desired motion.

    Where the desired velocity is zero a set-valued model has no single force; it is fed the middle of its interval.

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

    Returns
    -------
    ndarray, shape (step,)
        Force [N or N*m].
    """
    state, memory = conditioned(model, conditioning)
    return compensation_along(model, Shape(), velocity, dt, dt * np.cumsum(velocity), state=state, memory=memory)


@guarded(
    feedforward=instance(Feedforward, "a Feedforward"), position=array(least=2), acceleration=array(least=2), dt=PERIOD,
)  # fmt: skip
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
    effort = feedforward.mass * 0.5 * (acceleration + np.append(acceleration[1:], acceleration[-1:]))
    terms = None if feedforward.plant is None else terms_of(feedforward.plant)
    if terms is not None:
        effort = effort + effort_of_place(0.5 * (position + np.append(position[1:], position[-1:])), terms)
    if feedforward.friction is None or feedforward.along == "measured":
        return effort
    steps = np.diff(position) / dt
    state, memory = conditioned(feedforward.friction, feedforward.conditioning)
    return effort + compensation_along(
        feedforward.friction, _shape(feedforward), np.append(steps, steps[-1:]), dt,
        np.append(position[1:], position[-1] + dt * steps[-1]), transmitted=effort, state=state, memory=memory,
    )  # fmt: skip


def compensator_of(feedforward: Feedforward) -> Compensator | None:
    """Return the compensator that a loop runs along the measured motion; None where there is none."""
    if feedforward.friction is None or feedforward.along == "desired":
        return None
    return Compensator(
        feedforward.friction, _shape(feedforward), *conditioned(feedforward.friction, feedforward.conditioning)
    )


def _shape(feedforward: Feedforward) -> Shape:
    return Shape(**{name: getattr(feedforward, name) for name in Shape._fields})
