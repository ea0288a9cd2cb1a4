r"""An observer of low bandwidth for a plant with friction: driven by the recorded effort, corrected by the recorded position.

With the prediction error :math:`e_k = q_k - \hat q_k`, before each sample

.. math:: \hat q \mathrel{+}= l_1 e, \quad \dot{\hat q} \mathrel{+}= l_2 e, \quad \hat d \mathrel{+}= l_3 M e,

after which the plant moves under :math:`u + \hat d` against its friction until the next sample. For a double integrator all
three poles are :math:`a = e^{-\omega \Delta t}`:

.. math:: l_1 = 1 - a^3, \quad l_2 = \tfrac{3}{2\Delta t} (1 - a)^2 (1 + a), \quad l_3 = \tfrac{1}{\Delta t^2} (1 - a)^3.

An impulse, spread over the sample, corrects the velocity, so that a sticking body does not move. A shift of the scale corrects
the position, so that no correction deflects a contact. Derivatives are computed in the same pass.

References
----------
.. [1] L. Ljung, "System Identification: Theory for the User", 2nd ed., Prentice Hall, 1999: prediction errors of a model in
   innovations form.
"""

import math
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np

from bristle.core.dispatch import plant_port
from bristle.core.kernel import kernel
from bristle.core.packing import Structure
from bristle.core.tangent import DIRECTIONS
from bristle.engine.compilation import compiled
from bristle.engine.derivatives import VECTOR, WRITTEN, Argument, in_blocks, padded, with_tangents
from bristle.engine.drivers import BOUND
from bristle.engine.implicit import mechanism_derivatives
from bristle.engine.loop_derivatives import Sensitive, begun_mechanism, mechanism_structure
from bristle.engine.mechanism import Mechanism, mechanism
from bristle.engine.signature import Vector
from bristle.engine.translation.tree import INTEGER, REAL


@cache
def make_observer(begin: Structure, plant: Structure, friction: Structure) -> Callable[..., Any]:
    """Return the entry that simulates one plant with friction and an observer along a recorded position, with tangents.

    `efforts` has consecutive rows, weighted by `weights`, each with one sample more than the position.
    """

    @kernel(portable=False)
    def observed(begin, memory, position, efforts, weights, gains, dt, steps, q, p, error):
        at, shift, push, count = begin, 0.0, 0.0, error.size
        for k in range(count):
            e = position[k] - (at.plant.x + shift)
            error[k] = e
            shift = shift + gains[0] * e
            push = push + gains[2] * e
            _, b = plant_port(at.plant, 0.0, dt, q)
            start = (push + gains[1] * e) * (-0.5 * dt / b)  # the mass times an acceleration
            end = start
            for j in range(weights.size):
                first = j * (count + 1) + k
                start = start + weights[j] * efforts[first]
                end = end + weights[j] * efforts[first + 1]
            before = Mechanism(
                at.plant, at.friction, at.effort, at.slope, at.acceleration, 0.0, 0.0
            )
            at = mechanism(before, memory, start, end, 0.0, 0.0, dt, steps, q, p)
            if not abs(at.plant.x) + abs(at.plant.v) < BOUND:
                return k + 1
        return count

    begun = (
        Argument("begin", begin, True),
        Argument("memory", WRITTEN, True),
        Argument("position", VECTOR),
    )
    pushed = (
        Argument("efforts", VECTOR),
        Argument("weights", VECTOR, True),
        Argument("gains", VECTOR),
    )
    steps = Argument("dt", REAL), Argument("steps", INTEGER)
    models = Argument("q", plant, True), Argument("p", friction, True)
    return with_tangents(
        mechanism_derivatives(),
        observed,
        [*begun, *pushed, *steps, *models, Argument("error", WRITTEN, True)],
    )


# An argument with derivatives is followed by its tangents. Initial mechanism and memory; position; efforts, their weights, gains; dt,
# steps per sample; parameters of plant and friction; prediction error of each sample.
Observer = Callable[[*(Vector,) * 5, *(Vector,) * 4, float, int, *(Vector,) * 6], float]


def gains_of(bandwidth: float, dt: float) -> np.ndarray:
    """Return the gains of position, acceleration by velocity, and acceleration for poles at `bandwidth` [rad/s]."""
    a = math.exp(-bandwidth * dt)
    velocity, force = 1.5 * (1.0 - a) ** 2 * (1.0 + a) / dt, (1.0 - a) ** 3 / dt**2
    # An impulse that is spread over a sample moves the position half as far as an impulse at its beginning.
    return np.array([1.0 - a**3 + 0.5 * dt * velocity, velocity / dt, force])


def prediction_errors(
    plant: Sensitive,  # like `friction`, with derivatives of parameters and initial state
    friction: Sensitive,
    position: np.ndarray,  # recorded [m or rad], shape (sample,); the plant begins at rest at the first sample
    efforts: np.ndarray,  # linear between samples, shape (column, sample + 1); their weighted sum acts [N or N*m]
    weights: np.ndarray,  # shape (column,)
    weight_tangents: np.ndarray,  # shape (column, direction)
    bandwidth: float,  # of the observer [rad/s]
    dt: float,  # [s]
    steps: int,  # of integration per sample
) -> tuple[np.ndarray, np.ndarray]:
    """Return recorded minus predicted position [m or rad], NaN after divergence, and its derivatives, shape (sample, direction)."""
    count, gains = position.size, gains_of(bandwidth, dt)

    def run(first: int) -> tuple[np.ndarray, np.ndarray]:
        body, part, begun, models = begun_mechanism(plant, friction, first, float(position[0]))
        make = partial(
            make_observer, mechanism_structure(body, part), body.structures[0], part.structures[0]
        )
        entry = compiled(
            f"observer_with_tangents-{body.key}-{part.key}",
            make,
            Observer,
            body.functions + part.functions,
        )
        errors, slopes = np.full(count, np.nan), np.full(count * DIRECTIONS, np.nan)
        moved = padded(weight_tangents[:, first : first + DIRECTIONS], weights.size)
        entry(
            *begun,
            position,
            efforts.ravel(),
            weights,
            moved,
            gains,
            float(dt),
            int(steps),
            *models,
            errors,
            slopes,
        )
        return errors, slopes

    return in_blocks(run, plant.tangents.shape[1])
