"""A mass on a contact whose force is led over break-away, back below it, and up and down there."""

import numpy as np
from tests.simulation.certificates.ballscrew import RIPPLE

from bristle import plants
from bristle.engine import run_open_loop
from bristle.simulation.certificates import certify, holding_of

DT, PERIOD = 2e-4, 0.5


def steps_per_cycle(model, low, high, top, cycles=6):
    """How far the mass goes in each cycle [rad]; the force has been at `top` before."""
    t = DT * np.arange(round(cycles * PERIOD / DT) + 1)
    wave = low + (high - low) * np.abs(2.0 * ((t / PERIOD) % 1.0) - 1.0)
    effort = np.concatenate((np.linspace(0.0, top, 2500), np.linspace(top, high, 2500), wave))
    trace = run_open_loop(
        plants.inertia(kind="rotational", M=1e-4), model, effort, DT, steps=4, hold="linear"
    )
    marks = effort.size - wave.size + np.arange(cycles + 1) * round(PERIOD / DT)
    return np.diff(trace.position[marks])


def drift_of(model, ripple=RIPPLE):
    """The certificate of the drift alone, which a check of everything has too."""
    return certify.drift(model, holding_of(model), ripple, is_magnet=False)


def closure_of(model, loop):
    """The certificate of a minor loop alone."""
    return certify.closure(model, holding_of(model), loop)
