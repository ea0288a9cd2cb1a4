"""Wind-up of a screw along a desired motion: one pass with the kernels of the exported law."""

from collections.abc import Callable

import numpy as np

from bristle.engine.compilation import compiled
from bristle.engine.path import Lead
from bristle.engine.signature import Vector
from bristle.models.controllers.wind_up import (
    AROUND,
    WindUp,
    Wound,
    bend_at,
    lead_at,
    rate_at,
    wind,
    winding_effort,
)

# (masses and screw, weights, memory, force of the screw and mean acceleration in each step, dt, rows of a `Lead`).
WindUpAlong = Callable[[Vector, Vector, Vector, Vector, Vector, float, Vector], float]


def wind_up_entry(numbers, weights, memory, force, acceleration, dt, rows):
    """Write the rows of a `Lead` one after another; after its end, the force stays constant."""
    p = WindUp(
        numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5], numbers[6], weights
    )
    state, count, at = Wound(0.0, 0.0), force.size, weights.size + AROUND
    late = weights.size // 2 + AROUND
    for k in range(count + late):
        state = wind(state, memory, force[min(k, count - 1)], k == 0, p)
        if k >= late:
            i = k - late
            rows[i] = lead_at(memory, at, dt, p)
            rows[count + i] = rate_at(memory, at, dt, p)
            rows[2 * count + i] = bend_at(memory, at, dt, p)
            rows[3 * count + i] = winding_effort(memory, at, acceleration[i], dt, p)
    return 0.0


def wind_up_along(p: WindUp, force: np.ndarray, acceleration: np.ndarray, dt: float) -> Lead:
    """Return the lead of the motor for the force of the screw [N] and the mean desired acceleration [rad/s^2] of each step."""
    rows, memory = (
        np.empty(len(Lead._fields) * force.size),
        np.empty(p.weights.size + 2 * AROUND + 1),
    )
    kernels = (wind, lead_at, rate_at, bend_at, winding_effort)
    entry = compiled("wind_up_along", lambda: wind_up_entry, WindUpAlong, kernels)
    entry(np.array(p[:-1]), p.weights, memory, force, acceleration, float(dt), rows)
    return Lead(*rows.reshape(len(Lead._fields), -1))
