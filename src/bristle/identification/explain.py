r"""One linear stage that explains a log: friction, springs, cables, cogging, delay and load compete at once.

The columns of the `dictionary` are rows of one least-squares problem. Everything after their Gram matrices, one for each of
20 folds, is a choice of columns:

- weights, penalties and errors as in `gram`;
- the delay from rows at speed, where the memory of friction is saturated and cannot imitate a delay;
- ripples from the periodogram of the residual over the position;
- terms by backward elimination with the error of held-out folds;
- inertia, Coulomb and viscous friction from the rows at speed.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bristle.core.axis import Axis
from bristle.core.cores import cores_for_simulations
from bristle.core.variable import Kind
from bristle.files.arguments import logs_and_axes
from bristle.identification.dictionary import (
    AT_REST,
    SHAPES,
    Grid,
    Group,
    Motion,
    along_axis,
    line_of_ramps,
    memory_of,
    over_time,
    ramps,
)
from bristle.identification.explanation import Curve, Explanation, Part, explanation_of
from bristle.identification.friction_law import (
    Refitted,
    at_speed,
    friction_law,
    least_biased,
    refitted,
)
from bristle.identification.gram import rms
from bristle.identification.term_search import Choice, Search, chosen_terms, time_to_reversal
from bristle.identification.work_rate import FEWEST_ROWS, delayed, motion_of, narrowed
from bristle.logs.log import Log

NARROWER = (0.4, 0.16)  # of the cut-off: narrower bands for the delay
# Groups of elements that saturate within 0.3 % of the stroke.
MEMORY = ("stop", "fall", "dahl", "fall_dahl")
SETTLING = 2.0  # periods of the cut-off after a reversal, in which a row mixes both directions
LEAST_SETTLED = 0.5  # of the rows at speed
LEAST_BACKWARD = 0.02  # of the rows at speed in the rarer direction
MOST_CABLE = 0.5  # of the memory: with a larger cable, no row is saturated
POINTS = 401  # of a table


def explain(log: Any, axis: Any = None) -> Explanation:
    r"""Explain the effort of a log by friction, inertia and further forces, all at once.

    .. math:: u(t + \tau) = M a + o + p(x) + f(x, v, \text{past}) \Bigl(1 + \sum_k c_k \mu_k\Bigr)

    with friction :math:`f` of elements with memory and rising curves of the speed, a force :math:`p` over the position
    (spring, gravity of a link, cubic spring, free curve, ripples), a cable with a hysteresis of its own, and changes of
    the level of friction along the axis, with the load or over time. Non-negative least squares fits all of them; a term
    must lower the error of held-out parts of the log.

    The stage does not measure pre-sliding stiffness, break-away force and Stribeck speed: `identify` does.

    Parameters
    ----------
    log : Log, path, table of columns, or sequence of these
        One or several logs of one axis, with position and effort.
    axis : Axis, path, dict, or sequence of these, optional
        Description of the axis, or one per log.

    Returns
    -------
    Explanation
        Shares of the forces with their evidence, forces over position, speed and travel, inertia, Coulomb and viscous
        friction with 95 % intervals, delay, and the unexplained force.

    Raises
    ------
    InputError
        If the log has no effort, is too short, or hardly moves.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(12000) * 1e-3
    >>> x = 0.02 * np.sin(3.0 * t) + 0.01 * np.sin(11.0 * t)
    >>> v = 0.06 * np.cos(3.0 * t) + 0.11 * np.cos(11.0 * t)
    >>> effort = 12.0 * np.gradient(v, t) + 5.0 * np.sign(v) + 80.0 * v + 300.0 * x
    >>> explained = explain({"time": t, "position": x, "effort": effort})
    >>> [part.name for part in explained.terms], round(explained.M.value, 1)
    (['spring'], 12.0)
    """
    pairs = logs_and_axes(log, axis)
    with cores_for_simulations():
        return explained(fitted_terms(motion_of(pairs), delay_of(pairs)), pairs[0][0].kind)


def delay_of(pairs: Sequence[tuple[Log, Axis | None]]) -> float | None:
    """Return the delay of the effort that is left in logs [s]; None if their axes do not state it."""
    axes = [axis for _, axis in pairs if axis is not None]
    if all(axis.seeks_delay and not axis.delay for axis in axes):
        return None
    return 0.0


def fitted_terms(motion: Motion, delay: float | None = None) -> Refitted:
    """Return the fit of a motion with the terms that it shows, with a known delay or with its own."""
    choice = choice_for(motion, delay)
    widest = at_speed(choice)
    if delay is not None:
        return refitted(choice, widest)
    narrower = [narrowed(motion, share) for share in NARROWER]
    enough = [narrow for narrow in narrower if sum(narrow.counts) >= FEWEST_ROWS]
    best = least_biased([widest, *(at_speed(choice_for(narrow)) for narrow in enough)])
    if best.delay.value != widest.delay.value:
        choice = choice_for(delayed(motion, best.delay.value), best.delay.value)
    return refitted(choice, best)


def choice_for(motion: Motion, delay: float | None = None) -> Choice:
    """Return the terms of a motion, with a known delay or with its own."""
    search = Search(motion, delay)
    search.fit()
    return chosen_terms(search)


# ---------------------------------------------------------------- result
def explained(final: Refitted, kind: Kind) -> Explanation:
    """Return the result of a fit."""
    choice = final.choice
    friction = friction_law(final)
    forces = {group.name: final.rows(group) for group in final.groups}
    inertia = choice.groups[0]
    y = final.equations.y
    residual = y - sum(forces.values(), np.zeros(y.size))
    total = final.motion.row(final.motion.u, final.band.delay.value)
    return explanation_of(
        kind=kind,
        parts=parts_of(final, forces),
        inertia=rms(final.band.M.value * inertia.columns[:, 0]),
        effort=rms(total),
        unexplained=rms(residual),
        floor=floor_of(final, final.groups),
        filter=choice.evidence.get("filter"),
        rejected=choice.rejected,
        M=final.band.M,
        friction=friction,
        delay=final.band.delay,
        curves=curves_of(final),
        doubts=doubts_of(final),
    )


def floor_of(final: Refitted, groups: Sequence[Group]) -> float:
    """Return the rms error of held-out folds with some groups, each row with the same weight [N or N*m]."""
    equations = final.equations
    equations.weigh(np.ones(equations.count))
    errors, _ = equations.held_out(groups, final.fitted.penalties, final.fitted.support)
    equations.weigh(final.choice.search.weight)
    return equations.unit * math.sqrt(max(float(errors.sum()), 0.0) / equations.count)


def parts_of(final: Refitted, forces: Mapping[str, np.ndarray]) -> list[Part]:
    """Return the parts of the effort without inertia, the largest first; their shares sum up to 1."""
    sums = dict[str, np.ndarray]()
    for group in final.groups:
        if group.role == "filter":
            continue
        for name, force in named_forces(final, group, forces[group.name]).items():
            sums[name] = sums.get(name, 0.0) + force
    sizes = {name: rms(force) for name, force in sums.items()}
    total = max(sum(sizes.values()), np.finfo(float).tiny)
    frequencies = {group.name: group.frequency for group in final.groups}
    waves = {group.name: final.weights(group).tolist() for group in final.groups if group.frequency}
    parts = [
        Part(
            name=name,
            rms=size,
            share=size / total,
            evidence=final.choice.evidence.get(name),
            frequency=frequencies.get(name, 0.0),
            wave=tuple(waves.get(name, ())),
        )
        for name, size in sizes.items()
        if size > 0.0
    ]
    return sorted(parts, key=lambda part: -part.rms)


def named_forces(final: Refitted, group: Group, force: np.ndarray) -> dict[str, np.ndarray]:
    """Return the force of a group by the parts to which it belongs."""
    if group.name == "ramps":
        return named_ramps(final, group, force)
    if group.role == "place" and not group.frequency:
        # Its mean is a part of the constant force.
        return {group.name: force - force.mean(), "offset": np.full_like(force, force.mean())}
    if group.name not in MEMORY:
        return {group.name: force}
    members = memory_of(final.choice.search.grid)[group.name]
    falls = np.array([math.isfinite(element.v_S) and element.c == 0.0 for element in members])
    falling = group.columns @ np.where(falls, final.weights(group), 0.0)
    return {"coulomb": force - falling, "stribeck": falling}


def named_ramps(final: Refitted, group: Group, force: np.ndarray) -> dict[str, np.ndarray]:
    """Return the line of the rising curves at high speed, which is viscous, and the rest, which does not rise there."""
    v = final.motion.v[final.motion.places]
    viscous = line_of_ramps(v, final.weights(group), final.choice.search.grid.V)
    return {"viscous": viscous, "coulomb": force - viscous}


def curves_of(final: Refitted) -> dict[str, Curve]:
    """Return the forces over position, speed and travel, and the level of friction over position and time."""
    search = final.choice.search
    grid = search.grid
    weights = {group.name: final.weights(group) for group in final.groups}
    x = np.linspace(grid.low, grid.high, POINTS)
    place = np.zeros(x.size)
    level = np.ones(x.size)
    time = np.linspace(0.0, search.motion.span, POINTS)
    warm = np.ones(time.size)
    for group in final.groups:
        if group.role == "place" and not group.frequency:
            place += weights[group.name] @ SHAPES[group.name](x, grid)
        elif group.name == "level":
            level += weights["level"] @ along_axis(x, grid)
        elif group.name == "warmup":
            warm += weights["warmup"] @ over_time(time, search.motion.span)
    v = np.linspace(-grid.V, grid.V, POINTS + 1)
    # Slower than that, the rows do not show the limits of falling elements.
    v = v[np.abs(v) > AT_REST * grid.V]
    travel = np.geomspace(0.1 * grid.narrow[0], grid.stroke, POINTS)
    return {
        "position": Curve("length", x, "force", place - place.mean()),
        "level": Curve("length", x, "1", level),
        "time": Curve("time", time, "1", warm),
        "speed": Curve("length/time", v, "force", steady_friction(weights, grid, v)),
        "travel": Curve("length", travel, "force", after_reversal(weights, grid, travel)),
    }


def steady_friction(weights: Mapping[str, np.ndarray], grid: Grid, v: np.ndarray) -> np.ndarray:
    """Return friction at constant velocities [N or N*m]."""
    total = weights["viscous"][0] * v + weights["ramps"] @ ramps(v, grid.V)
    for name, members in memory_of(grid).items():
        for weight, element in zip(weights.get(name, ()), members, strict=False):
            total += weight * element.limit(v) * np.sign(v)
    return total


def after_reversal(weights: Mapping[str, np.ndarray], grid: Grid, travel: np.ndarray) -> np.ndarray:
    """Return friction after a slow reversal, over the travel [N or N*m]."""
    total = np.zeros(travel.size)
    for name, members in memory_of(grid).items():
        for weight, element in zip(weights.get(name, ()), members, strict=False):
            total += weight * element.after_reversal(travel)
    return total


def doubts_of(final: Refitted) -> tuple[str, ...]:
    """Return the reasons for which the numbers of the rows at speed are unknown."""
    doubts = list[str]()
    named = final.named
    nothing = np.zeros(final.equations.count)
    memory = rms(sum((final.rows(named[name]) for name in MEMORY if name in named), nothing))
    cable = rms(final.rows(named["cable"])) if "cable" in named else 0.0
    if cable > MOST_CABLE * max(memory + cable, np.finfo(float).tiny):
        doubts.append("not_saturated")
    search = final.choice.search
    settled = search.fast[time_to_reversal(final.motion) > SETTLING].sum()
    if settled < LEAST_SETTLED * search.fast.sum():
        doubts.append("reverses_fast")
    if final.band.M.half_width > final.band.M.value:
        doubts.append("no_inertia")
    if final.band.is_at_edge:
        doubts.append("delay_at_edge")
    forward = search.fast[final.motion.v[final.motion.places] > 0.0].sum() / search.fast.sum()
    if min(forward, 1.0 - forward) < LEAST_BACKWARD:
        doubts.append("one_direction")
    if "load" in named:
        doubts.append("loaded")
    return tuple(doubts)
