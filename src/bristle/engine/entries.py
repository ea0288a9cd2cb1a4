"""The entry points that run compiled, and the drivers built on them.

Every entry takes flat vectors and scalars only, so its signature does not depend on the model. An entry that runs a
component is made by a factory, once for each component: the closure holds how its vectors are laid out, and the
dispatch by type does the rest. A driver (`open_loop`, `closed_loop`) receives entries as first-class
functions: it is compiled once for everything, and the cost of compiling adds instead of multiplying.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bristle.controllers.feedforward import Shape, compensate
from bristle.controllers.law import law
from bristle.core.borrowed import borrowed
from bristle.core.contracts import NOMINAL_LOAD, NOMINAL_TEMPERATURE, Motion, Reference
from bristle.core.dispatch import (
    friction_commit,
    friction_trial,
    operator_commit,
    operator_trial,
    sensor_step,
)
from bristle.core.kernel import kernel
from bristle.core.packing import Structure, packer, unpacker
from bristle.engine import semi_implicit
from bristle.engine.mechanism import Mechanism, drive_over, mechanism

# Where a burst leaves what it found, in the vector `out`: mean friction force [N or N*m], solves that failed in this
# burst, slope of the last solve per step [1/s] and mean acceleration (both read again by the next burst), solves
# that failed so far, effort of the drive [N or N*m] (read again); and what it is told: the error of the mean velocity
# that a solve may leave [m/s or rad/s], the time constant of the drive [s].
FORCE, FAILED, SLOPE, FAILED_SO_FAR, ACCELERATION, SLACK, DRIVE_EFFORT, DRIVE_LAG, OUT_SIZE = 0, 1, 2, 3, 4, 5, 6, 7, 8
# Rows of the flat history of a closed loop.
POSITION, VELOCITY, MEASURED, COMMAND, EFFORT, FRICTION = 0, 1, 2, 3, 4, 5
MOTOR_POSITION, MOTOR_VELOCITY, FED, ROWS = 6, 7, 8, 9
# Beyond this magnitude of position plus velocity a simulation has left the numbers worth following.
BOUND = 1e100

__all__ = [
    "closed_loop",
    "compensate_nothing",
    "make_burst",
    "make_compensate",
    "make_compensate_along",
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
        p, memory = unpack(p_vector), borrowed(memory)
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
        q, p, memory = unpack_plant(q_vector), unpack_friction(p_vector), borrowed(memory)
        before = Mechanism(
            load_plant(plant_vector), load_friction(state_vector), out[DRIVE_EFFORT], out[SLOPE], out[ACCELERATION],
            0.0, 0.0,
        )  # fmt: skip
        after = mechanism(before, memory, effort, effort_end, out[DRIVE_LAG], out[SLACK], dt, steps, q, p)
        store_plant(after.plant, plant_vector)
        store_friction(after.friction, state_vector)
        out[FORCE], out[FAILED] = after.force, after.failures
        out[SLOPE], out[ACCELERATION], out[DRIVE_EFFORT] = after.slope, after.acceleration, after.effort
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
        p, s, memory = unpack_friction(p_vector), load_friction(state_vector), borrowed(memory)
        h = dt / steps
        drive = drive_over(h, out[DRIVE_EFFORT], out[DRIVE_LAG])
        given = drive.effort
        total = 0.0
        for i in range(steps):
            command = effort + (effort_end - effort) * ((i + 0.5) / steps)
            u = command + drive.in_mean * (given - command)
            given = command + drive.at_end * (given - command)
            done = semi_implicit.advance(body, s, memory, u, h, q, p)
            body, s = done.plant_state, done.friction_state
            total += done.force
        store_plant(body, plant_vector)
        store_friction(s, state_vector)
        out[FORCE], out[FAILED], out[DRIVE_EFFORT] = total / steps, 0.0, given
        return 0.0

    return burst


def make_control(parameters: Structure, state: Structure) -> Callable[..., Any]:
    """Return the entry that computes what one controller commands at one sample."""
    unpack, load, store = unpacker(parameters), unpacker(state), packer(state)

    def control(p_vector, state_vector, position, velocity, acceleration, effort, measured, injected, limit, dt):
        reference = Reference(position, velocity, acceleration, effort)
        command, s = law(load(state_vector), reference, measured, injected, limit, dt, unpack(p_vector))
        store(s, state_vector)
        return command

    return control


def make_compensate(parameters: Structure, state: Structure) -> Callable[..., Any]:
    """Return the entry that runs one friction model along the measured motion, to be fed forward at one sample.

    ``shape`` holds the fields of `Shape`, and what the entry keeps from sample to sample: the position measured [m or
    rad] and the effort fed forward [N or N*m].
    """
    unpack, load, store = unpacker(parameters), unpacker(state), packer(state)

    def compensate_at(p_vector, state_vector, memory, shape, measured, dt):
        v = (measured - shape[5]) / dt
        effort, s = compensate(
            load(state_vector), borrowed(memory), Motion(v, measured, NOMINAL_LOAD, NOMINAL_TEMPERATURE), shape[6], dt,
            Shape(shape[0], shape[1], shape[2], shape[3], shape[4]), unpack(p_vector),
        )  # fmt: skip
        store(s, state_vector)
        shape[5], shape[6] = measured, effort
        return effort

    return compensate_at


def make_compensate_along(parameters: Structure, state: Structure) -> Callable[..., Any]:
    """Return the entry that runs one friction model along a desired motion, to be fed forward step by step.

    ``shape`` holds the fields of `Shape`.
    """
    unpack, load, store = unpacker(parameters), unpacker(state), packer(state)

    def compensate_along(p_vector, state_vector, memory, shape, v, x, dt, effort):
        p, s, memory = unpack(p_vector), load(state_vector), borrowed(memory)
        form = Shape(shape[0], shape[1], shape[2], shape[3], shape[4])
        before = 0.0
        for k in range(v.size):
            motion = Motion(v[k], x[k], NOMINAL_LOAD, NOMINAL_TEMPERATURE)
            before, s = compensate(s, memory, motion, before, dt, form, p)
            effort[k] = before
        store(s, state_vector)
        return 0.0

    return compensate_along


def compensate_nothing(p_vector, state_vector, memory, shape, measured, dt):
    """Feed nothing forward."""
    return 0.0


def make_sense(parameters: Structure, state: Structure) -> Callable[..., Any]:
    """Return the entry that reads one sensor at one sample."""
    unpack, load, store = unpacker(parameters), unpacker(state), packer(state)

    def sense(p_vector, state_vector, x, dt):
        measured, s = sensor_step(load(state_vector), x, dt, unpack(p_vector))
        store(s, state_vector)
        return measured

    return sense


def open_loop(burst, q, plant, p, state, memory, load, effort, effort_end, dt, steps, history, out):
    """Drive a plant by a recorded effort; return the number of samples that stayed finite.

    `load` begins with position and velocity of what the axis moves: `plant` itself, where that is one mass. `history`
    is as in `closed_loop`, without what a controller measures and commands.
    """
    count = effort.size
    for k in range(count):
        record(history, count, k, load, plant)
        history[EFFORT * count + k] = effort[k]
        burst(q, plant, p, state, memory, effort[k], effort_end[k], dt, steps, out)
        history[FRICTION * count + k] = out[FORCE]
        out[FAILED_SO_FAR] += out[FAILED]
        if not abs(plant[0]) + abs(plant[1]) < BOUND:
            return k + 1
    return count


@kernel
def record(history, count, k, load, plant):
    """Write where load and motor are at sample `k`."""
    history[POSITION * count + k], history[VELOCITY * count + k] = load[0], load[1]
    history[MOTOR_POSITION * count + k], history[MOTOR_VELOCITY * count + k] = plant[0], plant[1]


def closed_loop(
    control, c, control_state, compensate, f, f_state, f_memory, shape, sense, m, sense_state,
    burst, q, plant, p, state, memory, load, seen,
    reference, injected, disturbance, limit, delay, effort_before, dt, steps, history, out,
):  # fmt: skip
    """Run a sampled loop; return the number of samples that stayed finite.

    `reference` is flat, [position | velocity | acceleration | effort] of all samples; `history` is flat, and receives
    [x | v | measured | commanded effort | applied effort | mean friction force until the next sample | x | v of the
    motor | effort fed forward along the measured motion]. `load` begins with position and velocity of what the axis
    moves, `seen` with the position that the sensor reads. The effort computed at sample k acts from sample
    ``k + delay`` on, held until the next one; before, `effort_before` acts.
    """
    count = injected.size
    for k in range(count):
        measured = sense(m, sense_state, seen[0], dt)
        fed = compensate(f, f_state, f_memory, shape, measured, dt)
        command = control(
            c, control_state, reference[k], reference[count + k], reference[2 * count + k],
            reference[3 * count + k] + fed, measured, injected[k], limit, dt,
        )  # fmt: skip
        record(history, count, k, load, plant)
        history[MEASURED * count + k], history[COMMAND * count + k] = measured, command
        applied = history[COMMAND * count + k - delay] if k >= delay else effort_before
        history[EFFORT * count + k], history[FED * count + k] = applied, fed
        driven = applied - disturbance[k]
        burst(q, plant, p, state, memory, driven, driven, dt, steps, out)
        history[FRICTION * count + k] = out[FORCE]
        out[FAILED_SO_FAR] += out[FAILED]
        if not abs(plant[0]) + abs(plant[1]) < BOUND:
            return k + 1
    return count
