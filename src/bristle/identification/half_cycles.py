r"""Groups of rows: half-cycles, over which friction has one level, and held-out blocks.

The level of friction scatters by a few percent from half-cycle to half-cycle. It is constant within a half-cycle, so
samples do not average it out.

With the force :math:`F(c)` of a model whose forces are all scaled by :math:`c`, the scale of a half-cycle `k` is

.. math:: \hat c_k = 1 + \frac{s_k \cdot r_k}{s_k \cdot s_k}, \qquad s = \frac{\partial F}{\partial c}

from the residual `r` there. The visible scatter :math:`\tau` is the root mean square of
:math:`\hat c_k - 1` with the weights :math:`1 / (\tau^2 + v_k)` of a random effect [1]_, where
:math:`v_k = \sigma^2 / (s_k \cdot s_k)` is the error of :math:`\hat c_k`. A long slide determines one level, as a short
stroke does. The parameters of a fit absorb part of the scatter.

A contiguous held-out part is the harder test, because no neighbouring rows were fitted. It is unfair if that part is a
separate experiment, as in a designed log: without the only fast slides, viscous friction is unknown. Each part then
consists of short segments from the whole log. Several logs are one experiment: a part has a block of each.

References
----------
.. [1] R. DerSimonian, N. Laird, "Meta-analysis in clinical trials", Controlled Clinical Trials 7(3), 1986.
   doi:10.1016/0197-2456(86)90046-2
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from bristle.core.contracts import FrictionModel, Model
from bristle.core.packing import pack
from bristle.core.values import numbers_of
from bristle.engine.motion import in_turns
from bristle.identification.dataset import Dataset, Segment
from bristle.identification.settings import DEFAULT, Settings
from bristle.logs.filters import derivative, low_passed
from bristle.logs.turns import half_cycle_numbers, turning_points
from bristle.models.friction.level import TRANSMITTED
from bristle.models.friction.slots import OFFSET

STEPS = 2.0  # of the encoder
NUDGE = 1e-3
FEWEST_LEVELS = 8
BLOCKS = 5  # default number of parts of a log
TIME, SHORT = "time blocks", "short time blocks"
BINS = 4  # of a decade of speed
FEW = 0.25  # of the rows of a block: fewer rows at a speed in other blocks do not count
LEAST = 4  # length of a short segment over twice the reach of the filters
SEED = 5


@dataclass(frozen=True)
class Groups:
    """Groups of consecutive rows, by the number of the group of each row, shape (row,), never decreasing."""

    of_rows: np.ndarray

    index: np.ndarray = field(init=False)
    """Number of the group of each row, counted among groups with rows."""
    first: np.ndarray = field(init=False)
    """The first row of each group."""
    count: int = field(init=False)

    def __post_init__(self) -> None:
        first, index = np.unique(self.of_rows, return_index=True, return_inverse=True)[1:]
        self.__dict__.update(index=index, first=first, count=first.size)

    def summed(self, rows: np.ndarray) -> np.ndarray:
        """Return the sum of a signal over the rows of each group, shape (group, ...)."""
        return np.add.reduceat(rows, self.first, axis=0)


def half_cycle_starts(dataset: Dataset) -> tuple[tuple[int, ...], ...]:
    """Return the first sample, 0 first, of each half-cycle of each segment; noise and encoder steps are not reversals."""
    least = least_way(dataset.resolution, dataset.noise)
    return tuple(
        (0, *turning_points(segment.position, least, turns))
        for segment, turns in zip(dataset.segments, dataset.reversals, strict=True)
    )


def half_cycles(dataset: Dataset) -> Groups:
    """Return the rows of each half-cycle, counted through all segments."""
    turns = [starts[1:] for starts in half_cycle_starts(dataset)]
    return Groups(
        dataset.sampled(
            half_cycle_numbers(turns, [segment.time.size for segment in dataset.segments])
        )
    )


def least_way(resolution: float, noise: float) -> float:
    """Return the smallest way [m or rad] that is a motion, from the encoder step and the position noise."""
    # Times the position noise: a body at rest stays within.
    return max(STEPS * resolution, 8.0 * noise)


def scatter_in(cycles: Groups, slope: np.ndarray, residual: np.ndarray) -> float:
    """Return the standard deviation of the friction level between half-cycles; `slope` is the derivative of the signal by the level."""
    power, excess = _excess(cycles, slope, residual)
    if not np.any(excess):
        return 0.0
    rest = within_cycles(cycles, slope, residual)
    # The filter distorts rows near a reversal: half-cycles of a few rows do not show a level.
    # Rows of a half-cycle that reaches beyond the reversal.
    long = np.bincount(cycles.index, minlength=power.size) >= 4
    if np.count_nonzero(long) >= FEWEST_LEVELS:
        power, excess = power[long], excess[long]
    noise, square = float(rest @ rest) / independent_rows(rest), math.inf
    for _ in range(8):  # iterations of the weights, which depend on the scatter
        weight = power / (power + noise / square)
        square = float(np.sum(weight * excess * excess) / np.sum(weight))
    return square**0.5


def within_cycles(cycles: Groups, slope: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """Return the residual [N or N*m] with the best level for each half-cycle, shape (row,)."""
    return residual - _excess(cycles, slope, residual)[1][cycles.index] * slope


def _excess(
    cycles: Groups, slope: np.ndarray, residual: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the sum of squares of the slope in each half-cycle, and the relative excess of its level over the model."""
    power, pull = cycles.summed(slope * slope), cycles.summed(slope * residual)
    return power, np.divide(pull, power, out=np.zeros_like(pull), where=power > 0.0)


def most_apart(
    dataset: Dataset, slope: np.ndarray, residual: np.ndarray
) -> tuple[int, float, float]:
    """Return the log whose level differs most from that of the others, the relative difference, and its standard error."""
    cycles = half_cycles(dataset)
    power, excess = _excess(cycles, slope, residual)
    log = dataset.log_of_row[cycles.first].astype(int)
    weight = np.maximum(np.bincount(log, power), np.finfo(float).tiny)
    level = np.bincount(log, power * excess) / weight
    # The scatter between the half-cycles of a log, of which each counts by its weight.
    variance = (
        float(power @ (excess - level[log]) ** 2 / np.sum(weight))
        * np.bincount(log, power**2)
        / weight**2
    )
    rest = np.sum(weight) - weight
    level_of_rest = (weight @ level - weight * level) / rest
    error = np.sqrt(variance + (weight**2 @ variance - weight**2 * variance) / rest**2)
    number = int(np.argmax(np.abs(level - level_of_rest)))
    return number, float(level[number] - level_of_rest[number]), float(error[number])


def neighbour_correlation(residual: np.ndarray) -> float:
    """Return the correlation of consecutive rows; 0 for a zero residual."""
    square = float(residual @ residual)
    return float(residual[1:] @ residual[:-1]) / square if square > 0.0 else 0.0


def independent_rows(residual: np.ndarray) -> float:
    r"""Return the effective number of independent rows of a residual, :math:`N (1 - \rho) / (1 + \rho)`."""
    correlation = min(max(neighbour_correlation(residual), 0.0), 0.999)
    return residual.size * (1.0 - correlation) / (1.0 + correlation)


def blocks_for(dataset: Dataset, requested: int | None, settings: Settings) -> int:
    """Return the number of held-out blocks: as requested, else five, fewer for a short log, 0 without room."""
    if requested is not None:
        return requested
    most = room_for_blocks(dataset, settings)
    return min(most, BLOCKS) if most > 1 else 0


def room_for_blocks(dataset: Dataset, settings: Settings) -> int:
    """Return the number of time blocks for which the logs have rows, margins excluded; of several logs, each is a block at least."""
    return int(np.sum(_capacity(dataset, settings)))


def _capacity(dataset: Dataset, settings: Settings = DEFAULT) -> np.ndarray:
    """Return the number of time blocks for which each log has rows, shape (log,)."""
    rows = np.unique(dataset.log_of_row, return_counts=True)[1]
    return np.maximum(rows // (int(settings.held_out_rows) + 2 * dataset.reach), rows.size > 1)


def time_blocks(dataset: Dataset, count: int) -> tuple[str, list[np.ndarray]]:
    """Return the name of the parts of the logs, and a mask of the rows of each of `count` parts, shape (row,) of bool."""
    rows, capacity = np.unique(dataset.log_of_row, return_counts=True)[1], _capacity(dataset)
    # A part has a block of each log. A log without room for as many blocks has fewer, which the parts take in turn.
    blocks = np.minimum(capacity, count) if np.sum(capacity) >= count else np.full_like(rows, count)
    owners = np.split(np.arange(np.sum(blocks)) % count, np.cumsum(blocks)[:-1])
    edges = [
        np.linspace(0, size, owner.size + 1).astype(int)
        for size, owner in zip(rows, owners, strict=True)
    ]
    of, part = (
        TIME,
        np.concatenate(
            [np.repeat(owner, np.diff(ends)) for owner, ends in zip(owners, edges, strict=True)]
        ),
    )
    pieces = np.clip(rows // (blocks * 2 * LEAST * max(dataset.reach, 1)), 1, 8)  # of each block
    if np.any(pieces > 1):
        speed, moving = np.abs(dataset.velocity), dataset.velocity != 0.0
        place = np.floor(BINS * np.log10(speed[moving])).astype(int)
        place -= place.min(initial=0)
        counts = np.zeros((count, place.max(initial=0) + 1))
        np.add.at(counts, (part[moving], place), 1.0)
        alone = np.where(counts.sum(axis=0) - counts < FEW * counts, counts, 0.0).sum(axis=1)
        # Share of the rows of a block at speeds missing in other blocks.
        if np.any(alone > 0.1 * np.bincount(part, minlength=count)):
            # A part has speeds that the others lack: give each part one piece of each neighbourhood, in random order, so that no
            # periodic motion is in step with it.
            rng = np.random.default_rng(SEED)
            owners = [
                np.concatenate([rng.permutation(owner) for _ in range(n)])
                for owner, n in zip(owners, pieces, strict=True)
            ]
            of = SHORT
            part = np.concatenate(
                [
                    owner[np.arange(size) * owner.size // size]
                    for size, owner in zip(rows, owners, strict=True)
                ]
            )
    return of, [part == number for number in range(count)]


def beside(part: np.ndarray, reach: int) -> np.ndarray:
    """Return a mask of the rows that share no sample with a part through filters of this `reach`."""
    return np.convolve(part, np.ones(2 * reach + 1))[reach : reach + part.size] < 0.5


ROUNDING = 0.37  # of an encoder step: the robust noise estimate for rounding alone
SIGN_BLOCKS = 40  # blocks of a segment in which the unexplained force keeps its sign


class Disturbance(NamedTuple):
    """The size of each cause of a disturbance."""

    scatter: float
    noise: float
    resolution: float
    jitter: float = 0.0
    unexplained: float = 0.0


def disturbance_of(dataset: Dataset, scatter: float) -> Disturbance:
    """Return the disturbances of a log: its encoder, its noise, and a known scatter."""
    # Rounding also looks like noise.
    jitter = max(dataset.noise**2 - (ROUNDING * dataset.resolution) ** 2, 0.0) ** 0.5
    return Disturbance(scatter, dataset.effort_noise, dataset.resolution, jitter)


def signs(count: int, rng: np.random.Generator) -> np.ndarray:
    """Return a random sign for each block of samples, to draw a residual of the same shape."""
    blocks = np.minimum(np.arange(count) * SIGN_BLOCKS // count, SIGN_BLOCKS - 1)
    return rng.choice([-1.0, 1.0], SIGN_BLOCKS)[blocks]


def correlation_time(residual: np.ndarray, row_time: float, unexplained: float) -> float:
    """Return the correlation time of the unexplained force [s], from a residual with the best level for each half-cycle."""
    # Force that does not average out over a block counts as unexplained; times longer than a block are not resolved.
    slow = float(
        np.mean([float(np.mean(part)) ** 2 for part in np.array_split(residual, SIGN_BLOCKS)])
    )
    share = min(slow / unexplained**2, 1.0) if unexplained > 0.0 else 0.0
    return share * row_time * residual.size / SIGN_BLOCKS


def scaled(component: FrictionModel, values: Mapping[str, float], level: float) -> dict[str, float]:
    """Return the values of a model with its forces scaled, except the constant offset."""
    values = dict(values)
    for name, variable in component.variables.items():
        if (
            variable.quantity == "force" and variable.excitation and variable is not OFFSET
        ) or variable == TRANSMITTED:
            values[name] = level * values[name]
    return values


def force_with_scatter(
    friction: Model,
    segment: Segment,
    starts: Sequence[int],  # first samples of half-cycles
    dt: float,
    scatter: float,  # relative standard deviation of the level
    rng: np.random.Generator,
    transmitted: np.ndarray | None = None,
) -> np.ndarray:
    """Return unfiltered friction [N or N*m] with a random relative level after each reversal, shape (sample,)."""
    # Of the level: friction does not vanish on any half-cycle.
    levels = np.maximum(1.0 + scatter * rng.standard_normal(len(starts)), 0.05)
    mean = pack(friction.parameters)
    component = friction.component
    doubled = pack(
        component.assemble(scaled(component, numbers_of(component, friction.parameters), 2.0))
    )
    # A parameter may be infinite; the difference is defined only for forces.
    rise = np.subtract(doubled, mean, out=np.zeros_like(mean), where=doubled != mean)
    first = segment.first_cycle
    turns = [0, *(first + start for start in starts[1:])]
    parameters = mean + (levels[:, None] - 1.0) * rise
    return in_turns(friction, parameters, dt=dt, starts=turns, **segment.signals(dt, transmitted))[
        first:
    ]


FINER = 5  # steps of a sample
ABOVE = 4.0  # standard deviations of the noise
FLOOR = 0.4  # of the sampling frequency: above, the position is not filtered, and the noise is estimated


class Recovered(NamedTuple):
    """A segment along the unfiltered motion, and the visibility of its corners, shape (sample,), 0 to 1."""

    segment: Segment
    visible: np.ndarray


def noise_density(position: np.ndarray, resolution: float, dt: float) -> float:
    """Return the spectral density of the noise of a position [m^2/Hz or rad^2/Hz], at least that of rounding."""
    from scipy.signal import welch

    bent = np.diff(position, 2)
    # Samples
    frequencies, density = welch(bent, fs=1.0 / dt, nperseg=min(512, bent.size), detrend="constant")
    top = frequencies >= FLOOR / dt
    of_second_difference = (2.0 * np.sin(np.pi * frequencies[top] * dt)) ** 4
    return max(
        float(np.median(density[top] / of_second_difference)), 2.0 * dt * resolution**2 / 12.0
    )


def recovered(segment: Segment, dataset: Dataset) -> Recovered:
    """Return a segment along the unfiltered motion, as far as noise permits."""
    from scipy.ndimage import maximum_filter1d, uniform_filter1d

    dt, origin, cutoff = dataset.sample_time, segment.position[0], dataset.cutoff
    raw, smooth = segment.recorded - origin, segment.position - origin
    density = noise_density(raw, dataset.resolution, dt)
    position, below, visible = smooth, low_passed(raw, cutoff, dt), np.zeros(0)
    while below is not raw:
        wide = 2.0 * cutoff
        above = raw if wide >= FLOOR / dt else low_passed(raw, wide, dt)
        noise = (density * (min(wide, 0.5 / dt) - cutoff)) ** 0.5
        # 1 within reach of a visible deviation, less around it.
        stands_out, reach = (
            np.abs(above - below) > ABOVE * noise,
            max(round(0.5 / (dataset.cutoff * dt)), 1),
        )
        share = uniform_filter1d(
            maximum_filter1d(stands_out.astype(float), 4 * reach + 1), 2 * reach + 1
        )
        position = position + share * (above - below)
        visible = share if not visible.size else visible
        cutoff, below = wide, above
    position = position + (1.0 - visible) * (smooth - low_passed(smooth, dataset.cutoff, dt))
    velocity = derivative(position, dt)
    at_rest = segment.velocity == 0.0
    moved = replace(
        segment,
        position=position + origin,
        velocity=np.where(at_rest, segment.velocity, velocity),
        acceleration=derivative(velocity, dt),
    )
    return Recovered(moved, visible)


def between_samples(segment: Segment, dt: float) -> Segment:
    """Return a segment on a grid with `FINER` points per sample; velocities are means over the step around a point."""
    from scipy.interpolate import CubicSpline

    h, origin = dt / FINER, segment.position[0]
    count = (segment.position.size - 1) * FINER + 1
    along = CubicSpline(dt * np.arange(segment.position.size), segment.position - origin)
    edges = along(h * (np.arange(count + 1) - 0.5))
    at_rest = np.repeat(segment.velocity, FINER)[:count] == 0.0
    signed = np.repeat(segment.velocity, FINER)[:count]
    samples, points = np.arange(segment.position.size), np.arange(count) / FINER

    def fine(signal: np.ndarray) -> np.ndarray:
        return np.interp(points, samples, signal)

    return replace(
        segment,
        time=fine(segment.time),
        position=0.5 * (edges[1:] + edges[:-1]) + origin,
        velocity=np.where(at_rest, signed, np.diff(edges) / h),
        acceleration=fine(segment.acceleration),
        effort=fine(segment.effort),
        recorded=fine(segment.recorded),
        first_cycle=segment.first_cycle * FINER,
        surroundings={name: fine(values) for name, values in segment.surroundings.items()},
        regressors=tuple(fine(column) for column in segment.regressors),
    )
