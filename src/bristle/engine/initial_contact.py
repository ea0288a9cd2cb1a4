"""Where a contact stood before its log began: found from the first samples, until it no longer matters."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.engine.motion import each_from

__all__ = ["place_of", "state_at"]

Signals = Mapping[str, np.ndarray]
PLACES = 7  # tried at once, from one stop to the other, then between the two neighbours of the best
CLOSER = 3  # times
FIRST = 1000  # samples that are looked at first
THINNED = 500  # of them suffice to tell one place from another
MARGIN = 100  # samples without a difference that end the look-out
ALIKE = 1e-9  # of the largest force: two runs that have become the same


def place_of(friction: Model, motion: Signals, dt: float, wanted: np.ndarray) -> float:
    """Return where a contact stood at first, from -1, about to slip backward, to 1, about to slip forward."""
    count = _forgotten(friction, motion, dt)
    if not count:
        return 0.0
    every = max(count // THINNED, 1)
    first = {name: values[every - 1 : count : every] for name, values in motion.items()}
    # What happened in a step of several samples shows in the mean of its velocity.
    first["v"] = np.diff(first["x"], prepend=motion["x"][0] - dt * motion["v"][0]) / (every * dt)
    measured = wanted[every - 1 : count : every]

    def costs(places: np.ndarray) -> np.ndarray:
        force = each_from(friction, [state_at(friction, one) for one in places.tolist()], dt=every * dt, **first)
        return np.sum((measured - force) ** 2, axis=1)

    places = np.linspace(-1.0, 1.0, PLACES)
    cost = costs(places)
    for _ in range(CLOSER):
        places, cost = _closer(places, cost, costs)
    return _lowest(places, cost)


def _closer(places: np.ndarray, cost: np.ndarray, costs: Callable[[np.ndarray], np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return as many places around the best one, and their costs; those between neighbours are new."""
    best = int(np.argmin(cost))
    low, high = max(best - 1, 0), min(best + 1, PLACES - 1)
    finer = np.linspace(places[low], places[high], PLACES)
    computed = np.linspace(0, PLACES - 1, high - low + 1).astype(int)
    new = np.delete(np.arange(PLACES), computed)
    finer_cost = np.empty(PLACES)
    finer_cost[computed], finer_cost[new] = cost[low : high + 1], costs(finer[new])
    return finer, finer_cost


def _lowest(places: np.ndarray, cost: np.ndarray) -> float:
    """Return where a parabola through the best place and its neighbours is lowest."""
    best = int(np.argmin(cost))
    if not 0 < best < places.size - 1:
        return float(places[best])
    before, here, after = cost[best - 1 : best + 2].tolist()
    bend = before - 2.0 * here + after
    step = 0.5 * (before - after) / bend if bend > 0.0 else 0.0
    return float(places[best] + step * (places[1] - places[0]))


def _forgotten(friction: Model, motion: Signals, dt: float) -> int:
    """Return after how many samples no start shows any more: the two extremes have become the same."""
    count, length = 0, motion["v"].size
    for size in (*(FIRST * 4**k for k in range(12) if FIRST * 4**k < length), length):
        part = {name: values[:size] for name, values in motion.items()}
        low, high = each_from(friction, [state_at(friction, at) for at in (-1.0, 1.0)], dt=dt, **part)
        apart = np.flatnonzero(np.abs(high - low) > ALIKE * max(float(np.max(np.abs(high))), 1e-300))
        count = int(apart[-1]) + 1 if apart.size else 0
        if count < size - MARGIN:
            return count
    return count


def state_at(friction: Model, place: float) -> Any:
    """Return the state of a contact at a place from -1, about to slip backward, to 1, about to slip forward."""
    return friction.component.start(place, friction.parameters)
