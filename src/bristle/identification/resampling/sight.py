r"""What a log does not see: parameters that can be moved far away without a price, once the others follow.

A parameter is changed by 30 %, up and down, and all others are fitted again, on all rows but a block of them. If the
error on the block rises in neither case by more than the 95 % threshold of a likelihood ratio,

.. math:: \sum_\text{blocks} \left(\|r'\|^2 - \|r\|^2\right) < \chi^2_{1,\,0.95}\; s^2,

the log does not see that parameter. With it held where it is, the others are asked again: of a product of two, only
one is not seen.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from bristle.identification.problem import Problem
from bristle.identification.resampling.refit import Refit, Space

__all__ = ["Unseen", "unseen"]

CHANGES = (1.3, 0.7)
THRESHOLD = 3.841  # of chi-square with one degree of freedom, 95 %
BLOCKS = 4
FOLLOWS = 0.1  # relative change of another parameter that makes up for it


@dataclass(frozen=True)
class Unseen:
    """A parameter that the log does not see.

    Parameters
    ----------
    name : str
        The parameter.
    rise : float
        By how much the error rises at most, in units of the variance of the residual; 3.84 is the threshold.
    instead : tuple of str
        Parameters that take its place: the log sees its combination with them only.
    """

    name: str
    rise: float
    instead: tuple[str, ...]

    @property
    def note(self) -> str:
        """Why, in words."""
        if self.instead:
            return (
                f"the log sees it only together with {', '.join(self.instead)}: changed by 30 %, it is made up for by "
                "them, and the error on held-out blocks does not rise noticeably"
            )
        return "changed by 30 %, with all others fitted again, the error on held-out blocks does not rise noticeably"


def unseen(problem: Problem, space: Space, candidates: frozenset[str]) -> tuple[Unseen, ...]:
    """Return the parameters that a log does not see, each with those found before it held.

    Parameters
    ----------
    problem : Problem
        What was fitted.
    space : Space
        The coordinates of the solution.
    candidates : frozenset of str
        Parameters that are asked about; those that are zero, or on an edge, have no 30 %.
    """
    free = np.ones(len(space.names), dtype=bool)
    found: list[Unseen] = []
    asked = [name for name in space.names if name in candidates and space.values(space.phi)[name] != 0.0]
    while asked:
        rises = {name: _Change(problem, space, free, name).rise() for name in asked}
        least = min(rises, key=lambda name: rises[name][0])
        if rises[least][0] >= THRESHOLD:
            break
        found.append(Unseen(least, *rises[least]))
        free[space.names.index(least)] = False
        # Those that are clearly seen now are seen with one parameter less to follow, too.
        asked = [name for name in asked if name != least and rises[name][0] < THRESHOLD]
    return tuple(found)


@dataclass(frozen=True)
class _Change:
    """One parameter moved away, the others in pursuit."""

    problem: Problem
    space: Space
    free: np.ndarray
    name: str

    def rise(self) -> tuple[float, tuple[str, ...]]:
        """Return the larger of the rises of the held-out error, and which parameters made up for the change."""
        count, reach = self.problem.regression.effort.size, self.problem.regression.reach
        edges = np.linspace(0, count, BLOCKS + 1).astype(int)
        followers = self.free.copy()
        followers[self.space.names.index(self.name)] = False
        rises, instead = np.zeros(len(CHANGES)), set()
        start = self.problem.residual(self.space.values(self.space.phi))
        variance = float(start @ start) / max(count - len(self.space.names), 1)
        for first, last in pairwise(edges.tolist()):
            fitted = np.ones(count, dtype=bool)
            fitted[max(first - reach, 0) : last + reach] = False
            if not fitted.any():
                continue
            _, before = Refit(self.space, self.free, fitted).solve(self.problem, self.space.phi)
            for number, change in enumerate(CHANGES):
                moved = self._moved(change)
                phi, after = Refit(self.space, followers, fitted).solve(self.problem, moved)
                rises[number] += float(np.sum(after[first:last] ** 2) - np.sum(before[first:last] ** 2))
                instead |= self._made_up(phi)
        return float(np.max(rises)) / variance, tuple(name for name in self.space.names if name in instead)

    def _moved(self, change: float) -> np.ndarray:
        """Return the coordinates at which only this parameter is another one."""
        index = self.space.names.index(self.name)
        phi, goal = self.space.phi.copy(), change * self.space.values(self.space.phi)[self.name]
        for _ in range(30):
            slope = self._slope(phi, index)
            if slope == 0.0:
                break
            step = (goal - self.space.values(phi)[self.name]) / slope
            phi[index] = np.clip(phi[index] + step, self.space.low[index], self.space.high[index])
            if abs(step * slope) <= 1e-9 * abs(goal):
                break
        return phi

    def _slope(self, phi: np.ndarray, index: int) -> float:
        nudged = phi.copy()
        nudge = 1e-6 * max(abs(phi[index]), 1e-3)
        nudged[index] += nudge
        return (self.space.values(nudged)[self.name] - self.space.values(phi)[self.name]) / nudge

    def _made_up(self, phi: np.ndarray) -> set[str]:
        now, then = self.space.values(phi), self.space.values(self.space.phi)
        return {
            name
            for name in self.space.names
            if name != self.name and abs(now[name] - then[name]) > FOLLOWS * abs(then[name]) > 0.0
        }
