"""A rehearsal: the motion run on what is believed of the axis, logged as the axis would, and identified from that."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.status import Status
from bristle.core.variable import unit_of
from bristle.engine import Trace, force_along, run_closed_loop
from bristle.excitation.limits import Prior
from bristle.excitation.motion import ExcitationMotion
from bristle.identification import Identification, identify
from bristle.logs.log import Channel, Log
from bristle.logs.turns import numbered, reversals
from bristle.sensors import encoder

NOISE = 0.005  # of the friction force, standard deviation: what a drive adds to its effort
SCATTER = 0.05  # of the friction force, from one reversal to the next
SUBSTEPS = 8
ASTRAY = 10.0  # times the whole motion, that no stable loop errs by
FITTED = "lugre"  # where the prior is a model that is not identified

Progress = Callable[[float, str], None]


@dataclass(frozen=True)
class Rehearsal:
    """What a motion would show of the axis, if the axis were the prior.

    Parameters
    ----------
    log : Log
        As the drive would write it: position in counts of the encoder, effort with noise.
    friction : ndarray, shape (sample,)
        Friction force [N or N*m], which no log has.
    peak_effort : float
        Largest effort [N or N*m].
    lag : float
        Largest distance between the motion and the axis while it moves slowly, before sliding [m or rad].
    identification : Identification
        What was identified from the log.
    truth : dict
        The parameters of the prior [SI], as far as the identified model has them.
    loop : bool
        Whether the controller of the axis was running; else the axis followed the motion exactly.
    """

    log: Log
    friction: np.ndarray
    peak_effort: float
    lag: float
    identification: Identification
    truth: dict[str, float]
    loop: bool


def rehearse(motion: ExcitationMotion, axis: Axis, prior: Prior, *, draws: int, progress: Progress | None = None) -> Rehearsal:
    """Run a motion on the prior, and identify the prior from the log.

    Friction scatters by 5 % from one reversal to the next, the effort has a noise of 0.5 % of friction, and the
    position is in counts of the encoder.
    """
    if progress is not None:
        progress(0.1, "running the motion on the prior")
    log, friction, loop = recorded(motion, axis, prior)
    name = model_to_fit(prior.friction)
    # Without a controller no loop is simulated, which tells how wide its positions scatter: no rehearsal asks that.
    simulated = replace(axis, delay=0.0, seeks_delay=False, held=loop, controller=None)
    identification = identify(
        log,
        name,
        axis=simulated,
        blocks=0,
        draws=draws,
        progress=None if progress is None else lambda share, text: progress(0.2 + 0.6 * share, text),
    )
    same_base = name.partition("+")[0] == prior.friction.name.partition("+")[0]
    values = prior.plant.values | (prior.friction.values if same_base else {})
    truth = {estimate.name: float(values[estimate.name]) for estimate in identification.best.estimates if estimate.name in values}
    assert log.effort is not None
    return Rehearsal(log, friction, float(np.max(np.abs(log.effort.values))), _lag(motion, log), identification, truth, loop)


def _lag(motion: ExcitationMotion, log: Log) -> float:
    away = np.abs(motion.position - log.position.values)
    parts = [
        away[slice(*np.searchsorted(motion.time, (begin, begin + piece.duration)))]
        for piece, begin in zip(motion.pieces, motion.begins, strict=True)
        if piece.name in ("triangles", "decaying loops")
    ]
    return float(np.max(np.concatenate(parts))) if parts else 0.0


def model_to_fit(friction: Model) -> str:
    """Return the name of the model that is fitted: that of the prior, unless it has lists of elements."""
    component = friction.component
    return FITTED if any(component.is_array(name) for name in component.variables) else friction.name


def recorded(motion: ExcitationMotion, axis: Axis, prior: Prior) -> tuple[Log, np.ndarray, bool]:
    """Return the log of a motion run on the prior, the friction force along it [N or N*m], and whether in the loop."""
    # The velocity at a sample is the mean over the step around it.
    dt, v = motion.sample_time, motion.velocity
    expected = force_along(prior.friction, v, dt, motion.position + 0.5 * dt * v)
    disturbance = (_scattered(motion) - 1.0) * expected
    generator = np.random.default_rng(1)
    size = float(np.sqrt(np.mean(expected**2)))
    noise = NOISE * size * generator.standard_normal(expected.size)
    trace = _in_loop(motion, axis, prior, disturbance)
    if trace is not None:
        position, effort, friction = trace.measured, trace.command, trace.friction
    else:
        step = axis.resolution or 0.0
        position = np.round(motion.position / step) * step if step else motion.position
        friction = expected + disturbance
        effort = prior.plant.values["M"] * motion.acceleration + friction
    offset = axis.offset if isinstance(axis.offset, float) else 0.0
    return _log(motion, position, effort + offset + noise, axis), friction, trace is not None


def _in_loop(motion: ExcitationMotion, axis: Axis, prior: Prior, disturbance: np.ndarray) -> Trace | None:
    """Return the run in the loop of the controller; None where there is none, or where it is not stable.

    A controller is tuned to the mass of its axis: with a mass that is a guess, its loop would tell nothing.
    """
    if axis.controller is None or not prior.mass_known:
        return None
    trace = run_closed_loop(
        prior.plant,
        prior.friction,
        axis.controller,
        encoder(kind=axis.kind, resolution=axis.resolution or 0.0),
        np.stack((motion.position, motion.velocity, motion.acceleration, np.zeros_like(motion.time))),
        motion.sample_time,
        steps=SUBSTEPS,
        disturbance=disturbance,
        limit=axis.effort_limit or math.inf,
        x=float(motion.position[0]),
    )
    if trace.status is Status.NOT_FINITE:
        return None
    astray = float(np.max(np.abs(trace.position - motion.position)))
    return None if astray > ASTRAY * float(np.ptp(motion.position)) else trace


def _scattered(motion: ExcitationMotion) -> np.ndarray:
    """Return a factor for the friction force at each sample, drawn anew after every reversal."""
    turns = reversals(motion.velocity)
    factors = 1.0 + SCATTER * np.random.default_rng(2).standard_normal(turns.size + 1)
    return factors[numbered(turns, motion.velocity.size)]


def _log(motion: ExcitationMotion, position: np.ndarray, effort: np.ndarray, axis: Axis) -> Log:
    length, force = unit_of("length", axis.kind), unit_of("force", axis.kind)
    return Log(
        time=Channel(motion.time, "s", "time"),
        position=Channel(position, length, "position"),
        effort=Channel(effort, force, "effort"),
        reference=Channel(motion.position, length, "reference"),
        sample_time=motion.sample_time,
        segments=(slice(0, motion.time.size),),
        kind=axis.kind,
    )
