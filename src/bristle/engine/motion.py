"""Friction along a prescribed motion, hysteresis along a path: no plant, no solve, one pass."""

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from bristle.core import InputError, Variable, did_you_mean
from bristle.core.contracts import NOTHING_TRANSMITTED, Model
from bristle.core.edge import Amount, among, amount, array, guarded, model, optional, vector
from bristle.core.experiment import RESTS
from bristle.core.surroundings import motion_with
from bristle.core.values import looked_at
from bristle.engine import entry_points
from bristle.engine.checks import FRICTION, PERIOD, SPEED, STATE, check_run, finite
from bristle.engine.instance import Instance, entry_of, memory_of, warn_of_lost
from bristle.engine.path import after, output_along
from bristle.models.controllers.feedforward import Shape
from bristle.models.friction.resting import with_rest

# From a picometre to a metre, and each step takes so long [s] that viscous parts do not show.
FARTHER = np.geomspace(1e-12, 1.0, 120)
SLOW = 1e6
CREEP = np.diff(FARTHER) / SLOW
AROUND = array(single=True)
MOTION = {"model": FRICTION, "v": array(), "dt": PERIOD}


@guarded(**MOTION, x=optional(array()), state=STATE, memory=optional(array()))
def force_along(
    model: Model,
    v: Any,
    dt: Amount,
    x: Any = None,
    *,
    state: Any = None,
    memory: np.ndarray | None = None,
    **around: Any,
) -> np.ndarray:
    """Return the friction force along a prescribed velocity.

    Parameters
    ----------
    model : Model
        A friction model with parameters.
    v : array_like, shape (step,)
        Mean velocity of each step [m/s or rad/s]; +0.0 and -0.0 are the two one-sided limits.
    dt : float
        Length of a step [s].
    x : array_like, shape (step,), optional
        Position at the end of each step [m or rad]; by default the integral of `v`.
    state : NamedTuple, optional
        State before the first step; virgin by default.
    memory : ndarray, optional
        Memory before the first step; the run does not change it.
    **around : float or array_like, shape (step,)
        Surroundings of the contact: `load` over its nominal value, `temperature` [K], `transmitted` effort to the load
        [N or N*m], and channels of slots of your own, by name [SI]. The default is the nominal value.

    Returns
    -------
    ndarray, shape (step,)
        Mean friction force of each step [N or N*m], positive when it opposes ``v > 0``.
    """
    return finite(
        along(model, v, dt, x, state=state, memory=memory, **_checked(model, around)), model
    )


def along(
    model: Model,
    v: np.ndarray,
    dt: float,
    x: np.ndarray | None = None,
    *,
    state: Any = None,
    memory: np.ndarray | None = None,
    **around: Any,
) -> np.ndarray:
    """Return the force of `force_along`, finite or not: a search may try parameters that overflow."""
    part, v = Instance(model), vector(v, "v")
    x = np.cumsum(v) * dt if x is None else vector(x, "x")
    part.begin(state)
    check_run(v.size, x=x)
    return follow(part, memory_of(model, memory), v, x, dt, _surroundings(part, v.size, around))


def in_turns(
    model: Model,
    parameters: np.ndarray,
    v: np.ndarray,
    dt: float,
    x: np.ndarray,
    starts: Sequence[int],
    **around: Any,
) -> np.ndarray:
    """Return the friction force along a prescribed velocity with parameters that change between turns, finite or not.

    The state of the contact continues from turn to turn, as for strokes over a surface of varying roughness. `parameters`
    are those of each turn, shape (turn, number), in the layout of `bristle.core.packing.pack`, and `starts` is the first
    step of each turn, beginning with 0.
    """
    part, memory, v, x = Instance(model), memory_of(model, None), vector(v, "v"), vector(x, "x")
    check_run(v.size, x=x)
    signals, force = _surroundings(part, v.size, around), np.empty(v.size)
    for row, (first, last) in zip(parameters, pairwise([*starts, v.size]), strict=True):
        part.parameters = np.ascontiguousarray(row)
        turn = slice(first, last)
        force[turn] = follow(part, memory, v[turn], x[turn], dt, signals[:, turn])
    return force


def compensation_along(
    model: Model,
    shape: Shape,
    v: np.ndarray,
    dt: float,
    x: np.ndarray,
    *,
    transmitted: Any = NOTHING_TRANSMITTED,
    state: Any = None,
    memory: np.ndarray | None = None,
) -> np.ndarray:
    """Return the effort [N or N*m] that a compensator feeds forward along a desired motion, step by step."""
    part = Instance(model)
    part.begin(state)
    passed_on = (
        np.full(v.size, float(transmitted)) if np.ndim(transmitted) == 0 else vector(transmitted)
    )
    check_run(v.size, x=x, transmitted=passed_on)
    effort = np.empty(v.size)
    entry = entry_of(
        "compensate_along", part, entry_points.CompensateAlong, entry_points.make_compensate_along
    )
    entry(
        part.parameters,
        part.state,
        memory_of(model, memory),
        np.array(shape),
        v,
        x,
        passed_on,
        float(dt),
        effort,
    )
    warn_of_lost(part)
    return finite(effort, model)


def _checked(model: Model, around: Mapping[str, Any]) -> dict[str, Any]:
    """Return the given surroundings of a contact as numbers."""
    usual = motion_with(model.component.surroundings)._field_defaults
    for name in around:
        if name not in usual:
            raise InputError(
                f"is not a channel of {model.name}",
                path=name,
                allowed=", ".join(usual),
                mend=did_you_mean(name, usual),
            )
    return {name: looked_at(AROUND, value, name, None) for name, value in around.items()}


def _surroundings(part: Instance, count: int, around: Mapping[str, Any]) -> np.ndarray:
    """Return the surroundings of a contact in each step that its motion contains, shape (surrounding, step)."""
    usual = part.motion._field_defaults
    table = np.empty((len(usual), count))
    for row, (name, value) in zip(table, usual.items(), strict=True):
        signal = around.get(name, value)
        if np.ndim(signal) > 0:
            signal = vector(signal)
            check_run(count, **{name: signal})
        row[:] = signal
    return table


@guarded(model=FRICTION, v=SPEED)
def settled(model: Model, v: Amount) -> tuple[Any, np.ndarray]:
    """Return the state and the memory of a friction model after steady sliding.

    Parameters
    ----------
    model : Model
        A friction model with parameters.
    v : float
        Velocity [m/s or rad/s]; zero returns the virgin state.

    Returns
    -------
    state : NamedTuple
        State of the model.
    memory : ndarray
        Memory of the model.
    """
    part, memory = Instance(model), memory_of(model, None)
    if v != 0.0:
        # Growing steps, from a picometre to a metre, settle a contact of any stiffness.
        for distance in np.geomspace(1e-12, 1.0, 80):
            finite(follow(part, memory, np.array([v]), np.zeros(1), distance / abs(v)), model)
    return part.state_now, memory


@guarded(model=FRICTION, amplitude=amount(Variable("length", "amplitude of the sweep", min=0.0)))
def conditioned(model: Model, amplitude: Amount) -> tuple[Any, np.ndarray]:
    """Return the state and the memory of a friction model after a sweep that decays from `amplitude` [m or rad] to 0.

    This brings a contact of unknown history to a known state: the sweep overwrites earlier turning points inside this
    amplitude. The sweep is slow and ends at its start.
    """
    part, memory = Instance(model), memory_of(model, None)
    if amplitude > 0.0:
        turn = np.arange(481) / 40.0  # twelve turns, 40 steps each
        path = amplitude * (1.0 - turn / 12.0) * np.sin(2.0 * np.pi * turn)
        finite(follow(part, memory, np.diff(path) / SLOW, path[1:], SLOW), model)
    return part.state_now, memory


@lru_cache(maxsize=256)
def presliding_distance(model: Model) -> float:
    """Return the distance [m or rad] to half the largest force of a virgin contact in slow motion; infinite for a static map."""
    part, memory = Instance(model), memory_of(model, None)
    if part.state.size + memory.size == 0:
        return float("inf")
    force = np.abs(follow(part, memory, CREEP, FARTHER[1:], SLOW))
    largest = float(np.max(force))
    return float(FARTHER[np.argmax(force >= 0.5 * largest)]) if largest > 0.0 else float("inf")


def follow(
    part: Instance,
    memory: np.ndarray,
    velocity: np.ndarray,
    position: np.ndarray,
    dt: float,
    around: np.ndarray | None = None,
) -> np.ndarray:
    """Return the friction force along a motion, and update the state and memory of the component."""
    force = np.empty(velocity.size)
    signals = (_surroundings(part, velocity.size, {}) if around is None else around).ravel()
    force_along_entry(part)(
        part.parameters, part.state, memory, velocity, position, signals, float(dt), force
    )
    warn_of_lost(part)
    return force


def force_along_entry(part: Instance) -> Callable[..., Any]:
    """Return the entry that runs this friction model along a prescribed motion."""
    return entry_of(
        "force_along", part, entry_points.ForceAlong, entry_points.make_force_along, part.motion
    )


@guarded(
    model=model("friction", "hysteresis"),
    x=array(least=1),
    dt=optional(PERIOD),
    history=array(),
    rest=among(*RESTS),
)
def response(
    model: Model, x: Any, dt: Amount | None = None, *, history: Any = (), rest: str = "middle"
) -> np.ndarray:
    """Return the friction force along a prescribed position, or the output of a hysteresis operator along its input.

    Parameters
    ----------
    model : Model
        A friction model or a hysteresis operator, with parameters.
    x : array_like, shape (time,)
        Position [m or rad] at equal time steps; for an operator, its input without time.
    dt : float or str
        Time step [s], or text such as ``"1 ms"``; only for friction models.
    history : array_like, shape (sample,), optional
        Inputs of an operator before the first sample (`bristle.models.hysteresis.saturated`, `bristle.models.hysteresis.conditioned`).
        By default the operator is virgin at the input 0.
    rest : {"middle", "held"}
        Force of a friction model without memory in a step of length 0, for which Coulomb friction is not unique: the mean
        of both directions, or the force of the last direction.

    Returns
    -------
    ndarray, shape (time,)
        Mean friction force [N or N*m] of the step that ends at each sample; 0 at the first sample, the origin. For an
        operator, its output at each sample; it reaches the first sample in one move from the end of the history.

    Raises
    ------
    InputError
        If `x` is not a finite 1-D array of at least one sample, if `dt` is not positive, or if an argument does not apply
        to this kind of model.

    Examples
    --------
    >>> from bristle import friction, hysteresis
    >>> response(friction.coulomb(F_C=2.0), [0.0, 1e-3, 2e-3, 1e-3, 1e-3], 0.1)
    array([ 0.,  2.,  2., -2.,  0.])
    >>> response(friction.coulomb(F_C=2.0), [0.0, 1e-3, 2e-3, 1e-3, 1e-3], 0.1, rest="held")
    array([ 0.,  2.,  2., -2., -2.])
    >>> response(hysteresis.preisach(s=1.0, f_p=1.0), [1.0, 0.0, 1.0])
    array([ 0.5       , -0.16666667,  0.5       ])
    """
    if model.component.family == "hysteresis":
        if dt is not None:
            raise InputError(
                "does not apply to a hysteresis operator", path="dt", value=dt, mend="Omit dt"
            )
        state, memory = after(model, history)
        return finite(output_along(model, x, state=state, memory=memory), model)
    if len(history):
        raise InputError(
            "applies only to hysteresis operators",
            path="history",
            mend="Prepend the earlier motion to x",
        )
    if dt is None:
        raise InputError("is needed for a friction model", path="dt", allowed="> 0 s")
    force = np.zeros(x.size)
    with np.errstate(over="ignore"):  # an overflow is refused as a velocity
        velocity = np.diff(x) / dt
    force[1:] = force_along(with_rest(model, rest), velocity, dt, x[1:])
    return force
