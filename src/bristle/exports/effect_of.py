"""The effect of an export: the loop that bristle knows of the axis, and the drive that reads the files."""

import math
from dataclasses import replace
from functools import partial

import numpy as np

from bristle.core.contracts import Model
from bristle.core.experiment import Variant
from bristle.engine import response
from bristle.exports import effect as effects
from bristle.exports.targets import Request
from bristle.simulation.compensation import COMPENSATED, compensation_experiment

FASTEST = 0.1  # [m/s or rad/s] of an axis of which no speed is known
REACHED = 0.1  # time to the largest velocity of an axis whose friction and inertia tell no acceleration [s]
SHORT_RECORD = 16  # samples of the motion that stands for a log where there is none


def effect_of_files(request: Request, drive: effects.Drive | None, *, of_cogging: bool = False) -> effects.Effect | None:
    """Return the effect of what a target wrote; `drive` is what a drive makes of it, the model itself where None.

    The model itself leaves no residual force to state where no loop is known. Of files with cogging the loop is one
    without cogging fed forward.
    """
    friction, loop, axis = request.model, loop_for(request), request.axis
    if friction.component.family != "friction" or (loop is None and (drive is None or of_cogging)):
        return None
    fastest = request.speed or (axis and axis.velocity_limit) or FASTEST
    limits = _limits_of(friction, request.plant, fastest)
    if axis is not None:
        limits = effects.Limits(
            min(limits.velocity, axis.velocity_limit or math.inf),
            min(limits.acceleration, axis.acceleration_limit or math.inf),
            axis.jerk_limit or math.inf,
        )
    drive = drive or partial(response, friction, rest=request.rest)
    distance = effects.turning_distance(friction, axis, limits.velocity)
    if loop is None:
        return effects.effect_in_force(friction, drive, limits, distance, request.dt, samples_ahead(None))
    loop = replace(loop, feedforward=replace(loop.feedforward, plant=None)) if of_cogging else loop
    return effects.effect_in_loop(loop, effects.driven_by(drive), limits, distance, samples_ahead(loop))


def effect_of_law(variant: Variant) -> effects.Effect | None:
    """Return the effect of the friction that a law feeds forward; None where it feeds none."""
    friction = variant.feedforward.friction
    if friction is None:
        return None
    loop = replace(variant, feedforward=replace(variant.feedforward, friction=None, offset=0.0))
    t = variant.run.sample_time * np.arange(round(variant.run.duration / variant.run.sample_time))
    fastest = float(np.max(np.abs(variant.reference.component.sample(t, variant.reference.parameters)[1]), initial=0.0))
    limits = _limits_of(friction, variant.plant, fastest or FASTEST)
    distance = effects.turning_distance(friction, variant.axis, limits.velocity)
    return replace(effects.effect_in_loop(loop, effects.fed_by(variant.feedforward), limits, distance, 0), ahead=variant.run.delay + 1)


def samples_ahead(loop: Variant | None) -> int:
    """Return how many samples ahead a feedforward is led: one for the step to come, and the delay and lag of the drive.

    The force of a step acts from one sample to the next, half a sample later on average than both; that half is in the
    one.
    """
    if loop is None:
        return 1
    run = loop.run
    return 1 + run.delay + round(run.current_lag / run.sample_time)


def ahead_text(loop: Variant | None) -> str:
    """Return how the desired motion is fed ahead, in a sentence."""
    if loop is None:
        return "feed the desired motion 1 sample ahead at least, and by delay and lag of the drive, which are not known"
    ahead, run = samples_ahead(loop), loop.run
    late = run.delay * run.sample_time + run.current_lag
    rest = f"{ahead - 1} for {1e3 * late:.3g} ms of delay and lag" if late else "no delay and no lag are known"
    samples = "sample" if ahead == 1 else "samples"
    head = f"feed the desired motion {ahead} {samples} of {1e3 * run.sample_time:g} ms ahead"
    return f"{head}: 1 for the step to come, {rest}"


def loop_for(request: Request) -> Variant | None:
    """Return the loop of the axis without friction fed forward; None where the axis file has no controller."""
    variant, axis, plant = request.loop, request.axis, request.plant
    if variant is None:
        if axis is None or axis.controller is None or plant is None or plant.component.screw is not None:
            return None
        experiment = compensation_experiment(
            plant,
            request.model,
            request.model,
            axis.controller,
            np.zeros(SHORT_RECORD),
            axis.sample_time or (request.dt if request.log is None else request.log.sample_time),
            resolution=axis.resolution or 0.0,
            effort_limit=axis.effort_limit or math.inf,
            lag=axis.lag,
            name=axis.name,
        )
        variant = next(variant for variant in experiment.variants if variant.name == COMPENSATED)
    return replace(variant, feedforward=replace(variant.feedforward, friction=None))


def _limits_of(friction: Model, plant: Model | None, fastest: float) -> effects.Limits:
    """Return the acceleration that takes as much effort as sliding friction does."""
    mass = 0.0 if plant is None else plant.values.get("M", 0.0)
    return effects.Limits(fastest, effects.sliding_level(friction, fastest) / mass if mass else fastest / REACHED)
