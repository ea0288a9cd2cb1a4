"""The rows of a fit in the search for a missing force, and their weights."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from bristle.core.lazy import cached_property
from bristle.core.least_squares import unbounded
from bristle.identification.dataset import PIECES, Dataset, spread
from bristle.identification.half_cycles import Groups, independent_rows

PARTS = 10  # parts of the half-cycles, each predicted from the others
FEWEST_CYCLES, FEWEST_ROWS = 5, 200
BANDS = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)  # periods of the cut-off from a reversal
SLOW = (0.003, 0.01, 0.03)  # of the largest speed
LEAST_BAND = 0.5  # of the median: lower bound of the residual of a band, which limits its weight
SMALL = 1e-3  # of a column: ridge against a fit to chance
TINY = 1e-9
GAP = 1.5  # of the time from row to row: a larger step is a gap
SMALLEST = float(np.finfo(float).tiny)
NARROW = 0.125  # of the cut-off: above, corners and filters dominate the rows


@dataclass(frozen=True)
class Rows:
    """The rows of a fit: motion and effort, the residual, the derivatives by its parameters, friction and its slope."""

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    effort: np.ndarray
    residual: np.ndarray
    jacobian: np.ndarray
    predicted: np.ndarray
    friction: np.ndarray
    slope: np.ndarray
    cycles: Groups
    cutoff: float
    turned: np.ndarray  # time to the nearest change of direction [s], trembles included
    narrow: float  # frequency below which noise of the acceleration is negligible [Hz]

    @classmethod
    def of(
        cls,
        dataset: Dataset,
        cycles: Groups,
        residual: np.ndarray,
        jacobian: np.ndarray,
        friction: np.ndarray,
        slope: np.ndarray,
    ) -> Rows:
        """Return the rows of a data set."""
        return cls(
            time=dataset.time,
            position=dataset.position,
            velocity=dataset.velocity,
            acceleration=dataset.acceleration,
            effort=dataset.effort,
            residual=residual,
            jacobian=jacobian,
            predicted=dataset.effort - residual,
            friction=friction,
            slope=slope,
            cycles=cycles,
            cutoff=dataset.cutoff,
            turned=dataset.samples_from_reversal * dataset.sample_time,
            narrow=min(
                (dataset.alignment and dataset.alignment.slow) or np.inf, NARROW * dataset.cutoff
            ),
        )

    def at(self, rows: np.ndarray) -> Rows:
        """Return the rows selected by a mask."""
        arrays = {
            entry.name: signal[rows]
            for entry in fields(self)
            if isinstance(signal := getattr(self, entry.name), np.ndarray)
        }
        return replace(self, **arrays, cycles=Groups(self.cycles.of_rows[rows]))

    def pieces(self, most: int) -> Rows:
        """Return at most `most` rows: pieces from the whole log."""
        size = self.residual.size
        if size <= most:
            return self
        chosen = np.zeros(size, dtype=bool)
        for piece in spread(size, most // PIECES):
            chosen[piece] = True
        return self.at(chosen)

    @property
    def enough(self) -> bool:
        """Whether there are enough rows and half-cycles for cross-validation."""
        return (
            self.residual.size >= FEWEST_ROWS
            and bool(self.friction.any())
            and self.cycles.count >= FEWEST_CYCLES
        )

    @cached_property
    def far(self) -> np.ndarray:
        """Mask of the moving rows far from reversals and trembles."""
        speed = np.abs(self.velocity)
        periods = np.minimum(self.turned, np.minimum(*self.from_ends(self.time))) * self.cutoff
        # Periods of the cut-off from a reversal.
        return (periods > 3.0) & (speed > SLOW[0] * float(np.quantile(speed, 0.99)))

    @cached_property
    def stretch(self) -> np.ndarray:
        """The number of the contiguous stretch of each row."""
        step = np.diff(self.time, prepend=self.time[0])
        return np.cumsum(step > GAP * np.median(step))

    @cached_property
    def side(self) -> np.ndarray:
        """The direction of motion, 1 or -1."""
        return np.where(self.velocity < 0.0, -1.0, 1.0)

    def from_ends(self, along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the distance of each row from the first and the last row of its half-cycle, along a signal."""
        cycle, first = self.cycles.index, self.cycles.first
        last = np.append(first[1:], self.residual.size) - 1
        return np.abs(along - along[first][cycle]), np.abs(along[last][cycle] - along)

    @cached_property
    def explained(self) -> np.ndarray:
        """Columns that do not count as a missing force, shape (row, column): parameters, inertia, delay and filter, a constant."""
        rate = self.rate(self.predicted)
        return np.column_stack(
            [self.jacobian, self.acceleration, rate, self.rate(rate), np.ones_like(rate)]
        )

    def rate(self, signal: np.ndarray) -> np.ndarray:
        """Return the rate of a signal; 0 at gaps."""
        time = self.time
        step = np.diff(time, prepend=time[0])
        apart = step > GAP * np.median(step)
        return np.where(apart | np.roll(apart, -1), 0.0, np.gradient(signal, time))


@dataclass(frozen=True)
class Weighed:
    """Rows weighted by their distance from a reversal, and whitened of the level scatter: `lost` is the removed share."""

    rows: Rows
    weight: np.ndarray
    lost: np.ndarray  # of the level, for each half-cycle
    part: np.ndarray  # number of the part of a row

    @classmethod
    def of(cls, rows: Rows) -> Weighed:
        """Return the rows with weights from the residual of a fit."""
        cycle, residual = rows.cycles.index, rows.residual
        nearest = np.minimum(*rows.from_ends(rows.time)) * rows.cutoff
        speed = np.abs(rows.velocity)
        slow = np.digitize(speed / float(np.quantile(speed, 0.99)), SLOW)
        band = np.digitize(nearest, BANDS) + (len(BANDS) + 1) * slow
        squares = np.bincount(band, residual**2) / np.maximum(np.bincount(band), 1)
        size = np.sqrt(squares)[band]
        size = np.maximum(
            size,
            max(LEAST_BAND * float(np.median(size)), TINY * float(np.abs(rows.predicted).max())),
        )
        weight = 1.0 / size
        weight /= float(np.sqrt(np.mean(weight**2)))
        part = np.arange(residual.size) * 2 * PARTS // residual.size
        part = (cycle if rows.cycles.count >= 2 * PARTS else part) % PARTS
        slope, residual, cycles = rows.slope * weight, residual * weight, rows.cycles
        power = _floored(cycles.summed(slope * slope))
        lost = np.zeros(cycles.count)
        if power.max() > SMALLEST:
            # After removal of this share, the rows of a half-cycle are nearly independent.
            level = cycles.summed(slope * residual) / power
            within = residual - level[cycles.index] * slope
            error = float(within @ within) / max(independent_rows(within), 1.0) / power
            square = float(np.mean(level**2))
            for _ in range(8):  # iterations of the weights, which depend on the scatter
                share = 1.0 / (square + error)
                square = float(np.sum(share * level**2) / np.sum(share))
            square = max(square - float(np.median(error)), 0.0)
            lost = 1.0 - np.sqrt(error / np.maximum(error + square, SMALLEST))
        return cls(rows, weight, lost, part)

    def of_columns(self, columns: np.ndarray) -> np.ndarray:
        """Return weighted columns or a weighted signal, shape (row, ...)."""
        slope = self.rows.slope * self.weight
        weighed = columns.reshape(columns.shape[0], -1) * self.weight[:, None]
        power, cycles = self.rows.cycles.summed(slope * slope), self.rows.cycles
        level = cycles.summed(slope[:, None] * weighed) / _floored(power)[:, None]
        return (weighed - (self.lost[:, None] * level)[cycles.index] * slope[:, None]).reshape(
            columns.shape
        )

    @cached_property
    def residual(self) -> np.ndarray:
        """The weighted residual."""
        return self.of_columns(self.rows.residual)

    def without(self, explained: np.ndarray) -> np.ndarray:
        """Return the weighted residual after a fit of columns to all rows."""
        columns = self.of_columns(explained)
        return self.residual - columns @ unbounded(columns, self.residual, rcond=TINY)

    def left(self, explained: np.ndarray) -> np.ndarray:
        """Return the weighted residual of each part after a fit of columns to the other parts."""
        return self._fitted(self.of_columns(explained), explained.shape[1])[0]

    def with_columns(
        self, explained: np.ndarray, columns: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the same with the columns of a cause, and their force beyond the explained columns [N or N*m]."""
        together = np.column_stack([explained, columns])
        left, coefficients = self._fitted(self.of_columns(together), explained.shape[1])
        coefficients = coefficients[explained.shape[1] :]
        force = (columns @ coefficients) * self.weight
        own = np.linalg.qr(explained * self.weight[:, None])[0]
        return left, force - own @ (own.T @ force)

    def _fitted(self, columns: np.ndarray, certain: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the residual of each part after a fit to the others, and the coefficients of a fit to all."""
        # A ridge on all but the first columns, which are `certain`.
        scale = np.linalg.norm(columns, axis=0)
        scale[scale == 0.0] = 1.0
        scaled, residual = columns / scale, self.residual
        parts, gram, right, left = list[Any](), 0, 0, np.empty_like(residual)
        for number in range(PARTS):
            rows = self.part == number
            own, pull = scaled[rows].T @ scaled[rows], scaled[rows].T @ residual[rows]
            parts.append((rows, own, pull))
            gram, right = gram + own, right + pull
        gram = gram + np.diag(np.where(np.arange(scale.size) < certain, TINY, SMALL))
        for rows, own, pull in parts:
            left[rows] = residual[rows] - scaled[rows] @ np.linalg.solve(gram - own, right - pull)
        return left, np.linalg.solve(gram, right) / scale


def _floored(power: np.ndarray) -> np.ndarray:
    # Of the half-cycle with the most friction: below, it has no level.
    return np.maximum(power, max(1e-12 * float(power.max()), SMALLEST))
