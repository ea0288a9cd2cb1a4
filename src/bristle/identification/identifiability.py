r"""What a log does not see: parameters that can be moved far away without a price, once the others follow.

A parameter is changed by 30 %, up and down, and all others are fitted again, on three quarters of the rows in turn. If
the error on the last quarter rises in neither case by more than the 95 % threshold of a likelihood ratio,

.. math:: \sum_\text{quarters} \left(\|r'\|^2 - \|r\|^2\right) < \chi^2_{1,\,0.95}\; s^2,

the log does not see that parameter. With it held where it is, the others are asked again: of a product of two, only
one is not seen. Where the rise is a hundred times that in the linear fit around the solution, nobody needs to ask.

All this is asked around the solution. A stiffness is asked about far from it, too: where pre-sliding is a few steps of
the encoder, the fit to a log of an axis that is ten times as stiff can end at the same value. The model is fitted to
such logs, and where one of the fits ends within the interval, the log does not tell the stiffness.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from bristle.core.cores import Abreast, abreast
from bristle.core.diagnostic import Diagnostic, Number
from bristle.core.lazy import cached_property
from bristle.core.least_squares import unbounded
from bristle.identification.bootstrap import SEED, Bootstrap
from bristle.identification.global_search import Refit
from bristle.identification.parameter_space import Solution
from bristle.identification.problem import Problem
from bristle.identification.settings import Settings

BEYOND_DOUBT = 100.0  # times the threshold, in the linear fit
CHUNKS = 40
STIFFER, PAIRS = 10.0, 8  # times; replicates of such an axis, each with its mirror image


@dataclass(frozen=True)
class Unidentifiable:
    """A parameter that the log does not see, and by how much it was changed [%]."""

    name: str
    rise: float
    flat: bool
    instead: tuple[str, ...]
    percent: float

    @property
    def diagnostic(self) -> Diagnostic:
        """Why."""
        if self.instead:
            return Diagnostic("seen_together", self.name, numbers={"percent": self.percent, "instead": self.instead})
        return Diagnostic("unseen", self.name, numbers={"percent": self.percent})


def unidentifiable(problem: Problem, solution: Solution, candidates: frozenset[str], settings: Settings) -> tuple[Unidentifiable, ...]:
    """Return the parameters that a log does not see, each with those found before it held.

    Only `candidates` are asked about; those that are zero, or on an edge, have no 30 %.
    """
    names = solution.space.names
    free = np.ones(len(names), dtype=bool)
    lost: list[Unidentifiable] = []
    doubtful = [name for name in names if name in candidates and solution.values[name] != 0.0]
    followed = _Followed(problem, solution, free, settings)
    # Where the linear fit makes sure that a parameter is seen, nobody asks.
    rises = {name: min(followed.linear_rise(name, change) for change in followed.changes) for name in doubtful}
    doubtful = [name for name, rise in rises.items() if not rise >= BEYOND_DOUBT * settings.seen_rise]
    while doubtful:
        around = _Followed(problem, solution, free, settings)
        with Abreast() as pool:
            rises = dict(zip(doubtful, pool.map(around.without, doubtful), strict=True))
        least = min(doubtful, key=lambda name: rises[name].rise)
        if rises[least].rise >= settings.seen_rise:
            break
        lost.append(rises[least])
        free[names.index(least)] = False
        # Those that are clearly seen now are seen with one parameter less to follow, too.
        doubtful = [name for name in doubtful if name != least and rises[name].rise < settings.seen_rise]
    return tuple(lost)


def as_soft(problem: Problem, found: Bootstrap, free: np.ndarray, names: Iterable[str], settings: Settings) -> dict[str, Diagnostic]:
    """Return why stiffnesses are not identified, of which fits to logs of a far stiffer axis end within the interval.

    Fits of the `free` coordinates begin at what made the replicate, so that none is led away from it.
    """
    solution = found.solution
    moved, refit = _Followed(problem, solution, free, settings), Refit(solution, free)
    draws = [(seed, side) for seed in np.random.SeedSequence(SEED).spawn(PAIRS) for side in (1.0, -1.0)]

    def alike(name: str) -> Diagnostic | None:
        truth, largest = moved.moved(name, STIFFER), max(found.interval(name)[1], solution.values[name])
        stiff = solution.space.values(truth)
        made = found.replicates.made_with(problem.parameters.complete(stiff))

        def end(draw: tuple[np.random.SeedSequence, float]) -> float:
            log = made.draw(found.disturbance, np.random.default_rng(draw[0]), draw[1])
            return float(solution.space.values(refit.solve(log, truth)[0])[name])

        count = sum(stiffness <= largest for stiffness in abreast(end)(draws))
        if not count or not largest < stiff[name]:
            return None
        numbers: dict[str, Number] = {"times": stiff[name] / solution.values[name], "alike": count, "fits": len(draws)}
        return Diagnostic("as_soft", name, numbers=numbers, kind=problem.dataset.kind)

    lost = {name: alike(name) for name in names}
    return {name: diagnostic for name, diagnostic in lost.items() if diagnostic is not None}


@dataclass(frozen=True)
class _Followed:
    """One parameter after another moved away, the others that are `free`, shape (coordinate,) of bool, in pursuit."""

    problem: Problem
    solution: Solution
    free: np.ndarray
    settings: Settings

    @property
    def changes(self) -> tuple[float, float]:
        """Times by which a parameter is moved."""
        return 1.0 + self.settings.moved, 1.0 - self.settings.moved

    def without(self, name: str) -> Unidentifiable:
        """Return by how much the error rises where one parameter is changed, and which made up for the change."""
        names, starts = self.solution.space.names, [self.moved(name, change) for change in self.changes]
        followers, ends = self.free & (np.array(names) != name), []
        for fitted, judged, before in self._trials:
            refit = Refit(self.solution, followers, fitted)
            solved = [refit.solve(self.problem, start) for start in starts]
            ends.append(([theta for theta, _ in solved], [float(np.sum(after[judged] ** 2)) - before for _, after in solved]))
        (thetas, rises), *held_out = ends
        then, others, least = self.solution.values, [self.solution.space.values(theta) for theta in thetas], self.settings.follows
        instead = tuple(
            part
            for part in names
            if part != name and part in then and any(abs(now[part] - then[part]) > least * abs(then[part]) > 0.0 for now in others)
        )
        return Unidentifiable(
            name,
            rise=float(np.max(np.sum([quarter for _, quarter in held_out], axis=0))) / self._variance,
            flat=max(rises) < self.settings.flat_rise * self._variance,
            instead=instead,
            percent=100.0 * self.settings.moved,
        )

    @cached_property
    def _trials(self) -> list[tuple[np.ndarray, np.ndarray, float]]:
        """Rows that are fitted, rows that are judged, and the squared error there: all of them, then each quarter."""
        count = self.solution.jacobian.shape[0]
        chunk = np.arange(count) * CHUNKS // count
        quarter = (np.random.default_rng(CHUNKS).permutation(CHUNKS) % 4)[chunk]
        rows = np.ones(count, dtype=bool)
        trials = [(rows, rows), *((quarter != number, quarter == number) for number in range(4))]
        return [
            (
                fitted,
                judged,
                float(np.sum(Refit(self.solution, self.free, fitted).solve(self.problem, self.solution.theta)[1][judged] ** 2)),
            )
            for fitted, judged in trials
        ]

    @cached_property
    def _variance(self) -> float:
        start = self.problem.residual(self.solution.values)
        return float(start @ start) / max(start.size - len(self.solution.space.names), 1)

    def linear_rise(self, name: str, change: float) -> float:
        """Return the rise of the error, over its variance, of a linear fit in which a parameter is another one."""
        index = self.solution.space.names.index(name)
        # The Jacobian in coordinates of its own range is as good for lengths, and much smaller.
        triangle = np.linalg.qr(self.solution.jacobian, mode="r")
        own, rest = triangle[:, index], np.delete(triangle, index, axis=1)
        alone = own - rest @ unbounded(rest, own)
        way = self.moved(name, change)[index] - self.solution.theta[index]
        return float(alone @ alone) * way**2 / self._variance if self._variance > 0.0 else np.inf

    def moved(self, name: str, change: float) -> np.ndarray:
        """Return the coordinates at which only this parameter is another one."""
        space, theta, goal = self.solution.space, self.solution.theta.copy(), change * self.solution.values[name]
        index = space.names.index(name)
        for _ in range(30):
            value, nudge, nudged = space.values(theta)[name], 1e-6 * max(abs(theta[index]), 1e-3), theta.copy()
            nudged[index] += nudge
            slope = (space.values(nudged)[name] - value) / nudge
            if slope == 0.0:
                break
            step = (goal - value) / slope
            theta[index] = np.clip(theta[index] + step, space.low[index], space.high[index])
            if abs(step * slope) <= 1e-9 * abs(goal):
                break
        return theta
