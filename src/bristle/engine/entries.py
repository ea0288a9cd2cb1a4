"""The entry points that run compiled, and the drivers built on them.

Every entry takes flat vectors and scalars only, so its signature does not depend on the model. An entry that runs a
component is made by a factory, once for each component: the closure holds how its vectors are laid out, and the
dispatch by type does the rest. A driver (`open_loop`, `closed_loop`) receives entries as first-class
functions: it is compiled once for everything, and the cost of compiling adds instead of multiplying.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bristle.core.contracts import Motion, Reference
from bristle.core.dispatch import (
    controller_step,
    friction_commit,
    friction_trial,
    operator_commit,
    operator_trial,
    sensor_step,
)
from bristle.core.packing import Structure, packer, unpacker
from bristle.engine import semi_implicit
from bristle.engine.efim import Start, advance

# Where a burst leaves what it found, in the vector `out`: mean friction force [N or N*m], solves that failed in this
# burst, slope of the last solve per step [1/s] and mean acceleration (both read again by the next burst), solves
# that failed so far; and what it is told: the error of the mean velocity that a solve may leave [m/s or rad/s].
FORCE, FAILED, SLOPE, FAILED_SO_FAR, ACCELERATION, SLACK, OUT_SIZE = 0, 1, 2, 3, 4, 5, 6
# Rows of the flat history of a closed loop.
POSITION, VELOCITY, MEASURED, COMMAND, EFFORT, FRICTION, ROWS = 0, 1, 2, 3, 4, 5, 6
# Beyond this magnitude of position plus velocity a simulation has left the numbers worth following.
BOUND = 1e100

__all__ = [
    "closed_loop",
    "make_burst",
    "make_control",
    "make_force_along",
    "make_output_along",
    "make_sense",
    "open_loop",
]


def make_force_along(parameters: Structure, state: Structure) -> Callable[..., Any]:
    """Return the entry that runs one friction model along a prescribed motion."""
    unpack, load, store = unpacker(parameters), unpacker(state), packer(state)

    def force_along(p_vector, state_vector, memory, v, x, loads, temperatures, dt, force):
        p = unpack(p_vector)
        s = load(state_vector)
        for k in range(v.size):
            force[k], move = friction_trial(s, memory, Motion(v[k], x[k], loads[k], temperatures[k]), dt, p)
            s = friction_commit(s, memory, move, p)
        store(s, state_vector)
        return 0.0

    return force_along


def make_output_along(parameters: Structure, state: Structure) -> Callable[..., Any]:
    """Return the entry that runs one hysteresis operator along an input."""
    unpack, load, store = unpacker(parameters), unpacker(state), packer(state)

    def output_along(p_vector, state_vector, memory, u, w):
        p = unpack(p_vector)
        s = load(state_vector)
        for k in range(u.size):
            w[k], move = operator_trial(s, memory, u[k], p)
            s = operator_commit(s, memory, move, p)
        store(s, state_vector)
        return 0.0

    return output_along


def make_burst(plant: Structure, plant_state: Structure, friction: Structure, friction_state: Structure) -> Any:
    """Return the entry that advances one plant with one friction model by a number of equal steps.

    ``out[FORCE]`` receives the mean friction force, ``out[FAILED]`` the number of solves that failed. ``out[SLOPE]``
    and ``out[ACCELERATION]`` keep where the next solve begins, whatever the length of its step: the slope of its
    residual over the length, and the acceleration. ``out[SLACK]`` is the error of the mean
    velocity that a solve may leave; ``out[FAILED_SO_FAR]`` is the drivers'.
    """
    unpack_plant, load_plant, store_plant = unpacker(plant), unpacker(plant_state), packer(plant_state)
    unpack_friction, load_friction, store_friction = (
        unpacker(friction),
        unpacker(friction_state),
        packer(friction_state),
    )

    def burst(q_vector, plant_vector, p_vector, state_vector, memory, effort, effort_end, dt, steps, out):
        q, body = unpack_plant(q_vector), load_plant(plant_vector)
        p, s = unpack_friction(p_vector), load_friction(state_vector)
        h = dt / steps
        slope, acceleration, slack = 1.0 + out[SLOPE] * h, out[ACCELERATION], out[SLACK]
        total, failures = 0.0, 0.0
        for i in range(steps):
            u = effort + (effort_end - effort) * ((i + 0.5) / steps)
            guess = 0.0 if body.v == 0.0 else body.v + 0.5 * h * acceleration
            done = advance(body, s, memory, u, h, q, p, Start(guess, slope, slack))
            body, s, slope = done.plant_state, done.friction_state, done.slope
            acceleration = 2.0 * (body.v - done.v_mean) / h
            total += done.force
            failures += done.failures
        store_plant(body, plant_vector)
        store_friction(s, state_vector)
        out[FORCE], out[FAILED] = total / steps, failures
        out[SLOPE], out[ACCELERATION] = (slope - 1.0) / h, acceleration
        return 0.0

    return burst


def make_semi_implicit_burst(
    plant: Structure, plant_state: Structure, friction: Structure, friction_state: Structure
) -> Callable[..., Any]:
    """Return the entry that advances one plant with one friction model by the semi-implicit step."""
    unpack_plant, load_plant, store_plant = unpacker(plant), unpacker(plant_state), packer(plant_state)
    unpack_friction, load_friction = unpacker(friction), unpacker(friction_state)
    store_friction = packer(friction_state)

    def burst(q_vector, plant_vector, p_vector, state_vector, memory, effort, effort_end, dt, steps, out):
        q, body = unpack_plant(q_vector), load_plant(plant_vector)
        p, s = unpack_friction(p_vector), load_friction(state_vector)
        h = dt / steps
        total = 0.0
        for i in range(steps):
            u = effort + (effort_end - effort) * ((i + 0.5) / steps)
            done = semi_implicit.advance(body, s, memory, u, h, q, p)
            body, s = done.plant_state, done.friction_state
            total += done.force
        store_plant(body, plant_vector)
        store_friction(s, state_vector)
        out[FORCE], out[FAILED] = total / steps, 0.0
        return 0.0

    return burst


def make_control(parameters: Structure, state: Structure) -> Callable[..., Any]:
    """Return the entry that computes the effort of one controller at one sample."""
    unpack, load, store = unpacker(parameters), unpacker(state), packer(state)

    def control(p_vector, state_vector, position, velocity, acceleration, effort, measured, dt):
        s = load(state_vector)
        reference = Reference(position, velocity, acceleration, effort)
        u, s = controller_step(s, reference, measured, dt, unpack(p_vector))
        store(s, state_vector)
        return u

    return control


def make_sense(parameters: Structure, state: Structure) -> Callable[..., Any]:
    """Return the entry that reads one sensor at one sample."""
    unpack, load, store = unpacker(parameters), unpacker(state), packer(state)

    def sense(p_vector, state_vector, x, dt):
        measured, s = sensor_step(load(state_vector), x, dt, unpack(p_vector))
        store(s, state_vector)
        return measured

    return sense


def open_loop(burst, q, plant, p, state, memory, effort, effort_end, dt, steps, x, v, force, out):
    """Drive a plant by a recorded effort; return the number of samples that stayed finite.

    ``x``, ``v`` [k] are those at the instant of sample k, ``force`` [k] is the mean friction force until the next.
    """
    for k in range(effort.size):
        x[k], v[k] = plant[0], plant[1]
        burst(q, plant, p, state, memory, effort[k], effort_end[k], dt, steps, out)
        force[k] = out[FORCE]
        out[FAILED_SO_FAR] += out[FAILED]
        if not abs(plant[0]) + abs(plant[1]) < BOUND:
            return k + 1
    return effort.size


def closed_loop(
    control, c, control_state, sense, m, sense_state, burst, q, plant, p, state, memory,
    reference, injected, disturbance, limit, delay, effort_before, dt, steps, history, out,
):  # fmt: skip
    """Run a sampled loop; return the number of samples that stayed finite.

    `reference` is flat, [position | velocity | acceleration | effort] of all samples; `history` is flat, and receives
    [x | v | measured | commanded effort | applied effort | mean friction force until the next sample]. The effort
    computed at sample k acts from sample ``k + delay`` on, held until the next one; before, `effort_before` acts.
    """
    count = injected.size
    for k in range(count):
        measured = sense(m, sense_state, plant[0], dt)
        u = control(
            c, control_state, reference[k], reference[count + k], reference[2 * count + k],
            reference[3 * count + k], measured, dt,
        )  # fmt: skip
        command = max(-limit, min(limit, u + injected[k]))
        history[POSITION * count + k], history[VELOCITY * count + k] = plant[0], plant[1]
        history[MEASURED * count + k], history[COMMAND * count + k] = measured, command
        applied = history[COMMAND * count + k - delay] if k >= delay else effort_before
        history[EFFORT * count + k] = applied
        driven = applied - disturbance[k]
        burst(q, plant, p, state, memory, driven, driven, dt, steps, out)
        history[FRICTION * count + k] = out[FORCE]
        out[FAILED_SO_FAR] += out[FAILED]
        if not abs(plant[0]) + abs(plant[1]) < BOUND:
            return k + 1
    return count
