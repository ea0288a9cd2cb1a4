"""Friction at a constant velocity, once it has settled."""

from __future__ import annotations

import math

import numpy as np

from bristle.core.contracts import Model, Motion
from bristle.engine.checks import finite
from bristle.friction import unvaried

__all__ = ["steady_force"]

STEPS_MAX = 200
SETTLED = 1e-12
FAR = 1.0  # [m or rad]


def steady_force(model: Model, v: float) -> float:
    """Return the force [N or N*m] that a friction model settles to at a constant velocity `v` [m/s or rad/s].

    The model itself is run, over steps that grow until each goes further than a metre, and the force no longer changes;
    one that varies along the axis as it is in the middle.
    """
    component, p = model.component, unvaried(model).parameters
    state, memory = component.initial_state(p), component.new_memory(p)
    dt, x, force, before = 1e-6, 0.0, math.nan, math.nan
    for _ in range(STEPS_MAX):
        x += v * dt
        force, move = component.trial(state, memory, Motion(v, x), dt, p)
        state = component.commit(state, memory, move, p)
        if not (state or memory.size):
            break
        far = abs(v) * dt > FAR
        if far and abs(force - before) <= SETTLED * abs(force):
            break
        # Much longer steps drown the stretch of a contact in rounding.
        before, dt = force, dt if far else 1.5 * dt
    return float(finite(np.array([force]), model)[0])
