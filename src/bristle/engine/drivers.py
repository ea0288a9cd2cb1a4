"""The drivers of plants with friction: by recorded efforts, and in the loop of a controller.

The arguments of a driver are tuples of an entry and of the vectors that this entry changes.
"""

from typing import NamedTuple

from bristle.core.kernel import kernel
from bristle.engine.entry_points import (
    FAILED,
    FAILED_SO_FAR,
    FORCE,
    Compensate,
    Control,
    MechanismVectors,
    Sense,
    Substeps,
)
from bristle.engine.signature import Vector

# Rows of the flat history of a run.
POSITION, VELOCITY, MEASURED, COMMAND, EFFORT, FRICTION = 0, 1, 2, 3, 4, 5
MOTOR_POSITION, MOTOR_VELOCITY, FED, ROWS = 6, 7, 8, 9
# Beyond this magnitude of position plus velocity a simulation counts as diverged.
BOUND = 1e100


class Driven(NamedTuple):
    """A plant with friction. `load` begins with position and velocity of the load.

    For a plant with one mass this is the state of the plant.
    """

    substeps: Substeps
    vectors: MechanismVectors
    load: Vector


class Controller(NamedTuple):
    """A control law."""

    control: Control
    parameters: Vector
    state: Vector


class Compensation(NamedTuple):
    """A friction model that is fed forward along the measured motion; `shape` is that of `Compensate`.

    `transmitted` is the effort that the desired motion transmits to the load at each sample.
    """

    compensate: Compensate
    parameters: Vector
    state: Vector
    memory: Vector
    shape: Vector
    transmitted: Vector


class Sensor(NamedTuple):
    """A sensor; `reading` begins with the true position."""

    sense: Sense
    parameters: Vector
    state: Vector
    reading: Vector


class Signals(NamedTuple):
    """Inputs of a loop; `reference` is flat, [position | velocity | acceleration | effort] of all samples."""

    reference: Vector
    injected: Vector
    disturbance: Vector


class Sampling(NamedTuple):
    """Sample time [s] and steps in it; the effort computed at sample k acts from sample ``k + delay`` on.

    It is at most `limit` [N or N*m]; `effort_before` acts until the first effort arrives.
    """

    dt: float
    steps: int
    delay: int
    limit: float
    effort_before: float


class Efforts(NamedTuple):
    """Efforts at each sample, and at its end: contiguous for all mechanisms of one sample, or common to all."""

    start: Vector
    end: Vector
    columns: int


class Records(NamedTuple):
    """Position, velocity and friction of all `mechanisms`: contiguous per sample for lanes, otherwise per mechanism."""

    x: Vector
    v: Vector
    force: Vector
    mechanisms: int


class Mechanisms(NamedTuple):
    """Several mechanisms of one kind, with consecutive vectors."""

    substeps: Substeps
    vectors: MechanismVectors


@kernel
def record(history, count, k, load, plant):
    """Record position and velocity of load and motor at sample `k`."""
    history[POSITION * count + k], history[VELOCITY * count + k] = load[0], load[1]
    history[MOTOR_POSITION * count + k], history[MOTOR_VELOCITY * count + k] = plant[0], plant[1]


def open_loop(
    driven: Driven, effort: Vector, effort_end: Vector, dt: float, steps: int, history: Vector
) -> int:
    """Drive a plant by a recorded effort; return the number of samples that stayed finite.

    `history` is as in `closed_loop`, without measurement and command.
    """
    count, vectors = effort.size, driven.vectors
    plant, out = vectors.plant_state, vectors.out
    for k in range(count):
        record(history, count, k, driven.load, plant)
        history[EFFORT * count + k] = effort[k]
        driven.substeps(vectors, effort[k], effort_end[k], dt, steps)
        history[FRICTION * count + k] = out[FORCE]
        out[FAILED_SO_FAR] += out[FAILED]
        if not abs(plant[0]) + abs(plant[1]) < BOUND:
            return k + 1
    return count


def readings(sensor: Sensor, dt: float, measured: Vector) -> int:
    """Write the reading of a sensor at each sample; `reading` is its state, `measured` holds the positions at first; return 0."""
    for k in range(measured.size):
        measured[k] = sensor.sense(sensor.parameters, sensor.state, sensor.reading[k], dt)
    return 0


def closed_loop(
    controller: Controller,
    compensation: Compensation,
    sensor: Sensor,
    driven: Driven,
    signals: Signals,
    sampling: Sampling,
    history: Vector,
) -> int:
    """Run a sampled loop; return the number of samples that stayed finite.

    `history` is flat, and receives [x | v | measured | commanded effort | applied effort | mean friction force until
    the next sample | x | v of the motor | effort fed forward along the measured motion].
    """
    reference, vectors, dt = signals.reference, driven.vectors, sampling.dt
    plant, out, count = vectors.plant_state, vectors.out, signals.injected.size
    for k in range(count):
        measured = sensor.sense(sensor.parameters, sensor.state, sensor.reading[0], dt)
        fed = compensation.compensate(
            compensation.parameters,
            compensation.state,
            compensation.memory,
            compensation.shape,
            measured,
            compensation.transmitted[k],
            dt,
        )
        command = controller.control(
            controller.parameters,
            controller.state,
            reference[k],
            reference[count + k],
            reference[2 * count + k],
            reference[3 * count + k] + fed,
            measured,
            signals.injected[k],
            sampling.limit,
            dt,
        )
        record(history, count, k, driven.load, plant)
        history[MEASURED * count + k], history[COMMAND * count + k] = measured, command
        late = sampling.delay
        applied = history[COMMAND * count + k - late] if k >= late else sampling.effort_before
        history[EFFORT * count + k], history[FED * count + k] = applied, fed
        pushed = applied - signals.disturbance[k]
        driven.substeps(vectors, pushed, pushed, dt, sampling.steps)
        history[FRICTION * count + k] = out[FORCE]
        out[FAILED_SO_FAR] += out[FAILED]
        if not abs(plant[0]) + abs(plant[1]) < BOUND:
            return k + 1
    return count


def open_loops(
    mechanisms: Mechanisms,
    first: int,
    last: int,
    efforts: Efforts,
    dt: float,
    steps: int,
    records: Records,
) -> int:
    """Drive the mechanisms `first` to `last` one after another; return 0.

    Records after the sample at which a mechanism diverged are not written.
    """
    x, v, force, count, columns = (
        records.x,
        records.v,
        records.force,
        records.mechanisms,
        efforts.columns,
    )
    size = x.size // count
    for m in range(first, last):
        vectors = of_one(mechanisms.vectors, m, count)
        body, out = vectors.plant_state, vectors.out
        for k in range(size):
            x[m * size + k], v[m * size + k] = body[0], body[1]
            at = k * columns + (m if columns > 1 else 0)
            mechanisms.substeps(vectors, efforts.start[at], efforts.end[at], dt, steps)
            force[m * size + k] = out[FORCE]
            out[FAILED_SO_FAR] += out[FAILED]
            if not abs(body[0]) + abs(body[1]) < BOUND:
                break
    return 0


@kernel
def of_one(vectors, m, count):
    """Return the vectors of mechanism `m` among the consecutive vectors of `count` mechanisms."""
    return MechanismVectors(
        share(vectors.plant, m, count),
        share(vectors.plant_state, m, count),
        share(vectors.friction, m, count),
        share(vectors.friction_state, m, count),
        share(vectors.memory, m, count),
        share(vectors.out, m, count),
    )


@kernel
def share(vector, m, count):
    """Return part `m` of a vector in `count` equal parts."""
    size = vector.size // count
    return vector[m * size : (m + 1) * size]
