"""Friction in continuous time, as an ordinary differential equation: which models have one, and its right-hand side."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.dispatch import friction_rate, friction_trial, plant_rate
from bristle.core.errors import InputError
from bristle.core.motion import Motion
from bristle.core.packing import pack, unpacker
from bristle.engine.instance import Instance
from bristle.friction import is_static

__all__ = ["axis_equations", "contact_equations"]

SAMPLED = 'Give dt, such as dt="0.5 ms": the sampled system takes the steps of bristle itself'

# From a state and an input [N, N*m or m/s, rad/s] the friction force [N or N*m] and the time derivative of the state.
Equations = Callable[[np.ndarray, float], tuple[float, np.ndarray]]


def axis_equations(plant: Model, friction: Model) -> Equations:
    """Return the equations of a plant with friction under an effort: the state is that of the plant, then of friction."""
    if plant.component.rate is None:
        raise InputError("has no rate, so it is no differential equation", path="plant", value=plant.name, mend=SAMPLED)
    body, contact, rate = Instance(plant), Instance(friction), _rate_of(friction)
    q, p, count = plant.parameters, friction.parameters, body.state.size
    load_plant, load_contact = unpacker(body.structures[1]), unpacker(contact.structures[1], count)

    def at(state: np.ndarray, effort: float) -> tuple[float, np.ndarray]:
        moved = load_plant(state)
        force, d_contact = rate(load_contact(state), Motion(moved.v, moved.x), p)
        return force, np.concatenate((pack(plant_rate(moved, effort, force, q)), pack(d_contact)))

    return at


def contact_equations(friction: Model) -> Equations:
    """Return the equations of friction under a velocity: the state is the position, then that of the friction."""
    contact, rate, p = Instance(friction), _rate_of(friction), friction.parameters
    load = unpacker(contact.structures[1], 1)

    def at(state: np.ndarray, velocity: float) -> tuple[float, np.ndarray]:
        force, d_contact = rate(load(state), Motion(velocity, float(state[0])), p)
        return force, np.concatenate(((velocity,), pack(d_contact)))

    return at


def _rate_of(friction: Model) -> Callable[..., Any]:
    """Return ``rate(state, motion, p) -> (force, d_state)`` of a friction model; refuse one that has none."""
    if friction.component.rate is not None:
        return friction_rate
    if not is_static(friction):
        if not friction.component.memory_size(friction.parameters):
            raise InputError(
                "has no `rate`, so it is no differential equation",
                path="friction",
                value=friction.name,
                mend=f"{SAMPLED}. A smooth model of your own may have `rate(state, motion, p) -> (force, d_state)`",
            )
        raise InputError(
            "remembers in jumps, where its motion turns or an element slips, so it is no differential equation",
            path="friction",
            value=friction.name,
            mend=SAMPLED,
        )
    forward, backward = (friction_trial((), (), Motion(v, 0.0), 0.0, friction.parameters)[0] for v in (0.0, -0.0))
    if forward != backward:
        raise InputError(
            "jumps at rest and holds with any force in between, so it is no differential equation",
            path="friction",
            value=friction.name,
            mend=SAMPLED,
        )
    return _static_rate


def _static_rate(state: Any, motion: Motion, p: Any) -> tuple[float, Any]:
    return friction_trial(state, (), motion, 0.0, p)[0], state
