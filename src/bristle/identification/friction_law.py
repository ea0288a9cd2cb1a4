"""Inertia, delay, Coulomb and viscous friction beside the found terms, from the rows at speed, with their intervals."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bristle.identification.dictionary import Element, Group, Motion, elements, memory_group
from bristle.identification.explanation import Friction, Interval
from bristle.identification.gram import Equations, Fitted, Penalties, are_alike, rms
from bristle.identification.term_search import SLOW, Choice, Search

NEAR_THRESHOLD = 5.0  # factor between the threshold of a law and those tried with a Stribeck speed
REFINEMENTS = (2.0, 1.25, 1.06)  # factor of the Stribeck speed to either side, in three searches
TRIALS = 7  # Stribeck speeds of a search

FLOOR_OF_M = 0.003  # of the value: error of the treatment
FLOOR_BESIDE_FRICTION = 0.001  # of the effort: error of the inertial force
FLOOR_OF_FRICTION = 0.001  # of the value
FLOOR_OF_SPLIT = 0.05  # of the limit of the cable: error of Coulomb friction beside it
FLOOR_OF_DELAY = 0.005  # periods of the cut-off
LEAST_DOUBT = 1.0  # standard errors: from here on, a rejected term may be there
STUDENT = 2.0  # standard errors of a 95 % interval from 60 stretches


class AtSpeed(NamedTuple):
    """Inertia and delay from the rows at speed in one band of frequencies, and the penalties of their fit."""

    M: Interval
    delay: Interval
    is_at_edge: bool
    penalties: Penalties


class Refitted(NamedTuple):
    """The fit with the found terms to all rows, with the inertia of the rows at speed."""

    choice: Choice
    groups: list[Group]  # without the inertia
    fitted: Fitted
    band: AtSpeed

    @property
    def equations(self) -> Equations:
        """Equations of the fit, without the inertial force."""
        return self.choice.search.equations

    @property
    def motion(self) -> Motion:
        """Motion of the log."""
        return self.choice.search.motion

    @property
    def named(self) -> dict[str, Group]:
        """Groups by name."""
        return {group.name: group for group in self.groups}

    def weights(self, group: Group) -> np.ndarray:
        """Return the weights of a group in SI units."""
        return self.equations.physical(group, self.fitted.weights)

    def rows(self, group: Group) -> np.ndarray:
        """Return the force of a group in the rows, shape (row,) [N or N*m]."""
        return group.columns @ self.weights(group)


def at_speed(choice: Choice) -> AtSpeed:
    """Return inertia and delay from the rows at speed, with the found terms."""
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
    similar = search.similar_delays(choice.groups, fitted.penalties, fitted.support)
    delays, masses = np.array(similar).T
    error_of_delay = delay_error(search, at, P, fitted.weights)
    spread = float(np.max(np.abs(delays - search.delay)))
    late = math.hypot(STUDENT * error_of_delay, spread) + FLOOR_OF_DELAY / search.motion.cutoff
    equations.weigh(search.weight)
    acceleration = max(rms(inertia.columns[:, 0]), np.finfo(float).tiny)
    floor = FLOOR_OF_M * M + FLOOR_BESIDE_FRICTION * rms(equations.y) / acceleration
    half_width = math.hypot(STUDENT * error, float(np.ptp(masses))) + floor
    delay = Interval(search.delay, late)
    return AtSpeed(Interval(M, half_width), delay, search.is_at_edge, fitted.penalties)


def least_biased(bands: Sequence[AtSpeed]) -> AtSpeed:
    """Return the band with the least error of its delay, from the widest to the narrowest band.

    In a closed loop, noise of the encoder reaches the effort without delay, so wide bands underestimate the delay. The bias
    of a band is the distance to a narrower one beyond the interval of that [1]_.

    .. [1] A. Goldenshluger, O. Lepski: Bandwidth selection in kernel density estimation. Ann. Statist. 39 (2011).
       https://doi.org/10.1214/11-AOS883
    """
    best = bands[0]
    least = math.inf
    for number, band in enumerate(bands):
        value = band.delay.value
        beyond = [
            abs(value - narrower.delay.value) - narrower.delay.half_width
            for narrower in bands[number + 1 :]
            if not narrower.is_at_edge
        ]
        half_width = band.delay.half_width + max([0.0, *beyond])
        if half_width < least and not band.is_at_edge:
            least = half_width
            best = band._replace(delay=Interval(value, half_width))
    return best


def refitted(choice: Choice, band: AtSpeed) -> Refitted:
    """Return the fit of all forces but the inertial force to all rows."""
    equations = choice.search.equations
    inertia = choice.groups[0]
    equations.retarget(equations.y - band.M.value * inertia.columns[:, 0])
    further = choice.groups[1:]
    support = choice.support.copy()
    support[equations.spans["inertia"]] = False
    fitted = equations.fit(further, band.penalties, support)
    return Refitted(choice, further, fitted, band)


def delay_error(search: Search, at: np.ndarray, P: np.ndarray, weights: np.ndarray) -> float:
    """Return the standard error of the delay [s], from the slope of the effort over the delay beside the columns in use."""
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
    return math.sqrt(float(np.sum(np.square(scores)))) / float(np.sum(W * apart**2))


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


class Laws:
    """Elements with a constant limit, each with the same element that falls with the speed, and viscous friction."""

    def __init__(
        self,
        final: Refitted,
        members: Sequence[Element],
        speeds: Sequence[float],
        further: Sequence[Group] = (),
    ) -> None:
        search = final.choice.search
        self.pairs = [(member, member._replace(v_S=v_S)) for member in members for v_S in speeds]
        self.final = final
        self.members = [*members, *(falling for _, falling in self.pairs)]
        law = memory_group(final.motion, search.grid, "law", self.members, is_fixed=True)
        viscous = [group for group in final.groups if group.name == "viscous"]
        beside = [group for group in final.groups if is_beside_law(group)]
        self.terms = [*viscous, *beside, *further]
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
        errors = self.equations.errors_of(weights, at)
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
    friction = Friction(
        F_C=coulomb.times(factor),
        F_v=laws.interval(best, laws.viscous, [law.F_v for law in similar]),
        sliding=sliding.times(factor),
    )
    return with_open_terms(friction, final, pair)


def with_open_terms(friction: Friction, final: Refitted, pair: tuple[Element, Element]) -> Friction:
    """Return friction with intervals widened by the terms that the log neither shows nor excludes: each moves the numbers."""
    choice = final.choice
    is_open = {name: entry.z > LEAST_DOUBT for name, entry in choice.rejected.items()}
    numbers = (friction.F_C, friction.F_v, friction.sliding)
    moved = np.zeros(len(numbers))
    for group in choice.search.every:
        if is_open.get(group.name, False):
            laws = Laws(final, pair[:1], [pair[1].v_S], [group])
            law = best_of(laws.fits())
            level = mean_level(laws, law)
            values = np.array([law.F_C * level, law.F_v, law.sliding * level])
            moved = np.maximum(moved, np.abs(values - [number.value for number in numbers]))
    F_C, F_v, sliding = map(widen, numbers, moved.tolist())
    return Friction(F_C, F_v, sliding)


def widen(interval: Interval, far: float) -> Interval:
    """Return an interval that also covers a possible shift of the value, taken as its standard error."""
    return interval._replace(half_width=math.hypot(interval.half_width, STUDENT * far))


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
