"""The moves along which an export is judged: from rest to rest, inside and outside pre-sliding."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bristle.core import Axis, Model, Motion
from bristle.engine.contact import sliding_level
from bristle.exports.described import Request
from bristle.models.references.legs import legs_through
from bristle.prediction.claims import FASTEST
from bristle.prediction.drive_table import reversal_distance
from bristle.simulation.two_masses import whole_inertia

# Distances of the moves over the reach, or over the pre-sliding distance.
TIMES = (1.0, 3.0, 10.0, 30.0)
# Pre-sliding distance if neither model nor axis file has one.
ASSUMED = {"translational": 1e-5, "rotational": 2e-4}
SIGNS = (1.0, 1.0, -1.0, -1.0, 1.0, -1.0)  # of the moves
SHORTEST = 0.1  # duration of a quick move [s]
SAMPLES = 1500  # of a move over 30 pre-sliding distances at full speed, at most
HARDENED = 2.0  # Stiffness of a hardened contact over its smallest stiffness before


class Limits(NamedTuple):
    """Limits of the moves: largest velocity, acceleration and jerk, in SI units of the axis."""

    velocity: float
    acceleration: float
    jerk: float = math.inf


def moves_for(request: Request, reach: float = 0.0) -> tuple[np.ndarray, float, float]:
    """Return positions of moves inside and outside pre-sliding and at full speed [m or rad], time step [s] and largest speed.

    With a `reach` [m or rad], no position is farther from the start.
    """
    fastest = fastest_of(request)
    distance = 0.5 * reach / TIMES[-1] or turning_distance(request.model, request.axis, fastest)[0]
    dt = max(0.005 * SHORTEST, TIMES[-1] * distance / fastest / SAMPLES)
    distances = [times * distance for times in TIMES]
    if not reach:
        distances.append(max(SHORTEST * fastest, TIMES[-1] * distance))
    return (
        np.concatenate(
            [moves_over(way, Limits(fastest, fastest / SHORTEST), dt) for way in distances]
        ),
        dt,
        fastest,
    )


def fastest_of(request: Request) -> float:
    """Return the largest speed of the axis [m/s or rad/s]."""
    return request.speed or (request.axis and request.axis.velocity_limit) or FASTEST


def hardening_distance(model: Model, fastest: float) -> float:
    """Return the distance at which a virgin contact has hardened, 1 m or rad at most [m or rad]."""
    component = model.component
    p = model.parameters
    speed = 1e-3 * fastest
    state = component.initial_state(p)
    memory = component.new_memory(p)
    at = 0.0
    least = math.inf
    for x in np.geomspace(1e-9, 1.0, 200).tolist():
        force, move = component.trial(state, memory, Motion(speed, x), (x - at) / speed, p)
        stiffness = abs(force) / (0.5 * (at + x))  # the force is that in the middle of the step
        if not stiffness <= HARDENED * least:
            break
        state = component.commit(state, memory, move, p)
        at = x
        least = min(least, stiffness)
    return at


def moves_over(distance: float, limits: Limits, dt: float, lasting: float = SHORTEST) -> np.ndarray:
    """Return positions of the moves from 0: forward twice, back twice, forward, back, each with a dwell after it [m or rad].

    A move takes `lasting` [s], or longer because of the limits.
    """
    return series_over(distance, limits, dt, SIGNS, rest=0.2, lasting=lasting)[0]


def series_over(
    distance: float,
    limits: Limits,
    dt: float,
    signs: Sequence[float] | np.ndarray,
    *,
    rest: float,
    lasting: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return positions of moves with some signs from 0, each with a `rest` [s] after it, and the first sample of each move.

    A move takes `lasting` [s], or longer because of the limits; with 0, it is as quick as they allow.
    """
    jerk = limits.jerk
    if lasting:
        jerk = min(limits.jerk, 32.0 * distance / lasting**3)
    leg = legs_through((distance,), limits.velocity, limits.acceleration, jerk)
    inside = leg.sample(dt * np.arange(1, math.ceil(leg.end / dt) + 1))[0]
    move = np.concatenate([inside, np.full(math.ceil(rest / dt), distance)])
    ends = distance * np.cumsum([0.0, *signs])
    before = np.zeros(math.ceil(0.1 / dt))
    moves = [end + sign * move for end, sign in zip(ends[:-1], signs, strict=True)]
    return np.concatenate([before, *moves]), before.size + move.size * np.arange(ends.size)


def turning_distance(model: Model, axis: Axis | None, fastest: float) -> tuple[float, float]:
    """Return the pre-sliding distance and the part of it that is an assumption, all or nothing [m or rad]."""
    distance = reversal_distance(model, fastest) or (axis and axis.presliding)
    if distance:
        return (distance, 0.0)
    return (ASSUMED[model.kind], ASSUMED[model.kind])


def moved_by(plant: Model | None) -> float:
    """Return the mass or inertia of a plant, at the motor of a screw [kg or kg*m^2]; 0 without a plant."""
    if plant is None:
        return 0.0
    if plant.component.screw is not None:
        return whole_inertia(plant, plant.component.screw(plant.parameters), SHORTEST)
    return plant.values.get("M", 0.0)


def limits_within(
    friction: Model, plant: Model | None, fastest: float, axis: Axis | None
) -> Limits:
    """Return the limits of an axis; without a stated acceleration, its effort is that of sliding friction.

    If the mass is unknown, too, the axis reaches full speed in 0.1 s.
    """
    mass = moved_by(plant)
    stated = axis or Axis()
    if mass:
        acceleration = sliding_level(friction, fastest) / mass
    else:
        acceleration = fastest / SHORTEST
    return Limits(
        min(fastest, stated.velocity_limit or math.inf),
        stated.acceleration_limit or acceleration,
        stated.jerk_limit or math.inf,
    )
