"""Many trajectories at once: time outside, lanes inside, so that one instruction steps several of them.

A block holds `LANES` trajectories of one mechanism, each with parameters, state and effort of its own, side by side.
The arithmetic of a lane is that of a serial run, operation by operation, and so are its bits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from bristle.core.kernel import kernel
from bristle.core.packing import LANES, LaneConstants, Structure, lane_packer, lane_unpacker
from bristle.engine.drivers import BOUND
from bristle.engine.entry_points import FAILED, FAILED_SO_FAR, FORCE, MechanismVectors, Substeps
from bristle.engine.semi_implicit import advance
from bristle.engine.signature import Vector

__all__ = ["Efforts", "InLanes", "Mechanisms", "Records", "Rows", "make_lanes", "open_loops"]


class Efforts(NamedTuple):
    """Efforts at each sample, and those that they run to: all mechanisms of one sample in a row, or one for all."""

    start: Vector
    end: Vector
    columns: int


class Records(NamedTuple):
    """Position, velocity and friction of all `mechanisms`: of one sample in a row in lanes, else of one mechanism."""

    x: Vector
    v: Vector
    force: Vector
    mechanisms: int


class Mechanisms(NamedTuple):
    """Several mechanisms of one kind: their vectors, those of all mechanisms in a row."""

    substeps: Substeps
    vectors: MechanismVectors


# One block by the semi-implicit step: (block, memories, size of each, first mechanism, number of them, efforts, dt,
# steps, records).
InLanes = Callable[[Vector, Vector, int, int, int, Efforts, float, int, Records], float]


class Rows:
    """Where in a block each part of the mechanism begins, one number of all lanes a row."""

    def __init__(self, plant: int, plant_state: int, friction: int, friction_state: int) -> None:
        self.plant_state = plant
        self.friction = self.plant_state + plant_state
        self.friction_state = self.friction + friction
        self.effort = self.friction_state + friction_state
        self.failures_so_far = self.lost_at = self.effort + 3  # a step without a solve fails nowhere, and goes on
        self.count = self.failures_so_far + 1


def make_lanes(
    plant: Structure,
    plant_state: Structure,
    friction: Structure,
    friction_state: Structure,
    rows: Rows,
    memory: bool,
    constants: LaneConstants,
) -> Callable[..., Any]:
    """Return the entry that drives one block by the semi-implicit step: the `used` mechanisms from `first` on.

    `memory` tells whether the friction model has one, `constants` what holds of its parameters in every lane.
    """
    unpack_plant, load_plant, store_plant = lane_unpacker(plant), lane_unpacker(plant_state), lane_packer(plant_state)
    unpack_friction = lane_unpacker(friction, constants)
    load_friction, store_friction = lane_unpacker(friction_state), lane_packer(friction_state)
    row_body, row_p, row_state = rows.plant_state, rows.friction, rows.friction_state
    row_effort, row_end, row_total = rows.effort, rows.effort + 1, rows.effort + 2

    def lanes(block, memories, size, first, used, efforts, dt, steps, records):
        h = dt / steps
        x, v, force, count, columns = records.x, records.v, records.force, records.mechanisms, efforts.columns
        for k in range(x.size // count):
            for j in range(LANES):
                # Lanes beyond the last trajectory repeat it.
                m = first + min(j, used - 1)
                at = k * columns + (m if columns > 1 else 0)
                block[row_effort * LANES + j] = efforts.start[at]
                block[row_end * LANES + j] = efforts.end[at]
                block[row_total * LANES + j] = 0.0
                x[k * count + m] = block[row_body * LANES + j]
                v[k * count + m] = block[(row_body + 1) * LANES + j]
            for i in range(steps):
                part = (i + 0.5) / steps
                for j in range(LANES):
                    s = load_friction(block, row_state, j)
                    start = block[row_effort * LANES + j]
                    u = start + (block[row_end * LANES + j] - start) * part
                    advanced = advance(
                        load_plant(block, row_body, j),
                        s,
                        memories[j * size : (j + 1) * size] if memory else memories,
                        u,
                        h,
                        unpack_plant(block, 0, j),
                        unpack_friction(block, row_p, j),
                    )
                    store_plant(advanced.plant_state, block, row_body, j)
                    store_friction(advanced.friction_state, block, row_state, j)
                    block[row_total * LANES + j] += advanced.force
            for j in range(used):
                force[k * count + first + j] = block[row_total * LANES + j] / steps
        return 0.0

    return lanes


def open_loops(mechanisms: Mechanisms, first: int, last: int, efforts: Efforts, dt: float, steps: int, records: Records) -> int:
    """Drive the mechanisms `first` to `last` one after the other; return 0.

    What follows a sample at which a mechanism left the finite numbers is left as it was.
    """
    x, v, force, count, columns = records.x, records.v, records.force, records.mechanisms, efforts.columns
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
    """Return the vectors of mechanism `m` among those of `count` mechanisms in a row."""
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
