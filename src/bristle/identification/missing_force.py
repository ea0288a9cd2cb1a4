r"""Forces missing from a model, found in the residual of its fit.

Each cause has a few columns: the first-order change of friction by this cause. A cause is present if its columns,
fitted to most half-cycles, predict the residual of the others (cross-validation [1]_). Weights remove two
disturbances first. Sampling errors dominate rows around reversals: forces that also act elsewhere are sought farther
away, and the weight of each band of distance from a reversal follows from its residual. And friction has another
level in each half-cycle: with the share :math:`1 - \sqrt{v_k / (\tau^2 + v_k)}` of that level removed, for a scatter
:math:`\tau` and an error :math:`v_k`, rows are nearly independent of it [2]_.

Changes of the parameters, of the inertia, of the delay or of a filter are not missing forces: their derivatives are
fitted with each cause.

Errors of the treatment also repeat in each half-cycle. A cause must therefore exceed a threshold: its force, times the
share of the residual that it explains, must be a share of friction. It must also exceed the result of random signs for
each half-cycle [3]_.

References
----------
.. [1] M. Stone, "Cross-validatory choice and assessment of statistical predictions", Journal of the Royal Statistical
   Society B 36(2), 1974. doi:10.1111/j.2517-6161.1974.tb00994.x
.. [2] W. A. Fuller, G. E. Battese, "Transformations for estimation of linear models with nested-error structure",
   Journal of the American Statistical Association 68(343), 1973. doi:10.1080/01621459.1973.10481414
.. [3] P. Kline, A. Santos, "A score based approach to wild bootstrap inference", Journal of Econometric Methods 1(1),
   2012. doi:10.1515/2156-6674.1006
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from bristle.core.least_squares import unbounded
from bristle.identification.half_cycles import Groups
from bristle.identification.missing_rows import FEWEST_ROWS, SMALL, SMALLEST, TINY, Rows, Weighed
from bristle.identification.settings import Settings

FALLS = (0.01, 0.03, 0.1, 0.3, 1.0)  # of the largest speed, over which friction may fall
# Of the range: build-up length of a force after a reversal.
WAYS = tuple(np.geomspace(1e-4, 0.03, 6).tolist())
LAGS = (0.01, 0.04)  # [s]
LAG_FALLS = (0.003, 0.01, 0.03, 0.1)  # of the largest speed
MOST_CAUSES = 3
FEWEST_UNITS = 24  # half-cycles, or parts of them, with separate signs
DRAWS = 1999  # of signs
HALF_POWER = np.log(2.0) ** 0.5 / (2.0 * np.pi)  # of a Gaussian: its width times its cut-off


class Missing(NamedTuple):
    """A force that the model lacks."""

    cause: str
    share: float
    force: float
    ratio: float = 0.0

    @property
    def evidence(self) -> float:
        """The force [N or N*m] times the explained share of the residual, both small for errors of the treatment."""
        return self.share * self.force


def missing_forces(
    rows: Rows, settings: Settings, *, static: bool = False
) -> tuple[tuple[Missing, ...], float]:
    """Return the forces that a model lacks away from reversals, strongest evidence first, and the remaining residual [N or N*m]."""
    # Noise dominates the acceleration at high frequencies. A `static` model lacks the force that builds up after reversals.
    if not rows.enough:
        return (), 0.0
    columns_of, missing, left = columns_by_cause(rows), list[Missing](), 0.0
    behind = columns_of.pop("presliding")
    if np.count_nonzero(rows.far) >= FEWEST_ROWS and (away := rows.at(rows.far)).enough:
        causes = {name: columns[rows.far] for name, columns in columns_of.items()}
        search = _Search.of(away, rows.explained[rows.far])
        missing, left = search.causes_in(causes, settings)
    if static:
        # A force that builds up over a way also lags: omit a lag from the explained columns.
        known = [columns_of[force.cause] for force in missing if force.cause != "lag"]
        search = _Search.of(rows, np.column_stack([rows.explained, *known]))
        around, of_all = search.causes_in({"presliding": behind}, settings)
        missing, left = [*missing, *around], left if missing else of_all
    return tuple(sorted(missing, key=attrgetter("evidence"), reverse=True)[:MOST_CAUSES]), left


@dataclass
class _Search:
    """A search for causes in rows, filtered or not; each found cause is added to the explained columns."""

    rows: Rows
    passed: _LowPass
    weighed: Weighed
    explained: np.ndarray

    @classmethod
    def of(cls, rows: Rows, explained: np.ndarray) -> _Search:
        """Return a search in the slow part of the rows."""
        passed = _LowPass.of(rows)
        explained = passed(explained / np.maximum(np.linalg.norm(explained, axis=0), SMALLEST))
        residual = passed(rows.residual)
        residual = residual - explained @ unbounded(explained, residual, rcond=TINY)
        slow = replace(rows, residual=residual, slope=passed(rows.slope))
        return cls(rows, passed, Weighed.of(slow), explained)

    def causes_in(
        self, candidates: Mapping[str, np.ndarray], settings: Settings
    ) -> tuple[list[Missing], float]:
        """Return the significant causes, and the remaining residual."""
        least = settings.missing_evidence * float(np.sqrt(np.mean(self.rows.friction**2)))
        causes = {name: self.passed(columns) for name, columns in candidates.items()}
        missing = list[Missing]()
        left = self.weighed.left(self.explained)
        while causes and len(missing) < MOST_CAUSES:
            level = 1.0 - (1.0 - settings.missing_level) / len(causes)
            forces = {name: self._force(name, columns, left) for name, columns in causes.items()}
            forces = {
                name: force
                for name, force in forces.items()
                if force.evidence >= least
                and _no_chance(self.weighed, self.explained, causes[name], level)
            }
            if not forces:
                break
            best = max(forces.values(), key=attrgetter("share"))
            missing.append(best)
            self.explained = np.column_stack([self.explained, causes.pop(best.cause)])
            left = self.weighed.left(self.explained)
        return missing, float(np.sqrt(np.mean(left**2)))

    def _force(self, cause: str, columns: np.ndarray, left: np.ndarray) -> Missing:
        """Return the force of a cause, fitted with the explained columns; `left` is the residual of these alone."""
        after, force = self.weighed.with_columns(self.explained, columns)
        share = 1.0 - float(after @ after) / max(float(left @ left), SMALLEST)
        return Missing(cause, max(share, 0.0), float(np.sqrt(np.mean(force**2))))


def columns_by_cause(rows: Rows) -> dict[str, np.ndarray]:
    """Return the first-order changes of friction by each cause, shape (row, column) each."""
    side, speed = rows.side[:, None], np.abs(rows.velocity)
    speed = speed / float(np.quantile(speed, 0.99))
    falls = np.exp(-speed[:, None] / np.array(FALLS))
    stroke = float(np.ptp(rows.position))
    behind = rows.from_ends(rows.position)[0][:, None] / (stroke * np.array(WAYS))
    return {
        "speed": side * np.column_stack([falls, np.sqrt(speed), speed**2]),
        "direction": np.column_stack([np.ones_like(speed), speed, falls]),
        "lag": lagging_columns(rows),
        "presliding": side * np.exp(-behind),
    }


def lagging_columns(rows: Rows) -> np.ndarray:
    """Return the change of falling friction by a lag behind the speed, shape (row, column); omitted rows are at rest."""
    speed, time = np.abs(rows.velocity), rows.time
    top, step = float(np.quantile(speed, 0.99)), np.diff(time, prepend=time[0])
    usual, falls = float(np.median(step)), np.array(LAG_FALLS)
    columns = []
    for lag in LAGS:
        keep, gain = np.exp(-step / lag), 1.0 - np.exp(-np.minimum(step, usual) / lag)
        lagged, late = np.empty_like(speed), float(speed[0])
        for row, (share, gained) in enumerate(
            zip(keep.tolist(), (gain * speed).tolist(), strict=True)
        ):
            late = share * late + gained
            lagged[row] = late
        columns.append(
            np.exp(-lagged[:, None] / (falls * top)) - np.exp(-speed[:, None] / (falls * top))
        )
    return rows.side[:, None] * np.hstack(columns)


@dataclass(frozen=True)
class _LowPass:
    """A Gaussian filter over stretches of rows, with its width in rows."""

    starts: np.ndarray
    ends: np.ndarray
    width: float

    @classmethod
    def of(cls, rows: Rows) -> _LowPass:
        """Return the filter whose cut-off separates the acceleration of the rows from its noise."""
        starts = np.flatnonzero(np.diff(rows.stretch, prepend=-1))
        width = HALF_POWER / (rows.narrow * float(np.median(np.diff(rows.time))))
        return cls(starts, np.append(starts[1:], rows.time.size), width)

    def __call__(self, signals: np.ndarray) -> np.ndarray:
        """Return filtered signals, shape (row, ...); at the ends the weights are renormalised."""
        from scipy.ndimage import gaussian_filter1d

        behind = np.empty_like(signals, dtype=float)
        for start, end in zip(self.starts, self.ends, strict=True):
            weight = gaussian_filter1d(np.ones(end - start), self.width, mode="constant")
            behind[start:end] = (
                gaussian_filter1d(signals[start:end], self.width, axis=0, mode="constant").T
                / weight
            ).T
        return behind


def _no_chance(weighed: Weighed, explained: np.ndarray, columns: np.ndarray, level: float) -> bool:
    """Return whether columns explain more of the residual than with random signs, at this level."""
    certain, free = weighed.of_columns(explained), weighed.of_columns(columns)
    free = free - certain @ unbounded(certain, free, rcond=TINY)
    free = free / np.maximum(np.linalg.norm(free, axis=0), SMALLEST)
    cycle, count = weighed.rows.cycles.index, weighed.rows.cycles.count
    part = np.arange(cycle.size) * FEWEST_UNITS // cycle.size
    units = Groups(cycle if count >= FEWEST_UNITS else cycle * FEWEST_UNITS + part)
    pulls = units.summed(free * weighed.without(explained)[:, None])
    # Drawn for each
    signs = np.random.default_rng(units.count).choice([-1.0, 1.0], (DRAWS, units.count))
    drawn = np.vstack([np.ones(units.count), signs]) @ pulls
    squares = np.sum(
        drawn * np.linalg.solve(free.T @ free + SMALL * np.eye(free.shape[1]), drawn.T).T, axis=1
    )
    return bool(squares[0] > np.quantile(squares[1:], level))
