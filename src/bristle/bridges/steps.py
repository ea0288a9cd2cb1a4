"""Friction in samples: the steps of the engine, with all that is remembered in one vector."""

from __future__ import annotations

import copy
from collections.abc import Callable

import numpy as np

from bristle.core.contracts import Model
from bristle.engine.entry_points import ACCELERATION, FORCE, OUT_SIZE, SLOPE, MechanismVectors
from bristle.engine.instance import Instance, warn_of_lost
from bristle.engine.loop import substeps_entry
from bristle.engine.motion import force_along_entry

__all__ = ["SOLVER", "axis_step", "contact_step"]

SOLVER = {"solver_slope": "1/s", "solver_acceleration": ""}
"""Where the solve of the next step begins; without it the last bits would differ. The unit is that of the axis."""

# From a state and an input [N, N*m or m/s, rad/s] the mean friction force of the step [N or N*m] and the next state,
# which is written over the first one.
Step = Callable[[np.ndarray, float], tuple[float, np.ndarray]]


def axis_step(plant: Model, friction: Model, dt: float, steps: int) -> Step:
    """Return one sample of a plant with friction under an effort that is held.

    The state is that of the plant, that of the friction, its memory, and what `SOLVER` names.
    """
    body, contact = Instance(plant), Instance(friction)
    memory_size = friction.component.memory_size(friction.parameters)
    cuts = np.cumsum((body.state.size, contact.state.size, memory_size))
    entry = substeps_entry(body, contact, "efim")

    def step(state: np.ndarray, effort: float) -> tuple[float, np.ndarray]:
        plant_state, friction_state, memory, solver = np.split(state, cuts)
        out = np.zeros(OUT_SIZE)
        out[SLOPE], out[ACCELERATION] = solver
        vectors = MechanismVectors(body.parameters, plant_state, contact.parameters, friction_state, memory, out)
        entry(vectors, effort, effort, dt, steps)
        solver[:] = out[SLOPE], out[ACCELERATION]
        _warn_where_memory_was_full(contact, friction_state)
        return float(out[FORCE]), state

    return step


def contact_step(friction: Model, dt: float) -> Step:
    """Return one sample of friction under a velocity: the state is the position, that of the friction, its memory."""
    contact = Instance(friction)
    cuts = np.cumsum((1, contact.state.size))
    entry = force_along_entry(contact)
    around = np.array(list(contact.motion._field_defaults.values()), dtype=float)

    def step(state: np.ndarray, velocity: float) -> tuple[float, np.ndarray]:
        position, friction_state, memory = np.split(state, cuts)
        position += velocity * dt
        v, force = np.full(1, velocity), np.empty(1)
        entry(contact.parameters, friction_state, memory, v, position, around, dt, force)
        _warn_where_memory_was_full(contact, friction_state)
        return float(force[0]), state

    return step


def _warn_where_memory_was_full(contact: Instance, friction_state: np.ndarray) -> None:
    after = copy.copy(contact)
    after.state = friction_state
    warn_of_lost(after)
