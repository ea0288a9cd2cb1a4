r"""One linear stage that explains a log: friction, springs, cables, cogging, delay and load compete at once.

The columns of the `dictionary` are rows of one least-squares problem. Everything after their Gram matrices, one for each of
20 folds, is a choice of columns:

- weights, penalties and errors as in `gram`;
- the delay from rows at speed, where the memory of friction is saturated and cannot imitate a delay;
- ripples from the periodogram of the residual over the position;
- terms by backward elimination with the error of held-out folds;
- inertia, Coulomb and viscous friction from the rows at speed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from bristle.core.cores import cores_for_simulations
from bristle.core.variable import Kind
from bristle.files.arguments import logs_and_axes
from bristle.identification.dictionary import (
    SHAPES,
    Element,
    Grid,
    Group,
    Motion,
    along_axis,
    elements,
    filter_group,
    friction_groups,
    grid_of,
    level_groups,
    memory_group,
    memory_of,
    over_time,
    place_groups,
    plant_groups,
    ramps,
    ripple_group,
)
from bristle.identification.explanation import (
    Curve,
    Evidence,
    Explanation,
    Friction,
    Interval,
    Part,
    explanation_of,
)
from bristle.identification.gram import FOLDS, Equations, Fitted
from bristle.identification.work_rate import motion_of

SLOW = 0.05  # of the top speed: rows below it have no weight in the delay and the inertia
RISE = 0.1  # of the top speed, over which the weight of a row rises to 1
LEAST_WEIGHT = 1e-3
COARSE = np.arange(-4, 14) * 0.05  # periods of the cut-off: first delays of the search
FINE = np.arange(-3, 4) * 0.02  # periods of the cut-off: further delays around the best one
PASSES = 2  # over the changes of the level, which are relative to the friction of the last fit

NO_MOTION = 2e-3  # of the top speed
BANDS = np.array(
    [0.5, 1.0, 2.0, 4.0, 8.0, 16.0]
)  # periods of the cut-off from a row to the nearest reversal
QUIET = 0.25  # of the median power of the residual: its power in a band, at least

CELLS = 16_384  # of the stroke, for the periodogram over the position
PADDING = 4  # lengths of the padded periodogram
SLOWEST_WAVE = 2.5  # waves in the stroke
FASTEST_WAVE = 2000.0  # waves in the stroke
WAVES_A_SEARCH = 4
MOST_WAVES = 6
LEAST_WAVE = 0.004  # of the power of the residual
FALSE_WAVE = 0.01  # chance that white noise shows a wave
NEAR_WAVES = 0.7  # waves in the stroke: nearer frequencies are the same

LEAST_GAIN = 0.012  # of the rms of friction, held out: the smallest term
LEAST_CABLE = 0.006
LEAST_Z = 2.5  # standard errors of the mean logarithm of the held-out errors
MOST_RISE = 1.04  # factor of the squared error, above which two fits differ
APART = 2.0  # standard errors at which two fits differ
NEAR_THRESHOLD = 5.0  # factor between the threshold of a law and those tried with a Stribeck speed
REFINEMENTS = (2.0, 1.25, 1.06)  # factor of the Stribeck speed to either side, in three searches
TRIALS = 7  # Stribeck speeds of a search

FLOOR_OF_M = 0.003  # of the value: error of the treatment
FLOOR_BESIDE_FRICTION = 0.001  # of the effort: error of the inertial force
FLOOR_OF_FRICTION = 0.001  # of the value
FLOOR_OF_SPLIT = 0.05  # of the limit of the cable: error of Coulomb friction beside it
FLOOR_OF_DELAY = 0.005  # periods of the cut-off
MEMORY = (
    "stop",
    "fall",
    "dahl",
    "fall_dahl",
)  # groups of elements that saturate within 0.3 % of the stroke
SETTLING = 2.0  # periods of the cut-off after a reversal, in which a row mixes both directions
LEAST_SETTLED = 0.5  # of the rows at speed
LEAST_BACKWARD = 0.02  # of the rows at speed in the rarer direction
MOST_CABLE = 0.5  # of the memory: with a larger cable, no row is saturated
POINTS = 401  # of a table
STUDENT = 2.0  # standard errors of a 95 % interval from 60 stretches


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
        motion = motion_of(pairs)
        search = Search(motion)
        search.fit()
        chosen = chosen_terms(search)
        return explained(chosen, pairs[0][0].kind)


# ---------------------------------------------------------------- weights of rows, ripples
def time_to_reversal(motion: Motion) -> np.ndarray:
    """Return the time from each row to the nearest reversal or rest, in periods of the cut-off, shape (row,)."""
    speed = np.abs(motion.v)
    side = np.sign(np.where(speed > NO_MOTION * speed.max(), motion.v, 0.0))
    turns = np.flatnonzero(np.diff(side) != 0.0)
    ends = np.concatenate([[-np.inf], turns, [np.inf]])
    after = np.searchsorted(turns, motion.places) + 1
    gap = np.minimum(ends[after] - motion.places, motion.places - ends[after - 1])
    return gap * motion.dt * motion.cutoff


def reversal_weights(motion: Motion, residual: np.ndarray) -> np.ndarray:
    """Return the weight of each row, by the residual in bands of the time to the nearest reversal."""
    band = np.searchsorted(BANDS, time_to_reversal(motion))
    power = np.full(BANDS.size + 1, np.nan)
    for number in np.unique(band):
        power[number] = np.mean(residual[band == number] ** 2)
    power = np.maximum(power, QUIET * np.nanmedian(power))
    weight = 1.0 / power[band]
    return weight / weight.mean()


def waves_in(motion: Motion, grid: Grid, residual: np.ndarray) -> list[float]:
    """Return the frequencies of waves in the residual over the position [1/m or 1/rad], the strongest first."""
    x = motion.x[motion.places]
    left = residual.copy()
    cell = np.minimum(((x - grid.low) / grid.stroke * CELLS).astype(int), CELLS - 1)
    frequencies = np.fft.rfftfreq(PADDING * CELLS, grid.stroke / CELLS)
    # Shorter waves are the noise of the position.
    fastest = min(FASTEST_WAVE / grid.stroke, 0.25 / max(grid.narrow[0], 1e-300))
    able = (frequencies > SLOWEST_WAVE / grid.stroke) & (frequencies < fastest)
    trials = max(np.count_nonzero(able) / PADDING, 2.0)
    least = max(LEAST_WAVE, 2.0 * math.log(trials / FALSE_WAVE) / x.size)
    waves = list[float]()
    total = float(left @ left)
    for _ in range(WAVES_A_SEARCH):
        sums = np.bincount(cell, left, CELLS)
        spectrum = np.abs(np.fft.rfft(sums, PADDING * CELLS)) ** 2
        best = float(frequencies[able][np.argmax(spectrum[able])])
        fits = [
            wave_at(best + shift / grid.stroke, x, left) for shift in np.linspace(-0.3, 0.3, 13)
        ]
        frequency, power, wave = max(fits, key=lambda fit: fit[1])
        if power < least * total:
            break
        waves.append(frequency)
        left = left - wave
    return waves


def wave_at(
    frequency: float, x: np.ndarray, residual: np.ndarray
) -> tuple[float, float, np.ndarray]:
    """Return a frequency, and power and values of its wave in a residual."""
    phase = 2.0 * np.pi * frequency * x
    W = np.stack([np.cos(phase), np.sin(phase)], axis=1)
    right = W.T @ residual
    weights = np.linalg.solve(W.T @ W, right)
    return frequency, float(weights @ right), W @ weights


# ---------------------------------------------------------------- all columns at once
class Search:
    """The fit of all columns: delay, ripples, and the friction to which changes of the level are relative."""

    def __init__(self, motion: Motion) -> None:
        self.motion = motion
        self.grid = grid_of(motion)
        self.plant = plant_groups(motion)
        self.places = place_groups(motion, self.grid)
        self.base = [*self.plant, *friction_groups(motion, self.grid), self.places["curve"]]
        speed = np.abs(motion.v[motion.places]) / self.grid.V
        self.fast = np.clip((speed - SLOW) / RISE, LEAST_WEIGHT, 1.0)
        self.weight = np.ones(motion.places.size)
        self.frequencies = list[float]()
        self.every = self.base
        self.equations = Equations(self.base, motion.row(motion.u), self.weight)
        self.delay = 0.0
        self.similar = list[
            tuple[float, float]
        ]()  # delays like the best one [s], with their inertia
        self.is_at_edge = False
        self.friction = np.zeros(motion.x.size)
        self.fitted = self.equations.fit(self.base)

    def fit(self) -> None:
        """Find the delay, the ripples, and the fit of all columns."""
        equations = self.equations
        self.find_delay(self.base)
        self.fitted = equations.fit(self.base, None, self.fitted.support)
        residual = self.residual
        self.weight = reversal_weights(self.motion, residual)
        self.frequencies = waves_in(self.motion, self.grid, residual)
        for turn in range(PASSES):
            self.refit()
            if turn < PASSES - 1:
                residual = self.residual
                self.find_delay(self.every)
                self.add_waves(waves_in(self.motion, self.grid, residual))

    @property
    def residual(self) -> np.ndarray:
        """Effort of the rows that the fit leaves unexplained [N or N*m], shape (row,)."""
        equations = self.equations
        return equations.y - equations.unit * (equations.X @ self.fitted.weights)

    def force(self, *roles: str) -> np.ndarray:
        """Return the force of the groups of some roles along the motion, shape (sample,) [N or N*m]."""
        total = np.zeros(self.motion.x.size)
        for group in self.every:
            if group.role in roles:
                total += group.force(self.equations.physical(group, self.fitted.weights))
        return total

    def refit(self) -> None:
        """Fit all columns, with changes of the level relative to the friction of the last fit."""
        self.friction = self.force("friction")
        place = self.force("place", "offset")
        effort = self.force("inertia") + self.friction + place
        y = self.equations.y
        waves = [ripple_group(self.motion, frequency) for frequency in self.frequencies]
        levels = level_groups(self.motion, self.grid, self.friction, place, self.frequencies)
        self.every = [*self.base, *waves, *levels, filter_group(self.motion, effort)]
        shapes = [group for name, group in self.places.items() if name != "curve"]
        names = {group.name for group in self.base}
        start = {name: value for name, value in self.fitted.penalties.items() if name in names}
        self.equations = Equations([*self.every, *shapes], y, self.weight)
        self.fitted = self.equations.fit(self.every, start)
        self.weight = reversal_weights(self.motion, self.residual)
        self.equations.weigh(self.weight)
        penalties = self.fitted.penalties
        self.fitted = self.equations.fit(self.every, penalties, self.fitted.support, rounds=1)

    def add_waves(self, frequencies: Sequence[float]) -> None:
        """Add the frequencies that differ from the known frequencies."""
        for frequency in frequencies:
            distances = [abs(frequency - known) * self.grid.stroke for known in self.frequencies]
            if min(distances, default=math.inf) > NEAR_WAVES and len(distances) < MOST_WAVES:
                self.frequencies.append(frequency)

    def find_delay(self, chosen: Sequence[Group]) -> None:
        """Find the delay from the rows at speed: near reversals, memory and delay are alike."""
        period = 1.0 / self.motion.cutoff
        self.equations.weigh(self.fast)
        self.delay = self.best_delay(chosen, COARSE * period)
        for _ in range(2):
            self.delay = self.best_delay(chosen, self.delay + FINE * period)
        ends = COARSE[[1, -2]] * period
        self.is_at_edge = not ends[0] < self.delay < ends[1]
        self.similar = self.similar_delays(chosen, np.array([self.delay, *(COARSE * period)]))
        self.equations.y = self.motion.row(self.motion.u, self.delay)
        self.equations.weigh(self.weight)

    def best_delay(self, chosen: Sequence[Group], delays: np.ndarray) -> float:
        """Return the delay with the least penalised error: vertex of a parabola through three delays [s]."""
        equations = self.equations
        efforts = [self.motion.row(self.motion.u, delay) for delay in delays]
        Y = np.stack(efforts, axis=1) / equations.unit
        rights = equations.X.T @ (Y * equations.weight[:, None])
        powers = equations.weight @ Y**2
        support = self.fitted.support
        errors = np.empty(delays.size)
        for number, right in enumerate(rights.T):
            weights, support = equations.solve(chosen, self.fitted.penalties, support, right)
            errors[number] = powers[number] - weights @ right
        best = int(np.clip(np.argmin(errors), 1, delays.size - 2))
        before, at, after = errors[best - 1 : best + 2].tolist()
        bend = before - 2.0 * at + after
        if bend <= 0.0:
            return float(delays[best])
        vertex = min(max(0.5 * (before - after) / bend, -1.0), 1.0)
        return float(delays[best] + (delays[1] - delays[0]) * vertex)

    def similar_delays(
        self, chosen: Sequence[Group], delays: np.ndarray
    ) -> list[tuple[float, float]]:
        """Return the delays that the folds do not tell from the first one [s], each with its inertia."""
        equations = self.equations
        similar = list[tuple[float, float]]()
        best = np.ones(FOLDS)
        for delay in delays.tolist():
            equations.y = self.motion.row(self.motion.u, delay)
            rights, powers = equations.targets()
            weights, active = equations.solve(
                chosen, self.fitted.penalties, self.fitted.support, rights.sum(axis=0)
            )
            at = np.flatnonzero(active)
            x = weights[at]
            bent = np.einsum("i,kij,j->k", x, equations.grams[:, at][:, :, at], x)
            errors = powers - 2.0 * rights[:, at] @ x + bent
            if not similar:
                best = errors
            if are_alike(errors, best):
                mass = float(equations.physical(self.plant[0], weights)[0])
                similar.append((delay, mass))
        return similar


# ---------------------------------------------------------------- choice of terms
@dataclass
class Choice:
    """The terms that a log shows, and the fit with them."""

    search: Search
    groups: list[Group]
    shape: str  # of the force over the position, empty without
    evidence: dict[str, Evidence]
    rejected: dict[str, Evidence]
    support: np.ndarray


def chosen_terms(search: Search) -> Choice:
    """Return the shape of the force over the position, and the other terms by backward elimination."""
    selection = Selection(search)
    optional = [group for group in search.every if group.is_judged]
    kept = [group for group in search.every if group.role != "place" and not group.is_judged]
    cable = [group for group in optional if group.name == "cable"]
    others = [group for group in optional if group.name != "cable"]
    shape = ""
    evidence = dict[str, Evidence]()
    for turn in range(2):
        # Long thresholds imitate a spring, so the shape is first chosen without them.
        shape, of_shape = selection.shape_beside(kept + others)
        if turn == 0:
            others = others + cable
        if shape in ("", "curve"):
            # Beside a free curve, the load would be a free level.
            others = [group for group in others if group.name != "load"]
            others += [group for group in optional if group.name in selection.rivals]
            selection.rivals.clear()
        fixed = kept + [group for name, group in search.places.items() if name == shape]
        others, of_terms = selection.eliminated(fixed, others)
        evidence = of_shape | of_terms
    fixed = kept + [group for name, group in search.places.items() if name == shape]
    return Choice(search, fixed + others, shape, evidence, selection.rejected, selection.support)


class Selection:
    """Errors of held-out folds with and without terms."""

    def __init__(self, search: Search) -> None:
        self.search = search
        self.equations = search.equations
        self.penalties = dict(search.fitted.penalties)
        self.support = search.fitted.support
        self.level = rms(search.motion.row(search.force("friction")))
        self.rejected = dict[str, Evidence]()
        self.rivals = set[str]()  # terms that gave way to others like them

    def errors(self, chosen: Sequence[Group]) -> np.ndarray:
        """Return the held-out errors of a choice of groups."""
        errors, _ = self.equations.held_out(chosen, self.penalties, self.support)
        return errors

    def evidence(self, without: np.ndarray, present: np.ndarray) -> Evidence:
        """Return the rise of the held-out error without a term, and its score over the folds."""
        # The best fold is left out of the gain; the mean of logarithms does not hang on few folds.
        rises = np.sort(without - present)[:-1]
        ratios = np.log(without / present)
        power = max(float(rises.mean()) * without.size, 0.0) / self.equations.count
        error = float(ratios.std(ddof=1)) / math.sqrt(ratios.size)
        gain = self.equations.unit * math.sqrt(power) / self.level
        return Evidence(gain, float(ratios.mean()) / max(error, np.finfo(float).tiny))

    def is_needed(self, evidence: Evidence, name: str = "") -> bool:
        """Whether a term lowers the held-out error by enough."""
        least = LEAST_GAIN
        if name == "cable":
            least = LEAST_CABLE
        return evidence.gain > least and evidence.z > LEAST_Z

    def shape_beside(self, chosen: Sequence[Group]) -> tuple[str, dict[str, Evidence]]:
        """Return the simplest force over the position that no other shape beats, with its evidence."""
        errors = {"": self.errors(chosen)}
        for name, group in self.search.places.items():
            errors[name] = self.errors([*chosen, group])
        best = min(errors.values(), key=np.sum)
        shape = ""
        for name, of_shape in errors.items():
            shape = name
            if not self.is_needed(self.evidence(of_shape, best)):
                break
        if not shape:
            return shape, {}
        return shape, {shape: self.evidence(errors[""], errors[shape])}

    def eliminated(
        self, fixed: Sequence[Group], others: Sequence[Group]
    ) -> tuple[list[Group], dict[str, Evidence]]:
        """Remove the weakest term until the log shows all others; return these and their evidence."""
        remaining = list(others)
        while True:
            chosen = [*fixed, *remaining]
            present, self.support = self.equations.held_out(chosen, self.penalties, self.support)
            evidence = dict[str, Evidence]()
            for group in remaining:
                without = self.errors([entry for entry in chosen if entry is not group])
                evidence[group.name] = self.evidence(without, present)
            weakest = self.weakest(evidence)
            if weakest is None:
                return remaining, evidence
            self.rejected[weakest] = evidence[weakest]
            remaining = [group for group in remaining if group.name != weakest]

    def weakest(self, evidence: Mapping[str, Evidence]) -> str | None:
        """Return the term that the log shows least; None if it shows all of them."""
        weak = {name: entry for name, entry in evidence.items() if not self.is_needed(entry, name)}
        if weak:
            return min(weak, key=lambda name: weak[name].gain * max(weak[name].z, 0.0))
        both = [name for name in ("level", "load") if name in evidence]
        if len(both) < 2:
            return None
        # Level and load are not told apart together: the worse of both gives way.
        worse = min(both, key=lambda name: evidence[name].gain)
        if worse == "level":
            self.rivals.add(worse)
        return worse


def rms(values: np.ndarray) -> float:
    """Return the root mean square."""
    return math.sqrt(float(np.mean(np.square(values))))


# ---------------------------------------------------------------- numbers and forces
class Refitted(NamedTuple):
    """The fit with the found terms to all rows, with the inertia of the rows at speed."""

    choice: Choice
    groups: list[Group]  # without the inertia
    fitted: Fitted
    M: Interval
    delay: Interval

    @property
    def equations(self) -> Equations:
        """Equations of the fit, without the inertial force."""
        return self.choice.search.equations

    @property
    def motion(self) -> Motion:
        """Motion of the log."""
        return self.choice.search.motion

    def weights(self, group: Group) -> np.ndarray:
        """Return the weights of a group in SI units."""
        return self.equations.physical(group, self.fitted.weights)

    def rows(self, group: Group) -> np.ndarray:
        """Return the force of a group in the rows, shape (row,) [N or N*m]."""
        return group.columns @ self.weights(group)


def refitted(choice: Choice) -> Refitted:
    """Return the inertia from the rows at speed, and the fit of all other forces to all rows."""
    search = choice.search
    equations = search.equations
    inertia = choice.groups[0]
    equations.weigh(search.fast)
    fitted = equations.fit(choice.groups, search.fitted.penalties, choice.support)
    at = np.flatnonzero(fitted.support)
    P = equations.penalty(choice.groups, fitted.penalties)
    covariance = equations.covariance(at, P, fitted.weights)
    place = int(equations.spans["inertia"][0])
    M = float(equations.physical(inertia, fitted.weights)[0])
    error = 0.0
    if place in at:
        variance = float(covariance[at == place, at == place][0])
        error = math.sqrt(variance) * equations.unit / equations.scale[place]
    delay = delay_interval(search, at, P, fitted.weights)
    equations.weigh(search.weight)
    equations.retarget(equations.y - M * inertia.columns[:, 0])
    others = choice.groups[1:]
    support = choice.support.copy()
    support[place] = False
    again = equations.fit(others, fitted.penalties, support)
    masses = np.array([mass for _, mass in search.similar])
    acceleration = max(rms(inertia.columns[:, 0]), np.finfo(float).tiny)
    floor = FLOOR_OF_M * M + FLOOR_BESIDE_FRICTION * rms(equations.y) / acceleration
    half_width = math.hypot(STUDENT * error, float(np.ptp(masses))) + floor
    return Refitted(choice, others, again, Interval(M, half_width), delay)


def delay_interval(search: Search, at: np.ndarray, P: np.ndarray, weights: np.ndarray) -> Interval:
    """Return the delay with its interval, from the slope of the effort over the delay beside the columns in use."""
    equations = search.equations
    motion = search.motion
    shift = 0.1 * motion.dt
    ahead = motion.row(motion.u, search.delay + shift)
    behind = motion.row(motion.u, search.delay - shift)
    slope = (ahead - behind) / (2.0 * shift * equations.unit)
    X = equations.X[:, at]
    W = equations.weight
    A = (equations.gram + P)[np.ix_(at, at)]
    apart = slope - X @ np.linalg.solve(A, X.T @ (W * slope))
    residual = equations.y / equations.unit - equations.X @ weights
    scores = [float(np.sum((W * residual * apart)[a:b])) for a, b in pairwise(equations.edges)]
    error = math.sqrt(float(np.sum(np.square(scores)))) / float(np.sum(W * apart**2))
    delays = np.array([delay for delay, _ in search.similar])
    spread = float(np.max(np.abs(delays - search.delay)))
    half_width = math.hypot(STUDENT * error, spread) + FLOOR_OF_DELAY / motion.cutoff
    return Interval(search.delay, half_width)


class Law(NamedTuple):
    """A simple law beside the found terms: its weights, its numbers in SI units, and the error of each fold."""

    element: Element
    weights: np.ndarray
    errors: np.ndarray
    F_C: float
    F_v: float
    sliding: float

    @property
    def cost(self) -> float:
        """Squared error of all folds."""
        return float(self.errors.sum())


def are_alike(errors: np.ndarray, best: np.ndarray) -> bool:
    """Whether the errors of the folds do not tell a fit from the best one."""
    ratios = np.log(errors / best)
    error = float(ratios.std(ddof=1)) / math.sqrt(ratios.size)
    is_close = float(errors.sum()) < MOST_RISE * float(best.sum())
    return is_close and float(ratios.mean()) < APART * error + 1e-12


class Laws:
    """Elements with a constant limit, each with the same element that falls with the speed, and viscous friction."""

    def __init__(
        self, final: Refitted, members: Sequence[Element], speeds: Sequence[float]
    ) -> None:
        search = final.choice.search
        self.pairs = [(member, member._replace(v_S=v_S)) for member in members for v_S in speeds]
        self.final = final
        self.members = [*members, *(falling for _, falling in self.pairs)]
        law = memory_group(final.motion, search.grid, "law", self.members, is_fixed=True)
        viscous = [group for group in final.groups if group.name == "viscous"]
        self.terms = [*viscous, *(group for group in final.groups if is_beside_law(group))]
        self.groups = [law, *self.terms]
        weight = search.weight * search.fast
        self.equations = Equations(self.groups, final.equations.y, weight)
        self.P = self.equations.penalty(self.groups, final.fitted.penalties)
        self.beside = self.equations.columns_of(self.terms).tolist()
        self.viscous = self.equations.spans["viscous"].tolist()
        self.cable = self.equations.spans.get("cable", np.zeros(0, dtype=int)).tolist()

    def fits(self) -> list[Law]:
        """Return the law of each element, alone without Stribeck speeds."""
        if not self.pairs:
            return [self.fit((member,)) for member in self.members]
        return [self.fit(pair) for pair in self.pairs]

    def fit(self, members: Sequence[Element], without: Sequence[int] = ()) -> Law:
        """Return the law of some elements, without some columns of the terms."""
        columns = [self.members.index(member) for member in members]
        at = np.array([*columns, *(j for j in self.beside if j not in without)])
        weights, _ = self.equations.solve_columns(at, self.P)
        x = np.broadcast_to(weights[at], (FOLDS, at.size))
        errors = self.equations.fold_errors(at, x)
        F_C = self.value(weights, columns[:1])
        sliding = F_C + self.value(weights, self.cable)
        return Law(members[-1], weights, errors, F_C, self.value(weights, self.viscous), sliding)

    def value(self, weights: np.ndarray, columns: Sequence[int]) -> float:
        """Return the sum of the weights of some columns in SI units."""
        at = np.asarray(columns, dtype=int)
        return float(np.sum(self.equations.unit * weights[at] / self.equations.scale[at]))

    def interval(self, law: Law, columns: Sequence[int], similar: Sequence[float]) -> Interval:
        """Return the sum of the weights of some columns; its interval also holds the values of `similar` laws."""
        active = law.weights != 0.0
        active[columns] = True
        at = np.flatnonzero(active)
        covariance = self.equations.covariance(at, self.P, law.weights)
        factors = np.isin(at, columns) * self.equations.unit / self.equations.scale[at]
        error = math.sqrt(float(factors @ covariance @ factors))
        value = self.value(law.weights, columns)
        spread = float(np.max(np.abs(np.asarray(similar) - value)))
        return Interval(value, math.hypot(STUDENT * error, spread) + FLOOR_OF_FRICTION * abs(value))


def is_beside_law(group: Group) -> bool:
    """Whether a group is fitted beside a simple law."""
    return group.is_judged or group.role in ("offset", "place")


def friction_law(final: Refitted) -> Friction:
    """Return Coulomb and viscous friction from the rows at speed, over all laws that the folds do not tell apart."""
    grid = final.choice.search.grid
    flat = list[Element]()
    for is_dahl in (False, True):
        flat += elements(is_dahl=is_dahl, d=grid.narrow[:-1])
    fits = Laws(final, flat, ()).fits()
    d = best_of(fits).element.d
    near = [member for member in flat if d / NEAR_THRESHOLD < member.d < d * NEAR_THRESHOLD]
    fits += Laws(final, near, grid.v_S[:-1].tolist()).fits()
    for width in REFINEMENTS:
        fits += laws_around(
            final, flat, fits, width * np.geomspace(1.0 / width**2, 1.0, TRIALS)
        ).fits()
    laws = laws_around(final, flat, fits, np.ones(1))
    best = best_of(laws.fits())
    pair = next(pair for pair in laws.pairs if pair[1] == best.element)
    fits += [laws.fit(pair, [j for j in laws.cable if j != threshold]) for threshold in laws.cable]
    similar = [law for law in [*fits, best] if are_alike(law.errors, best.errors)]
    factor = mean_level(laws, best)
    place = [laws.members.index(pair[0])]
    coulomb = laws.interval(best, place, [law.F_C for law in similar])
    # Slip of the cable and of the contact share rows.
    split = FLOOR_OF_SPLIT * laws.value(best.weights, laws.cable)
    coulomb = coulomb._replace(half_width=coulomb.half_width + split)
    sliding = laws.interval(best, [*place, *laws.cable], [law.sliding for law in similar])
    return Friction(
        F_C=coulomb.times(factor),
        F_v=laws.interval(best, laws.viscous, [law.F_v for law in similar]),
        sliding=sliding.times(factor),
    )


def best_of(laws: Sequence[Law]) -> Law:
    """Return the law with the least error."""
    return min(laws, key=lambda law: law.cost)


def laws_around(
    final: Refitted, members: Sequence[Element], laws: Sequence[Law], factors: np.ndarray
) -> Laws:
    """Return the laws with the threshold of the best one and multiples of its Stribeck speed."""
    best = best_of(laws).element
    v_S = min(best.v_S, final.choice.search.grid.V)
    return Laws(
        final, [member for member in members if member.d == best.d], (v_S * factors).tolist()
    )


def mean_level(laws: Laws, law: Law) -> float:
    """Return the mean level of friction in motion over its level without the changes along the axis, with load and time."""
    search = laws.final.choice.search
    friction = search.friction
    moves = np.abs(search.motion.v) > SLOW * search.grid.V
    moves &= np.abs(friction) > 1e-3 * np.abs(friction).max()
    factor = 1.0
    for group in laws.terms:
        if group.role == "level":
            change = group.force(laws.equations.physical(group, law.weights))
            factor += float(np.mean(change[moves] / friction[moves]))
    return factor


# ---------------------------------------------------------------- result
def explained(choice: Choice, kind: Kind) -> Explanation:
    """Return the result of a choice of terms."""
    final = refitted(choice)
    friction = friction_law(final)
    forces = {group.name: final.rows(group) for group in final.groups}
    inertia = choice.groups[0]
    y = final.equations.y
    residual = y - sum(forces.values(), np.zeros(y.size))
    total = final.motion.row(final.motion.u, final.delay.value)
    return explanation_of(
        kind=kind,
        parts=parts_of(final, forces),
        inertia=rms(final.M.value * inertia.columns[:, 0]),
        effort=rms(total),
        unexplained=rms(residual),
        floor=floor_of(final),
        filter=choice.evidence.get("filter"),
        rejected=choice.rejected,
        M=final.M,
        friction=friction,
        delay=final.delay,
        curves=curves_of(final),
        doubts=doubts_of(final),
    )


def floor_of(final: Refitted) -> float:
    """Return the rms error of held-out folds, each row with the same weight [N or N*m]."""
    equations = final.equations
    equations.weigh(np.ones(equations.count))
    errors, _ = equations.held_out(final.groups, final.fitted.penalties, final.fitted.support)
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
    whole = max(sum(sizes.values()), np.finfo(float).tiny)
    frequencies = {group.name: group.frequency for group in final.groups}
    waves = {group.name: final.weights(group).tolist() for group in final.groups if group.frequency}
    parts = [
        Part(
            name=name,
            rms=size,
            share=size / whole,
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
    V = final.choice.search.grid.V
    ends = final.weights(group) @ ramps(np.array([-V, -0.5 * V, 0.5 * V, V]), V)
    v = final.motion.v[final.motion.places]
    slopes = np.diff(ends)[[0, 2]] / (0.5 * V)
    slopes = np.minimum(slopes, np.abs(ends[[0, 3]]) / V)
    viscous = v * np.where(v < 0.0, *slopes)
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
    limits = {group.name: float(final.weights(group).sum()) for group in final.groups}
    memory = sum(limits.get(name, 0.0) for name in MEMORY)
    cable = limits.get("cable", 0.0)
    if cable > MOST_CABLE * max(memory + cable, np.finfo(float).tiny):
        doubts.append("not_saturated")
    search = final.choice.search
    settled = search.fast[time_to_reversal(final.motion) > SETTLING].sum()
    if settled < LEAST_SETTLED * search.fast.sum():
        doubts.append("reverses_fast")
    if search.is_at_edge:
        doubts.append("delay_at_edge")
    forward = search.fast[final.motion.v[final.motion.places] > 0.0].sum() / search.fast.sum()
    if min(forward, 1.0 - forward) < LEAST_BACKWARD:
        doubts.append("one_direction")
    return tuple(doubts)
