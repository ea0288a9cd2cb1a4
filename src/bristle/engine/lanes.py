"""Many trajectories at once: time outside, lanes inside, so that one instruction steps several of them.

A block holds `LANES` trajectories of one mechanism, each with parameters, state and effort of its own, side by side.
The arithmetic of a lane is that of a serial run, operation by operation, and so are its bits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bristle.core.packing import LANES, Structure, lane_packer, lane_unpacker
from bristle.engine.entries import BOUND, FAILED, FAILED_SO_FAR, FORCE, OUT_SIZE
from bristle.engine.semi_implicit import advance

__all__ = ["Rows", "make_lanes", "open_loops"]


class Rows:
    """Where in a block each part of the mechanism begins, one number of all lanes a row."""

    def __init__(self, plant: int, plant_state: int, friction: int, friction_state: int) -> None:
        self.plant_state = plant
        self.friction = self.plant_state + plant_state
        self.friction_state = self.friction + friction
        self.effort = self.friction_state + friction_state
        self.count = self.effort + 3


def make_lanes(
    plant: Structure, plant_state: Structure, friction: Structure, friction_state: Structure, rows: Rows, memory: bool,
    infinite: frozenset[int],
) -> Callable[..., Any]:  # fmt: skip
    """Return the entry that drives one block by the semi-implicit step.

    `memory` tells whether the friction model has one, `infinite` which of its parameters are so in every lane.
    """
    unpack_plant, load_plant, store_plant = lane_unpacker(plant), lane_unpacker(plant_state), lane_packer(plant_state)
    unpack_friction = lane_unpacker(friction, infinite)
    load_friction, store_friction = lane_unpacker(friction_state), lane_packer(friction_state)
    row_body, row_p, row_state = rows.plant_state, rows.friction, rows.friction_state
    row_effort, row_end, row_total = rows.effort, rows.effort + 1, rows.effort + 2

    def lanes(block, memories, size, first, used, effort, effort_end, columns, dt, steps, x, v, force, count):
        h = dt / steps
        for k in range(x.size // count):
            for j in range(LANES):
                # Lanes beyond the last trajectory repeat it.
                m = first + min(j, used - 1)
                at = k * columns + (m if columns > 1 else 0)
                block[row_effort * LANES + j] = effort[at]
                block[row_end * LANES + j] = effort_end[at]
                block[row_total * LANES + j] = 0.0
                x[k * count + m] = block[row_body * LANES + j]
                v[k * count + m] = block[(row_body + 1) * LANES + j]
            for i in range(steps):
                part = (i + 0.5) / steps
                for j in range(LANES):
                    s = load_friction(block, row_state, j)
                    start = block[row_effort * LANES + j]
                    u = start + (block[row_end * LANES + j] - start) * part
                    done = advance(
                        load_plant(block, row_body, j), s, memories[j * size : (j + 1) * size] if memory else memories,
                        u, h, unpack_plant(block, 0, j), unpack_friction(block, row_p, j),
                    )  # fmt: skip
                    store_plant(done.plant_state, block, row_body, j)
                    store_friction(done.friction_state, block, row_state, j)
                    block[row_total * LANES + j] += done.force
            for j in range(used):
                force[k * count + first + j] = block[row_total * LANES + j] / steps
        return 0.0

    return lanes


def open_loops(
    burst, q, plant, p, state, memory, first, last, effort, effort_end, columns, dt, steps, x, v, force, outs
):  # fmt: skip
    """Drive the mechanisms `first` to `last` one after the other; return 0.

    The vectors hold those of all mechanisms in a row, the records and efforts all mechanisms of one sample in a row.
    What follows a sample at which a mechanism left the finite numbers is left as it was.
    """
    count = outs.size // OUT_SIZE
    sizes = (q.size // count, plant.size // count, p.size // count, state.size // count, memory.size // count)
    for m in range(first, last):
        q_m, body = q[m * sizes[0] : (m + 1) * sizes[0]], plant[m * sizes[1] : (m + 1) * sizes[1]]
        p_m, state_m = p[m * sizes[2] : (m + 1) * sizes[2]], state[m * sizes[3] : (m + 1) * sizes[3]]
        memory_m, out = memory[m * sizes[4] : (m + 1) * sizes[4]], outs[OUT_SIZE * m : OUT_SIZE * m + OUT_SIZE]
        for k in range(x.size // count):
            x[k * count + m], v[k * count + m] = body[0], body[1]
            at = k * columns + (m if columns > 1 else 0)
            burst(q_m, body, p_m, state_m, memory_m, effort[at], effort_end[at], dt, steps, out)
            force[k * count + m] = out[FORCE]
            out[FAILED_SO_FAR] += out[FAILED]
            if not abs(body[0]) + abs(body[1]) < BOUND:
                break
    return 0
