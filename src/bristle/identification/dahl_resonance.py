r"""Stiffness and damping of the contact from sweeps of small amplitude, without a friction model.

At small amplitudes `A` friction acts as a spring. The mass on this spring resonates, and the resonance falls as the amplitude
grows (Dahl resonance [1]_). With the first harmonics `U` of the effort and `X` of the position,

.. math:: \frac{U}{X}\,e^{j\omega\tau} = K(A) - \omega^2 M + j\,\bigl(\omega c(A) + H(A)\bigr), \qquad
   K = K_0 - g_1 H - g_2 H^2 / K_0, \quad c = c_0 + e\,H .

`K` and `H` are stiffness and loss of the hysteresis. The loss vanishes with the amplitude, and with it the difference of `K`
from the stiffness :math:`K_0` at the amplitude zero: for elements that slip at thresholds with a power law as density,
:math:`g_2 = 0`, and for Dahl friction :math:`g_1 = 0`. Therefore the loss, and not the amplitude, extrapolates `K` and `c`. The
loss is free at up to five amplitudes. The sum :math:`c_0` has the bristle damping and the viscous friction.

The harmonics come from windows of four periods with the weight `w`. Derivatives move from the position to the weight, so that

.. math:: \int w\,e^{-j\omega t}\,\ddot x\,dt = \int \frac{d^2 (w\,e^{-j\omega t})}{dt^2}\,x\,dt

holds for each motion, and a transient does not matter [2]_. A constant force has no harmonic. The effort of a closed loop is no
problem either: both signals far exceed noise at the frequency of the sweep. Half-widths of the 95 % intervals come from
the scatter of the windows, and from the error of the encoder at the amplitude of each window.

References
----------
.. [1] J. Y. Yoon, D. L. Trumper, "Friction modeling, identification, and compensation based on friction hysteresis and Dahl
   resonance", Mechatronics 24(6), 2014.
.. [2] M. Shinbrot, "On the analysis of linear and nonlinear systems", Transactions of the ASME 79, 1957.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from bristle.core.least_squares import unbounded
from bristle.logs.log import Log

CYCLES = 4.0  # of a window
OF_RATE, PER_OCTAVE = 0.1, 6  # highest frequency over the sampling frequency; frequencies tried
PURE, OVERLAP = 0.8, 0.25  # least share of the sweep in the motion of a window; most common share of two windows
STEPS = 1.2  # encoder steps: smallest amplitude
FEWEST, SPAN, AMPLITUDES = 15, 3.0, 1.6  # windows; ratio of frequencies; ratio of amplitudes
NODES, SHRINK = 5, 1.25  # amplitudes with their own loss; between trials of the largest amplitude
MOST_LOSS, SOFTEST = 0.25, 0.65  # of the stiffness, at the largest amplitude: loss and stiffness
LATE, EARLY = 8.0, -4.0  # samples: range of the delay
PRIORS = ((1.2, 1.2), (1.5, 2.0), (0.0, 1.0), (0.75, 0.4))  # mean, deviation: g_1, g_2, e omega, exponent of the hold
NEAR = 12  # windows that share a variance
MISFIT, WIDEST = 0.15, 0.3  # of the response, rms; relative half-width of a reported stiffness
STUDENT = 2.0
TINY = float(np.finfo(float).tiny)


class DahlResonance(NamedTuple):
    """Stiffness, damping and mass at the amplitude zero with their 95 % half-widths, and the stiffness over the amplitude.

    Parameters
    ----------
    stiffness, stiffness_half_width : float
        Stiffness of the contact [N/m or N*m/rad].
    damping, damping_half_width : float
        Bristle damping and viscous friction together [N*s/m or N*m*s/rad].
    mass, mass_half_width : float
        Moving mass [kg] or inertia [kg*m^2].
    amplitudes, stiffnesses, losses : tuple of float
        Amplitudes [m or rad], with real and imaginary part of the describing function of the hysteresis [N/m or N*m/rad].
    """

    stiffness: float
    stiffness_half_width: float
    damping: float
    damping_half_width: float
    mass: float
    mass_half_width: float
    amplitudes: tuple[float, ...]
    stiffnesses: tuple[float, ...]
    losses: tuple[float, ...]


class _Windows(NamedTuple):
    """Windows of a sweep: frequency [Hz], amplitude, response, its acceleration and velocity over position, samples, shape (window,)."""

    frequency: np.ndarray
    amplitude: np.ndarray
    response: np.ndarray
    acceleration: np.ndarray
    velocity: np.ndarray
    samples: np.ndarray

    def where(self, chosen: np.ndarray) -> _Windows:
        return _Windows(*(values[chosen] for values in self))


def dahl_resonance(logs: Sequence[Log], step: float, highest: float = math.inf) -> DahlResonance | str | None:
    """Return the contact in sweeps of small amplitude, or the reason against it; None if the logs have no such sweeps.

    `step` is that of the encoder [m or rad], and `highest` the highest frequency [Hz] at which the axis is one mass.
    """
    windows, dt = _windows_of(logs, step), float(logs[0].sample_time)
    small = _before_sliding(windows, dt) if windows.frequency.size >= FEWEST else None
    if small is None:
        return None
    if (few := small.where(small.frequency <= highest)).frequency.size < small.frequency.size:
        if few.frequency.size < FEWEST or np.ptp(np.log(few.frequency)) < math.log(SPAN):
            return f"the load is coupled elastically, and the sweep has too few frequencies below {highest:.3g} Hz"
        small = few
    return _Fit(small, dt, step).result


def _windows_of(logs: Sequence[Log], step: float) -> _Windows:
    """Return the windows in which position and effort are a sweep, without large overlap."""
    found = [np.empty((6, 0), complex)]
    for log in logs:
        assert log.effort is not None
        for part in log.segments or (slice(0, len(log)),):
            found.append(_windows_along(log.position.values[part], log.effort.values[part], float(log.sample_time), step))
    frequency, amplitude, *ratios, samples = np.concatenate(found, axis=1)
    return _Windows(frequency.real, amplitude.real, *ratios, samples.real)


def _windows_along(position: np.ndarray, effort: np.ndarray, dt: float, step: float) -> np.ndarray:
    """Return the windows of one stretch, shape (field, window)."""
    found, halved = [(np.empty((6, 0), complex), np.empty(0, int), np.empty(0))], 1
    lengths = [math.ceil(CYCLES / OF_RATE * 2.0 ** (part / PER_OCTAVE)) for part in range(PER_OCTAVE)]
    moved, pulled = position - position[:1], effort
    while moved.size >= lengths[0]:
        for length in (length for length in lengths if length <= moved.size):
            hop = length // 3
            views = (sliding_window_view(signal, length)[::hop] for signal in (moved, pulled))
            fields, share = _projected(*views, halved * dt)
            chosen = (share > PURE) & (fields[1].real > STEPS * step)
            found.append((fields[:, chosen], halved * hop * np.flatnonzero(chosen), share[chosen]))
        # The mean of two samples acts on both signals and leaves their ratio as it is.
        moved, pulled = (0.5 * (signal[:-1:2] + signal[1::2]) for signal in (moved, pulled))
        halved *= 2
    candidates, begin, share = (np.concatenate(parts, axis=-1) for parts in zip(*found, strict=True))
    ends = begin + np.round(CYCLES / (dt * np.maximum(candidates[0].real, TINY))).astype(int)
    taken, kept = np.zeros(position.size, bool), list[int]()
    for place in np.argsort(-share):
        inside = slice(begin[place], ends[place])
        if taken[inside].mean() <= OVERLAP:
            taken[inside] = True
            kept.append(int(place))
    return candidates[:, sorted(kept, key=lambda place: begin[place])]


def _projected(position: np.ndarray, effort: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Return windows, shape (field, window), and the share of the sweep in their motion, from signals of shape (window, sample)."""
    length = position.shape[1]
    t = (np.arange(length) - 0.5 * (length - 1)) * dt
    span = length * dt
    omega, turn = 2.0 * math.pi * CYCLES / span, 2.0 * math.pi / span
    # Weight and derivatives of weight times harmonic.
    w, w_1, w_2 = 0.5 + 0.5 * np.cos(turn * t), -0.5 * turn * np.sin(turn * t), -0.5 * turn**2 * np.cos(turn * t)
    wave = np.exp(-1j * omega * t)
    tests = np.stack([w * wave, -(w_1 - 1j * omega * w) * wave, (w_2 - 2j * omega * w_1 - omega**2 * w) * wave], axis=1)
    line = np.stack([w, w * t], axis=1) / np.array([w.sum(), (w * t) @ t])
    moved = position - position[:, :1]
    level = moved @ line
    moved = moved - level[:, :1] - level[:, 1:] * t
    pulled = effort - effort[:, :1]
    pulled = pulled - pulled @ line @ np.stack([np.ones_like(t), t])
    harmonics, force = moved @ tests, pulled @ tests[:, 0]
    first = np.where(np.abs(harmonics[:, 0]) > 0.0, harmonics[:, 0], TINY)
    amplitude = 2.0 * np.abs(first) / w.sum()
    energy = np.maximum(moved**2 @ w, TINY)
    share = 0.5 * amplitude**2 * w.sum() / energy
    share = np.where(np.abs(level[:, 1]) * span > amplitude, 0.0, share)
    count = len(position)
    ratios = force / first, harmonics[:, 2] / first, harmonics[:, 1] / first
    fields = np.full(count, CYCLES / span), amplitude, *ratios, np.full(count, span)
    return np.stack([np.asarray(field, complex) for field in fields]), share


def _before_sliding(windows: _Windows, dt: float) -> _Windows | None:
    """Return the windows with amplitudes at which the contact is a spring; None without a sweep of several amplitudes."""
    largest = float(np.quantile(windows.amplitude, 0.98))
    while True:
        inside = windows.where(windows.amplitude <= largest)
        if inside.frequency.size < FEWEST:
            return None
        if np.ptp(np.log(inside.frequency)) < math.log(SPAN) or np.ptp(np.log(inside.amplitude)) < math.log(AMPLITUDES):
            return None
        stiffness, change, loss = _rough(inside, dt)[1][2:]
        if stiffness > 0.0 and stiffness + change > SOFTEST * stiffness and loss < MOST_LOSS * stiffness:
            return inside
        largest /= SHRINK


def _rough(windows: _Windows, dt: float) -> tuple[float, np.ndarray]:
    """Return delay, mass, damping, stiffness, and changes of stiffness and loss up to the largest amplitude, by linear least squares."""
    share, one = windows.amplitude / np.max(windows.amplitude), np.ones_like(windows.amplitude)
    columns = np.stack([windows.acceleration, windows.velocity, one, share, 1j * share], axis=1)
    weight = np.sqrt(windows.samples) / (np.abs(windows.response) + np.median(np.abs(windows.response)))
    best, fewest = (0.0, np.zeros(5)), math.inf
    scale = np.array([np.mean(np.abs(column)) for column in columns.T])
    for delay in np.arange(EARLY, LATE, 0.5) * dt:
        turned = windows.response * np.exp(2j * np.pi * windows.frequency * delay)
        A, b = weight[:, None] * columns / scale, weight * turned
        A, b = np.concatenate([A.real, A.imag]), np.concatenate([b.real, b.imag])
        found = unbounded(A, b)
        left = float(np.sum((A @ found - b) ** 2))
        if left < fewest:
            best, fewest = (float(delay), found / scale), left
    return best


class _Fit:
    """The fit of the response. Point: mass, damping, stiffness, delay, g_1, g_2, e, hold, and the loss of each node, all relative."""

    def __init__(self, windows: _Windows, dt: float, step: float) -> None:
        self.windows, self.dt, self.step = windows, dt, step
        self.omega = 2.0 * np.pi * windows.frequency
        delay, (mass, damping, stiffness, change, loss) = _rough(windows, dt)
        del change
        self.middle = float(np.exp(np.mean(np.log(self.omega))))
        self.scales = np.array([stiffness / self.middle**2, stiffness / self.middle, stiffness])
        size = np.log(windows.amplitude)
        self.nodes = np.linspace(*np.quantile(size, [0.02, 0.98]), NODES)
        self.hats = np.stack([np.interp(size, self.nodes, unit) for unit in np.eye(NODES)], axis=1)
        share = np.exp(self.nodes - self.nodes[-1])
        start = np.array([mass, damping, stiffness]) / self.scales
        losses = np.maximum(loss / stiffness, 0.01) * share
        self.start = np.concatenate([start, [delay / dt, 1.2, 1.5, 0.0, 0.5], losses])
        low = np.array([1e-3, 0.0, 1e-2, EARLY - 1.0, 0.0, 0.0, -20.0, -1.0, *np.zeros(NODES)])
        high = np.array([1e3, 1e2, 1e2, LATE + 1.0, 20.0, 50.0, 20.0, 2.0, *np.ones(NODES)])
        self.bounds = low, high
        self.weight = np.sqrt(windows.samples) / (np.abs(windows.response) + np.median(np.abs(windows.response)))

    def contact(self, point: np.ndarray, loss: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the stiffness and the damping at a loss relative to the stiffness, relative to their scales."""
        stiffness = point[2] * (1.0 - point[4] * loss - point[5] * loss**2)
        return stiffness, point[1] + point[6] * point[2] * loss

    def response(self, point: np.ndarray) -> np.ndarray:
        """Return the response of effort to position of each window."""
        loss = self.hats @ point[8:]
        stiffness, damping = self.contact(point, loss)
        mass, of_damping, of_stiffness = self.scales
        moved = mass * point[0] * self.windows.acceleration + of_damping * damping * self.windows.velocity
        moved = moved + of_stiffness * (stiffness + 1j * point[2] * loss)
        held = np.exp(point[7] * np.log(np.sinc(self.windows.frequency * self.dt)))
        return moved * np.exp(-1j * self.omega * self.dt * point[3]) / held

    def residual(self, point: np.ndarray) -> np.ndarray:
        left = self.weight * (self.response(point) - self.windows.response)
        priors = [(value - mean) / deviation for value, (mean, deviation) in zip(point[4:8], PRIORS, strict=True)]
        return np.concatenate([left.real, left.imag, priors])

    def _solved(self, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        from scipy.optimize import least_squares

        low, high = self.bounds
        inside = np.clip(start, low + 1e-6 * np.abs(high - low), high - 1e-6 * np.abs(high - low))
        ended = least_squares(self.residual, inside, bounds=self.bounds, x_scale="jac", max_nfev=200)
        return ended.x, ended.jac

    def _weights(self, point: np.ndarray) -> np.ndarray:
        """Return weights from the residuals of windows of about the same frequency and amplitude."""
        left = np.abs(self.response(point) - self.windows.response) ** 2 * self.windows.samples
        place = np.stack([np.log(self.omega), np.log(self.windows.amplitude)], axis=1)
        apart = np.sum((place[:, None] - place[None]) ** 2, axis=2)
        near = np.argsort(apart, axis=1)[:, : min(NEAR, len(left))]
        variance = 0.5 * left[near].mean(axis=1)
        model = (1e-3 * np.abs(self.windows.response)) ** 2 * self.windows.samples
        return np.sqrt(self.windows.samples / (variance + model))

    @property
    def result(self) -> DahlResonance | str:
        """The contact, or the reason why the sweep does not show it."""
        point, _ = self._solved(self.start)
        for _ in range(3):
            self.weight = self._weights(point)
            point, slope = self._solved(point)
        response = self.response(point)
        misfit = math.sqrt(float(np.mean(np.abs(response / self.windows.response - 1.0) ** 2)))
        if misfit > MISFIT:
            return f"the response is not that of one mass on a spring (misfit {100.0 * misfit:.0f} %)"
        errors = self._errors(point, slope)
        stiffness, width = self.scales[2] * point[2], self.scales[2] * errors[2]
        if width > WIDEST * stiffness:
            return f"the sweep determines the stiffness only within {100.0 * width / stiffness:.0f} %"
        losses = point[8:]
        stiffnesses, _ = self.contact(point, losses)
        return DahlResonance(
            float(stiffness),
            float(width),
            float(self.scales[1] * point[1]),
            float(self.scales[1] * errors[1]),
            float(self.scales[0] * point[0]),
            float(self.scales[0] * errors[0]),
            tuple(np.exp(self.nodes).tolist()),
            tuple((self.scales[2] * stiffnesses).tolist()),
            tuple((stiffness * losses).tolist()),
        )

    def _errors(self, point: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """Return half-widths of mass, damping and stiffness, from the scatter of the windows and the error of the encoder."""
        count = self.omega.size
        inverse = np.linalg.pinv(slope.T @ slope, rcond=1e-12)
        left = self.residual(point)[: 2 * count]
        scores = slope[:count] * left[:count, None] + slope[count : 2 * count] * left[count:, None]
        prior = slope[2 * count :].T @ slope[2 * count :]
        free = count / max(count - 0.5 * len(point), 1.0)
        cover = inverse @ (free * scores.T @ scores + prior) @ inverse
        # The encoder changes the gain of a sine by an error of A^-3/2 steps, the same for windows of one amplitude.
        gain = 0.11 * (self.step / self.windows.amplitude) ** 1.5
        response = self.weight * self.response(point)
        changes = (self.hats * gain[:, None]).T
        moved = inverse @ slope[: 2 * count].T @ np.concatenate([changes * response.real, changes * response.imag], axis=1).T
        return STUDENT * np.sqrt(np.maximum(np.diag(cover) + np.sum(moved**2, axis=1), 0.0))[:3][[0, 1, 2]]
