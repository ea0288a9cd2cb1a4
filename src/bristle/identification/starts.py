"""Where a contact stood before its log began: found from the first samples, until it no longer matters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.engine import force_along

__all__ = ["place_of", "starting_state"]

Signals = Mapping[str, np.ndarray]
PLACES = 7  # tried first, from one stop to the other
FINER = 8  # evaluations between the two neighbours of the best
FIRST = 1000  # samples that are looked at first
THINNED = 500  # of them suffice to tell one place from another
MARGIN = 100  # samples without a difference that end the look-out
ALIKE = 1e-9  # of the largest force: two runs that have become the same


def starting_state(friction: Model, motion: Signals, dt: float, wanted: np.ndarray) -> Any:
    """Return the state before a motion from which a model fits best.

    Parameters
    ----------
    friction : Model
        A friction model whose component has a `start`.
    motion : mapping of str to ndarray, shape (step,)
        What `force_along` takes, by name, ``v`` and ``x`` among it.
    dt : float
        Length of a step [s].
    wanted : ndarray, shape (step,)
        The friction that was measured [N or N*m].
    """
    return _state(friction, place_of(friction, motion, dt, wanted))


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

    def cost(place: float) -> float:
        force = force_along(friction, dt=every * dt, state=_state(friction, place), **first)
        return float(np.sum((measured - force) ** 2))

    from scipy.optimize import minimize_scalar

    places = np.linspace(-1.0, 1.0, PLACES)
    best = int(np.argmin([cost(place) for place in places.tolist()]))
    ends = float(places[max(best - 1, 0)]), float(places[min(best + 1, PLACES - 1)])
    found: Any = minimize_scalar(cost, bounds=ends, method="bounded", options={"maxiter": FINER, "xatol": 1e-4})
    return float(found.x)


def _forgotten(friction: Model, motion: Signals, dt: float) -> int:
    """Return after how many samples no start shows any more: the two extremes have become the same."""
    count, whole = 0, motion["v"].size
    for size in (*(FIRST * 4**k for k in range(12) if FIRST * 4**k < whole), whole):
        part = {name: values[:size] for name, values in motion.items()}
        low, high = (force_along(friction, dt=dt, state=_state(friction, at), **part) for at in (-1.0, 1.0))
        apart = np.flatnonzero(np.abs(high - low) > ALIKE * max(float(np.max(np.abs(high))), 1e-300))
        count = int(apart[-1]) + 1 if apart.size else 0
        if count < size - MARGIN:
            return count
    return count


def _state(friction: Model, place: float) -> Any:
    return friction.component.start(place, friction.parameters)
