"""What gravity and cogging take along a motion, by the kernel that simulations and exported laws run: the same bits."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bristle.engine.compilation import compiled
from bristle.engine.signature import Vector
from bristle.plants.terms import Place, effort_at, gravity_at

__all__ = ["effort_along"]

# (both coefficients of gravity, angle of each wave over the position, cosines, sines, positions, efforts).
EffortAlong = Callable[[Vector, Vector, Vector, Vector, Vector, Vector], float]


def effort_entry(gravity, waves, cosines, sines, x, effort):
    """Write the effort at each position."""
    place = Place(gravity[0], gravity[1], waves, cosines, sines)
    for k in range(x.size):
        effort[k] = effort_at(x[k], place)
    return 0.0


def effort_along(x: np.ndarray, place: Place) -> np.ndarray:
    """Return the effort [N or N*m] that gravity and cogging take at some positions [m or rad], shape (sample,)."""
    effort = np.empty(x.size)
    entry = compiled("effort_along", lambda: effort_entry, EffortAlong, (effort_at, gravity_at))
    waves = (np.array(part, dtype=float) for part in (place.waves, place.cosines, place.sines))  # none is read-only
    entry(np.array([place.g_sin, place.g_cos]), *waves, np.array(x, dtype=float), effort)
    return effort
