"""Where a contact stood before its log began: found from the first samples, until it no longer matters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.engine import force_along

__all__ = ["place_of", "starting_state"]

PLACES = 11  # tried first, from one stop to the other
FINER = 14  # evaluations between the two neighbours of the best
ALIKE = 1e-9  # of the largest force: two runs that have become the same


def starting_state(friction: Model, motion: Mapping[str, np.ndarray], dt: float, wanted: np.ndarray) -> Any:
    """Return the state before a motion from which a model fits best.

    Parameters
    ----------
    friction : Model
        A friction model whose component has a `start`.
    motion : mapping of str to ndarray
        What `force_along` takes, by name, ``v`` and ``x`` among it.
    dt : float
        Length of a step [s].
    wanted : ndarray, shape (step,)
        The friction that was measured [N or N*m].
    """
    return _state(friction, place_of(friction, motion, dt, wanted))


def place_of(friction: Model, motion: Mapping[str, np.ndarray], dt: float, wanted: np.ndarray) -> float:
    """Return where a contact stood at first, from -1, about to slip backward, to 1, about to slip forward."""
    low, high = (force_along(friction, dt=dt, state=_state(friction, place), **motion) for place in (-1.0, 1.0))
    apart = np.flatnonzero(np.abs(high - low) > ALIKE * max(float(np.max(np.abs(high))), 1e-300))
    if not apart.size:
        return 0.0
    # Beyond the last sample at which the two extremes differ, no start shows any more.
    first = slice(0, int(apart[-1]) + 1)
    beginning = {name: signal[first] for name, signal in motion.items()}

    def cost(place: float) -> float:
        force = force_along(friction, dt=dt, state=_state(friction, place), **beginning)
        return float(np.sum((wanted[first] - force) ** 2))

    from scipy.optimize import minimize_scalar

    places = np.linspace(-1.0, 1.0, PLACES)
    best = int(np.argmin([cost(place) for place in places.tolist()]))
    ends = float(places[max(best - 1, 0)]), float(places[min(best + 1, PLACES - 1)])
    found = minimize_scalar(cost, bounds=ends, method="bounded", options={"maxiter": FINER, "xatol": 1e-4})
    return float(found.x)


def _state(friction: Model, place: float) -> Any:
    return friction.component.start(place, friction.parameters)
