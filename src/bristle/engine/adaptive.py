"""A plant with friction, integrated with steps of the length that a tolerance asks for."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.edge import FLAG, Amount, among, amount, guarded
from bristle.core.errors import InputError
from bristle.core.motion import Motion
from bristle.core.packing import pack, structure_of, unpacker
from bristle.core.status import Status
from bristle.core.variable import Variable
from bristle.engine import rodas5p
from bristle.engine.compilation import compiled, driver
from bristle.engine.entry_points import OUT_SIZE, Substeps
from bristle.engine.instance import Instance, memory_of
from bristle.engine.loop import DRIVEN, MECHANISM, Trace, held, substeps_entry, vectors_of
from bristle.engine.motion import presliding_distance
from bristle.engine.pieces import Layout, PieceVectors, Rates, Turn, make_rates, make_turn, never_turn
from bristle.engine.rosenbrock import STAGES, RosenbrockEntries, Search, Step, Tableau, Work, make_search, make_step, rosenbrock
from bristle.engine.screwed import refuse_screw
from bristle.engine.step_doubling import DoublingEntries, doubling, make_rest_time
from bristle.engine.step_length import GIVE_UP, ROUNDING, Course, Limits, Samples

__all__ = ["METHODS", "AdaptiveTrace", "run_adaptive"]

METHODS = ("auto", "efim", "rosenbrock")
# Measured on stick-slip, pre-sliding and break-away: with this share of the tolerance allowed over the duration, the
# global error stays below the tolerance. A contact must be resolved whatever the tolerance, or it breaks away at the
# wrong time: hence the share of its pre-sliding distance allowed per step.
SHARE_OF_TOLERANCE = {"efim": 0.3, "rosenbrock": 0.1}
SHARE_OF_PRESLIDING = 0.02
# A contact carried along for so many times its pre-sliding distance only follows.
FAR = 5.0
REFINEMENTS = 4
SHORTEST_STEP, FIRST_STEP = 1e-13, 1e-6


@dataclass(frozen=True, kw_only=True)
class AdaptiveTrace(Trace):
    """What an adaptive run leaves behind: a `Trace`, and the count of its steps.

    Parameters
    ----------
    steps, rejected : int
        Steps that were accepted, and that were rejected.
    """

    steps: int
    rejected: int


@guarded(
    **MECHANISM,
    **DRIVEN,
    tolerance=amount(Variable("length", "error wanted", min=0.0), exclusive=True),
    method=among(*METHODS),
    verify=FLAG,
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
    method: str = "auto",
    max_step: Amount = np.inf,
    verify: bool = False,
    x: Amount = 0.0,
    v: Amount = 0.0,
    state: Any = None,
    memory: Any = None,
) -> AdaptiveTrace:
    """Drive a plant with friction by a recorded effort, with steps of the length that the tolerance asks for.

    Parameters
    ----------
    plant, friction : Model
        The mechanism.
    effort : array_like, shape (sample,)
        Effort [N or N*m] at each sample. Steps end where it bends or jumps, and only there.
    dt : float
        Time between samples [s]; steps may be longer.
    tolerance : float
        Largest error of the position wanted over the whole run [m or rad]. Where a motion is unstable, its growth
        multiplies errors; `verify` finds that out.
    hold : {"linear", "zero"}
        Between samples the effort runs straight to the next one, or is held.
    method : {"auto", "efim", "rosenbrock"}
        EFIM by step doubling serves every model. The Rosenbrock method, of order 5, serves plants and models with
        a ``rate``, and models with a ``flow`` from event to event; there ``"auto"`` takes it.
    max_step : float
        Longest step [s].
    verify : bool
        Integrate again and again, each time ten times as finely, until two runs agree within the tolerance.
    x, v : float
        Position [m or rad] and velocity [m/s or rad/s] at the first sample.
    state, memory
        Of the friction model at the first sample; virgin where not given.

    Returns
    -------
    AdaptiveTrace
        Position, velocity, effort and friction at each sample.

    Raises
    ------
    InputError
        If the tolerance is not positive, or the method does not fit the model.

    Examples
    --------
    >>> from bristle import friction, plants
    >>> plant = plants.pulled_inertia(M=1.0, k=2.0, v_e=0.1)
    >>> run_adaptive(plant, friction.coulomb(F_C=1.0), [0.0] * 8, 1.0, tolerance=1e-6).position.round(3)
    array([0.   , 0.   , 0.   , 0.   , 0.   , 0.   , 0.03 , 0.178])
    """
    refuse_screw(plant, "run_adaptive")
    chosen, distance = _method(plant, friction, method), presliding_distance(friction)
    times = dt * np.arange(effort.size + 1)
    duration = float(times[-1])
    course = _stretches(effort, held(effort, hold), dt)
    # The last sample must not be missed by rounding.
    course.knots[-1] = duration * (1.0 + 1e-12)

    def run(allowed: float) -> AdaptiveTrace:
        body, contact = Instance(plant), Instance(friction)
        body.state[0], body.state[1] = x, v
        contact.begin(state)
        limits = Limits(
            SHARE_OF_TOLERANCE[chosen] * allowed / duration,
            SHARE_OF_PRESLIDING * distance,
            min(max_step, duration),
            SHORTEST_STEP * duration,
            FIRST_STEP * duration,
            FAR * distance if np.isfinite(distance) else 0.0,
            SHARE_OF_TOLERANCE[chosen] * allowed,
        )
        record = _Record(times)
        by = _by_rosenbrock if chosen == "rosenbrock" else _by_doubling
        reached = by(body, contact, memory_of(friction, memory), course, limits, record)
        return record.trace(effort, dt, allowed, reached, contact)

    trace = run(tolerance)
    if not verify:
        return trace
    for refinement in range(1, REFINEMENTS + 1):
        coarse, trace = trace, run(tolerance * 0.1**refinement)
        is_alike = trace.position.size == coarse.position.size
        if is_alike and np.max(np.abs(trace.position - coarse.position), initial=0.0) <= tolerance:
            return trace
    return replace(trace, status=max(trace.status, Status.TOLERANCE_MISSED))


class _Record:
    """What a driver writes: the samples, and its report."""

    def __init__(self, times: np.ndarray) -> None:
        self.times = times
        self.position, self.velocity, self.impulse = (np.zeros(times.size) for _ in range(3))
        self.report = np.zeros(4)

    @property
    def samples(self) -> Samples:
        return Samples(self.times, self.position, self.velocity, self.impulse)

    def trace(self, u: np.ndarray, dt: float, tolerance: float, reached: int, contact: Instance) -> AdaptiveTrace:
        cut = slice(0, min(reached, u.size))
        accepted, rejected, missed, failed = self.report
        if tolerance < 16.0 * ROUNDING * float(np.max(np.abs(self.position))):
            missed = max(missed, 1.0)
        unfinished = reached < self.times.size and missed <= GIVE_UP
        causes = {
            Status.NOT_FINITE: unfinished,
            Status.MEMORY_OVERFLOW: contact.lost > 0,
            Status.TOLERANCE_MISSED: missed > 0.0,
            Status.SOLVE_INACCURATE: failed > 0.0,
        }
        x, v = self.position[cut], self.velocity[cut]
        return AdaptiveTrace(
            time=self.times[cut],
            position=x,
            velocity=v,
            effort=u[cut],
            friction=np.diff(self.impulse)[cut] / dt,
            measured=x,
            command=u[cut],
            motor_position=x,
            motor_velocity=v,
            status=next((status for status, happened in causes.items() if happened), Status.OK),
            steps=int(accepted),
            rejected=int(rejected),
            kind=contact.model.kind,
        )


def _method(plant: Model, friction: Model, method: str) -> str:
    """Return the method to be used; refuse one that does not fit."""
    smooth = plant.component.rate, friction.component.rate or friction.component.flow
    lacking = [model.name for model, rate in zip((plant, friction), smooth, strict=True) if rate is None]
    if method == "rosenbrock" and lacking:
        raise InputError(
            f"{' and '.join(lacking)} has no rate, which the Rosenbrock method integrates",
            path="method",
            value=method,
            mend='Use method="efim", which serves every model',
        )
    return "efim" if method == "efim" or lacking else "rosenbrock"


def _by_doubling(body: Instance, contact: Instance, memory: np.ndarray, course: Course, limits: Limits, record: _Record) -> int:
    rest_time = compiled(
        f"rest_time-{body.key}-{contact.key}",
        lambda: make_rest_time(*body.structures, *contact.structures),
        Substeps,
        body.functions + contact.functions,
    )
    vectors = vectors_of(body, contact, memory, np.zeros(OUT_SIZE))
    before, full_step = (
        vectors._replace(plant_state=body.state.copy(), friction_state=contact.state.copy(), out=np.zeros(OUT_SIZE)) for _ in range(2)
    )
    before = before._replace(memory=memory.copy())
    run = DoublingEntries(substeps_entry(body, contact, "efim"), rest_time)
    return int(driver(doubling)(run, vectors, before, full_step, course, limits, record.samples, record.report))


def _by_rosenbrock(body: Instance, contact: Instance, memory: np.ndarray, course: Course, limits: Limits, record: _Record) -> int:
    layout, varying, piece = _first_piece(body, contact, memory)
    key, functions = f"{body.key}-{contact.key}", body.functions + contact.functions
    if layout.piece is None:
        turn = compiled("never_turn", lambda: never_turn, Turn)
    else:
        turn = compiled(f"turn-{key}", lambda: make_turn(layout), Turn, functions)
    run = RosenbrockEntries(
        compiled(f"step-{key}", lambda: make_step(layout), Step, functions),
        compiled(f"rates-{key}", lambda: make_rates(layout), Rates, functions),
        compiled(f"search-{key}", lambda: make_search(layout), Search, functions),
        turn,
    )
    n = layout.size
    y = np.concatenate((body.state, varying, np.zeros(1)))
    work = Work(y, *(np.zeros(size) for size in (n, n, n, n * n, n * n, STAGES * n, n + 1, 9, n)))
    vectors = PieceVectors(body.parameters, contact.parameters, piece, contact.state, memory)
    tableau = Tableau(rodas5p.TABLEAU, rodas5p.ADVANCES, rodas5p.COUPLINGS, rodas5p.DENSE)
    return int(driver(rosenbrock)(run, vectors, work, course, limits, tableau, record.samples, record.report))


def _first_piece(body: Instance, contact: Instance, memory: np.ndarray) -> tuple[Layout, np.ndarray, np.ndarray]:
    """Return the layout of a continuous run, the numbers of the contact that vary, and those that hold at first."""
    component, (p, s) = contact.component, contact.structures
    if component.flow is None:
        return Layout(*body.structures, p, s, s, None), contact.state, np.zeros(0)
    motion = Motion(body.state[1], body.state[0])
    varies, holds = component.piece(unpacker(s)(contact.state), memory, motion, contact.model.parameters)
    layout = Layout(*body.structures, p, s, structure_of(varies), structure_of(holds))
    return layout, pack(varies), pack(holds)


def _stretches(start: np.ndarray, end: np.ndarray, dt: float) -> Course:
    """Return knots [s], and efforts at the beginning and the end of each stretch: samples on one line make one."""
    slope = end - start
    bends = np.flatnonzero((start[1:] != end[:-1]) | (slope[1:] != slope[:-1])) + 1
    first = np.concatenate(([0], bends))
    last = np.append(bends, start.size) - 1
    return Course(dt * np.append(first, start.size).astype(float), start[first], end[last])
