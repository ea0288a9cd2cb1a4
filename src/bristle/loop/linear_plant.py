r"""A drive and its plant as a linear system, by the equations of the simulation's own steps.

Behind a screw of stiffness `k` and damping `d` the table follows at the mean velocity :math:`v_t` while the motor turns
at :math:`v_m`, both counted at the motor; over a step of length `h`

.. math::
    f_s = k\left[\theta - x + \tfrac12 h (v_m - v_t)\right] + d\,(v_m - v_t), \qquad
    v_m = a + b\,(F_m + f_s), \qquad v_t = v_{t,0} + \frac{h}{2M}(f_s - F_t)

A backlash is taken as closed: what is at rest leans on one of its flanks.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from bristle.core.contracts import Model, Screw
from bristle.core.experiment import Variant
from bristle.core.packing import pack, structure_of, unpacker
from bristle.loop.linear_system import NO_FRICTION, LinearFriction, LinearSystem, measured_on, varied_in

__all__ = ["linear_plant"]


def linear_plant(
    variant: Variant, amplitude: float, friction: LinearFriction = NO_FRICTION, table: LinearFriction = NO_FRICTION
) -> LinearSystem:
    """Return drive and plant of a loop from the effort commanded, held over a sample, to the position at the samples."""
    component, p, run = variant.plant.component, variant.plant.parameters, variant.run
    rest = component.initial_state(p)
    load, h = unpacker(structure_of(rest)), run.sample_time / run.substeps
    screw = None if component.screw is None else component.screw(p)
    reads_table = screw is not None and variant.sensor_at == "load"

    def sample(state: np.ndarray, command: float) -> tuple[np.ndarray, float]:
        body, (x, v, drive_effort) = load(state[:-3]), state[-3:]
        position = x if reads_table else body.x
        for _ in range(run.substeps):
            effort, drive_effort = _driven(command, drive_effort, h, run.current_lag)
            if screw is None:
                body = _moved(variant.plant, body, effort, friction, h)
            else:
                body, x, v = _pulled(variant.plant, body, effort, friction, screw, table, x, v, h)
        return np.append(pack(body), (x, v, drive_effort)), position

    varied = np.append(varied_in(structure_of(rest)), [True, True, True])
    return measured_on(sample, np.append(pack(rest), [0.0, 0.0, 0.0]), varied, amplitude)


def _driven(command: float, before: float, h: float, lag: float) -> tuple[float, float]:
    """Return the mean effort of a drive over a step, and that at its end."""
    if lag <= 0.0:
        return command, command
    rate = h / lag
    decay = math.expm1(-rate)
    return command - (before - command) * decay / rate, before - (command - before) * decay


def _moved(plant: Model, body: Any, effort: float, friction: LinearFriction, h: float) -> Any:
    """Return the state of a plant after a step."""
    k, c = friction
    a, b = plant.component.port(body, effort, h, plant.parameters)
    # The mean force of the step is k (x + v h/2) + c v, and the mean velocity v is a + b times this force.
    v = (a + b * k * body.x) / (1.0 - b * (0.5 * k * h + c))
    force = k * (body.x + 0.5 * h * v) + c * v
    return plant.component.step(body, effort, force, h, plant.parameters)[1]


def _pulled(
    plant: Model, body: Any, effort: float, friction: LinearFriction, screw: Screw, table: LinearFriction, x: float, v: float, h: float
) -> tuple[Any, float, float]:
    """Return the state of a motor, and position and velocity of the table behind it counted at the motor."""
    square = screw.arm * screw.arm
    (k_m, c_m), (k_t, c_t), k, half = friction, table, square * screw.k, 0.5 * h / (square * screw.M)
    a, b = plant.component.port(body, effort, h, plant.parameters)
    pulls, own, behind = 0.5 * k * h + square * screw.d, 0.5 * k_m * h + c_m, square * (0.5 * k_t * h + c_t)
    twisted = k * (body.x - x)
    means = np.linalg.solve(
        [[1.0 - b * (own + pulls), b * pulls], [-half * pulls, 1.0 + half * (pulls + behind)]],
        [a + b * (k_m * body.x + twisted), v + half * (twisted - square * k_t * x)],
    )
    v_m, v_t = float(means[0]), float(means[1])
    force = k_m * body.x + own * v_m + twisted + pulls * (v_m - v_t)
    body = plant.component.step(body, effort, force, h, plant.parameters)[1]
    return body, x + h * v_t, 2.0 * v_t - v
