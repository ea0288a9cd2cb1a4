"""Running an experiment: every variant of it, and what came out in numbers."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike

import numpy as np

from bristle.controllers.limits import within_drive
from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.experiment import Experiment, Feedforward, Variant
from bristle.engine import force_along, run_closed_loop
from bristle.simulation.result import SimulationResult, VariantResult, statistics_of

__all__ = ["feedforward_effort", "friction_along", "simulate"]

Progress = Callable[[float, str], None]


def simulate(experiment: Experiment | str | PathLike[str], progress: Progress | None = None) -> SimulationResult:
    """Simulate every variant of an experiment.

    Parameters
    ----------
    experiment : Experiment or path-like
        What to simulate, or the file that describes it. A controller with a ``limit`` knows that of the drive, and
        what is fed forward is handed to it ahead by the delay of the loop.
    progress : callable, optional
        Called with the share done and the name of what comes next.

    Returns
    -------
    SimulationResult
        Each variant with its errors and efforts; a loop that diverged is cut short and says so in its status.
    """
    if isinstance(experiment, (str, PathLike)):
        from bristle.files.experiment import read_experiment

        experiment = read_experiment(experiment)
    if not isinstance(experiment, Experiment):
        raise InputError("must be an experiment or its file", path="experiment", value=experiment)
    results = {}
    for index, variant in enumerate(experiment.variants):
        if progress is not None:
            progress(index / len(experiment.variants), variant.name)
        results[variant.name] = _simulate_variant(variant)
    return SimulationResult(experiment, results)


def friction_along(model: Model, velocity: np.ndarray, dt: float) -> np.ndarray:
    """Return the friction force that a compensator expects along a desired motion.

    Where the desired velocity is zero a set-valued model has no single force; it is fed the middle of its interval.

    Parameters
    ----------
    model : Model
        The compensator.
    velocity : ndarray, shape (step,)
        Mean desired velocity of each step [m/s or rad/s].
    dt : float
        Length of a step [s].

    Returns
    -------
    ndarray, shape (step,)
        Force [N or N*m].
    """
    forward = force_along(model, velocity, dt)
    if not np.any(velocity == 0.0):
        return forward
    backward = force_along(model, np.where(velocity == 0.0, -0.0, velocity), dt)
    return 0.5 * (forward + backward)


def feedforward_effort(
    feedforward: Feedforward, position: np.ndarray, acceleration: np.ndarray, dt: float
) -> np.ndarray:
    """Return the effort fed forward along a desired trajectory, for the step that begins at each sample.

    Parameters
    ----------
    feedforward : Feedforward
        Mass and compensator.
    position, acceleration : ndarray, shape (sample,)
        Desired motion.
    dt : float
        Sample time [s].

    Returns
    -------
    ndarray, shape (sample,)
        Effort [N or N*m].
    """
    effort = feedforward.mass * 0.5 * (acceleration + np.append(acceleration[1:], acceleration[-1:]))
    if feedforward.friction is not None:
        steps = np.diff(position) / dt
        effort += feedforward.gain * friction_along(feedforward.friction, np.append(steps, steps[-1:]), dt)
    return effort


def _simulate_variant(variant: Variant) -> VariantResult:
    run = variant.run
    dt = run.sample_time
    count = round(run.duration / dt)
    # What is fed forward acts `delay` samples after the controller receives it: it is taken that much ahead.
    t = dt * np.arange(count + run.delay)
    ahead, velocity, acceleration = variant.reference.component.sample(t, variant.reference.parameters)
    effort = feedforward_effort(variant.feedforward, ahead, acceleration, dt)[run.delay :]
    position, velocity, acceleration = ahead[:count], velocity[:count], acceleration[:count]
    trace = run_closed_loop(
        variant.plant,
        variant.friction,
        within_drive(variant.controller, run.effort_limit),
        variant.sensor,
        np.stack((position, velocity, acceleration, effort)),
        dt,
        steps=run.substeps,
        disturbance=variant.disturbance,
        limit=run.effort_limit,
        delay=run.delay,
        lag=run.current_lag,
        x=float(position[0]),
        v=float(velocity[0]),
        acceleration=float(acceleration[0]),
    )
    done = trace.time.size
    judged = slice(min(round(run.settle / dt), done), done)
    following, true = position[:done] - trace.measured, position[:done] - trace.position
    moving = velocity[:done][judged]
    return VariantResult(
        name=variant.name,
        following_error=statistics_of(following[judged]),
        true_error=statistics_of(true[judged]),
        by_direction={
            "forward": statistics_of(following[judged][moving > 0.0]),
            "backward": statistics_of(following[judged][moving < 0.0]),
        },
        effort_rms=statistics_of(trace.effort[judged]).rms,
        effort_peak=float(np.max(np.abs(trace.effort[judged]), initial=0.0)),
        time=trace.time,
        reference=position[:done],
        measured=trace.measured,
        position=trace.position,
        velocity=trace.velocity,
        effort=trace.effort,
        feedforward=effort[:done],
        friction=trace.friction,
        status=trace.status,
    )
