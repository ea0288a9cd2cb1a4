"""The wide rows of a log, with sharp reversals of friction, and their fits by `bristle.identification.first_stage`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.core.least_squares import apart_from, left_out, normal
from bristle.core.tangent import DIRECTIONS
from bristle.engine.filtered_rows import filtered_every
from bristle.identification.dataset import Segment
from bristle.identification.preprocessing import segment_of, step_of
from bristle.logs.filters import at_spline, butterworth, derivative, low_passed, through_filter
from bristle.logs.log import Log
from bristle.logs.waves import frequency_in, waves
from bristle.models.plants.terms import SPRINGS

# Sampling frequency over the cut-off of the wide rows, the widest first.
WIDTHS = (5.0, 10.0, 20.0, 40.0)
WIDEST = 250.0  # Hz
SPEED_NOISE = 0.025  # of the top speed: noise of the speed in wide rows
TOP = 0.995  # quantile of the speeds that defines the top speed
SLOW, FAST = 0.05, 0.15  # of the top speed: slower rows are omitted, faster rows have full weight
EDGE = 0.5  # s at the ends of a stretch
FINE = 0.25  # periods of the wide cut-off from row to row
SPEEDS = (0.03, 0.1, 0.3)  # of the top speed: scales of nonlinear friction
# Search range of a delay in samples or s; step [s]
REACH, REACH_TIME, REACH_STEP = (12.0, 8e-3, 0.4e-3)
ROUGH = 25.0  # Hz: cut-off of the rough search
STEPS = 8
# Of the narrow cut-off; Hz: above, noise dominates the slope of the acceleration.
CALM, CALMEST = (2.0, 60.0)
CLOSE, CLOSE_FILTER = 0.02, 3e-8  # samples, s^2: converged steps
BLOCKS = 20  # of the jackknife
FILTER = 2e-6  # s^2: c of a filter of 2 ms, the prior of an undocumented filter
WAVES, WAVE_SHARE = 2, 0.05  # over the position: largest number, share of the residual
TURNS, MOST_TURNS = 3.0, 1024.0  # turns over the range
FEWEST = 400  # rows
SINGULAR = 1e-9  # for normal equations with a unit diagonal


@dataclass
class _Stretch:
    """A stretch of the log on the wide rows: position, side of motion, regressor (column, row), weight, effort at a delay [s]."""

    position: np.ndarray
    side: np.ndarray
    columns: np.ndarray
    weight: np.ndarray

    effort_at: Callable[[float], np.ndarray]


class InstrumentFit(NamedTuple):
    """Inertia first of `theta`, delay [s] and filter [s^2] at one cut-off, with their covariance in this order."""

    cutoff: float
    theta: np.ndarray
    delay: float
    c: float
    covariance: np.ndarray
    bias: float
    converged: bool
    parts: np.ndarray = np.empty(0)  # of the inertia, without each block of time in turn

    def std(self, place: int) -> float:
        """Return the standard error at a place of the covariance."""
        return float(self.covariance[place, place]) ** 0.5

    def below(self, other: InstrumentFit, errors: float, least: float) -> float:
        """Return the relative decrease of the inertia from the other fit; 0 if within `errors` standard errors or the `least` share."""
        # The common random error of both fits, by blocks of time, cancels in their difference (Durbin, Wu, Hausman).
        apart, change = other.parts - self.parts, float(other.theta[0] - self.theta[0])
        surely = change > errors * ((BLOCKS - 1) / BLOCKS * float(apart @ apart)) ** 0.5
        return (
            change / float(other.theta[0])
            if surely and change > least * float(other.theta[0])
            else 0.0
        )

    def doubted(self, scale: float) -> InstrumentFit:
        """Return the same fit with errors multiplied by `scale`."""
        return self._replace(covariance=scale**2 * self.covariance)


@dataclass
class WideRows:
    """The rows of all stretches, with the regressor after each requested narrow filter."""

    stretches: list[_Stretch]
    width: float  # Hz
    step: float  # s from row to row
    dt: float
    noise: float  # of the position, sample by sample
    narrow: dict[float, np.ndarray] = field(default_factory=dict)
    passed: tuple[float, list[np.ndarray]] | None = None  # filter [s^2], and the columns after it
    calm: tuple[tuple[float, float], list[np.ndarray]] | None = (
        None  # cut-off and filter, and the acceleration after both
    )

    def suffice(self) -> bool:
        """Return whether there are enough rows; drop columns without rows, as in a log in one direction."""
        if not self.stretches:
            return False
        weight, largest = self._together("weight"), list[list[tuple[float, float]]]()
        for stretch in self.stretches:  # column by column, to save memory
            largest.append(
                [
                    (float(np.abs(stretch.weight * column).max()), float(np.abs(column).max()))
                    for column in stretch.columns
                ]
            )
        weighed, plain = np.moveaxis(np.max(largest, axis=0), -1, 0)
        present = weighed > 1e-6 * plain
        for stretch in self.stretches:
            stretch.columns = stretch.columns[present]
        return bool(present[0] and np.count_nonzero(weight > 0.5) >= FEWEST)

    def _signals(self, name: str) -> list[np.ndarray]:
        return list(map(attrgetter(name), self.stretches))

    def _together(self, name: str) -> np.ndarray:
        """Return a signal of all stretches, concatenated."""
        return np.concatenate(self._signals(name), axis=-1)

    def behind(self, cutoff: float, signals: Sequence[np.ndarray]) -> np.ndarray:
        """Return weighted signals after the narrow filter, shape (signal, sample), all stretches concatenated."""
        stride, narrow = max(int(0.2 / (cutoff * self.step)), 1), butterworth(cutoff, self.step)
        return np.hstack(
            [
                filtered_every(stride, s.weight * x, *narrow)
                for s, x in zip(self.stretches, signals, strict=True)
            ]
        )

    def regressor(self, cutoff: float) -> np.ndarray:
        """Return the weighted columns after the narrow filter, shape (column, row)."""
        if cutoff not in self.narrow:
            self.narrow[cutoff] = self.behind(cutoff, self._signals("columns"))
        return self.narrow[cutoff]

    def springiness(self, cutoff: float) -> float:
        """Return the absolute correlation of acceleration and position; 1 for a single sine."""
        constant = self.behind(cutoff, [np.ones((1, s.weight.size)) for s in self.stretches])[0]
        both = self.regressor(cutoff)[:2]
        both = both - np.outer(both @ constant, constant) / max(
            float(constant @ constant), np.finfo(float).tiny
        )
        lengths = float(np.prod(np.sum(both**2, axis=1)))
        return abs(float(both[0] @ both[1])) / lengths**0.5 if lengths > 0.0 else 0.0

    def scanned(self) -> float:
        """Return a rough delay: that with the smallest residual."""
        cutoff = min(ROUGH, self.width)
        basis = np.linalg.qr(self.regressor(cutoff).T)[0]
        reach = max(REACH * self.dt, REACH_TIME)
        delays, left = np.arange(-reach, reach, max(0.5 * self.dt, REACH_STEP)), list[np.ndarray]()
        for some in np.array_split(delays, -(-delays.size // DIRECTIONS)):
            efforts = self.behind(cutoff, self._efforts(*some))
            left.append(np.sum((efforts - efforts @ basis @ basis.T) ** 2, axis=1))
        return float(delays[np.argmin(np.concatenate(left))])

    def fit(
        self,
        cutoff: float,
        delay: float,
        c: float = 0.0,
        *,
        free: tuple[bool, bool],
        steps: int = STEPS,
    ) -> InstrumentFit:
        """Return the fit at one cut-off after at most `steps` steps; `free` are delay and filter."""
        rows, target = self._weighed(cutoff, delay, c)
        theta = normal(rows @ rows.T, rows @ target, rcond=SINGULAR)
        for step in range(steps):
            # Derivatives by delay and filter, if free.
            columns = self._filtered(c)
            slopes = list[np.ndarray]()
            for x, calm in zip(columns, self._calm(cutoff, c), strict=True):
                effort = theta @ x
                late = (
                    [-derivative(effort + theta[0] * (calm - x[0]), self.step)] if free[0] else []
                )
                bent = [derivative(derivative(effort, self.step), self.step)] if free[1] else []
                slopes.append(np.reshape(late + bent, (-1, effort.size)))
            equations = np.vstack([rows, self.behind(cutoff, slopes)])
            full = normal(equations @ equations.T, equations @ target, rcond=SINGULAR)
            theta = full[: rows.shape[0]]
            moved, further = (
                float(full[theta.size]) if free[0] else 0.0,
                float(full[-1]) if free[1] else 0.0,
            )
            converged = abs(moved) < CLOSE * self.dt and abs(further) < CLOSE_FILTER
            if converged or step == steps - 1:
                # Bias of the inertia by white position noise.
                first = np.zeros(equations.shape[0])
                first[0] = 1.0
                weight = self._together("weight")
                noise = (
                    0.4
                    * self.dt
                    * self.noise**2
                    * (2.0 * np.pi) ** 4
                    * cutoff**5
                    * equations.shape[1]
                    * float(np.mean(weight**2))
                )
                bias = abs(
                    noise
                    * float(theta[0])
                    * float(normal(equations @ equations.T, first, rcond=SINGULAR)[0])
                )
                # The covariance by a jackknife over blocks.
                *_, parts = zip(*left_out(equations, target, BLOCKS, rcond=SINGULAR), strict=True)
                changes = np.array(parts) - np.mean(parts, axis=0)
                covariance = (BLOCKS - 1) / BLOCKS * changes.T @ changes
                return InstrumentFit(
                    cutoff,
                    theta,
                    delay + moved,
                    c + further,
                    covariance,
                    bias,
                    converged,
                    changes[:, 0],
                )
            delay += float(np.clip(moved, -2.0 * self.dt, 2.0 * self.dt))
            c = float(np.clip(c + np.clip(further, -FILTER, FILTER), -25.0 * FILTER, 25.0 * FILTER))
            rows, target = self._weighed(cutoff, delay, c)
        raise AssertionError

    def _calm(self, cutoff: float, c: float) -> list[np.ndarray]:
        """Return the acceleration of `_filtered` without noise, which a weight would spread over all rows."""
        calm = max(CALM * cutoff, CALMEST)
        if calm >= self.width:
            return [x[0] for x in self._filtered(c)]
        if self.calm is None or self.calm[0] != (calm, max(c, 0.0)):
            self.calm = (
                (calm, max(c, 0.0)),
                [low_passed(x[0], calm, self.step) for x in self._filtered(c)],
            )
        return self.calm[1]

    def _filtered(self, c: float) -> list[np.ndarray]:
        """Return the columns after the filter of the effort; cached, because each step needs them twice."""
        columns = self._signals("columns")
        if c <= 0.0:
            return columns
        if self.passed is None or self.passed[0] != c:
            self.passed = c, [through_filter(x, (2.0 * c) ** 0.5, self.step) for x in columns]
        return self.passed[1]

    def _weighed(self, cutoff: float, delay: float, c: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the equations for a delay and a filter: the regressor, shape (column, row), and the effort."""
        efforts = self._efforts(delay)
        if c < 0.0:
            efforts = [through_filter(x, (-2.0 * c) ** 0.5, self.step) for x in efforts]
        rows = self.behind(cutoff, self._filtered(c)) if c > 0.0 else self.regressor(cutoff)
        return rows, self.behind(cutoff, efforts)[0]

    def _efforts(self, *delays: float) -> list[np.ndarray]:
        """Return the effort of all stretches for each delay, shape (delay, row)."""
        return [np.stack([s.effort_at(delay) for delay in delays]) for s in self.stretches]

    def lowered(self, bent: InstrumentFit, delay: float) -> np.ndarray:
        """Return the decrease of the squared residual of each block by a filter; without filter, the effort lags by `delay`."""
        rows, target = self._weighed(bent.cutoff, bent.delay, bent.c)
        plain = self._weighed(bent.cutoff, delay, bent.c)[1]
        lag = (2.0 * abs(bent.c)) ** 0.5
        columns = [
            s.columns if bent.c > 0.0 else through_filter(s.columns, lag, self.step)
            for s in self.stretches
        ]
        without = self.behind(bent.cutoff, columns)
        squares = [
            np.array(
                [
                    float(np.sum((effort - theta @ part) ** 2))
                    for part, effort, theta in left_out(*pair, BLOCKS, rcond=SINGULAR)
                ]
            )
            for pair in ((without, plain), (rows, target))
        ]
        return squares[0] - squares[1]

    def find_waves(self, delay: float) -> None:
        """Add waves of force and friction over the position found in the residual: cogging, pitch of a screw."""
        for _ in range(WAVES):
            weight, x, side = map(self._together, ("weight", "position", "side"))
            rows = weight * self._together("columns")
            target = weight * np.hstack(self._efforts(delay))[0]
            basis = np.linalg.qr(rows.T)[0]
            residual = apart_from(basis, target)
            frequency = frequency_in(x, side, weight * residual, MOST_TURNS, TURNS)
            if frequency is None:
                return
            columns = apart_from(basis, weight[:, None] * waves(x, side, frequency))
            if np.sum((np.linalg.qr(columns)[0].T @ residual) ** 2) < WAVE_SHARE * np.sum(
                residual**2
            ):
                return
            for s in self.stretches:
                s.columns = np.vstack([s.columns, waves(s.position, s.side, frequency).T])
            self.narrow.clear()
            self.passed = None


def wide_rows(
    logs: Sequence[Log],
    axes: Sequence[Axis | None],
    widths: Sequence[float] = WIDTHS,
    *,
    few: bool = False,
) -> WideRows | None:
    """Return the rows after the widest filter with little noise of the speed; None if the log is too short."""
    dt = float(logs[0].sample_time)
    narrowest = 1.0 / (widths[-1] * dt)
    for share in widths:
        width = 1.0 / (share * dt)
        if width > max(WIDEST, narrowest):
            continue
        parts, noises = list[Segment](), list[float]()
        for log, axis in zip(logs, axes, strict=True):
            step = step_of(log, axis)
            for part in log.segments or (slice(0, len(log)),):
                if len(range(*part.indices(len(log)))) * log.sample_time >= 4.0 * EDGE:
                    segment, noise, _ = segment_of(
                        log, part, width, step, held=bool(axis and axis.held)
                    )
                    parts.append(replace(segment, time=segment.time - log.time.values[0]))
                    # White noise above the cut-off determines the total noise; it is at least that of rounding.
                    noises.append(
                        max(
                            noise / max(1.0 - 2.0 * width * log.sample_time, 0.1) ** 0.5,
                            step / 12.0**0.5,
                        )
                    )
        speeds = [derivative(segment.position - segment.position[0], dt) for segment in parts]
        top = float(np.quantile(np.abs(np.concatenate([*speeds, [0.0]])), TOP))
        noise = float(np.sqrt(np.mean(np.square([*noises, 0.0][: max(len(noises), 1)]))))
        little = 2.0 * np.pi * noise * (2.0 / 3.0 * dt * width**3) ** 0.5 < SPEED_NOISE * top
        if little or width <= narrowest:
            stride = max(int(FINE / (width * dt)), 1)
            pairs = zip(parts, speeds, strict=True)
            frequencies, degree = list[float](), 0
            if axes[0] is not None:
                # The known waves of the plant over the position [1/m or 1/rad]: gravity, cogging.
                frequencies = [
                    2.0 * np.pi * n / cogging.turn
                    for cogging in axes[0].cogging
                    for n in cogging.harmonics or ()
                ]
                frequencies = [1.0] * axes[0].gravity + frequencies
                degree = SPRINGS.get(axes[0].spring or "", 0)
            stretches = [
                _stretch(*pair, width, dt, stride, top, frequencies, degree, few=few)
                for pair in pairs
                if top > 0.0
            ]
            rows = WideRows(stretches, width, stride * dt, dt, noise)
            return rows if rows.suffice() else None
    return None


def _stretch(
    segment: Segment,
    speed: np.ndarray,
    width: float,
    dt: float,
    stride: int,
    top: float,
    plant: Sequence[float] = (),
    degree: int = 0,
    *,
    few: bool = False,
) -> _Stretch:
    from scipy.ndimage import minimum_filter1d, spline_filter1d, uniform_filter1d

    def columns() -> Iterator[np.ndarray]:
        yield derivative(speed, dt)
        yield segment.position
        if few:
            yield speed
        rates = (0.0,) if few else (None, 0.0, *(1.0 / (share * top) for share in SPEEDS))
        for side in (1.0, -1.0):
            along = speed * side > 0.0
            for rate in rates:
                yield np.where(
                    along, speed if rate is None else side * np.exp(-np.abs(speed) * rate), 0.0
                )
        if not few:
            # While an axis warms up, faster motions at the end of a log seem to have another delay.
            yield np.sign(speed) * segment.time
        for wave in plant:
            yield from (bend(wave * segment.position) for bend in (np.cos, np.sin))
        yield from (
            (segment.position - segment.position.mean()) ** power for power in range(2, degree + 1)
        )
        yield from segment.regressors

    def wide(signals: Iterable[np.ndarray]) -> np.ndarray:
        # Signal by signal, to save memory.
        return np.stack([low_passed(signal, width, dt)[::stride].copy() for signal in signals])

    rows, smooth = wide(columns()), wide((segment.position - segment.position[0], speed))
    share = np.abs(smooth[1]) / top
    # The filter spreads friction at rest into neighbouring rows.
    guard = max(int(1.0 / (width * dt * stride)), 1)
    moving = minimum_filter1d((share > SLOW).astype(float), 2 * guard + 1)
    rise = np.clip((share - SLOW) / (FAST - SLOW), 0.0, 1.0)
    weight = uniform_filter1d(moving, max(guard, 3)) * moving * rise**2 * (3.0 - 2.0 * rise)
    edge = int(EDGE / (stride * dt))
    weight[:edge], weight[-edge:] = 0.0, 0.0
    effort = spline_filter1d(segment.effort)
    position, side = smooth[0] + segment.position[0], np.sign(smooth[1])
    return _Stretch(
        position, side, rows, weight, lambda delay: at_spline(effort, delay / dt)[::stride]
    )
