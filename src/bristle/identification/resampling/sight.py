r"""What a log does not see: parameters that can be moved far away without a price, once the others follow.

A parameter is changed by 30 %, up and down, and all others are fitted again, on three quarters of the rows in turn. If
the error on the last quarter rises in neither case by more than the 95 % threshold of a likelihood ratio,

.. math:: \sum_\text{quarters} \left(\|r'\|^2 - \|r\|^2\right) < \chi^2_{1,\,0.95}\; s^2,

the log does not see that parameter. With it held where it is, the others are asked again: of a product of two, only
one is not seen.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bristle.identification.problem import Problem
from bristle.identification.resampling.refit import Refit, Space

__all__ = ["Unseen", "unseen"]

CHANGES = (1.3, 0.7)
THRESHOLD = 3.841  # of chi-square with one degree of freedom, 95 %
CHUNKS = 40
FLAT = 0.1  # rise of the error, in units of the variance, that is none
FOLLOWS = 0.1  # relative change of another parameter that makes up for it


@dataclass(frozen=True)
class Unseen:
    """A parameter that the log does not see.

    Parameters
    ----------
    name : str
        The parameter.
    rise : float
        By how much the error on rows that were held out rises at most, in units of the variance of the residual.
    flat : bool
        Whether the error on the fitted rows does not rise either: nothing in the log depends on it.
    instead : tuple of str
        Parameters that take its place: the log sees its combination with them only.
    """

    name: str
    rise: float
    flat: bool
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
        rises = {name: _Change(problem, space, free, name).found() for name in asked}
        least = min(asked, key=lambda name: rises[name].rise)
        if rises[least].rise >= THRESHOLD:
            break
        found.append(rises[least])
        free[space.names.index(least)] = False
        # Those that are clearly seen now are seen with one parameter less to follow, too.
        asked = [name for name in asked if name != least and rises[name].rise < THRESHOLD]
    return tuple(found)


@dataclass(frozen=True)
class _Change:
    """One parameter moved away, the others in pursuit."""

    problem: Problem
    space: Space
    free: np.ndarray
    name: str

    def found(self) -> Unseen:
        """Return by how much the error rises, and which parameters made up for the change."""
        count = self.problem.regression.effort.size
        start = self.problem.residual(self.space.values(self.space.phi))
        variance = float(start @ start) / max(count - len(self.space.names), 1)
        whole = np.ones(count, dtype=bool)
        fitted, instead = self._rises(whole, whole)
        held_out = np.sum([self._rises(~quarter, quarter)[0] for quarter in _quarters(count)], axis=0)
        names = tuple(name for name in self.space.names if name in instead)
        return Unseen(self.name, float(np.max(held_out)) / variance, bool(np.max(fitted) < FLAT * variance), names)

    def _rises(self, fitted: np.ndarray, judged: np.ndarray) -> tuple[np.ndarray, set[str]]:
        """Return the rise of the squared error on some rows for each change, and what made up for it."""
        followers = self.free.copy()
        followers[self.space.names.index(self.name)] = False
        _, before = Refit(self.space, self.free, fitted).solve(self.problem, self.space.phi)
        rises, instead = [], set()
        for change in CHANGES:
            phi, after = Refit(self.space, followers, fitted).solve(self.problem, self._moved(change))
            rises.append(float(np.sum(after[judged] ** 2) - np.sum(before[judged] ** 2)))
            instead |= self._made_up(phi)
        return np.array(rises), instead

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
            if name in now and name != self.name and abs(now[name] - then[name]) > FOLLOWS * abs(then[name]) > 0.0
        }


def _quarters(count: int) -> list[np.ndarray]:
    """Return four sets of rows, each of short stretches from all over the log, as arrays of bool."""
    chunk = np.arange(count) * CHUNKS // count
    quarter = np.random.default_rng(CHUNKS).permutation(CHUNKS) % 4
    return [quarter[chunk] == one for one in range(4)]
