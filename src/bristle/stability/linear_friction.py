r"""Friction as a loop feels it at one working point: a spring and a damper, :math:`F = k\,x + c\,v`.

Stuck, before it breaks away, friction is a stiff spring with a little damping; in sliding it is the slope of the
steady curve, which is negative where friction falls with velocity. Both are measured on the model itself.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bristle.core.contracts import Model, Motion
from bristle.engine.checks import finite
from bristle.engine.steady import steady_force

__all__ = ["NO_FRICTION", "LinearFriction", "slope_in_sliding", "stiffness_at_rest"]

MOVE = 1e-12  # far below every break-away distance [m or rad]
ALIKE = 1e-3  # relative difference of two slopes that are the same one
ROUNDING = 1e-9  # share of a slope below which it is none
APART = 0.05  # relative distance of the two velocities that a slope is taken between


class LinearFriction(NamedTuple):
    """A spring `k` [N/m or N*m/rad] and a damper `c` [N*s/m or N*m*s/rad] between the port and the ground."""

    k: float = 0.0
    c: float = 0.0


NO_FRICTION = LinearFriction()


def stiffness_at_rest(friction: Model, dt: float) -> LinearFriction | None:
    """Return the friction of an axis that is stuck, at small motions about where it rests."""
    slow, fast = (_slope(friction, MOVE, time) for time in (dt, 0.1 * dt))
    if abs(_slope(friction, 0.1 * MOVE, dt) - slow) > ALIKE * abs(slow):
        return None
    # Over a move of length d in a time T the mean force is k d/2 + c d/T.
    c = (fast - slow) * dt / 9.0
    k = 2.0 * (slow - c / dt)
    return LinearFriction(k if k > ROUNDING * slow else 0.0, c)


def _slope(friction: Model, move: float, time: float) -> float:
    """Return the mean force of a first move over its length, the mean of both directions."""
    component, p = friction.component, friction.parameters
    forces = []
    for way in (move, -move):
        state, memory = component.initial_state(p), component.new_memory(p)
        force, _ = component.trial(state, memory, Motion(way / time, way), time, p)
        forces.append(force)
    finite(np.array(forces), friction)
    return (forces[0] - forces[1]) / (2.0 * move)


def slope_in_sliding(friction: Model, speed: float) -> LinearFriction:
    """Return the friction of an axis that slides at a constant `speed` [m/s or rad/s], the mean of both directions."""
    fast, slow = (1.0 + APART) * speed, (1.0 - APART) * speed
    forces = [steady_force(friction, v) - steady_force(friction, -v) for v in (fast, slow)]
    return LinearFriction(0.0, 0.5 * (forces[0] - forces[1]) / (fast - slow))
