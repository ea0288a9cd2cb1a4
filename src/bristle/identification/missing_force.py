r"""Forces that a model has no place for, found in what its fit leaves over.

Each cause has a few columns: what friction would do with it, to first order. A cause is there where its columns,
fitted to most half-cycles, tell the residual of the others (cross-validation [1]_). Two things would hide it, and are
weighed first. Rows around reversals err by their sampling: what does not act there alone is looked for farther away,
and each band of distance from a reversal counts by what it leaves over. And friction has another level on each
half-cycle: with the share :math:`1 - \sqrt{v_k / (\tau^2 + v_k)}` of that level taken out, of a scatter :math:`\tau`
and an error :math:`v_k`, rows are as good as independent of it [2]_.

What the parameters of the model can take is no missing force, nor is what a wrong inertia, a delay or a filter of
a channel makes: their derivatives are fitted with each cause.

References
----------
.. [1] M. Stone, "Cross-validatory choice and assessment of statistical predictions", Journal of the Royal Statistical
   Society B 36(2), 1974. doi:10.1111/j.2517-6161.1974.tb00994.x
.. [2] W. A. Fuller, G. E. Battese, "Transformations for estimation of linear models with nested-error structure",
   Journal of the American Statistical Association 68(343), 1973. doi:10.1080/01621459.1973.10481414
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from bristle.core.lazy import cached_property
from bristle.core.least_squares import unbounded
from bristle.core.variable import Kind
from bristle.friction.next_model import CHANNELS
from bristle.identification.dataset import Dataset
from bristle.identification.half_cycles import Groups, independent_rows
from bristle.identification.missing_columns import columns_by_cause
from bristle.identification.recorded_surroundings import holds
from bristle.identification.settings import Settings
from bristle.identification.waves import frequency_in, refined, waves

__all__ = ["Missing", "Rows", "missing_forces"]

PARTS = 10  # of the half-cycles, each told by the others
FEWEST_CYCLES, FEWEST_ROWS = 5, 200
BANDS = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)  # periods of the cut-off from a reversal
SLOW = (0.003, 0.01, 0.03)  # of the largest speed
LEAST_BAND = 0.5  # of the median: no band counts for much more than the others
SMALL = 1e-3  # of a column: what keeps one that is seldom seen from being fitted to chance
TINY = 1e-9
ROUNDS = 8  # of the weights, which depend on the scatter that they tell
GAP = 1.5  # of the time from row to row, beyond which some are left out
MOST = 3  # causes
SMALLEST = float(np.finfo(float).tiny)
SEEN = 1e-12  # of the friction of the half-cycle with most: less has no level
FAR = 3.0  # periods of the cut-off from a reversal
AS_GOOD = 1.05  # times what another cause leaves: gravity is what turns with an angle, before a parabola or a ripple
EVEN = 0.9  # of what a ripple tells, where it is alike in both directions, or not
OVERTONES = range(2, 7)  # of a ripple
OVERTONE = 0.1  # of the residual without the ripple, that one tells
ANYWHERE = ("speed", "direction", "position", "ripple", "gravity", *CHANNELS, "transmitted")
AROUND = ("lag", "play")
"""Causes that act everywhere, and those that act around reversals."""


class Missing(NamedTuple):
    """A force that the model lacks.

    Parameters
    ----------
    cause : str
        What it depends on: ``speed``, ``direction``, ``lag``, ``play``, ``position``, ``ripple``,
        ``gravity``, ``transmitted``, or a channel of what surrounds the axis.
    share : float
        Of the weighted squares of the residual, what it tells on half-cycles that it was not fitted to.
    force : float
        Root mean square of it over all rows [N or N*m], without what the parameters of the model would take.
    period : float
        Of a ripple [m or rad].
    amplitude : float
        Of gravity [N*m].
    alike : bool or None
        Whether a ripple is the same in both directions; False where it changes its sign with the motion, None where it
        does a part of both, or the log tells neither.
    overtones : tuple of int
        Of a ripple that is: how often in a period it comes back, 1 first.
    """

    cause: str
    share: float
    force: float
    period: float = 0.0
    amplitude: float = 0.0
    alike: bool | None = None
    overtones: tuple[int, ...] = ()


@dataclass(frozen=True)
class Rows:
    """The rows of a fit: motion and effort, the residual, the derivatives by its parameters, friction and its slope.

    `surroundings` are those that were recorded, by name.
    """

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
    surroundings: Mapping[str, np.ndarray]
    cutoff: float
    kind: Kind

    @classmethod
    def of(cls, dataset: Dataset, cycles: Groups, residual: np.ndarray, jacobian: np.ndarray, friction: np.ndarray,
           slope: np.ndarray) -> Rows:  # fmt: skip
        """Return the rows of a data set."""
        surroundings = dict[str, np.ndarray]()
        for name, surrounding in CHANNELS.items():
            if holds(dataset, surrounding):
                surroundings[name] = dataset.sampled([segment.surroundings[name] for segment in dataset.segments])
        return cls(
            dataset.time, dataset.position, dataset.velocity, dataset.acceleration, dataset.effort, residual, jacobian,
            dataset.effort - residual, friction, slope, cycles, surroundings, dataset.cutoff,
            dataset.kind,
        )  # fmt: skip

    def at(self, rows: np.ndarray) -> Rows:
        """Return some of the rows, of which an array of bool is true."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        arrays = {name: value[rows] for name, value in values.items() if isinstance(value, np.ndarray)}
        surroundings = {name: signal[rows] for name, signal in self.surroundings.items()}
        return replace(self, **arrays, cycles=Groups(self.cycles.of_rows[rows]), surroundings=surroundings)

    @property
    def enough(self) -> bool:
        """Whether there are enough rows and half-cycles for some to be told by the others."""
        moves = self.residual.size >= FEWEST_ROWS and bool(self.friction.any())
        return moves and self.cycles.count >= FEWEST_CYCLES

    @cached_property
    def far(self) -> np.ndarray:
        """Which rows are far from reversals, and move."""
        speed = np.abs(self.velocity)
        periods = np.minimum(*self.from_ends(self.time)) * self.cutoff
        return (periods > FAR) & (speed > SLOW[0] * float(np.quantile(speed, 0.99)))

    @cached_property
    def side(self) -> np.ndarray:
        """The direction of motion, 1 or -1."""
        return np.where(self.velocity < 0.0, -1.0, 1.0)

    @cached_property
    def first(self) -> np.ndarray:
        """The first row of each half-cycle."""
        return np.flatnonzero(np.diff(self.cycles.index, prepend=-1))

    @cached_property
    def last(self) -> np.ndarray:
        """The last row of each half-cycle."""
        return np.append(self.first[1:], self.residual.size) - 1

    def from_ends(self, along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return how far each row is from the first and from the last one of its half-cycle, along a signal."""
        cycle = self.cycles.index
        return np.abs(along - along[self.first][cycle]), np.abs(along[self.last][cycle] - along)

    @cached_property
    def explained(self) -> np.ndarray:
        """What is no missing force, shape (row, column): parameters, inertia, delay and filter, a constant."""
        rate = self._rate(self.predicted)
        further = (self.acceleration, rate, self._rate(rate), np.ones_like(rate))
        return np.column_stack([self.jacobian, *further])

    def _rate(self, signal: np.ndarray) -> np.ndarray:
        """Return the rate of a signal; none where rows are left out."""
        time = self.time
        step = np.diff(time, prepend=time[0])
        apart = step > GAP * np.median(step)
        return np.where(apart | np.roll(apart, -1), 0.0, np.gradient(signal, time))


def missing_forces(rows: Rows, settings: Settings) -> tuple[tuple[Missing, ...], float]:
    """Return the forces that a model lacks, the one that tells most first, and what is left without them [N or N*m].

    A cause counts from the shares of the weighted squares, of friction and of the effort that the settings name.
    """
    if not rows.enough:
        return (), 0.0
    missing, left = list[Missing](), 0.0
    if np.count_nonzero(rows.far) >= FEWEST_ROWS and (away := rows.at(rows.far)).enough:
        missing, left = _search(away, away.explained, ANYWHERE, settings.missing_share, settings)
    explained = np.column_stack([rows.explained, *(_columns_of(rows, force) for force in missing)])
    around, of_all = _search(rows, explained, AROUND, settings.missing_share_around, settings)
    return (*missing, *around), left if missing else of_all


def _search(
    rows: Rows, explained: np.ndarray, names: Sequence[str], least_share: float, settings: Settings
) -> tuple[list[Missing], float]:  # fmt: skip
    """Return the causes of these names that tell something of rows, besides what is explained, and what is left."""
    friction, effort = (float(np.sqrt(np.mean(signal**2))) for signal in (rows.friction, rows.effort))
    least = max(settings.missing_force * friction, settings.missing_effort * effort)
    weighed, missing = _Weighed.of(rows), list[Missing]()
    causes = {name: columns for name, columns in columns_by_cause(rows).items() if name in names}
    left = weighed.left(explained)
    while len(missing) < MOST:
        ripple, period = _ripple(rows, weighed, explained) if "ripple" in names else (None, 0.0)
        tried = causes | ({} if ripple is None or any(force.period for force in missing) else {"ripple": ripple})
        forces = [_tried(weighed, name, columns, explained=explained, left=left) for name, columns in tried.items()]
        forces = [force for force in forces if force.share >= least_share and force.force >= least]
        if not forces:
            break
        best = _likeliest(forces, tried, partial(_tried, weighed, explained=explained, left=left))
        if best.cause == "ripple":
            best = _in_detail(best._replace(period=period), rows, weighed, explained, left, least)
        missing.append(best)
        explained = np.column_stack([explained, tried[best.cause]])
        causes.pop(best.cause, None)
        left = weighed.left(explained)
    return missing, float(np.sqrt(np.mean(left**2)))


def _columns_of(rows: Rows, force: Missing) -> np.ndarray:
    """Return what friction does by the cause of a force, shape (row, column)."""
    return waves(rows.position, rows.side, 1.0 / force.period) if force.period else columns_by_cause(rows)[force.cause]


def _ripple(rows: Rows, weighed: _Weighed, explained: np.ndarray) -> tuple[np.ndarray | None, float]:
    """Return the waves over the position that take most of what is left, added to friction and in proportion to it."""
    x, side = rows.position, rows.side
    most = float(np.ptp(x)) * rows.cutoff / float(np.median(np.abs(rows.velocity)))
    residual = weighed.without(explained)
    frequency = frequency_in(x, side, residual, most)
    frequency = None if frequency is None else refined(x, side, residual, frequency)
    return (None, 0.0) if frequency is None else (waves(x, side, frequency), 1.0 / frequency)


def _tried(weighed: _Weighed, cause: str, columns: np.ndarray, *, explained: np.ndarray, left: np.ndarray) -> Missing:
    after, force, coefficients = weighed.with_columns(explained, columns)
    share = 1.0 - float(after @ after) / max(float(left @ left), SMALLEST)
    amplitude = float(np.hypot(*coefficients)) if cause == "gravity" else 0.0
    return Missing(cause, share, float(np.sqrt(np.mean(force**2))), amplitude=amplitude)


def _likeliest(
    forces: Sequence[Missing], columns: Mapping[str, np.ndarray], tried: Callable[[str, np.ndarray], Missing]
) -> Missing:
    """Return the cause that tells most; gravity before a place or a ripple that tell no more, alike in both directions.

    The first two columns of either are those.
    """
    best = max(forces, key=lambda force: force.share)
    gravity = next((force for force in forces if force.cause == "gravity"), None)
    if gravity is None or best.cause not in ("position", "ripple"):
        return best
    alike = tried(best.cause, columns[best.cause][:, :2])
    return gravity if 1.0 - gravity.share <= AS_GOOD * (1.0 - alike.share) else best


def _in_detail(
    ripple: Missing, rows: Rows, weighed: _Weighed, explained: np.ndarray, left: np.ndarray, least: float
) -> Missing:
    """Return a ripple with whether it is alike in both directions, and how often in its period it comes back."""
    columns = waves(rows.position, rows.side, 1.0 / ripple.period)
    even, odd = (
        _tried(weighed, "ripple", part, explained=explained, left=left).share >= EVEN * ripple.share
        for part in (columns[:, :2], columns[:, 2:])
    )
    if not even or odd:
        return ripple._replace(alike=False if odd and not even else None)
    overtones, explained = [1], np.column_stack([explained, columns])
    for times in OVERTONES:
        pair = waves(rows.position, rows.side, times / ripple.period)[:, :2]
        force = _tried(weighed, "ripple", pair, explained=explained, left=weighed.left(explained))
        if force.share >= OVERTONE and force.force >= least:
            overtones.append(times)
            explained = np.column_stack([explained, pair])
    return ripple._replace(alike=True, overtones=tuple(overtones))


@dataclass(frozen=True)
class _Weighed:
    """Rows of equal worth: weighed by their distance from a reversal, and freed of the scatter of the level.

    `lost` is the share of its level that each half-cycle loses, `part` the number of the part that a row is in.
    """

    rows: Rows
    weight: np.ndarray
    lost: np.ndarray
    part: np.ndarray

    @classmethod
    def of(cls, rows: Rows) -> _Weighed:
        """Return the weights that the residual of a fit asks for."""
        cycle, residual = rows.cycles.index, rows.residual
        nearest = np.minimum(*rows.from_ends(rows.time)) * rows.cutoff
        speed = np.abs(rows.velocity)
        slow = np.digitize(speed / float(np.quantile(speed, 0.99)), SLOW)
        band = np.digitize(nearest, BANDS) + (len(BANDS) + 1) * slow
        squares = np.bincount(band, residual**2) / np.maximum(np.bincount(band), 1)
        size = np.sqrt(squares)[band]
        size = np.maximum(size, max(LEAST_BAND * float(np.median(size)), TINY * float(np.abs(rows.predicted).max())))
        weight = 1.0 / size
        weight /= float(np.sqrt(np.mean(weight**2)))
        part = np.arange(residual.size) * 2 * PARTS // residual.size
        part = (cycle if rows.cycles.count >= 2 * PARTS else part) % PARTS
        return cls(rows, weight, _lost(rows, weight), part)

    def of_columns(self, columns: np.ndarray) -> np.ndarray:
        """Return columns or a signal, shape (row, ...), weighed."""
        slope = self.rows.slope * self.weight
        weighed = columns.reshape(columns.shape[0], -1) * self.weight[:, None]
        power, cycles = self.rows.cycles.summed(slope * slope), self.rows.cycles
        level = cycles.summed(slope[:, None] * weighed) / _floored(power)[:, None]
        freed = weighed - (self.lost[:, None] * level)[cycles.index] * slope[:, None]
        return freed.reshape(columns.shape)

    @cached_property
    def residual(self) -> np.ndarray:
        """The residual, weighed."""
        return self.of_columns(self.rows.residual)

    def without(self, explained: np.ndarray) -> np.ndarray:
        """Return the weighed residual without what some columns take of it, fitted to all rows."""
        columns = self.of_columns(explained)
        return self.residual - columns @ unbounded(columns, self.residual, rcond=TINY)

    def left(self, explained: np.ndarray) -> np.ndarray:
        """Return the weighed residual without what some columns, fitted to the other parts, tell of each part."""
        return self._fitted(self.of_columns(explained), explained.shape[1])[0]

    def with_columns(self, explained: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the same with the columns of a cause, what these take beside the others [N or N*m], coefficients."""
        together = np.column_stack([explained, columns])
        left, coefficients = self._fitted(self.of_columns(together), explained.shape[1])
        coefficients = coefficients[explained.shape[1] :]
        force = (columns @ coefficients) * self.weight
        own = np.linalg.qr(explained * self.weight[:, None])[0]
        return left, force - own @ (own.T @ force), coefficients

    def _fitted(self, columns: np.ndarray, certain: int) -> tuple[np.ndarray, np.ndarray]:
        """Return what is left of each part by a fit to the others, and the coefficients of a fit to all.

        All but the first columns, which are `certain`, are held back a little.
        """
        scale = np.linalg.norm(columns, axis=0)
        scale[scale == 0.0] = 1.0
        scaled, residual = columns / scale, self.residual
        parts = [self.part == number for number in range(PARTS)]
        grams = [scaled[rows].T @ scaled[rows] for rows in parts]
        rights = [scaled[rows].T @ residual[rows] for rows in parts]
        held = np.diag(np.where(np.arange(scale.size) < certain, TINY, SMALL))
        gram, right, left = sum(grams) + held, sum(rights), np.empty_like(residual)
        for rows, own, pull in zip(parts, grams, rights, strict=True):
            left[rows] = residual[rows] - scaled[rows] @ np.linalg.solve(gram - own, right - pull)
        return left, np.linalg.solve(gram, right) / scale


def _floored(power: np.ndarray) -> np.ndarray:
    return np.maximum(power, max(SEEN * float(power.max()), SMALLEST))


def _lost(rows: Rows, weight: np.ndarray) -> np.ndarray:
    """Return the share of its level that each half-cycle loses, so that its rows are as good as independent."""
    slope, residual, cycles = rows.slope * weight, rows.residual * weight, rows.cycles
    power = _floored(cycles.summed(slope * slope))
    if power.max() <= SMALLEST:
        return np.zeros(cycles.count)
    level = cycles.summed(slope * residual) / power
    within = residual - level[cycles.index] * slope
    error = float(within @ within) / max(independent_rows(within), 1.0) / power
    square = float(np.mean(level**2))
    for _ in range(ROUNDS):
        share = 1.0 / (square + error)
        square = float(np.sum(share * level**2) / np.sum(share))
    square = max(square - float(np.median(error)), 0.0)
    return 1.0 - np.sqrt(error / np.maximum(error + square, SMALLEST))
