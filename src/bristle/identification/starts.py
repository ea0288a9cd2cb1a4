"""Where a contact stood before its log began: found from the first samples, until it no longer matters."""

from __future__ import annotations

import numpy as np

from bristle.core.contracts import Model
from bristle.engine import force_along

__all__ = ["place_of", "started_force"]

PLACES = 11  # tried first, from one stop to the other
FINER = 14  # evaluations between the two neighbours of the best
ALIKE = 1e-9  # of the largest force: two runs that have become the same


def started_force(friction: Model, v: np.ndarray, dt: float, x: np.ndarray, target: np.ndarray | None) -> np.ndarray:
    """Return the friction force along a motion [N or N*m], begun where it fits best.

    Parameters
    ----------
    friction : Model
        A friction model; one without a `start` begins virgin.
    v, dt, x : ndarray, float, ndarray
        As `force_along` takes them.
    target : ndarray, shape (step,), or None
        The friction that was measured [N or N*m]; None where there is none to begin with.
    """
    if friction.component.start is None or target is None:
        return force_along(friction, v, dt, x)
    return force_along(friction, v, dt, x, state=_state(friction, place_of(friction, v, dt, x, target)))


def place_of(friction: Model, v: np.ndarray, dt: float, x: np.ndarray, target: np.ndarray) -> float:
    """Return where a contact stood at first, from -1, about to slip backward, to 1, about to slip forward."""
    low, high = (force_along(friction, v, dt, x, state=_state(friction, place)) for place in (-1.0, 1.0))
    apart = np.flatnonzero(np.abs(high - low) > ALIKE * max(float(np.max(np.abs(high))), 1e-300))
    if not apart.size:
        return 0.0
    # Beyond the last sample at which the two extremes differ, no start shows any more.
    first = slice(0, int(apart[-1]) + 1)
    wanted, along, at = target[first], v[first], x[first]

    def cost(place: float) -> float:
        force = force_along(friction, along, dt, at, state=_state(friction, place))
        return float(np.sum((wanted - force) ** 2))

    from scipy.optimize import minimize_scalar

    places = np.linspace(-1.0, 1.0, PLACES)
    best = int(np.argmin([cost(place) for place in places.tolist()]))
    ends = float(places[max(best - 1, 0)]), float(places[min(best + 1, PLACES - 1)])
    found = minimize_scalar(cost, bounds=ends, method="bounded", options={"maxiter": FINER, "xatol": 1e-4})
    return float(found.x)


def _state(friction: Model, place: float):
    return friction.component.start(place, friction.parameters)
