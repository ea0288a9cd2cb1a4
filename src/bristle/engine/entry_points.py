"""The entry points that run compiled: one component, or one plant with its friction.

The arguments of every entry are vectors, numbers, or tuples of these, so that its signature does not depend on the
model. A factory creates the entry of each component: the closure contains the layout of its vectors, and the dispatch by
type selects the kernels. A driver (`bristle.engine.drivers`) receives entries as first-class functions. It is compiled
once for all components, so that compile times add and do not multiply.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from bristle.core.contracts import NOMINAL_LOAD, NOMINAL_TEMPERATURE, Motion, Reference
from bristle.core.dispatch import (
    friction_commit,
    friction_trial,
    operator_commit,
    operator_trial,
    sensor_step,
)
from bristle.core.packing import Structure, motion_reader, packer, unpacker
from bristle.engine.mechanism import Mechanism, mechanism
from bristle.engine.signature import Vector
from bristle.models.controllers.feedforward import FIELDS, compensate, form_of
from bristle.models.controllers.law import law

# Indices of the vector `out` of substeps. Results: mean friction force [N or N*m], failed solves in these steps, slope of
# the last solve per step [1/s] and mean acceleration (both are inputs of the next steps), failed solves so far, effort of
# the drive [N or N*m] (also an input). Inputs: allowed error of the mean velocity in a solve [m/s or rad/s], time
# constant of the drive [s].
FORCE, FAILED, SLOPE, FAILED_SO_FAR, ACCELERATION, SLACK, DRIVE_EFFORT, DRIVE_LAG, OUT_SIZE = (
    0,
    1,
    2,
    3,
    4,
    5,
    6,
    7,
    8,
)


class MechanismVectors(NamedTuple):
    """A plant with one friction model: parameters and states, its memory, and its results in `out`."""

    plant: Vector
    plant_state: Vector
    friction: Vector
    friction_state: Vector
    memory: Vector
    out: Vector


# The kinds of entries and their arguments. Parameters, state and memory of a component are vectors that it unpacks.
# A friction model along a motion: (parameters, state, memory, v, x, consecutive surroundings, dt, force).
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
CompensateAlong = Callable[
    [Vector, Vector, Vector, Vector, Vector, Vector, Vector, float, Vector], float
]
# A sensor at one sample: (parameters, state, x, dt).
Sense = Callable[[Vector, Vector, float, float], float]


def make_force_along(
    parameters: Structure, state: Structure, motion: Any = Motion
) -> Callable[..., Any]:
    """Return the entry that runs one friction model along a prescribed motion of the class `motion`."""
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


def make_substeps(
    plant: Structure, plant_state: Structure, friction: Structure, friction_state: Structure
) -> Any:
    """Return the entry that advances one plant with one friction model by a number of equal steps.

    ``out[FORCE]`` receives the mean friction force, ``out[FAILED]`` the number of failed solves. ``out[SLOPE]`` and
    ``out[ACCELERATION]`` store the start values of the next solve, independent of its step length: the slope of the
    residual divided by the length, and the acceleration. ``out[SLACK]`` is the allowed error of the mean velocity in a
    solve; ``out[FAILED_SO_FAR]`` belongs to the drivers.
    """
    unpack_plant, load_plant, store_plant = (
        unpacker(plant),
        unpacker(plant_state),
        packer(plant_state),
    )
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
        after = mechanism(
            before, vectors.memory, effort, effort_end, out[DRIVE_LAG], out[SLACK], dt, steps, q, p
        )
        store_plant(after.plant, vectors.plant_state)
        store_friction(after.friction, vectors.friction_state)
        out[FORCE], out[FAILED] = after.force, after.failures
        out[SLOPE], out[ACCELERATION], out[DRIVE_EFFORT] = (
            after.slope,
            after.acceleration,
            after.effort,
        )
        return 0.0

    return substeps


def make_control(parameters: Structure, state: Structure) -> Callable[..., Any]:
    """Return the entry that computes the command of one controller at one sample."""
    unpack, load, store = unpacker(parameters), unpacker(state), packer(state)

    def control(
        p_vector,
        state_vector,
        position,
        velocity,
        acceleration,
        effort,
        measured,
        injected,
        limit,
        dt,
    ):
        reference = Reference(position, velocity, acceleration, effort)
        command, s = law(
            load(state_vector), reference, measured, injected, limit, dt, unpack(p_vector)
        )
        store(s, state_vector)
        return command

    return control


def make_compensate(parameters: Structure, state: Structure) -> Callable[..., Any]:
    """Return the entry that runs one friction model along the measured motion, to be fed forward at one sample.

    ``shape`` contains the fields of `Shape` and the state of the entry: the last measured position [m or rad], the last
    share, and the last effort fed forward [N or N*m].
    """
    unpack, load, store = unpacker(parameters), unpacker(state), packer(state)

    def compensate_at(p_vector, state_vector, memory, shape, measured, transmitted, dt):
        v = (measured - shape[FIELDS]) / dt
        effort, share, s = compensate(
            load(state_vector),
            memory,
            Motion(v, measured, NOMINAL_LOAD, NOMINAL_TEMPERATURE, transmitted),
            shape[FIELDS + 1],
            shape[FIELDS + 2],
            dt,
            form_of(shape),
            unpack(p_vector),
        )
        store(s, state_vector)
        shape[FIELDS], shape[FIELDS + 1], shape[FIELDS + 2] = measured, share, effort
        return effort

    return compensate_at


def make_compensate_along(parameters: Structure, state: Structure) -> Callable[..., Any]:
    """Return the entry that runs one friction model along a desired motion, to be fed forward step by step.

    ``shape`` contains the fields of `Shape`.
    """
    unpack, load, store = unpacker(parameters), unpacker(state), packer(state)

    def compensate_along(p_vector, state_vector, memory, shape, v, x, transmitted, dt, effort):
        p, s = unpack(p_vector), load(state_vector)
        form = form_of(shape)
        share, before = 0.0, 0.0
        for k in range(v.size):
            motion = Motion(v[k], x[k], NOMINAL_LOAD, NOMINAL_TEMPERATURE, transmitted[k])
            before, share, s = compensate(s, memory, motion, share, before, dt, form, p)
            effort[k] = before
        store(s, state_vector)
        return 0.0

    return compensate_along


def compensate_nothing(p_vector, state_vector, memory, shape, measured, transmitted, dt):
    """Return without feedforward."""
    return 0.0


def make_sense(parameters: Structure, state: Structure) -> Callable[..., Any]:
    """Return the entry that reads one sensor at one sample."""
    unpack, load, store = unpacker(parameters), unpacker(state), packer(state)

    def sense(p_vector, state_vector, x, dt):
        measured, s = sensor_step(load(state_vector), x, dt, unpack(p_vector))
        store(s, state_vector)
        return measured

    return sense
