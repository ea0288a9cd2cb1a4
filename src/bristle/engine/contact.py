"""A contact that moves step by step: friction with its state and memory."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from bristle.core import Model, Motion, Variable, amount, guarded, model as of_family, whole
from bristle.engine.checks import finite
from bristle.engine.instance import Instance
from bristle.engine.motion import along, follow
from bristle.models.friction import unvaried
from bristle.models.friction.slots import whole_parts

DISTANCE, SPEED = (
    Variable("length", "distance of a move"),
    Variable("length/time", "speed of a move", min=0.0),
)
VELOCITY = Variable("length/time", "velocity")


class Contact:
    """A friction model on a prescribed path, with access to its state between the moves.

    Parameters
    ----------
    model : Model
        A friction model with parameters; it starts virgin, at position 0.
    """

    @guarded(model=of_family("friction"))
    def __init__(self, model: Model) -> None:
        self.model = model
        self.x = 0.0
        self._part = Instance(model)
        self._memory = model.component.new_memory(model.parameters)

    @property
    def state(self) -> np.ndarray:
        """The scalars of the state, in the order of its fields."""
        return self._part.state.copy()

    def copy(self) -> Contact:
        """Return an independent contact in the same state."""
        copied = copy.copy(self)
        copied._part = copy.copy(self._part)
        copied._part.state, copied._memory = self._part.state.copy(), self._memory.copy()
        return copied

    @guarded(distance=amount(DISTANCE), speed=amount(SPEED, exclusive=True), count=whole(1))
    def move(self, distance: float, speed: float, count: int = 1) -> np.ndarray:
        """Move in equal steps at constant speed.

        Parameters
        ----------
        distance : float
            Distance of the move [m or rad], signed.
        speed : float
            Speed of the move [m/s or rad/s], positive.
        count : int
            Number of steps.

        Returns
        -------
        ndarray, shape (count,)
            Mean friction force of each step [N or N*m].
        """
        v = np.full(count, np.copysign(speed, distance))
        x = self.x + distance * (np.arange(1, count + 1) / count)
        force = follow(self._part, self._memory, v, x, abs(distance) / speed / count)
        self.x += distance
        return force

    @guarded(v=amount(VELOCITY))
    def force(self, v: float) -> float:
        """Return the friction force [N or N*m] at velocity `v` [m/s or rad/s] in the present state, without a motion."""
        still = self.copy()
        return float(follow(still._part, still._memory, np.array([v]), np.array([self.x]), 0.0)[0])


Signals = Mapping[str, np.ndarray]
PLACES = 7  # trials at once, between the extremes, then between the neighbours of the best
FIRST = 1000  # samples of the first comparison
THINNED = 500  # samples that suffice to distinguish places
MARGIN = 100  # samples without a difference that end the look-out
ALIKE = 1e-9  # of the largest force: two runs with a smaller difference count as equal


def place_of(friction: Model, motion: Signals, dt: float, measured: np.ndarray) -> float:
    """Return the initial place of a contact, from -1 (about to slip backward) to 1 (about to slip forward)."""
    count = _forgotten(friction, motion, dt)
    if not count:
        return 0.0
    stride = max(count // THINNED, 1)
    thinned = {name: values[stride - 1 : count : stride] for name, values in motion.items()}
    # A step of several samples has the mean of their velocities.
    thinned["v"] = np.diff(thinned["x"], prepend=motion["x"][0] - dt * motion["v"][0]) / (
        stride * dt
    )

    def costs(places: np.ndarray) -> np.ndarray:
        force = [
            along(friction, dt=stride * dt, state=state_at(friction, place), **thinned)
            for place in places.tolist()
        ]
        return np.sum((measured[stride - 1 : count : stride] - np.array(force)) ** 2, axis=1)

    places = np.linspace(-1.0, 1.0, PLACES)
    cost = costs(places)
    for _ in range(3):
        # More places between the neighbours of the best place, whose costs are known.
        best = int(np.argmin(cost))
        low, high = max(best - 1, 0), min(best + 1, PLACES - 1)
        places = np.linspace(places[low], places[high], PLACES)
        computed = np.linspace(0, PLACES - 1, high - low + 1).astype(int)
        new, coarse, cost = (
            np.delete(np.arange(PLACES), computed),
            cost[low : high + 1],
            np.empty(PLACES),
        )
        cost[computed], cost[new] = coarse, costs(places[new])
    best = int(np.argmin(cost))
    if not 0 < best < PLACES - 1:
        return float(places[best])
    # Minimum of a parabola through the best place and its neighbours.
    before, lowest, after = cost[best - 1 : best + 2].tolist()
    bend = before - 2.0 * lowest + after
    step = 0.5 * (before - after) / bend if bend > 0.0 else 0.0
    return float(places[best] + step * (places[1] - places[0]))


def _forgotten(friction: Model, motion: Signals, dt: float) -> int:
    """Return the number of samples until the initial place has no influence: the runs of both extremes are equal."""
    count, length = 0, motion["v"].size
    for size in (*(FIRST * 4**k for k in range(12) if FIRST * 4**k < length), length):
        part = {name: values[:size] for name, values in motion.items()}
        low, high = (
            along(friction, dt=dt, state=state_at(friction, at), **part) for at in (-1.0, 1.0)
        )
        apart = np.flatnonzero(
            np.abs(high - low) > ALIKE * max(float(np.max(np.abs(high))), 1e-300)
        )
        count = int(apart[-1]) + 1 if apart.size else 0
        if count < size - MARGIN:
            return count
    return count


def state_at(friction: Model, place: float) -> Any:
    """Return the state of a contact at a place from -1 (about to slip backward) to 1 (about to slip forward)."""
    return friction.component.start(place, friction.parameters)


def steady_force(model: Model, v: float) -> float:
    """Return the steady force [N or N*m] of a friction model at a constant velocity `v` [m/s or rad/s].

    The model runs over growing steps, up to more than a metre, until the force no longer changes. Friction that varies
    along the axis is evaluated in the middle. InputError if the force grows without bound.
    """
    component, p = model.component, unvaried(model).parameters
    state, memory = component.initial_state(p), component.new_memory(p)
    dt, x, force, before = 1e-6, 0.0, math.nan, math.nan
    # A force that grows without bound is refused at the end.
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(200):
            x += v * dt
            force, move = component.trial(state, memory, Motion(v, x), dt, p)
            state = component.commit(state, memory, move, p)
            if not (state or memory.size):
                break
            far = abs(v) * dt > 1.0
            if far and abs(force - before) <= 1e-12 * abs(force):
                break
            # In much longer steps, rounding would hide the deflection of a contact.
            before, dt = force, dt if far else 1.5 * dt
    return float(finite(np.array([force]), model)[0])


def sliding_level(model: Model, fastest: float) -> float:
    """Return the level of sliding friction at a low speed, the mean of both directions [N or N*m]."""
    slow = 1e-3 * fastest
    return max(0.5 * (steady_force(model, slow) - steady_force(model, -slow)), 1e-300)


def level_of(model: Model, fastest: float) -> float:
    """Return the smaller level of sliding friction at a low speed and, without its viscous part, at full speed [N or N*m]."""
    at_full_speed = (
        0.5 * (steady_force(model, fastest) - steady_force(model, -fastest))
        - whole_parts(model)["viscous"] * fastest
    )
    slow = sliding_level(model, fastest)
    return min(slow, at_full_speed) if at_full_speed > 0.0 else slow
