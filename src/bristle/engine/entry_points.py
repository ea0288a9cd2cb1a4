"""The entry points that run compiled: one component, or one plant with its friction.

Every entry takes vectors and numbers only, or tuples of them, so its signature does not depend on the model. An entry
that runs a component is made by a factory, once for each component: the closure holds how its vectors are laid out,
and the dispatch by type does the rest. A driver (`bristle.engine.drivers`) receives entries as first-class functions:
it is compiled once for everything, and the cost of compiling adds instead of multiplying.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from bristle.controllers.feedforward import Shape, compensate
from bristle.controllers.law import law
from bristle.core.contracts import NOMINAL_LOAD, NOMINAL_TEMPERATURE, Motion, Reference
from bristle.core.dispatch import friction_commit, friction_trial, operator_commit, operator_trial, sensor_step
from bristle.core.packing import Structure, motion_reader, packer, unpacker
from bristle.engine.mechanism import Mechanism, mechanism
from bristle.engine.signature import Vector

# Where substeps leave what they found, in the vector `out`: mean friction force [N or N*m], solves that failed in them,
# slope of the last solve per step [1/s] and mean acceleration (both read again by the next ones), solves that failed so
# far, effort of the drive [N or N*m] (read again); and what they are told: the error of the mean velocity that a solve
# may leave [m/s or rad/s], the time constant of the drive [s].
FORCE, FAILED, SLOPE, FAILED_SO_FAR, ACCELERATION, SLACK, DRIVE_EFFORT, DRIVE_LAG, OUT_SIZE = 0, 1, 2, 3, 4, 5, 6, 7, 8


class MechanismVectors(NamedTuple):
    """A plant with one friction model: parameters and states, its memory, and what it leaves in `out`."""

    plant: Vector
    plant_state: Vector
    friction: Vector
    friction_state: Vector
    memory: Vector
    out: Vector


# The kinds of entries: what each takes. Parameters, state and memory of a component are vectors that it unpacks itself.
# A friction model along a motion: (parameters, state, memory, v, x, surroundings one after the other, dt, force).
ForceAlong = Callable[[Vector, Vector, Vector, Vector, Vector, Vector, float, Vector], float]
# An operator along an input: (parameters, state, memory, u, w).
OutputAlong = Callable[[Vector, Vector, Vector, Vector, Vector], float]
# A plant with friction over some time: (vectors, effort, effort at the end, dt, steps).
Substeps = Callable[[MechanismVectors, float, float, float, int], float]
# A controller at one sample: (parameters, state, position, velocity, acceleration and effort of the reference,
# measured, injected, limit, dt).
Control = Callable[[Vector, Vector, float, float, float, float, float, float, float, float], float]
# Friction that is fed forward at one sample: (parameters, state, memory, shape, measured, transmitted, dt).
Compensate = Callable[[Vector, Vector, Vector, Vector, float, float, float], float]
# The same along a desired motion: (parameters, state, memory, shape, v, x, transmitted, dt, effort).
CompensateAlong = Callable[[Vector, Vector, Vector, Vector, Vector, Vector, Vector, float, Vector], float]
# A sensor at one sample: (parameters, state, x, dt).
Sense = Callable[[Vector, Vector, float, float], float]


def make_force_along(parameters: Structure, state: Structure, motion: Any = Motion) -> Callable[..., Any]:
    """Return the entry that runs one friction model along a prescribed motion, by the class of what it sees of it."""
    unpack, load, store = unpacker(parameters), unpacker(state), packer(state)
    moved = motion_reader(motion)

    def force_along(p_vector, state_vector, memory, v, x, around, dt, force):
        p = unpack(p_vector)
        s = load(state_vector)
        for k in range(v.size):
            force[k], move = friction_trial(s, memory, moved(v, x, around, k), dt, p)
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


def make_substeps(plant: Structure, plant_state: Structure, friction: Structure, friction_state: Structure) -> Any:
    """Return the entry that advances one plant with one friction model by a number of equal steps.

    ``out[FORCE]`` receives the mean friction force, ``out[FAILED]`` the number of solves that failed. ``out[SLOPE]``
    and ``out[ACCELERATION]`` keep where the next solve begins, whatever the length of its step: the slope of its
    residual over the length, and the acceleration. ``out[SLACK]`` is the error of the mean
    velocity that a solve may leave; ``out[FAILED_SO_FAR]`` is the drivers'.
    """
    unpack_plant, load_plant, store_plant = unpacker(plant), unpacker(plant_state), packer(plant_state)
    unpack_friction, load_friction = unpacker(friction), unpacker(friction_state)
    store_friction = packer(friction_state)

    def substeps(vectors, effort, effort_end, dt, steps):
        q, p, out = unpack_plant(vectors.plant), unpack_friction(vectors.friction), vectors.out
        before = Mechanism(
            load_plant(vectors.plant_state),
            load_friction(vectors.friction_state),
            out[DRIVE_EFFORT],
            out[SLOPE],
            out[ACCELERATION],
            0.0,
            0.0,
        )
        after = mechanism(before, vectors.memory, effort, effort_end, out[DRIVE_LAG], out[SLACK], dt, steps, q, p)
        store_plant(after.plant, vectors.plant_state)
        store_friction(after.friction, vectors.friction_state)
        out[FORCE], out[FAILED] = after.force, after.failures
        out[SLOPE], out[ACCELERATION], out[DRIVE_EFFORT] = after.slope, after.acceleration, after.effort
        return 0.0

    return substeps


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

    def compensate_at(p_vector, state_vector, memory, shape, measured, transmitted, dt):
        v = (measured - shape[5]) / dt
        effort, s = compensate(
            load(state_vector),
            memory,
            Motion(v, measured, NOMINAL_LOAD, NOMINAL_TEMPERATURE, transmitted),
            shape[6],
            dt,
            Shape(shape[0], shape[1], shape[2], shape[3], shape[4]),
            unpack(p_vector),
        )
        store(s, state_vector)
        shape[5], shape[6] = measured, effort
        return effort

    return compensate_at


def make_compensate_along(parameters: Structure, state: Structure) -> Callable[..., Any]:
    """Return the entry that runs one friction model along a desired motion, to be fed forward step by step.

    ``shape`` holds the fields of `Shape`.
    """
    unpack, load, store = unpacker(parameters), unpacker(state), packer(state)

    def compensate_along(p_vector, state_vector, memory, shape, v, x, transmitted, dt, effort):
        p, s = unpack(p_vector), load(state_vector)
        form = Shape(shape[0], shape[1], shape[2], shape[3], shape[4])
        before = 0.0
        for k in range(v.size):
            motion = Motion(v[k], x[k], NOMINAL_LOAD, NOMINAL_TEMPERATURE, transmitted[k])
            before, s = compensate(s, memory, motion, before, dt, form, p)
            effort[k] = before
        store(s, state_vector)
        return 0.0

    return compensate_along


def compensate_nothing(p_vector, state_vector, memory, shape, measured, transmitted, dt):
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
