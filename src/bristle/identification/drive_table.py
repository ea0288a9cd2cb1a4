"""The friction as a drive takes it: a table of velocity and effort."""

from __future__ import annotations

import math

import numpy as np

from bristle.core.contracts import Model, Motion
from bristle.core.errors import InputError
from bristle.identification.result import Fit

__all__ = ["drive_table", "steady_force"]

STEPS_MAX = 200
SETTLED = 1e-12


def drive_table(fit: Fit, entries: int = 20) -> list[tuple[float, float]]:
    """Return the steady friction force over velocity, for the friction compensation of a drive.

    Parameters
    ----------
    fit : Fit
        An identified model.
    entries : int
        Number of entries at most, 4 to 1000.

    Returns
    -------
    list of (float, float)
        Velocity [m/s or rad/s], ascending, and the force to be fed forward [N or N*m], offset included, inertia not.
        The table covers the velocities of the log, in both directions if the log has both, and is denser near zero.
        At standstill it has two entries, -0.0 and +0.0: the limits from either side.

    Raises
    ------
    InputError
        If `entries` is out of range.
    """
    if entries != int(entries) or not 4 <= entries <= 1000:
        raise InputError("out of range", path="entries", value=entries, allowed="4 to 1000")
    lowest, highest = float(np.min(fit.traces.velocity)), float(np.max(fit.traces.velocity))
    sides = [(-1.0, -lowest)] * (lowest < 0.0) + [(1.0, highest)] * (highest > 0.0)
    share = np.linspace(0.0, 1.0, int(entries) // len(sides))
    table = [
        (math.copysign(speed, side), steady_force(fit.friction, math.copysign(max(speed, 1e-9 * top), side)))
        for side, top in sides
        for speed in (top * share * share).tolist()
    ]
    return sorted(table, key=lambda entry: (entry[0], math.copysign(1.0, entry[0])))


def steady_force(model: Model, v: float) -> float:
    """Return the force [N or N*m] that a friction model settles to at a constant velocity `v` [m/s or rad/s].

    The model itself is run, over steps that grow until its force no longer changes.
    """
    component, p = model.component, model.parameters
    state, memory = component.initial_state(p), component.new_memory(p)
    dt, x, force, before = 1e-6, 0.0, math.nan, math.nan
    for _ in range(STEPS_MAX):
        x += v * dt
        force, move = component.trial(state, memory, Motion(v, x), dt, p)
        state = component.commit(state, memory, move, p)
        if abs(v) * dt > 1.0 and abs(force - before) <= SETTLED * abs(force):
            break
        before, dt = force, 1.5 * dt
    return float(force)
