r"""The delay between effort and position, a filter in one of the channels, and the inertia: found before any model.

Noise of the position makes the inertia too small, and a delay makes it wrong to either side. Both are taken care of by
instrumental variables [1]_: the equations of the wide rows, in which friction turns where it does, are weighed with
the same motion behind a narrow low-pass filter `H`, in which noise is nothing,

.. math:: X^T W H W \left[u(t + \tau) - X \theta + \tau' \tfrac{d}{dt} X \theta - c\, \tfrac{d^2}{dt^2} X \theta\right]
   = 0 .

`X` has the acceleration, friction that may bend with speed, by direction, a spring, and the waves over the position
that the residual shows. `W` leaves out what is slow: friction before sliding turns after the motion, as if the effort
were late. A first-order filter of time constant `T` is a delay of `T` and a :math:`c = T^2 / 2`, positive where the
effort passed it. A `c` that is not seen clearly is drawn to zero, as one of some milliseconds is.

The cut-off of `H` is the widest at which neither noise of the encoder nor an estimate from narrower ones speaks against
it [2]_. Errors are those of a jackknife over blocks of time.

References
----------
.. [1] A. Janot, P.-O. Vandanjon, M. Gautier, "A generic instrumental variable approach for industrial robot
   identification", IEEE Transactions on Control Systems Technology 22(1), 2014. doi:10.1109/TCST.2013.2246163
.. [2] O. V. Lepskii, "On a problem of adaptive estimation in Gaussian white noise", Theory of Probability & Its
   Applications 35(3), 1991. doi:10.1137/1135065
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.identification.dataset import Segment, derivative, low_passed
from bristle.identification.delay import Alignment, at, through_filter
from bristle.identification.preprocessing import segment_of, smallest_step
from bristle.identification.settings import Settings
from bristle.logs.log import Log

__all__ = ["alignment_of"]

WIDTHS = (5.0, 10.0, 20.0, 40.0)  # sampling frequency over the cut-off of the wide rows, the widest first
WIDEST, NARROWEST = 250.0, 3.0  # Hz: of the wide rows, of the instruments
SPEED_NOISE = 0.025  # of the top speed: noise of the speed in wide rows
TOP = 0.995  # quantile of the speeds that is the top speed
SLOW, FAST = 0.05, 0.15  # of the top speed: what is slower is left out, what is faster counts fully
EDGE = 0.5  # s at the ends of a stretch
FINE = 0.25  # periods of the wide cut-off from row to row
SPEEDS = (0.03, 0.1, 0.3)  # of the top speed: where friction may bend
RUNGS, LOWEST, HIGHEST = 8, 0.04, 110.0  # cut-offs of the instruments: share of the widest, and the highest [Hz]
REACH, REACH_TIME, REACH_STEP = 12.0, 8e-3, 0.4e-3  # samples, or s, to either side in which a delay is sought; s
ROUGH = 25.0  # Hz: where it is sought roughly
STEPS = 8
CLOSE, CLOSE_FILTER = 0.02, 3e-8  # samples, s^2: a step that is none
CHANGE = 0.4  # of the change to another cut-off that is put to the error
SPARE_MASS, SPARE_DELAY = 5e-4, 0.05  # of the inertia, samples: what no log says better
BLOCKS, STUDENT = 20, 2.093  # of the jackknife, and the 97.5 % quantile of Student's t of 19 degrees of freedom
BIAS_OVER_ERROR, BIAS_UNSURE = 0.3, 50.0  # noise is not white and may bias so many times more than computed
AGREE, ALIKE, POOR, SHARPER = 2.0, 0.7, 6.0, 1.3  # of rungs: see `_agreeing`
FILTER = 2e-6  # s^2: c of a filter of 2 ms, which a channel may have without a word
ALIKE_FILTER = 0.6  # of a filter: what two fits may say differently
WAVES, TURNS, BINS, WAVE_SHARE = 2, 3.0, 8192, 0.05  # over the position: most, fewest periods, share of the residual
FEWEST = 400  # rows
SINGULAR = 1e-9  # of normal equations with a diagonal of ones


@dataclass
class _Stretch:
    """A stretch of the log on the grid of the wide rows: time [s], regressor (column, row), weight, effort."""

    time: np.ndarray
    position: np.ndarray
    columns: np.ndarray
    weight: np.ndarray
    segment: Segment

    def effort(self, delay: float) -> np.ndarray:
        return at(self.time + delay, self.segment.time, self.segment.effort)


class _Fit(NamedTuple):
    """Inertia first of `theta`, delay [s] and filter [s^2] at one cut-off, with their covariance in this order."""

    cutoff: float
    theta: np.ndarray
    delay: float
    c: float
    covariance: np.ndarray
    bias: float
    converged: bool

    def std(self, place: int) -> float:
        return float(self.covariance[place, place]) ** 0.5


class _Rung(NamedTuple):
    """The fit at one cut-off without a filter, and with one that is free."""

    plain: _Fit
    free: _Fit


@dataclass
class _WideRows:
    stretches: list[_Stretch]
    width: float  # Hz
    step: float  # s from row to row
    dt: float
    noise: float  # of the position, sample by sample
    waves: list[float] = field(default_factory=list)
    seen: dict[float, np.ndarray] = field(default_factory=dict)

    def suffice(self) -> bool:
        """Return whether these are enough; columns that a log in one direction does not have are dropped."""
        if not self.stretches:
            return False
        weight = np.concatenate([s.weight for s in self.stretches])
        columns = np.concatenate([s.columns for s in self.stretches], axis=1)
        there = np.max(np.abs(weight * columns), axis=1) > 1e-6 * np.max(np.abs(columns), axis=1)
        for stretch in self.stretches:
            stretch.columns = stretch.columns[there]
        return bool(there[0] and np.count_nonzero(weight > 0.5) >= FEWEST)

    def behind(self, cutoff: float, signals: Sequence[np.ndarray]) -> np.ndarray:
        """Return signals weighed and behind the narrow filter, all stretches one after the other."""
        every = max(int(0.2 / (cutoff * self.step)), 1)
        parts = zip(self.stretches, signals, strict=True)
        return np.concatenate([low_passed(s.weight * x, cutoff, self.step)[..., ::every] for s, x in parts], axis=-1)

    def regressor(self, cutoff: float) -> np.ndarray:
        if cutoff not in self.seen:
            self.seen[cutoff] = self.behind(cutoff, [s.columns for s in self.stretches])
        return self.seen[cutoff]

    def scanned(self) -> float:
        """Return the delay that leaves least, roughly."""
        cutoff = min(ROUGH, self.width)
        basis = np.linalg.qr(self.regressor(cutoff).T)[0]
        reach = max(REACH * self.dt, REACH_TIME)

        def left(delay: float) -> float:
            effort = self.behind(cutoff, [s.effort(delay) for s in self.stretches])
            return float(np.sum((effort - basis @ (basis.T @ effort)) ** 2))

        return float(min(np.arange(-reach, reach, max(0.5 * self.dt, REACH_STEP)).tolist(), key=left))

    def fit(
        self, cutoff: float, delay: float, c: float = 0.0, *, free: tuple[bool, bool], steps: int = STEPS
    ) -> _Fit:  # fmt: skip
        """Return what the equations say at one cut-off, after so many steps; `free` are delay and filter."""
        rows, target = self._weighed(cutoff, delay, c)
        theta = _solved(rows @ rows.T, rows @ target)
        for step in range(steps):
            every = np.vstack([rows, *self._slopes(cutoff, c, theta, free)])
            full = _solved(every @ every.T, every @ target)
            theta = full[: rows.shape[0]]
            moved, bent = float(full[theta.size]) if free[0] else 0.0, float(full[-1]) if free[1] else 0.0
            converged = abs(moved) < CLOSE * self.dt and abs(bent) < CLOSE_FILTER
            if converged or step == steps - 1:
                bias, covariance = self._bias(cutoff, theta, every), _jackknife(every, target)
                return _Fit(cutoff, theta, delay + moved, c + bent, covariance, bias, converged)
            delay += float(np.clip(moved, -2.0 * self.dt, 2.0 * self.dt))
            c = float(np.clip(c + np.clip(bent, -FILTER, FILTER), -25.0 * FILTER, 25.0 * FILTER))
            rows, target = self._weighed(cutoff, delay, c)
        raise AssertionError

    def _filtered(self, c: float) -> list[np.ndarray]:
        """Return the columns, behind the filter that the effort passed."""
        columns = [s.columns for s in self.stretches]
        return [through_filter(x, (2.0 * c) ** 0.5, self.step) for x in columns] if c > 0.0 else columns

    def _weighed(self, cutoff: float, delay: float, c: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the equations for a delay and a filter: the regressor, shape (column, row), and the effort."""
        efforts = [s.effort(delay) for s in self.stretches]
        if c < 0.0:
            efforts = [through_filter(x, (-2.0 * c) ** 0.5, self.step) for x in efforts]
        rows = self.behind(cutoff, self._filtered(c)) if c > 0.0 else self.regressor(cutoff)
        return rows, self.behind(cutoff, efforts)

    def _slopes(self, cutoff: float, c: float, theta: np.ndarray, free: tuple[bool, bool]) -> list[np.ndarray]:
        """Return the columns of a little more delay and a little more of a filter, those of them that are free."""
        slopes = [derivative(theta @ x, self.step) for x in self._filtered(c)]
        parts = [[-x for x in slopes], [derivative(x, self.step) for x in slopes]]
        return [self.behind(cutoff, part) for part, wanted in zip(parts, free, strict=True) if wanted]

    def _bias(self, cutoff: float, theta: np.ndarray, rows: np.ndarray) -> float:
        """Return by how much white noise of the position makes the inertia too small."""
        first = np.zeros(rows.shape[0])
        first[0] = 1.0
        weight = np.concatenate([s.weight for s in self.stretches])
        noise = (
            0.4 * self.dt * self.noise**2 * (2.0 * np.pi) ** 4 * cutoff**5 * rows.shape[1] * float(np.mean(weight**2))
        )
        return abs(noise * float(theta[0]) * float(_solved(rows @ rows.T, first)[0]))

    def find_waves(self, delay: float) -> None:
        """Add waves over the position that the residual shows: cogging, the pitch of a screw."""
        for _ in range(WAVES):
            weight, x = (np.concatenate([getattr(s, name) for s in self.stretches]) for name in ("weight", "position"))
            rows = weight * np.concatenate([s.columns for s in self.stretches], axis=1)
            target = weight * np.concatenate([s.effort(delay) for s in self.stretches])
            basis = np.linalg.qr(rows.T)[0]
            residual, span = target - basis @ (basis.T @ target), float(np.ptp(x))
            sums = np.bincount(((x - x.min()) * (BINS - 1) / span).astype(int), weight * residual, BINS)
            spectrum = np.abs(np.fft.rfft(sums, 4 * BINS))[: BINS // 8 * 4]
            first = int(4 * TURNS)
            wave = 2.0 * np.pi * 0.25 * (first + int(np.argmax(spectrum[first:]))) * (BINS - 1) / BINS / span
            both = weight * np.stack([np.cos(wave * x), np.sin(wave * x)])
            both = both.T - basis @ (basis.T @ both.T)
            if np.sum((np.linalg.qr(both)[0].T @ residual) ** 2) < WAVE_SHARE * np.sum(residual**2):
                return
            for s in self.stretches:
                waves = np.stack([np.cos(wave * s.position), np.sin(wave * s.position)])
                s.columns = np.vstack([s.columns, waves])
            self.seen.clear()


def _solved(gram: np.ndarray, right: np.ndarray) -> np.ndarray:
    scale = np.sqrt(np.maximum(np.diag(gram), np.finfo(float).tiny))
    return np.linalg.lstsq(gram / np.outer(scale, scale), right / scale, rcond=SINGULAR)[0] / scale


def _jackknife(rows: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Return the covariance of the solution by leaving out one block after the other."""
    gram, right = rows @ rows.T, rows @ target
    blocks = zip(np.array_split(rows, BLOCKS, 1), np.array_split(target, BLOCKS), strict=True)
    parts = [_solved(gram - part @ part.T, right - part @ effort) for part, effort in blocks]
    changes = np.array(parts) - np.mean(parts, axis=0)
    return (BLOCKS - 1) / BLOCKS * changes.T @ changes


def alignment_of(
    logs: Sequence[Log], axes: Sequence[Axis | None], settings: Settings, *, sought: bool = True
) -> Alignment:  # fmt: skip
    """Return how the channels of some logs of one axis stand in time; the delay is zero where it is not `sought`."""
    rows = _wide_rows(logs, axes)
    if rows is None:
        return Alignment(sought=sought)
    start = rows.scanned() if sought else 0.0
    rows.find_waves(start)
    highest, rungs = min(0.8 * rows.width, HIGHEST), list[_Rung]()
    lowest = min(max(LOWEST * rows.width, NARROWEST), 0.5 * highest)
    for cutoff in np.geomspace(lowest, highest, RUNGS).tolist():
        plain = rows.fit(cutoff, start, free=(sought, False))
        rungs.append(_Rung(plain, rows.fit(cutoff, plain.delay, free=(sought, True), steps=1)))
    agreeing = _agreeing(rungs, rows.dt, sought=sought)
    return _told(rows, agreeing, settings, sought=sought) if agreeing else Alignment(sought=sought)


def _agreeing(rungs: Sequence[_Rung], dt: float, *, sought: bool) -> list[_Rung]:
    """Return the most rungs in a row that do not contradict each other, the narrowest first."""
    usable = [rung for rung in rungs if rung.plain.converged and rung.plain.theta[0] > 2.0 * rung.plain.std(0)]
    worst = POOR * min((rung.free.std(0) for rung in usable), default=0.0)
    usable, most = [rung for rung in usable if rung.free.std(0) <= worst], list[_Rung]()
    for first in range(len(usable)):
        run = usable[first : first + 1]
        for rung in usable[first + 1 :]:
            if any(_contradicts(rung.free, narrow.free, dt, sought=sought) for narrow in run):
                break
            run.append(rung)
        most = run if len(run) > len(most) else most
    return most


def _contradicts(wide: _Fit, narrow: _Fit, dt: float, *, sought: bool) -> bool:
    def apart(place: int, change: float, spare: float) -> bool:
        before, after = narrow.std(place), wide.std(place)
        joint = math.hypot(max(before**2 - after**2, 0.0) ** 0.5, ALIKE * before)
        return abs(change) > AGREE * joint + spare

    return apart(0, float(wide.theta[0] - narrow.theta[0]), 0.0) or (
        sought and apart(wide.theta.size, wide.delay - narrow.delay, 0.05 * dt)
    )


def _told(rows: _WideRows, rungs: list[_Rung], settings: Settings, *, sought: bool) -> Alignment:
    """Return what the sharpest of the rungs says, noise being nothing in it, and how sure that is."""
    clean = [rung for rung in rungs if BIAS_UNSURE * rung.plain.bias <= BIAS_OVER_ERROR * rung.plain.std(0)] or rungs[
        :1
    ]
    sharp = SHARPER * min(rung.plain.std(0) for rung in clean)
    chosen = [rung for rung in clean if rung.plain.std(0) <= sharp][-1]
    other = rungs[max(rungs.index(chosen) - 2, 0)].plain
    places, dt = [0, chosen.plain.theta.size] if sought else [0], rows.dt
    steady = all(_alike(rung.free, chosen.free) for rung in rungs)
    spread = 0.0 if steady else max(abs(rung.free.c - chosen.free.c) for rung in rungs)
    seen = settings.filter_seen if steady else math.inf
    lag, std, values, errors, changes = _filtered(rows, chosen, other, places, (seen, spread), sought=sought)
    widths = [STUDENT * error + CHANGE * abs(change) for error, change in zip(errors, changes, strict=True)]
    mass, mass_width = values[0], widths[0] + SPARE_MASS * values[0]
    delay, width = (values[1], widths[1] + SPARE_DELAY * dt) if sought else (0.0, math.inf)
    # What does not show the inertia does not show the jerk either.
    known = width <= settings.delay_unsure * dt and mass_width <= settings.delay_inertia * mass
    lag = lag if known or not sought else None
    well = mass_width <= settings.inertia_unsure * mass
    return Alignment(
        delay if known else None, width if known else None, lag, None if lag is None else STUDENT * std / abs(lag),
        mass if well else None, mass_width if well else None, chosen.plain.cutoff, sought,
    )  # fmt: skip


def _alike(one: _Fit, other: _Fit) -> bool:
    """Return whether two fits see the same filter: noise of the position looks like one that grows with the cut-off."""
    return abs(one.c - other.c) <= ALIKE_FILTER * abs(other.c) + AGREE * math.hypot(one.std(-1), other.std(-1))


def _filtered(
    rows: _WideRows, rung: _Rung, other: _Fit, places: Sequence[int], known: tuple[float, float], *, sought: bool
) -> tuple[float | None, float, list[float], list[float], list[float]]:
    """Return what a filter in a channel does to the inertia and the delay.

    The time constant of one that is seen [s], the error of its square; values, errors, and changes to another cut-off.
    `known` is from how many standard errors on it is seen, and by how much the rungs differ [s^2].
    """
    (seen, spread), free, plain = known, rung.free, rung.plain
    std = free.std(-1)
    if abs(free.c) > seen * std:
        bent = rows.fit(plain.cutoff, plain.delay, free=(sought, True), steps=2 * STEPS)
        if bent.converged and abs(bent.c) > seen * bent.std(-1) and _alike(bent, free):
            again = rows.fit(other.cutoff, bent.delay, bent.c, free=(sought, False))
            changes = [float(again.theta[0] - bent.theta[0]), again.delay - bent.delay]
            lag = math.copysign((2.0 * abs(bent.c)) ** 0.5, bent.c)
            values, errors = [float(bent.theta[0]), bent.delay], [bent.std(place) for place in places]
            return lag, bent.std(-1), values, errors, changes[: len(places)]
        spread = max(spread, abs(bent.c - free.c))
    # A filter that is not seen clearly: what is known of it beforehand and what the rows say, together.
    doubt = math.hypot(std, spread)
    values, errors, share = [], [], FILTER**2 / (FILTER**2 + doubt**2)
    for place, found in zip(places, (float(free.theta[0]), free.delay), strict=False):
        slope = float(free.covariance[place, -1]) / std**2
        values.append(found - slope * (1.0 - share) * free.c)
        variance = float(free.covariance[place, place]) + slope**2 * (share * doubt**2 - std**2)
        errors.append(max(variance, 0.5 * plain.std(place) ** 2) ** 0.5)
    changes = [float(other.theta[0] - plain.theta[0]), other.delay - plain.delay]
    return None, std, values, errors, changes[: len(places)]


def _wide_rows(logs: Sequence[Log], axes: Sequence[Axis | None]) -> _WideRows | None:
    """Return the rows behind the widest filter in which noise of the speed is little; None of a log too short."""
    dt = float(logs[0].sample_time)
    widths = [1.0 / (share * dt) for share in WIDTHS]
    for width in [width for width in widths if width <= WIDEST] or widths[-1:]:
        parts, noises = _segments(logs, axes, width)
        speeds = [derivative(segment.position - segment.position[0], dt) for segment in parts]
        top = float(np.quantile(np.abs(np.concatenate([*speeds, [0.0]])), TOP))
        noise = float(np.sqrt(np.mean(np.square([*noises, 0.0][: max(len(noises), 1)]))))
        little = 2.0 * np.pi * noise * (2.0 / 3.0 * dt * width**3) ** 0.5 < SPEED_NOISE * top
        if little or width <= min(widths):
            every = max(int(FINE / (width * dt)), 1)
            pairs = zip(parts, speeds, strict=True)
            rows = _WideRows(
                [_stretch(*pair, width, dt, every, top) for pair in pairs if top > 0.0], width, every * dt, dt, noise
            )
            return rows if rows.suffice() else None
    return None


def _segments(logs: Sequence[Log], axes: Sequence[Axis | None], width: float) -> tuple[list[Segment], list[float]]:
    """Return the segments of logs behind a filter, and the noise of the position of each, sample by sample."""
    parts, noises = [], []
    for log, axis in zip(logs, axes, strict=True):
        step = smallest_step(log.position.values) if axis is None or axis.resolution is None else axis.resolution
        for part in log.segments or (slice(0, len(log)),):
            if len(range(*part.indices(len(log)))) * log.sample_time < 4.0 * EDGE:
                continue
            segment, noise, _ = segment_of(log, part, width, step, held=bool(axis and axis.held))
            parts.append(segment)
            # White noise above the cut-off tells how much there is in all; it is no less than that of rounding.
            noises.append(max(noise / max(1.0 - 2.0 * width * log.sample_time, 0.1) ** 0.5, step / 12.0**0.5))
    return parts, noises


def _stretch(segment: Segment, speed: np.ndarray, width: float, dt: float, every: int, top: float) -> _Stretch:
    from scipy.ndimage import minimum_filter1d, uniform_filter1d

    position = segment.position - segment.position[0]
    columns = [derivative(speed, dt), segment.position]
    for side in (1.0, -1.0):
        along = speed * side > 0.0
        shapes = (speed, side, *(side * np.exp(-np.abs(speed) / (share * top)) for share in SPEEDS))
        columns += [np.where(along, shape, 0.0) for shape in shapes]
    rows = low_passed(np.stack(columns), width, dt)[:, ::every]
    smooth = low_passed(np.stack([position, speed]), width, dt)[:, ::every]
    share = np.abs(smooth[1]) / top
    # The filter carries what friction does at rest into the rows beside.
    guard = max(int(1.0 / (width * dt * every)), 1)
    moving = minimum_filter1d((share > SLOW).astype(float), 2 * guard + 1)
    rise = np.clip((share - SLOW) / (FAST - SLOW), 0.0, 1.0)
    weight = uniform_filter1d(moving, max(guard, 3)) * moving * rise**2 * (3.0 - 2.0 * rise)
    edge = int(EDGE / (every * dt))
    weight[:edge], weight[-edge:] = 0.0, 0.0
    return _Stretch(segment.time[::every], smooth[0] + segment.position[0], rows, weight, segment)
