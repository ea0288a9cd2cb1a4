"""Rehearsal: a simulation of the motion on the prior, with a log like that of the axis, and its identification."""

import math
from dataclasses import dataclass, replace

import numpy as np

from bristle.core import Axis, Progress, Status, unit_of
from bristle.engine import Trace, force_along, run_closed_loop
from bristle.identification import Identification, identify
from bristle.logs.log import Channel, Log
from bristle.logs.turns import numbered, reversals
from bristle.models.sensors import encoder
from bristle.prediction.excitation.limits import Prior
from bristle.prediction.excitation.motion import ExcitationMotion

NOISE = 0.005  # of the friction force, standard deviation: noise of the effort of a drive
SCATTER = 0.05  # of the friction force, between reversals


@dataclass(frozen=True)
class Rehearsal:
    """Result of a simulated motion on an axis equal to the prior.

    Parameters
    ----------
    log : Log
        Log as written by the drive: position in encoder counts, effort with noise.
    friction : ndarray, shape (sample,)
        Friction force [N or N*m], which real logs do not contain.
    peak_effort : float
        Largest effort [N or N*m].
    lag : float
        Largest tracking error during slow pre-sliding motion [m or rad].
    identification : Identification
        Identification of this log.
    truth : dict
        True values of the identified parameters: those of the prior [SI].
    loop : bool
        Whether bristle simulated the controller of the axis. Otherwise the axis follows the motion exactly.
    """

    log: Log
    friction: np.ndarray
    peak_effort: float
    lag: float
    identification: Identification
    truth: dict[str, float]
    loop: bool

    @property
    def following_error(self) -> float:
        """Largest following error [m or rad]."""
        return following_error_of(self.log)


def following_error_of(log: Log) -> float:
    """Return the largest following error of a log with a reference [m or rad]."""
    assert log.reference is not None
    return float(np.max(np.abs(log.reference.values - log.position.values)))


def exceeded(motion: ExcitationMotion, axis: Axis, prior: Prior) -> dict[str, float] | None:
    """Return the ratios of effort and following error to their limits, if above 1; None without a stable loop."""
    log, _, loop = recorded(motion, axis, prior)
    assert log.effort is not None
    demands = {
        "effort": (float(np.max(np.abs(log.effort.values))), axis.effort_limit),
        "following error": (following_error_of(log), axis.following_error_limit),
    }
    ratios = {
        name: value / limit
        for name, (value, limit) in demands.items()
        if limit is not None and value > limit
    }
    if loop:
        return ratios
    return None


def rehearse(
    motion: ExcitationMotion,
    axis: Axis,
    prior: Prior,
    *,
    draws: int,
    progress: Progress | None = None,
) -> Rehearsal:
    """Simulate a motion on the prior with scatter, noise and counts of the encoder, and identify the simulated log."""
    if progress is not None:
        progress(0.1, "simulating the motion")
    log, friction, loop = recorded(motion, axis, prior)
    # Fit the model of the prior, unless it has lists of elements.
    component = prior.friction.component
    name = component.name
    if any(component.is_array(parameter) for parameter in component.variables):
        name = "lugre"
    # The scatter of positions in a simulated loop is not needed here: no controller, and no search for a steady state.
    simulated = replace(
        axis, delay=0.0, seeks_delay=False, held=loop, controller=None, periodic=False
    )
    identification = identify(
        log,
        name,
        axis=simulated,
        blocks=0,
        draws=draws,
        progress=None
        if progress is None
        else lambda share, text: progress(0.2 + 0.6 * share, text),
    ).finished
    values = prior.plant.values
    if name.partition("+")[0] == prior.friction.name.partition("+")[0]:
        values = values | prior.friction.values
    truth = {
        estimate.name: float(values[estimate.name])
        for estimate in identification.best.estimates
        if estimate.name in values
    }
    assert log.effort is not None
    return Rehearsal(
        log,
        friction,
        float(np.max(np.abs(log.effort.values))),
        lag_of(motion, log),
        identification,
        truth,
        loop,
    )


def lag_of(motion: ExcitationMotion, log: Log) -> float:
    """Return the largest tracking error during slow pre-sliding motion [m or rad]."""
    away = np.abs(motion.position - log.position.values)
    slow = [
        away[slice(*np.searchsorted(motion.time, (begin, begin + piece.duration)))]
        for piece, begin in zip(motion.pieces, motion.begins, strict=True)
        if piece.name in ("triangles", "decaying loops")
    ]
    if slow:
        return float(np.max(np.concatenate(slow)))
    return 0.0


def recorded(motion: ExcitationMotion, axis: Axis, prior: Prior) -> tuple[Log, np.ndarray, bool]:
    """Return the log of a motion on the prior, the friction force [N or N*m], and whether the loop was simulated."""
    # The velocity at a sample is the mean over the surrounding step.
    dt = motion.sample_time
    v = motion.velocity
    expected = force_along(prior.friction, v, dt, motion.position + 0.5 * dt * v)
    # Friction changes its scale at each reversal.
    turns = reversals(v)
    factors = 1.0 + SCATTER * np.random.default_rng(2).standard_normal(turns.size + 1)
    disturbance = (factors[numbered(turns, v.size)] - 1.0) * expected
    noise = (
        NOISE
        * float(np.sqrt(np.mean(expected**2)))
        * np.random.default_rng(1).standard_normal(expected.size)
    )
    trace = _in_loop(motion, axis, prior, disturbance)
    if trace is not None:
        position = trace.measured
        effort = trace.command
        friction = trace.friction
    else:
        position = motion.position
        step = axis.resolution
        if step:
            position = np.round(position / step) * step
        friction = expected + disturbance
        effort = prior.plant.values["M"] * motion.acceleration + friction
    offset = 0.0
    if isinstance(axis.offset, float):
        offset = axis.offset
    length = unit_of("length", axis.kind)
    force = unit_of("force", axis.kind)
    log = Log(
        time=Channel(motion.time, "s", "time"),
        position=Channel(position, length, "position"),
        effort=Channel(effort + offset + noise, force, "effort"),
        reference=Channel(motion.position, length, "reference"),
        sample_time=dt,
        segments=(slice(0, motion.time.size),),
        kind=axis.kind,
    )
    return log, friction, trace is not None


def _in_loop(
    motion: ExcitationMotion, axis: Axis, prior: Prior, disturbance: np.ndarray
) -> Trace | None:
    """Return the run in the loop of the controller; None without a controller, or if the loop is unstable."""
    # The controller is tuned to the mass of its axis: with a guessed mass, its loop is meaningless.
    if axis.controller is None or not prior.mass_known:
        return None
    controller = axis.controller
    most = axis.effort_limit or math.inf
    # Saturation would hide a demand beyond the limit.
    if controller.values.get("limit", 0.0) >= most:
        controller = controller.with_values(limit=math.inf)
    trace = run_closed_loop(
        prior.plant,
        prior.friction,
        controller,
        encoder(kind=axis.kind, resolution=axis.resolution or 0.0),
        np.stack(
            (motion.position, motion.velocity, motion.acceleration, np.zeros_like(motion.time))
        ),
        motion.sample_time,
        steps=8,
        disturbance=disturbance,
        x=float(motion.position[0]),
    )
    if trace.status is Status.NOT_FINITE:
        return None
    astray = float(np.max(np.abs(trace.position - motion.position)))
    if astray > 10.0 * float(np.ptp(motion.position)):  # stable loops have smaller errors
        return None
    return trace
