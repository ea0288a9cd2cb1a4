r"""A passive residual model behind an identified friction: elements that slip at limits depending on speed, and monotone functions.

Behind a model with effort :math:`\hat u` and friction :math:`\hat F`:

.. math::
    u = \hat u + m\,a + u_0 - c\,\hat F + \sum_i w_i\,e_i + \sum_j b_j\,\varphi_j(v),
    \qquad 0 \le c \le 1, \quad w_i, b_j \ge 0

:math:`e_i` is the deflection of an element that slips at :math:`|e_i| = r_i\,g_i(|v|)`. The limit is constant, falls with
the speed or rises with it. The functions :math:`\varphi_j` are odd and monotone.

Certificate: an element stores :math:`w_i e_i^2/2`. Motion does the work :math:`w_i e_i\,\mathrm dx` on it, and slip or a
falling limit only shortens :math:`e_i`. So the residual friction is passive for any :math:`g_i \ge 0`, and the factor
:math:`1 - c` leaves a passive friction passive. `slipping` returns the dissipated work of each step.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import NamedTuple, Self

import numba
import numpy as np

from bristle.core.least_squares import bounded
from bristle.identification import Fit
from bristle.identification.dataset import Dataset

RIDGE = 1e-3  # of the mean square of a column
LIMITS, SPEEDS = 12, (0.05, 0.15, 0.3, 0.5, 0.7, 0.9)  # number of limits; quantiles of the speed
NEAR = 0.1  # [s] around a reversal


@dataclass(frozen=True)
class Rows:
    """Rows of a record: effort, that of the model, and the inputs of the residual models."""

    effort: np.ndarray
    explained: np.ndarray
    # (row, column): elements, monotone functions, friction of the model with the sign reversed
    passive: np.ndarray
    lossless: np.ndarray  # (row, 2): acceleration and a constant
    state: np.ndarray  # (row, feature): deflections of the elements with constant limits over these limits, and the velocity
    near: np.ndarray
    reach: int

    def part(self, mask: np.ndarray) -> Rows:
        """Return some of the rows."""
        arrays = {
            one.name: getattr(self, one.name)[mask] for one in fields(self) if one.name != "reach"
        }
        return replace(self, **arrays)

    @classmethod
    def joined(cls, rows: Sequence[Rows]) -> Rows:
        """Return the rows of all records."""
        arrays = {
            one.name: np.concatenate([getattr(part, one.name) for part in rows])
            for one in fields(cls)
            if one.name != "reach"
        }
        return cls(reach=rows[0].reach, **arrays)


@numba.njit
def slipping(v: np.ndarray, dt: float, limit: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return force and dissipated work of each step of an element of stiffness 1; the limit [m or rad] varies."""
    force, dissipated, e = np.empty(v.size), np.empty(v.size), 0.0
    for k in range(v.size):
        before, way = e, v[k] * dt
        e = min(max(e, -limit[k]), limit[k])
        after = min(max(e + way, -limit[k]), limit[k])
        force[k] = after - 0.5 * (after - e) ** 2 / way if way != 0.0 else e
        dissipated[k] = force[k] * way - 0.5 * (after * after - before * before)
        e = after
    return force, dissipated


class Grid(NamedTuple):
    """Limits [m or rad] and speeds [m/s or rad/s] of the passive columns."""

    limits: np.ndarray
    speeds: np.ndarray

    @classmethod
    def over(cls, datasets: Sequence[Dataset]) -> Grid:
        """Return the grid for the motion of some records."""
        reach = 0.5 * max(float(np.ptp(part.position)) for one in datasets for part in one.segments)
        least = max(2.0 * datasets[0].resolution, 5.0 * datasets[0].noise, 1e-4 * reach)
        speed = np.abs(np.concatenate([one.velocity for one in datasets]))
        return cls(
            np.geomspace(least, reach, LIMITS), np.unique(np.quantile(speed[speed > 0.0], SPEEDS))
        )

    def elements(self, v: np.ndarray) -> Iterator[tuple[float, np.ndarray]]:
        """Yield the constant limit of each element [m or rad], and its limit along a motion."""
        yield from ((r, np.full(v.size, r)) for r in self.limits.tolist())
        for r in self.limits[::2].tolist():
            for scale in self.speeds[::2].tolist():
                yield r, r * np.exp(-np.abs(v) / scale)
                yield r, r * np.minimum(np.abs(v) / scale, 1.0)

    def monotone(self, v: np.ndarray) -> Iterator[np.ndarray]:
        """Yield odd monotone functions of the velocity, without unit."""
        yield v / self.speeds[-1]
        for scale in self.speeds.tolist():
            yield np.sign(v) * np.minimum(np.abs(v) / scale, 1.0)
            yield np.sign(v) * np.maximum(np.abs(v) - scale, 0.0) / self.speeds[-1]

    def columns(self, v: np.ndarray, dt: float) -> list[np.ndarray]:
        """Return the passive forces along a motion: elements over their limits, then monotone functions; shape (sample,) each."""
        elements = (slipping(v, dt, limit)[0] / r for r, limit in self.elements(v))
        return [*elements, *self.monotone(v)]


def rows_of(dataset: Dataset, fit: Fit, grid: Grid) -> Rows:
    """Return the rows of a record."""
    dt, filtered = dataset.sample_time, dataset.filtered
    columns = [
        [filtered(force) for force in grid.columns(part.velocity, dt)] for part in dataset.segments
    ]
    friction = dataset.rows_of(dataset.friction_along(fit.friction, fit.plant))
    forces = np.column_stack([dataset.rows_of(parts) for parts in zip(*columns, strict=True)])
    return Rows(
        dataset.effort,
        dataset.rows_of(dataset.explained(fit.plant, fit.friction)),
        np.column_stack([forces, -friction]),
        np.column_stack([dataset.acceleration, np.ones(friction.size)]),
        np.column_stack([forces[:, :LIMITS], dataset.velocity]),
        dataset.samples_from_reversal * dt <= NEAR,
        dataset.reach,
    )


class Passive:
    """Elements that slip and monotone functions, by ridge regression within bounds."""

    weights: np.ndarray

    def fit(self, rows: Rows) -> Self:
        """Find the weights."""
        A, target = np.column_stack([rows.passive, rows.lossless]), rows.effort - rows.explained
        scale = np.sqrt(np.mean(A * A, axis=0)) + np.finfo(float).tiny
        count, lossless = A.shape[1], rows.lossless.shape[1]
        low, high, penalty = (
            np.zeros(count),
            np.full(count, np.inf),
            np.full(count, (RIDGE * target.size) ** 0.5),
        )
        low[-lossless:], penalty[-lossless:] = -np.inf, 0.0
        # The factor of the model's friction does not fall below 0
        high[-lossless - 1] = scale[-lossless - 1]
        stacked = np.column_stack(
            [np.vstack([A / scale, np.diag(penalty)]), np.concatenate([target, np.zeros(count)])]
        )
        triangle = np.asarray(np.linalg.qr(stacked, mode="r"))
        self.weights = bounded(triangle[:, :-1], triangle[:, -1], low, high)[0] / scale
        return self

    def effort(self, rows: Rows) -> np.ndarray:
        """Return the residual effort."""
        return np.column_stack([rows.passive, rows.lossless]) @ self.weights
