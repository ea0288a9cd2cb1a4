r"""A plant with friction in open and in closed loop, with derivatives: sensitivities are computed in the same pass.

.. math:: \dot s_{k+1} = \frac{\partial s_{k+1}}{\partial s_k}\,\dot s_k + \frac{\partial s_{k+1}}{\partial \theta}\,\dot\theta

with the state :math:`s` of plant, friction, its memory, drive and controller. Each step is that of
`bristle.engine.mechanism`, and `bristle.engine.implicit` differentiates its searches. The signals are identical to those
of `bristle.engine.run_open_loop` and `bristle.engine.run_closed_loop`.
"""

from collections.abc import Callable
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np

from bristle.core import Model, Reference, kernel
from bristle.core.packing import Structure, pack, structure_of
from bristle.core.tangent import DIRECTIONS
from bristle.engine.compilation import compiled
from bristle.engine.derivatives import VECTOR, WRITTEN, Argument, in_blocks, padded, with_tangents
from bristle.engine.drivers import BOUND
from bristle.engine.implicit import mechanism_derivatives
from bristle.engine.instance import Instance
from bristle.engine.mechanism import Mechanism, mechanism
from bristle.engine.signature import Vector
from bristle.engine.translation.tree import INTEGER, REAL
from bristle.models.controllers.law import law


class Sensitive(NamedTuple):
    """A model, virgin by default, with derivatives of its packed numbers, shape (number, direction), 0 by default."""

    model: Model
    tangents: np.ndarray
    state: Any = None
    memory: np.ndarray | None = None
    state_tangents: np.ndarray | None = None
    memory_tangents: np.ndarray | None = None


@cache
def make_open_loop(begin: Structure, plant: Structure, friction: Structure) -> Callable[..., Any]:
    """Return the entry that drives one plant with friction by an effort, with tangents."""

    @kernel(portable=False)
    def driven(begin, memory, effort, effort_end, dt, steps, q, p, position):
        at = begin
        for k in range(effort.size):
            if k % steps == 0:
                position[k // steps] = at.plant.x
            before = Mechanism(
                at.plant, at.friction, at.effort, at.slope, at.acceleration, 0.0, 0.0
            )
            at = mechanism(before, memory, effort[k], effort_end[k], 0.0, 0.0, dt, 1, q, p)
            if not abs(at.plant.x) + abs(at.plant.v) < BOUND:
                return k + 1
        return effort.size

    efforts = (
        Argument("effort", VECTOR),
        Argument("effort_end", VECTOR),
        Argument("dt", REAL),
        Argument("steps", INTEGER),
    )
    models = Argument("q", plant, True), Argument("p", friction, True)
    begun = Argument("begin", begin, True), Argument("memory", WRITTEN, True)
    return with_tangents(
        mechanism_derivatives(),
        driven,
        [*begun, *efforts, *models, Argument("position", WRITTEN, True)],
    )


@cache
def make_closed_loop(
    begin: Structure,
    law_state: Structure,
    plant: Structure,
    friction: Structure,
    controller: Structure,
) -> Callable[..., Any]:
    """Return the entry that runs a plant with friction under a controller; `signals` are reference (4 rows), injected, disturbance."""

    @kernel(portable=False)
    def driven(begin, memory, law_state, lag, signals, limit, dt, steps, q, p, c, command):
        at, control, count = begin, law_state, command.size
        for k in range(count):
            desired = Reference(
                signals[k], signals[count + k], signals[2 * count + k], signals[3 * count + k]
            )
            effort, control = law(
                control, desired, at.plant.x, signals[4 * count + k], limit, dt, c
            )
            command[k] = effort
            pushed = effort - signals[5 * count + k]
            before = Mechanism(
                at.plant, at.friction, at.effort, at.slope, at.acceleration, 0.0, 0.0
            )
            at = mechanism(before, memory, pushed, pushed, lag, 0.0, dt, steps, q, p)
            if not abs(at.plant.x) + abs(at.plant.v) < BOUND:
                return k + 1
        return count

    begun = (
        Argument("begin", begin, True),
        Argument("memory", WRITTEN, True),
        Argument("law_state", law_state, True),
    )
    drive = Argument("lag", REAL, True), Argument("signals", VECTOR), Argument("limit", REAL)
    steps = Argument("dt", REAL), Argument("steps", INTEGER)
    models = Argument("q", plant, True), Argument("p", friction, True), Argument("c", controller)
    return with_tangents(
        mechanism_derivatives(),
        driven,
        [*begun, *drive, *steps, *models, Argument("command", WRITTEN, True)],
    )


# An argument with derivatives is followed by its tangents. Initial mechanism and memory; effort, effort at the end of each step, dt,
# steps per sample; parameters of plant and friction; position of each sample.
OpenLoop = Callable[[*(Vector,) * 6, float, int, *(Vector,) * 6], float]
# Initial mechanism, memory and controller; lag; signals, limit, dt, steps per sample; parameters of plant, friction and
# controller; command at each sample.
ClosedLoop = Callable[
    [*(Vector,) * 6, float, Vector, Vector, float, float, int, *(Vector,) * 7], float
]


def open_loop_with_derivatives(
    plant: Sensitive,
    friction: Sensitive,
    effort: np.ndarray,
    effort_end: np.ndarray,
    dt: float,
    steps: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the position after every `steps` steps [m or rad], NaN if not finite, and its derivatives, from rest at 0."""
    count, efforts = -(-effort.size // steps), (effort, effort_end, float(dt), int(steps))

    def run(first: int) -> tuple[np.ndarray, np.ndarray]:
        body, part, begun, models = begun_mechanism(plant, friction, first)
        make = partial(
            make_open_loop, mechanism_structure(body, part), body.structures[0], part.structures[0]
        )
        entry = compiled(
            f"open_loop_with_tangents-{body.key}-{part.key}",
            make,
            OpenLoop,
            body.functions + part.functions,
        )
        position, slopes = np.full(count, np.nan), np.full(count * DIRECTIONS, np.nan)
        entry(*begun, *efforts, *models, position, slopes)
        return position, slopes

    return in_blocks(run, plant.tangents.shape[1])


def closed_loop_with_derivatives(
    plant: Sensitive,
    friction: Sensitive,
    controller: Model,
    law_state: Any,
    reference: np.ndarray,
    injected: np.ndarray,
    disturbance: np.ndarray,
    *,
    dt: float,
    steps: int,
    limit: float,
    effort_before: float,
    lag: float,
    lag_tangents: np.ndarray,
    x: float,
    v: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the command at each sample [N or N*m] and its derivatives, in a loop of `run_closed_loop` with a perfect encoder."""
    count, control, c = injected.size, pack(law_state), Instance(controller)
    signals = (
        np.concatenate([reference.ravel(), injected, disturbance]),
        float(limit),
        float(dt),
        int(steps),
    )

    def run(first: int) -> tuple[np.ndarray, np.ndarray]:
        body, part, begun, models = begun_mechanism(plant, friction, first, x, v, effort_before)
        structures = (
            mechanism_structure(body, part),
            structure_of(law_state),
            body.structures[0],
            part.structures[0],
            c.structures[0],
        )
        name = f"closed_loop_with_tangents-{body.key}-{part.key}-{c.key}"
        entry = compiled(
            name,
            partial(make_closed_loop, *structures),
            ClosedLoop,
            body.functions + part.functions + c.functions,
        )
        command, slopes = np.full(count, np.nan), np.full(count * DIRECTIONS, np.nan)
        drive = (
            control,
            np.zeros(control.size * DIRECTIONS),
            lag,
            padded(lag_tangents[None, first : first + DIRECTIONS], 1),
        )
        entry(*begun, *drive, *signals, *models, c.parameters, command, slopes)
        return command, slopes

    return in_blocks(run, plant.tangents.shape[1])


def mechanism_structure(body: Instance, part: Instance) -> Structure:
    """Return the structure of a mechanism: plant, friction, and five numbers."""
    return Mechanism, (body.structures[1], part.structures[1], *("number",) * 5)


def begun_mechanism(
    plant: Sensitive,
    friction: Sensitive,
    first: int,
    x: float = 0.0,
    v: float = 0.0,
    effort: float = 0.0,
) -> tuple[Instance, Instance, list[np.ndarray], list[np.ndarray]]:
    """Return both components, the vectors of their initial states, and those of their parameters, each with its tangents."""

    def paired(numbers: np.ndarray, tangents: np.ndarray | None) -> list[np.ndarray]:
        return [
            numbers,
            padded(
                None if tangents is None else tangents[:, first : first + DIRECTIONS], numbers.size
            ),
        ]

    body, part = Instance(plant.model), Instance(friction.model)
    part.begin(friction.state)
    body.state[:2] = x, v
    virgin = friction.model.component.new_memory(friction.model.parameters)
    state, d_state = paired(part.state, friction.state_tangents)
    begin = np.concatenate([body.state, state, [effort, 0.0, 0.0, 0.0, 0.0]])
    d_begin = np.concatenate(
        [np.zeros(body.state.size * DIRECTIONS), d_state, np.zeros(5 * DIRECTIONS)]
    )
    memory = paired(
        virgin if friction.memory is None else friction.memory.copy(), friction.memory_tangents
    )
    models = paired(body.parameters, plant.tangents) + paired(part.parameters, friction.tangents)
    return body, part, [begin, d_begin, *memory], models
