"""What only a model with memory knows of a drive's compensation: how far a reversal goes before friction has turned."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from bristle.core.contracts import Model, Motion
from bristle.friction import unvaried

__all__ = ["SETTLED_SHARE", "reversal_distance"]

SETTLED_SHARE = 0.95
"""Of the change after a reversal: friction has turned."""
FINEST, FARTHEST, PACES = 1e-9, 1e-1, 160  # of the way after a reversal [m or rad]
SLOW = 1e-3  # of the largest speed
DISTANCES = 16  # to be remembered: a report asks for the same one again and again


@lru_cache(maxsize=DISTANCES)
def reversal_distance(model: Model, fastest: float) -> float:
    """Return over which distance after a reversal the force changes by 95 % of the change [m or rad]."""
    component, p, speed = model.component, unvaried(model).parameters, SLOW * fastest
    state, memory = component.initial_state(p), component.new_memory(p)
    far = np.geomspace(FINEST, FARTHEST, PACES)
    way = np.diff(np.concatenate([[0.0], far])).tolist()
    x, before = 0.0, 0.0
    forces: list[float] = []
    for direction in (-1.0, 1.0):
        before = forces[-1] if forces else 0.0
        forces = []
        for pace in way:
            x += direction * pace
            force, move = component.trial(state, memory, Motion(direction * speed, x), pace / speed, p)
            state = component.commit(state, memory, move, p)
            forces.append(force)
    change = np.array(forces) - before
    enough = SETTLED_SHARE * change[-1]
    first = int(np.argmax(change >= enough))
    return float(np.interp(enough, change[first - 1 : first + 1], far[first - 1 : first + 1])) if first > 0 else 0.0
