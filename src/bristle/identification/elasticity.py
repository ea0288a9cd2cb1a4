r"""An elastic coupling between motor and load, detected by the antiresonance in the residual of a rigid axis.

With a load on a spring, the motor moves the apparent inertia :math:`m_1 + m_2 H_a`, where :math:`H` is the response of a
resonator. The residual of a rigid axis is then :math:`\kappa (H_r - 1) u` for the effort `u`, with the resonance
:math:`\omega_r = \omega_a \sqrt{1 + \kappa}` and :math:`\kappa = m_2 / m_1`. Friction adds a term of the same form if it
is distributed differently from the inertia.

The controller feeds encoder noise back into the effort, and a transfer function between effort and position contains
it. Therefore both are averaged over blocks (Welch [1]_) with instruments [2]_ that are free of noise: the signs of the
smoothed velocity and acceleration. Delay, filter, inertia and level, and a smooth second-order lag of the same
frequency, are fitted too. bristle reports a coupling if a resonance explains more than the largest of all frequencies
would by chance, part of it below the resonance.

References
----------
.. [1] P. D. Welch, "The use of fast Fourier transform for the estimation of power spectra", IEEE Transactions on Audio
   and Electroacoustics 15(2), 1967. doi:10.1109/TAU.1967.1161901
.. [2] U. Forssell, L. Ljung, "Closed-loop identification revisited", Automatica 35(7), 1999.
   doi:10.1016/S0005-1098(99)00022-9
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bristle.core.contracts import Model
from bristle.core.least_squares import unbounded
from bristle.identification.dataset import Dataset
from bristle.identification.missing_rows import SMALLEST

BLOCK, FEWEST_BLOCKS = 0.5, 20  # s; number of blocks, which overlap by half
MOST_REST = 0.3  # of a block
SLOWEST = 4.0  # Hz: below, friction and gravity dominate
CALM, SLACK = 15.0, (0.02, 0.2)  # Hz: low-pass of the instruments; shares of velocity and acceleration too small for a sign
DAMPING, SMOOTH = 0.05, 0.5  # damping of a resonance, and of a smooth lag
STEP = 0.02  # step of the logarithm of the trial frequency
POOLED = 0.1  # the same: width over which errors are averaged
RATIOS = (0.08, 2.0)  # of load to motor
FRICTION = (-0.5, 2.5)  # the same for friction: lower bound, and upper bound over the inertia ratio
CORRELATED = 1.5  # factor of squared deviations due to correlation between frequencies
FALSE_ALARM = 0.002  # of all logs of a rigid axis
LEAST_SHARE, LEAST_BELOW = 0.1, 8.0  # of all squares; squared deviation explained below the resonance


class Elastic(NamedTuple):
    """An elastic coupling: antiresonance [Hz], explained share of the residual, force [N or N*m]."""

    antiresonance: float
    share: float
    force: float


def elastic_coupling(dataset: Dataset, plant: Model, friction: Model) -> Elastic | None:
    """Return the elastic coupling in a log, or None."""
    frictions = dataset.friction_along(friction, plant)
    rigid = [dataset.mechanical_along(plant, segment) + force for segment, force in zip(dataset.segments, frictions, strict=True)]
    spectra = _Spectra.of(dataset, rigid, frictions)
    best = spectra and max(spectra.resonances(dataset.cutoff), key=lambda resonance: resonance.gain, default=None)
    if best is None or not best.clear:
        return None
    forces = [
        dataset.without_edges(_lacking(best.ratio * segment.effort + best.of_friction * force, best.frequency, dataset.sample_time))
        for segment, force in zip(dataset.segments, frictions, strict=True)
    ]
    force = float(np.sqrt(np.mean(np.concatenate(forces) ** 2)))
    return Elastic(best.frequency / math.sqrt(1.0 + best.ratio), best.share, force)


class _Resonance(NamedTuple):
    """A resonance: frequency [Hz], load over motor, the same for friction, squared deviation in total and below it, share, threshold."""

    frequency: float
    ratio: float
    of_friction: float
    gain: float
    below: float
    share: float
    least: float

    @property
    def clear(self) -> bool:
        return self.gain > self.least and self.share > LEAST_SHARE and LEAST_BELOW < self.below < self.gain


@dataclass(frozen=True)
class _Spectra:
    """Cross spectra of the instruments with residual, effort and friction, shape (instrument and frequency,)."""

    frequency: np.ndarray
    residual: np.ndarray
    effort: np.ndarray
    friction: np.ndarray
    weight: np.ndarray
    blocks: float

    @classmethod
    def of(cls, dataset: Dataset, rigid: Sequence[np.ndarray], frictions: Sequence[np.ndarray]) -> _Spectra | None:
        """Return the spectra of a data set; None if it is too short."""
        dt, edge, parts = dataset.sample_time, dataset.dropped, list[np.ndarray]()
        size = round(BLOCK / dt)
        for segment, effort, friction in zip(dataset.segments, rigid, frictions, strict=True):
            signals = (segment.effort - effort, segment.effort, friction, *_instruments(segment.velocity, dt))
            inner = np.stack(signals)[:, edge : segment.time.size - edge]
            rests = (segment.velocity == 0.0)[edge : segment.time.size - edge]
            parts += [
                inner[:, first : first + size]
                for first in range(0, inner.shape[1] - size + 1, max(size // 2, 1))
                if np.mean(rests[first : first + size]) <= MOST_REST
            ]
        frequency = np.fft.rfftfreq(size, dt)
        inside = (frequency >= SLOWEST) & (frequency <= dataset.cutoff)
        if len(parts) < FEWEST_BLOCKS or np.count_nonzero(inside) < FEWEST_BLOCKS:
            return None
        blocks = np.stack(parts)
        window = np.hanning(size)
        blocks = np.fft.rfft(window * (blocks - blocks.mean(axis=-1, keepdims=True)))[..., inside]
        instruments = blocks[:, 3:].conj() / np.sqrt(np.mean(np.abs(blocks[:, 3:]) ** 2, axis=(0, 2), keepdims=True) + SMALLEST)
        cross = [(instruments * blocks[:, number : number + 1]).reshape(len(blocks), -1) for number in range(3)]
        residual, effort, friction = (np.mean(part, axis=0) for part in cross)
        square = np.mean(np.abs(cross[0] - residual) ** 2, axis=0).reshape(len(SLACK), -1)
        near = np.abs(np.subtract.outer(*[np.log(frequency[inside])] * 2)) < POOLED
        error = np.sqrt(square @ near / near.sum(axis=0)).ravel()
        weight = 1.0 / np.maximum(error, max(1e-9 * float(error.max()), SMALLEST))
        return cls(np.tile(frequency[inside], len(SLACK)), residual, effort, friction, weight, 0.5 * len(blocks))

    def rows(self, *signals: np.ndarray) -> np.ndarray:
        """Return complex signals as columns of weighted real rows, shape (row, signal)."""
        weighed = np.stack(signals, axis=-1) * self.weight[:, None]
        return np.concatenate([np.real(weighed), np.imag(weighed)])

    def resonances(self, highest: float) -> Iterator[_Resonance]:
        """Yield the fit of a resonance at each trial frequency with a plausible load."""
        relative = 1j * self.frequency / highest
        rigid = [signal * relative**power for signal in (self.effort, self.friction) for power in range(3)]
        rigid = np.linalg.qr(_scaled(self.rows(*rigid)))[0]
        residual = _without(rigid, self.rows(self.residual)[:, 0])
        total, of_rows = float(residual @ residual), np.tile(self.frequency, 2)
        frequencies = np.exp(np.arange(math.log(1.5 * SLOWEST), math.log(0.95 * highest), STEP))
        least = -2.0 * CORRELATED * math.log(FALSE_ALARM / max(frequencies.size, 1))
        for frequency in frequencies.tolist():
            lacking, lag = (_response(self.frequency / frequency, damping) - 1.0 for damping in (DAMPING, SMOOTH))
            columns = self.rows(lacking * self.effort, lacking * self.friction, lag * self.effort)
            columns = _without(rigid, columns)
            smooth = _scaled(columns[:, 2:])
            columns = _without(smooth, columns[:, :2])
            ratio, of_friction = unbounded(columns, residual, rcond=1e-6).tolist()
            if RATIOS[0] < ratio < RATIOS[1] and FRICTION[0] < of_friction < FRICTION[1] * ratio:
                fitted = columns @ (ratio, of_friction)
                gained = self.blocks * (2.0 * residual - fitted) * fitted
                gain, below = float(gained.sum()), float(gained[of_rows < (1.0 + STEP) * frequency].sum())
                yield _Resonance(frequency, ratio, of_friction, gain, below, gain / (self.blocks * total), least)


def _instruments(velocity: np.ndarray, dt: float) -> Iterator[np.ndarray]:
    """Yield the signs of the smoothed velocity and acceleration; while a signal is small, its sign is kept."""
    from scipy.ndimage import gaussian_filter1d

    signal = gaussian_filter1d(velocity, math.sqrt(math.log(2.0)) / (2.0 * math.pi * CALM * dt))
    for slack in SLACK:
        clear = np.abs(signal) > slack * float(np.quantile(np.abs(signal), 0.99))
        yield np.sign(signal)[np.maximum.accumulate(np.where(clear, np.arange(signal.size), 0))]
        signal = np.gradient(signal)


def _response(relative: np.ndarray, damping: float) -> np.ndarray:
    """Return the response of a resonator at frequencies relative to its resonance."""
    return 1.0 / (1.0 - relative**2 + 2j * damping * relative)


def _lacking(signal: np.ndarray, frequency: float, dt: float) -> np.ndarray:
    """Return the change of a signal by a resonator."""
    spectrum = np.fft.rfft(signal - signal.mean())
    return np.fft.irfft(spectrum * (_response(np.fft.rfftfreq(signal.size, dt) / frequency, DAMPING) - 1.0), signal.size)


def _scaled(columns: np.ndarray) -> np.ndarray:
    return columns / np.maximum(np.linalg.norm(columns, axis=0), SMALLEST)


def _without(basis: np.ndarray, columns: np.ndarray) -> np.ndarray:
    return columns - basis @ (basis.T @ columns)
