"""A plant with friction, integrated with steps whose length follows from a tolerance."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle.core import Amount, Model, Status, Variable, amount, guarded
from bristle.engine.compilation import compiled, driver
from bristle.engine.entry_points import OUT_SIZE, Substeps
from bristle.engine.instance import Instance, memory_of
from bristle.engine.loop import DRIVEN, MECHANISM, Trace, held, substeps_entry, vectors_of
from bristle.engine.motion import presliding_distance
from bristle.engine.screwed import refuse_screw
from bristle.engine.step_doubling import (
    GIVE_UP,
    ROUNDING,
    Course,
    DoublingEntries,
    Limits,
    Samples,
    doubling,
    make_rest_time,
)

# Measured on stick-slip, pre-sliding and break-away: with this share of the tolerance allowed over the duration, the
# global error stays below the tolerance. A contact must be resolved for any tolerance, or it breaks away at the wrong
# time: hence the limit on the share of its pre-sliding distance per step.
SHARE_OF_TOLERANCE, SHARE_OF_PRESLIDING = 0.3, 0.02
# After sliding over this many pre-sliding distances, a contact only follows the motion.
FAR = 5.0
SHORTEST_STEP, FIRST_STEP = 1e-13, 1e-6


@dataclass(frozen=True, kw_only=True)
class AdaptiveTrace(Trace):
    """Result of an adaptive run: a `Trace`, and the numbers of steps.

    Parameters
    ----------
    steps : int
        Number of accepted steps.
    rejected : int
        Number of rejected steps.
    """

    steps: int
    rejected: int


@guarded(
    **MECHANISM,
    **DRIVEN,
    tolerance=amount(Variable("length", "error wanted", min=0.0), exclusive=True),
    max_step=amount(Variable("time", "longest step", min=0.0), exclusive=True, endless=True),
)
def run_adaptive(
    plant: Model,
    friction: Model,
    effort: Any,
    dt: Amount,
    *,
    tolerance: Amount,
    hold: str = "linear",
    max_step: Amount = np.inf,
    x: Amount = 0.0,
    v: Amount = 0.0,
    state: Any = None,
    memory: Any = None,
) -> AdaptiveTrace:
    """Drive a plant with friction by a recorded effort, with steps whose length follows from a tolerance.

    Parameters
    ----------
    plant, friction : Model
        The mechanism.
    effort : array_like, shape (sample,)
        Effort [N or N*m] at each sample. Steps end at its corners and jumps.
    dt : float
        Time between samples [s]; steps may be longer.
    tolerance : float
        Allowed error of the position over the whole run [m or rad]. An unstable motion multiplies errors as it grows:
        compare with a second run at a tenth of the tolerance.
    hold : {"linear", "zero"}
        Effort between samples: linear to the next sample, or constant.
    max_step : float
        Longest step [s].
    x, v : float
        Position [m or rad] and velocity [m/s or rad/s] at the first sample.
    state, memory
        State and memory of the friction model at the first sample; virgin by default.

    Returns
    -------
    AdaptiveTrace
        Position, velocity, effort and friction at each sample.

    Raises
    ------
    InputError
        If the tolerance is not positive.

    Examples
    --------
    >>> from bristle import friction, plants
    >>> plant = plants.pulled_inertia(M=1.0, k=2.0, v_e=0.1)
    >>> run_adaptive(plant, friction.coulomb(F_C=1.0), [0.0] * 8, 1.0, tolerance=1e-6).position.round(3)
    array([0.   , 0.   , 0.   , 0.   , 0.   , 0.   , 0.03 , 0.178])
    """
    refuse_screw(plant, "run_adaptive")
    distance = presliding_distance(friction)
    times = dt * np.arange(effort.size + 1)
    duration = float(times[-1])
    course = _stretches(effort, held(effort, hold), dt)
    # The last sample must not be missed by rounding.
    course.knots[-1] = duration * (1.0 + 1e-12)

    body, contact = Instance(plant), Instance(friction)
    body.state[0], body.state[1] = x, v
    contact.begin(state)
    limits = Limits(
        SHARE_OF_TOLERANCE * tolerance / duration,
        SHARE_OF_PRESLIDING * distance,
        min(max_step, duration),
        SHORTEST_STEP * duration,
        FIRST_STEP * duration,
        FAR * distance if np.isfinite(distance) else 0.0,
        SHARE_OF_TOLERANCE * tolerance,
    )
    rest_time = compiled(
        f"rest_time-{body.key}-{contact.key}",
        lambda: make_rest_time(*body.structures, *contact.structures),
        Substeps,
        body.functions + contact.functions,
    )
    vectors = vectors_of(body, contact, memory_of(friction, memory), np.zeros(OUT_SIZE))
    before, full_step = (
        vectors._replace(
            plant_state=body.state.copy(),
            friction_state=contact.state.copy(),
            out=np.zeros(OUT_SIZE),
        )
        for _ in range(2)
    )
    before = before._replace(memory=vectors.memory.copy())
    entries, samples, report = (
        DoublingEntries(substeps_entry(body, contact), rest_time),
        Samples(times, *np.zeros((3, times.size))),
        np.zeros(4),
    )
    reached = int(
        driver(doubling)(entries, vectors, before, full_step, course, limits, samples, report)
    )
    cut = slice(0, min(reached, effort.size))
    accepted, rejected, missed, failed = report
    if tolerance < 16.0 * ROUNDING * float(np.max(np.abs(samples.x))):
        missed = max(missed, 1.0)
    causes = {
        Status.NOT_FINITE: reached < samples.times.size and missed <= GIVE_UP,
        Status.MEMORY_OVERFLOW: contact.lost > 0,
        Status.TOLERANCE_MISSED: missed > 0.0,
        Status.SOLVE_INACCURATE: failed > 0.0,
    }
    x, v = samples.x[cut], samples.v[cut]
    return AdaptiveTrace(
        time=samples.times[cut],
        position=x,
        velocity=v,
        effort=effort[cut],
        friction=np.diff(samples.impulse)[cut] / dt,
        measured=x,
        command=effort[cut],
        motor_position=x,
        motor_velocity=v,
        status=next((status for status, happened in causes.items() if happened), Status.OK),
        steps=int(accepted),
        rejected=int(rejected),
        kind=contact.model.kind,
    )


def _stretches(start: np.ndarray, end: np.ndarray, dt: float) -> Course:
    """Return knots [s], and efforts at both ends of each stretch; collinear samples form one stretch."""
    slope = end - start
    bends = np.flatnonzero((start[1:] != end[:-1]) | (slope[1:] != slope[:-1])) + 1
    first = np.concatenate(([0], bends))
    last = np.append(bends, start.size) - 1
    return Course(dt * np.append(first, start.size).astype(float), start[first], end[last])
