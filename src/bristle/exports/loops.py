"""The loop in which an export is judged: that of the axis, with the identified lateness; its reach, and the lead of a feed."""

import math
from dataclasses import replace

import numpy as np

from bristle.core import Model, Variant
from bristle.exports.described import Request
from bristle.exports.moves import fastest_of
from bristle.prediction.claims import in_samples, lateness_of, reach_of, samples_ahead
from bristle.simulation.compensation import COMPENSATED, compensation_experiment


def loop_for(request: Request) -> Variant | None:
    """Return the loop of the axis without friction fed forward; None if the axis file has no controller."""
    variant = request.loop
    axis = request.axis
    plant = request.plant
    if variant is None:
        if (
            axis is None
            or axis.controller is None
            or plant is None
            or plant.component.screw is not None
        ):
            return None
        variant = _loop_with(request, plant, axis.controller)
    return replace(
        variant, feedforward=replace(variant.feedforward, friction=None), draws=request.draws
    )


def reach_for(request: Request) -> float | None:
    """Return the reach F/K of the axis [m or rad]; None if the stiffness of its position loop is unknown."""
    controller = None
    if request.axis is not None:
        controller = request.axis.controller
    if request.loop is not None:
        controller = request.loop.controller
    if request.friction.component.family != "friction":
        return None
    return reach_of(request.friction, controller, request.treatment, fastest_of(request))


def cycle_of(request: Request) -> float:
    """Return the cycle of the controller [s]: that of the axis file, or the sample time of the log."""
    axis = request.axis
    if axis is not None and axis.cycle:
        return axis.cycle
    if request.loop is not None:
        return request.loop.run.sample_time
    if axis is not None and axis.sample_time:
        return axis.sample_time
    if request.log is None:
        return request.dt
    return request.log.sample_time


def late_of(request: Request) -> float:
    """Return the time by which an effort acts after its command [s]: as identified, or that of the loop."""
    known = lateness_of(request.axis, request.treatment)
    if request.loop is None:
        return known
    run = request.loop.run
    return max(known, run.delay * run.sample_time + run.current_lag)


def lead_of(request: Request) -> int:
    """Return the lead of a feed in cycles of the controller."""
    return samples_ahead(late_of(request), cycle_of(request))


def _loop_with(request: Request, plant: Model, controller: Model) -> Variant:
    """Return the loop of a controller, with encoder, limits, cycle and lateness of the axis."""
    axis = request.axis
    assert axis is not None
    cycle = cycle_of(request)
    late = in_samples(late_of(request), axis.lag, cycle)
    experiment = compensation_experiment(
        plant,
        request.friction,
        request.friction,
        controller,
        np.zeros(16),  # in place of the motion of a log
        cycle,
        resolution=axis.resolution or 0.0,
        effort_limit=axis.effort_limit or math.inf,
        lag=late.lag,
        delay=late.delay,
        name=axis.name,
    )
    return next(variant for variant in experiment.variants if variant.name == COMPENSATED)
