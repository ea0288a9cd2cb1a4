r"""Forces that a model lacks and that the noise of single rows hides: found where the acceleration is no noise.

Noise of the position is most of a residual at high frequencies, and biases what is fitted to it, the inertia above all.
What friction lacks is slow. Residual, columns of the causes and all that is fitted with them pass one low-pass filter,
which changes no coefficient, at the cut-off that the equations of the first stage were weighed with. Of what is then
left, a cause must tell a share on half-cycles that it was not fitted to, and take more of it than with a sign drawn by
chance for each half-cycle (wild bootstrap by cluster [1]_): rows are as correlated within one as they like.

References
----------
.. [1] P. Kline, A. Santos, "A score based approach to wild bootstrap inference", Journal of Econometric Methods 1(1),
   2012. doi:10.1515/2156-6674.1006
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from bristle.core.least_squares import unbounded
from bristle.identification.half_cycles import Groups
from bristle.identification.missing_force import ANYWHERE, Missing, columns_by_cause, force_of, lagging_columns, ripple_in
from bristle.identification.missing_rows import FEWEST_ROWS, SMALLEST, Rows, Weighed
from bristle.identification.settings import Settings

__all__ = ["slow_forces"]

HALF_POWER = np.log(2.0) ** 0.5 / (2.0 * np.pi)  # of a Gaussian: its width times its cut-off
FEWEST_CYCLES = 10  # fewer do not tell a scatter of friction from a cause
FEWEST_UNITS = 24  # half-cycles, or parts of them, that have a sign of their own
SIGNS = 499  # drawn for each
SMALL, TINY = 1e-3, 1e-9


def slow_forces(rows: Rows, settings: Settings) -> tuple[tuple[Missing, ...], float]:
    """Return the force that a model lacks, none or one, and what is left without it [N or N*m].

    It is looked for away from reversals; around them, a lag alone.
    """
    if not rows.enough:
        return (), 0.0
    friction, lag = float(np.sqrt(np.mean(rows.friction**2))), lagging_columns(rows)
    missing, left = (), 0.0
    if np.count_nonzero(rows.far) >= FEWEST_ROWS and (away := rows.at(rows.far)).enough:
        causes = {name: columns for name, columns in columns_by_cause(rows).items() if name in ANYWHERE} | {"lag": lag}
        causes = {name: columns[rows.far] for name, columns in causes.items()}
        forces = settings.missing_slow_force * friction, settings.missing_sought_force * friction
        least = _Least(settings.missing_slow_share, settings.missing_level, *forces)
        missing, left = _largest(away, rows.explained[rows.far], causes, least)
    if missing:
        return missing, left
    force = settings.missing_slow_force_around * friction
    return _largest(rows, rows.explained, {"lag": lag}, _Least(settings.missing_slow_share_around, settings.missing_level, force))


class _Least(NamedTuple):
    """From which share of what is left, level by chance and force [N or N*m] on a cause counts.

    A ripple, whose period is looked for, counts from a `ripple` of its own on; none is looked for without.
    """

    share: float
    level: float
    force: float
    ripple: float = math.inf


def _largest(rows: Rows, explained: np.ndarray, causes: Mapping[str, np.ndarray], least: _Least) -> tuple[tuple[Missing, ...], float]:
    """Return the cause that tells most behind the filter, none or one, and what is left beside all causes."""
    if rows.cycles.count < FEWEST_CYCLES:
        return (), 0.0
    passed = _LowPass.of(rows)
    explained = passed(explained / np.maximum(np.linalg.norm(explained, axis=0), SMALLEST))
    residual = passed(rows.residual)
    residual = residual - explained @ unbounded(explained, residual, rcond=TINY)
    weighed = Weighed.of(replace(rows, residual=residual, slope=passed(rows.slope)))
    ripple, period = (None, 0.0) if math.isinf(least.ripple) else ripple_in(rows, weighed, explained, rows.narrow)
    left, forces = weighed.left(explained), list[Missing]()
    for name, columns in ({**causes} | ({} if ripple is None else {"ripple": ripple})).items():
        slow = passed(columns)
        force = force_of(weighed, name, slow, explained=explained, left=left)
        large = force.force >= (least.ripple if name == "ripple" else least.force)
        if large and force.share >= least.share and _no_chance(weighed, explained, slow, least.level):
            forces.append(force._replace(period=period) if name == "ripple" else force)
    if not forces:
        return (), 0.0
    return (max(forces, key=lambda force: force.share),), float(np.sqrt(np.mean(left**2)))


@dataclass(frozen=True)
class _LowPass:
    """A Gaussian over stretches of rows, of a width in rows."""

    starts: np.ndarray
    ends: np.ndarray
    width: float

    @classmethod
    def of(cls, rows: Rows) -> _LowPass:
        """Return the filter whose cut-off is where the acceleration of rows begins to be noise."""
        starts = np.flatnonzero(np.diff(rows.stretch, prepend=-1))
        width = HALF_POWER / (rows.narrow * float(np.median(np.diff(rows.time))))
        return cls(starts, np.append(starts[1:], rows.time.size), width)

    def __call__(self, signals: np.ndarray) -> np.ndarray:
        """Return signals, shape (row, ...), behind the filter, which takes no more than there is at an end."""
        from scipy.ndimage import gaussian_filter1d

        behind = np.empty_like(signals, dtype=float)
        for start, end in zip(self.starts, self.ends, strict=True):
            weight = gaussian_filter1d(np.ones(end - start), self.width, mode="constant")
            slow = gaussian_filter1d(signals[start:end], self.width, axis=0, mode="constant")
            behind[start:end] = (slow.T / weight).T
        return behind


def _no_chance(weighed: Weighed, explained: np.ndarray, columns: np.ndarray, level: float) -> bool:
    """Return whether columns take more of what is left than with signs by chance, but for so many of them."""
    certain, free = weighed.of_columns(explained), weighed.of_columns(columns)
    free = free - certain @ unbounded(certain, free, rcond=TINY)
    free = free / np.maximum(np.linalg.norm(free, axis=0), SMALLEST)
    cycle, count = weighed.rows.cycles.index, weighed.rows.cycles.count
    part = np.arange(cycle.size) * FEWEST_UNITS // cycle.size
    units = Groups(cycle if count >= FEWEST_UNITS else cycle * FEWEST_UNITS + part)
    pulls = units.summed(free * weighed.without(explained)[:, None])
    signs = np.random.default_rng(units.count).choice([-1.0, 1.0], (SIGNS, units.count))
    drawn = np.vstack([np.ones(units.count), signs]) @ pulls
    squares = np.sum(drawn * np.linalg.solve(free.T @ free + SMALL * np.eye(free.shape[1]), drawn.T).T, axis=1)
    return bool(squares[0] > np.quantile(squares[1:], level))
