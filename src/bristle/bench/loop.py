"""The closed loop of an axis whose effort a competitor predicts along any motion."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from bristle import friction, plants
from bristle.bench.record import Record
from bristle.core import Experiment
from bristle.simulation import compensation_experiment, simulate

PASSES = 6


def following_error(effort_along: Callable[[Record], np.ndarray], reference: Record, mass: float) -> np.ndarray:
    """Return the following error of the known loop along a reference [m or rad], shape (sample,); not finite if it diverges.

    Each pass simulates the loop of a mass. The rest of the effort along the motion of the pass before is a disturbance. The
    fixed point is the loop of the axis with this effort, for any mass.
    """
    axis, kind, motion = reference.axis, reference.kind, reference
    plant, still = plants.inertia(kind=kind, M=mass), friction.coulomb(kind=kind, F_C=0.0)
    for _ in range(PASSES):
        rest = effort_along(motion) - mass * motion.acceleration
        loops = compensation_experiment(
            plant,
            still,
            still,
            axis.controller,  # type: ignore[arg-type]
            reference.position,
            reference.sample_time,
            resolution=axis.resolution or 0.0,
            disturbance=rest,
            effort_limit=axis.effort_limit or math.inf,
        )
        first = loops.variants[0]
        measured = simulate(Experiment("loop", kind, (first,))).variants[first.name].measured
        if measured.size != reference.position.size or not np.all(np.isfinite(measured)):
            return np.full(reference.position.shape, np.nan)
        motion = Record.of(reference.time, measured, None, axis)
    return reference.position - motion.position
