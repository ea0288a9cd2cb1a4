"""The loops in which an export is judged: that of the axis, or a slow and a stiff one if the controller is unknown."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bristle.controllers import cascade
from bristle.core.contracts import Model
from bristle.core.experiment import Variant
from bristle.exports.moves import MOVES, SHORTEST, SLOW, SLOW_MOVES
from bristle.exports.targets import Request
from bristle.loop.tuning import tuned
from bristle.plants import inertia
from bristle.simulation.compensation import COMPENSATED, compensation_experiment


class Assumed(NamedTuple):
    """An assumed loop: its bandwidth [Hz], and its moves with their duration [s]."""

    bandwidth: float
    motion: str
    lasting: float
    variant: Variant


def samples_ahead(loop: Variant | None) -> int:
    """Return the lead of a feedforward in samples: one for the next step, which is on average half a step late, plus delay and lag."""
    if loop is None:
        return 1
    run = loop.run
    return 1 + run.delay + round(run.current_lag / run.sample_time)


def loop_for(request: Request) -> Variant | None:
    """Return the loop of the axis without friction fed forward; None if the axis file has no controller."""
    variant, axis, plant = request.loop, request.axis, request.plant
    if variant is None:
        if axis is None or axis.controller is None or plant is None or plant.component.screw is not None:
            return None
        variant = _loop_with(request, plant, axis.controller)
    return replace(variant, feedforward=replace(variant.feedforward, friction=None))


def assumed_loops(request: Request, mass: float) -> list[Assumed]:
    """Return a slow loop with quick moves of a mass [kg or kg*m^2], and the stiffest loop with slow moves."""
    kind = request.model.kind
    variant = _loop_with(request, inertia(kind=kind, M=mass), cascade(kind=kind, k_p=1.0, k_v=1.0, k_i=1.0))
    variant = replace(variant, feedforward=replace(variant.feedforward, friction=None))
    laws = tuned(variant, "cascade", 2.0 * math.pi / SHORTEST), tuned(variant, "cascade")
    moves = (MOVES, SHORTEST), (SLOW_MOVES, SLOW)
    return [
        Assumed(law.bandwidth / (2.0 * math.pi), motion, lasting, replace(variant, controller=law.law))
        for law, (motion, lasting) in zip(laws, moves, strict=True)
        if law is not None
    ]


def _loop_with(request: Request, plant: Model, controller: Model) -> Variant:
    """Return the loop of a controller, with encoder, limits and sample time of the axis."""
    axis = request.axis
    experiment = compensation_experiment(
        plant,
        request.model,
        request.model,
        controller,
        np.zeros(16),  # in place of the motion of a log
        (axis and axis.sample_time) or (request.dt if request.log is None else request.log.sample_time),
        resolution=(axis and axis.resolution) or 0.0,
        effort_limit=(axis and axis.effort_limit) or math.inf,
        lag=axis.lag if axis else 0.0,
        name=axis.name if axis else request.name,
    )
    return next(variant for variant in experiment.variants if variant.name == COMPENSATED)
