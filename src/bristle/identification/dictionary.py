r"""The dictionary of a motion axis: forces that a log may show, each a column that a weight multiplies.

.. math:: u(t + \tau) = M a + o + p(x) + \sum_i w_i e_i + \sum_j r_j \rho_j(v) + \sum_k c_k \hat f \mu_k
    + b \ddot{\hat y}, \qquad w_i, r_j \ge 0

- :math:`e_i`, over its threshold :math:`d`: a stop [1]_ :math:`s \leftarrow \mathrm{clip}(s + \Delta x / d, \pm\gamma)`, or
  a Dahl element [2]_ :math:`z \leftarrow \pm\gamma + (z \mp \gamma) e^{-|\Delta x| / (d \gamma)}`. Its limit falls with the
  speed, :math:`\gamma(v) = c + (1 - c) e^{-(v / v_S)^2}`.
- :math:`\rho_j`: rising curves of the speed, separate for each direction.
- :math:`p(x)`: a spring, the gravity of a link, a cubic spring, or a free curve; and ripples
  :math:`\cos 2 \pi f x, \sin 2 \pi f x`.
- :math:`\mu_k`: relative changes of the level of friction over position, load or time. They multiply the friction
  :math:`\hat f` of an earlier fit.
- :math:`\ddot{\hat y}`: second derivative of the fitted effort, for unequal filters of effort and position.

Elements and curves with non-negative weights gain no energy over any closed cycle. Each column passes the same low-pass
filter as the effort and is then decimated to rows.

.. [1] M. Brokate, J. Sprekels: Hysteresis and Phase Transitions. Springer, 1996, chapter 2.
.. [2] P. R. Dahl: A solid friction model. Aerospace Corporation, 1968. https://doi.org/10.21236/ADA041920
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bristle.core.kernel import kernel
from bristle.core.lazy import cached_property
from bristle.engine.compilation import compiled
from bristle.engine.signature import Vector

Elements = Callable[[Vector, Vector, float, float, Vector], float]
"""Position, limit, threshold, initial state and output of an element."""
Filter = Callable[[Vector, Vector, int, int, Vector], float]
"""Signal, taps, sample of the first row, samples per row and rows of a filter."""

PER_DECADE = 3  # thresholds
SHORTEST = 1e-6  # of the stroke: the least threshold
NARROW = 3e-3  # of the stroke: longer thresholds are a group, the cable
WIDEST = 0.1  # of the stroke: a stop with a longer threshold is nearly a spring
WIDE_COUNT = 5  # thresholds of the cable
NOISES = 3.0  # standard deviations of the noise of the position: the least threshold
STRIBECK = (0.004, 0.5, 6)  # of the top speed: least and largest Stribeck speed, and their number
LASTING = 0.65  # share of a Dahl limit that does not fall with the speed
RAMPS = np.array([0.0, 0.02, 0.05, 0.1, 0.2, 0.35, 0.6, 1.0])  # of the top speed: ends of the ramps
HATS = 10  # nodes of a free curve over the position
TOP = 0.995  # quantile of the speed that counts as the top speed
LEAST_TOP = 0.05  # of the largest speed: the top speed of an axis that mostly rests
AT_REST = 0.02  # of the top speed
BEGINNING = 0.05  # [s] at the start of a stretch, in which an axis at rest does not move
SETTLED = 4.0  # longest narrow thresholds: range after which no element remembers its start
TAIL = 40.0  # exponent of a limit above which the fallen part is zero
RIDGE = 1e-3  # of the penalty of a curve on the curve, the rest is on its bends
RIDGE_OF_RAMPS = 1e-2


# ---------------------------------------------------------------- compiled loops
@kernel(portable=False)
def stop(s, dx, d, limit):
    """Return the next state of a stop."""
    return min(max(s + dx / d, -limit), limit)


@kernel(portable=False)
def dahl(z, dx, d, limit):
    """Return the next state of a Dahl element."""
    end = limit if dx > 0.0 else -limit
    if dx == 0.0:
        return z
    return end + (z - end) * math.exp(-abs(dx) / (d * limit)) if limit > 1e-9 else end


def stop_entry(x, limit, d, start, out):
    """Write the states of a stop along positions."""
    out[0] = start
    for i in range(1, x.size):
        out[i] = stop(out[i - 1], x[i] - x[i - 1], d, limit[i])
    return 0.0


def dahl_entry(x, limit, d, start, out):
    """Write the states of a Dahl element along positions."""
    out[0] = start
    for i in range(1, x.size):
        out[i] = dahl(out[i - 1], x[i] - x[i - 1], d, limit[i])
    return 0.0


def filter_entry(signal, taps, first, step, rows):
    """Write every `step`-th value of a signal after a filter."""
    for k in range(rows.size):
        at = first + k * step - taps.size // 2
        total = 0.0
        for i in range(taps.size):
            total += taps[i] * signal[at + i]
        rows[k] = total
    return 0.0


def low_pass_taps(cutoff: float, dt: float, ahead: float = 0.0, width: float = 0.4) -> np.ndarray:
    """Return the taps of a low-pass filter with a Kaiser window: cut-off [Hz], `ahead` by a part of a sample."""
    stop_band = 50.0  # [dB]
    count = math.ceil((stop_band - 8.0) / (2.285 * 2.0 * np.pi * width * cutoff * dt)) | 1
    k = np.arange(count) - count // 2 - ahead
    window = np.sqrt(np.maximum(1.0 - (2.0 * k / (count + 1)) ** 2, 0.0))
    taps = np.sinc(2.0 * cutoff * dt * k) * np.i0(0.1102 * (stop_band - 8.7) * window)
    return taps / taps.sum()


def filtered(signal: np.ndarray, taps: np.ndarray, first: int, step: int, count: int) -> np.ndarray:
    """Return `count` values of a signal after a filter, the first at the sample `first`, then every `step` samples."""
    rows = np.empty(count)
    if not count:
        return rows
    reach = taps.size // 2
    if first < reach or first + (count - 1) * step + reach >= signal.size:
        raise IndexError("a filter reaches beyond its signal")
    entry = compiled("dictionary_filter", lambda: filter_entry, Filter)
    entry(np.ascontiguousarray(signal, dtype=float), taps, first, step, rows)
    return rows


# ---------------------------------------------------------------- motion
@dataclass(frozen=True, eq=False)
class Motion:
    """Stretches of logs at the work rate, one after the other, and the filter from there to rows.

    Arrays have the shape (sample,): `time` [s], position `x`, velocity `v` and acceleration `a` [SI], effort `u` [N or N*m].
    """

    time: np.ndarray
    x: np.ndarray
    v: np.ndarray
    a: np.ndarray
    u: np.ndarray
    stretches: tuple[slice, ...]
    dt: float  # [s] of the work rate
    cutoff: float  # [Hz] of the rows
    noise: float  # of the position [m or rad], with the step of the encoder
    is_rotary: bool
    taps: np.ndarray
    step: int  # samples per row
    margin: int  # samples of a stretch before its first row, at least
    unsettled: tuple[
        int, ...
    ]  # samples of each stretch that depend on the unknown start of its friction
    logs: tuple[slice, ...] = ()  # samples of each of several logs
    # Columns of the log that a coefficient turns into an effort, shape (column, sample).
    regressors: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    # Recorded quantities on which friction may depend.
    channels: Mapping[str, np.ndarray] = field(default_factory=dict)

    @cached_property
    def firsts(self) -> tuple[int, ...]:
        """First row of each stretch, as a sample of it."""
        return tuple(self.margin + count for count in self.unsettled)

    @cached_property
    def counts(self) -> tuple[int, ...]:
        """Rows of each stretch."""
        pairs = zip(self.stretches, self.firsts, strict=True)
        lengths = [part.stop - part.start - first - self.margin for part, first in pairs]
        return tuple(max(length // self.step, 0) for length in lengths)

    @cached_property
    def places(self) -> np.ndarray:
        """Sample of each row, shape (row,)."""
        triples = zip(self.stretches, self.firsts, self.counts, strict=True)
        parts = [
            part.start + first + self.step * np.arange(count) for part, first, count in triples
        ]
        return np.concatenate(parts)

    @cached_property
    def span(self) -> float:
        """Duration of the longest log [s]."""
        return max(float(np.ptp(self.time[part])) for part in self.logs)

    def row(self, signal: np.ndarray, ahead: float = 0.0) -> np.ndarray:
        """Return the rows of a signal, shape (row,), ahead by some seconds."""
        shift = round(ahead / self.dt)
        taps = self.taps
        if ahead:
            taps = low_pass_taps(self.cutoff, self.dt, ahead / self.dt - shift)
        triples = zip(self.stretches, self.firsts, self.counts, strict=True)
        parts = [
            filtered(signal[part], taps, first + shift, self.step, count)
            for part, first, count in triples
        ]
        return np.concatenate(parts)

    def rows(self, signals: np.ndarray) -> np.ndarray:
        """Return the rows of several signals, shape (row, signal), from the shape (signal, sample)."""
        return np.stack([self.row(signal) for signal in signals], axis=1)

    def smooth(self, signal: np.ndarray) -> np.ndarray:
        """Return a signal after the filter of the rows, along each stretch, shape (sample,)."""
        from scipy.ndimage import convolve1d  # only when needed

        parts = [convolve1d(signal[part], self.taps, mode="nearest") for part in self.stretches]
        return np.concatenate(parts)

    def rate(self, signal: np.ndarray) -> np.ndarray:
        """Return the derivative of a signal along each stretch, shape (sample,)."""
        return np.concatenate([np.gradient(signal[part], self.dt) for part in self.stretches])


@dataclass(frozen=True)
class Grid:
    """Nodes of the dictionary, from the stroke, the noise and the speed of a motion."""

    low: float  # [m or rad]
    high: float
    narrow: np.ndarray  # thresholds [m or rad]
    wide: np.ndarray
    V: float  # top speed [m/s or rad/s]
    starts: tuple[float, ...]  # state of the elements before each stretch, from -1 to 1

    @property
    def stroke(self) -> float:
        """Range of the position [m or rad]."""
        return self.high - self.low

    @property
    def v_S(self) -> np.ndarray:
        """Stribeck speeds [m/s or rad/s]."""
        return self.V * np.geomspace(*STRIBECK)

    @property
    def coarse(self) -> np.ndarray:
        """Thresholds of falling and of Dahl elements [m or rad]."""
        return self.narrow[::2]

    def centred(self, x: np.ndarray) -> np.ndarray:
        """Return positions, -1 and 1 at the ends of the stroke."""
        return (2.0 * x - self.low - self.high) / self.stroke


def grid_of(motion: Motion) -> Grid:
    """Return the nodes of the dictionary for a motion."""
    low = float(motion.x.min())
    high = float(motion.x.max())
    stroke = high - low
    least = max(NOISES * motion.noise, SHORTEST * stroke)
    most = max(NARROW * stroke, 10.0 * least)
    count = max(round(PER_DECADE * math.log10(most / least)) + 1, 3)
    wide = np.zeros(0)
    if 2.0 * most < WIDEST * stroke:
        wide = np.geomspace(1.8 * most, WIDEST * stroke, WIDE_COUNT)
    speed = np.abs(motion.v)
    V = max(float(np.quantile(speed, TOP)), LEAST_TOP * float(speed.max()))
    grid = Grid(low, high, np.geomspace(least, most, count), wide, V, ())
    starts = tuple(start_of(motion, grid, part) for part in motion.stretches)
    return Grid(low, high, grid.narrow, wide, V, starts)


def start_of(motion: Motion, grid: Grid, part: slice) -> float:
    """Return the state of all elements before a stretch, 0 at rest, else the direction of its first motion."""
    x = motion.x[part]
    beginning = np.abs(motion.v[part][: max(int(BEGINNING / motion.dt), 3)])
    far = np.flatnonzero(np.abs(x - x[0]) > grid.narrow[0])
    if beginning.max() < AT_REST * grid.V or not far.size:
        return 0.0
    return float(np.sign(x[far[0]] - x[0]))


def unsettled(motion: Motion) -> tuple[int, ...]:
    """Return the samples of each stretch before its range is so large that no narrow element remembers its start."""
    needed = SETTLED * float(grid_of(motion).narrow[-1])
    counts = list[int]()
    for part in motion.stretches:
        x = motion.x[part]
        covered = np.maximum.accumulate(x) - np.minimum.accumulate(x)
        counts.append(int(np.searchsorted(covered, needed)))
    return tuple(counts)


# ---------------------------------------------------------------- elements with memory
class Element(NamedTuple):
    """A stop or Dahl element: its threshold, and the limit c + (1 - c) exp(-(v / v_S)^2)."""

    is_dahl: bool
    d: float  # [m or rad]
    v_S: float  # [m/s or rad/s]; infinite for a constant limit
    c: float

    def limit(self, v: np.ndarray) -> np.ndarray:
        """Return the limit at some speeds."""
        if math.isinf(self.v_S):
            return np.ones_like(v)
        exponent = np.square(v / self.v_S)
        fallen = np.where(exponent < TAIL, np.exp(-np.minimum(exponent, TAIL)), 0.0)
        return self.c + (1.0 - self.c) * fallen

    def after_reversal(self, travel: np.ndarray) -> np.ndarray:
        """Return the output along a slow travel [m or rad] after a reversal."""
        if self.is_dahl:
            return 1.0 - 2.0 * np.exp(-travel / self.d)
        return np.minimum(travel / self.d - 1.0, 1.0)


def elements(
    *, is_dahl: bool, d: np.ndarray, v_S: Iterable[float] = (math.inf,), c: float = 0.0
) -> list[Element]:
    """Return an element for each threshold and Stribeck speed."""
    thresholds = d.tolist()
    return [
        Element(is_dahl, threshold, float(speed), c) for speed in v_S for threshold in thresholds
    ]


def memory_of(grid: Grid) -> dict[str, list[Element]]:
    """Return all elements by group."""
    inner = grid.v_S[1:5]
    fall_dahl = elements(is_dahl=True, d=grid.coarse, v_S=inner)
    part_dahl = elements(is_dahl=True, d=grid.coarse, v_S=inner, c=LASTING)
    return {
        "stop": elements(is_dahl=False, d=grid.narrow),
        "fall": elements(is_dahl=False, d=grid.coarse, v_S=grid.v_S),
        "dahl": elements(is_dahl=True, d=grid.coarse),
        "fall_dahl": fall_dahl + part_dahl,
        "cable": elements(is_dahl=False, d=grid.wide),
    }


def outputs(motion: Motion, grid: Grid, members: Sequence[Element]) -> Iterator[np.ndarray]:
    """Yield the output of each element along a motion, shape (sample,), each time in the same array."""
    entries = {
        False: compiled("dictionary_stop", lambda: stop_entry, Elements),
        True: compiled("dictionary_dahl", lambda: dahl_entry, Elements),
    }
    out = np.empty(motion.x.size)
    limit = np.empty(0)
    last = (math.nan, math.nan)
    for element in members:
        if (element.v_S, element.c) != last:
            limit = element.limit(motion.v)
            last = (element.v_S, element.c)
        for part, start in zip(motion.stretches, grid.starts, strict=True):
            entries[element.is_dahl](motion.x[part], limit[part], element.d, start, out[part])
        yield out


def memory_rows(motion: Motion, grid: Grid, members: Sequence[Element]) -> np.ndarray:
    """Return the rows of elements, shape (row, element)."""
    rows = [motion.row(out) for out in outputs(motion, grid, members)]
    return np.stack(rows, axis=1)


def memory_force(
    motion: Motion, grid: Grid, members: Sequence[Element], weights: np.ndarray
) -> np.ndarray:
    """Return the sum of weighted elements along a motion, shape (sample,) [N or N*m]."""
    active = np.flatnonzero(weights).tolist()
    total = np.zeros(motion.x.size)
    signals = outputs(motion, grid, [members[i] for i in active])
    for weight, out in zip(weights[active], signals, strict=True):
        total += weight * out
    return total


# ---------------------------------------------------------------- curves over speed and position
def ramps(v: np.ndarray, V: float) -> np.ndarray:
    """Return rising curves of the speed, first of forward, then of backward motion, shape (ramp, sample)."""
    speed = np.abs(v)
    ends = [*(V * RAMPS[:-1]), math.inf]
    rises = [np.clip(speed - low, 0.0, high - low) for low, high in pairwise(ends)]
    stacked = np.stack(rises)
    return np.concatenate([stacked * (v > 0.0), -stacked * (v < 0.0)])


def line_of_ramps(v: np.ndarray, weights: np.ndarray, V: float) -> np.ndarray:
    """Return the line that rising curves approach at high speed, through zero, which is viscous friction, shape (sample,)."""
    ends = weights @ ramps(np.array([-V, -0.5 * V, 0.5 * V, V]), V)
    slopes = np.diff(ends)[[0, 2]] / (0.5 * V)
    slopes = np.minimum(slopes, np.abs(ends[[0, 3]]) / V)
    return v * np.where(v < 0.0, *slopes)


def spring(x: np.ndarray, grid: Grid) -> np.ndarray:
    """Return the column of a linear spring, shape (1, sample)."""
    return grid.centred(x)[None]


def gravity(x: np.ndarray, grid: Grid) -> np.ndarray:
    """Return the columns of the gravity of a link, shape (2, sample)."""
    return np.stack([np.sin(x), np.cos(x)])


def cubic(x: np.ndarray, grid: Grid) -> np.ndarray:
    """Return the columns of a cubic spring, shape (3, sample)."""
    z = grid.centred(x)
    return np.stack([z, z**2, z**3])


def curve(x: np.ndarray, grid: Grid) -> np.ndarray:
    """Return the columns of a free curve, shape (node, sample)."""
    nodes = np.linspace(grid.low, grid.high, HATS)
    return np.stack([np.interp(x, nodes, row) for row in np.eye(HATS)])


SHAPES: dict[str, Callable[[np.ndarray, Grid], np.ndarray]] = {
    "spring": spring,
    "gravity": gravity,
    "cubic": cubic,
    "curve": curve,
}
"""Forces over the position, the simplest first."""


def ripple(x: np.ndarray, frequency: float) -> np.ndarray:
    """Return cosine and sine of a wave over the position, shape (2, sample); frequency in 1/m or 1/rad."""
    phase = 2.0 * np.pi * frequency * x
    return np.stack([np.cos(phase), np.sin(phase)])


# ---------------------------------------------------------------- relative changes of the level of friction
def along_axis(x: np.ndarray, grid: Grid) -> np.ndarray:
    """Return Legendre polynomials of the position, of degree 1 to 4 without factors, shape (4, sample)."""
    z = grid.centred(x)
    return np.stack([z, z**2 - 1.0 / 3.0, z**3 - 0.6 * z, z**4 - 6.0 / 7.0 * z**2 + 3.0 / 35.0])


def with_load(transmitted: np.ndarray) -> np.ndarray:
    """Return the magnitude of the transmitted force, with mean 0 and standard deviation 1, shape (1, sample)."""
    return with_channel(np.abs(transmitted))


def with_channel(signal: np.ndarray) -> np.ndarray:
    """Return a recorded channel with mean 0 and standard deviation 1, shape (1, sample)."""
    return ((signal - signal.mean()) / max(float(signal.std()), np.finfo(float).tiny))[None]


def over_time(time: np.ndarray, span: float) -> np.ndarray:
    """Return a slope, a fast and a slow saturation over the time of a log, each with mean 0, shape (3, sample)."""
    t = (time - time[0]) / span
    changes = np.stack([t, 1.0 - np.exp(-8.0 * t), 1.0 - np.exp(-3.0 * t)])
    return changes - changes.mean(axis=1, keepdims=True)


def warm_up(motion: Motion) -> np.ndarray:
    """Return the changes over time along a motion, alike in each of its logs, shape (3, sample)."""
    parts = [over_time(motion.time[part], motion.span) for part in motion.logs]
    return np.concatenate(parts, axis=1)


# ---------------------------------------------------------------- groups of columns
def smooth(count: int, order: int, ridge: float) -> np.ndarray:
    """Return the penalty on the bends of a curve, shape (count, count)."""
    D = np.diff(np.eye(count), order, axis=0)
    return D.T @ D + ridge * np.eye(count)


@dataclass(frozen=True, eq=False)
class Group:
    """Columns with a common penalty.

    `force` gives the sum of the weighted columns along the motion, shape (sample,) [N or N*m].
    """

    name: str
    role: str  # inertia, offset, friction, place, level or filter
    columns: np.ndarray  # shape (row, column)
    force: Callable[[np.ndarray], np.ndarray]
    penalty: np.ndarray | None = None  # shape (column, column); None without a penalty
    is_positive: bool = False  # weights are >= 0
    is_judged: bool = False  # a term that the log may not show
    is_curve: bool = False  # columns that keep their relative sizes
    frequency: float = 0.0  # of a ripple [1/m or 1/rad]


def of_signals(motion: Motion, name: str, role: str, signals: np.ndarray, **options) -> Group:
    """Return a group of signals, shape (column, sample)."""
    return Group(name, role, motion.rows(signals), lambda weights: weights @ signals, **options)


def plant_groups(motion: Motion) -> list[Group]:
    """Return the inertia, the constant force, and the forces of known columns."""
    constant = np.ones((1, motion.x.size))
    groups = [
        of_signals(motion, "inertia", "inertia", motion.a[None], is_positive=True),
        of_signals(motion, "offset", "offset", constant),
    ]
    if len(motion.regressors):
        groups.append(of_signals(motion, "known", "offset", motion.regressors))
    return groups


def friction_groups(motion: Motion, grid: Grid) -> list[Group]:
    """Return elements with memory and rising curves; all weights are >= 0."""
    groups = list[Group]()
    for name, members in memory_of(grid).items():
        if members:
            groups.append(memory_group(motion, grid, name, members))
    groups.append(of_signals(motion, "viscous", "friction", motion.v[None], is_positive=True))
    penalty = np.kron(np.eye(2), smooth(RAMPS.size - 1, 1, RIDGE_OF_RAMPS))
    signals = ramps(motion.v, grid.V)
    options = {"penalty": penalty, "is_positive": True, "is_curve": True}
    groups.append(of_signals(motion, "ramps", "friction", signals, **options))
    return groups


def memory_group(
    motion: Motion, grid: Grid, name: str, members: Sequence[Element], *, is_fixed: bool = False
) -> Group:
    """Return a group of elements, without a penalty if it `is_fixed`."""
    return Group(
        name,
        "friction",
        memory_rows(motion, grid, members),
        partial(memory_force, motion, grid, members),
        penalty=None if is_fixed else np.eye(len(members)),
        is_positive=True,
        is_judged=name == "cable" and not is_fixed,
    )


def place_groups(motion: Motion, grid: Grid) -> dict[str, Group]:
    """Return the possible forces over the position, the simplest first."""
    groups = dict[str, Group]()
    for name, columns in SHAPES.items():
        if name == "gravity" and not motion.is_rotary:
            continue
        penalty = smooth(HATS, 2, RIDGE) if name == "curve" else None
        signals = columns(motion.x, grid)
        is_curve = name == "curve"
        groups[name] = of_signals(
            motion, name, "place", signals, penalty=penalty, is_curve=is_curve
        )
    return groups


def ripple_group(motion: Motion, frequency: float) -> Group:
    """Return a wave of the force over the position."""
    options = {"penalty": np.eye(2), "is_judged": True, "frequency": frequency}
    signals = ripple(motion.x, frequency)
    return of_signals(motion, f"ripple {frequency:.8g}", "place", signals, **options)


def scale_group(motion: Motion, frequency: float) -> Group:
    """Return the inertial force of a wave in the position error of the encoder."""
    wave = ripple(motion.x, frequency)
    bends = np.stack([motion.rate(motion.rate(row)) for row in wave])
    options = {"penalty": np.eye(2), "frequency": frequency}
    return of_signals(motion, f"scale {frequency:.8g}", "filter", bends, **options)


class Level(NamedTuple):
    """Forces of an earlier fit to which changes of the level are relative, shape (sample,) [N or N*m]."""

    friction: np.ndarray
    dry: np.ndarray  # friction without the part that rises with the speed
    transmitted: np.ndarray  # the load: the inertial force and the force over the position


def level_groups(
    motion: Motion, grid: Grid, signals: Level, frequencies: Sequence[float]
) -> list[Group]:
    """Return changes of the level, of first order about the friction of an earlier fit."""
    friction = signals.friction
    changes = {
        "level": (friction, along_axis(motion.x, grid), np.diag([1.0, 4.0, 9.0, 16.0])),
        "load": (signals.dry, with_load(signals.transmitted), np.eye(1)),
        "warmup": (friction, warm_up(motion), np.eye(3)),
    }
    for name, signal in motion.channels.items():
        changes[f"channel {name}"] = (friction, with_channel(signal), np.eye(1))
    groups = list[Group]()
    for frequency in frequencies:
        columns = friction * ripple(motion.x, frequency)
        options = {"penalty": np.eye(2), "is_judged": True, "frequency": frequency}
        name = f"level ripple {frequency:.8g}"
        groups.append(of_signals(motion, name, "level", columns, **options))
    for name, (force, factors, penalty) in changes.items():
        options = {"penalty": penalty, "is_judged": True, "is_curve": len(factors) > 1}
        groups.append(of_signals(motion, name, "level", force * factors, **options))
    return groups


def filter_group(motion: Motion, effort: np.ndarray) -> Group:
    """Return the second derivative of the fitted effort, shape (sample,) [N or N*m]."""
    bend = motion.rate(motion.rate(effort))
    return of_signals(motion, "filter", "filter", bend[None], is_judged=True)
