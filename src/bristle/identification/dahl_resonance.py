r"""Stiffness and damping of the contact from sweeps of small amplitude, without a friction model.

At small amplitudes `A` friction acts as a spring. The mass on this spring resonates, and the resonance falls as the amplitude
grows (Dahl resonance [1]_). With the first harmonics `U` of the effort and `X` of the position,

.. math:: \frac{U}{X}\,e^{j\omega\tau} = K(A) - \omega^2 M + j\,\bigl(\omega c(A) + H(A)\bigr), \qquad
   K = K_0 - (g_1 + g_3\,\omega)\,H - g_2 H^2 / K_0, \quad c = c_0 + e\,H .

`K` and `H` are stiffness and loss of the hysteresis. The loss vanishes with the amplitude, and with it :math:`K - K_0`: for
elements that slip at thresholds with a power law as density, :math:`g_2 = 0`, and for Dahl friction :math:`g_1 = 0`. Therefore
the loss, free at five amplitudes, extrapolates `K` and `c`. :math:`c_0` is the sum of bristle damping and viscous friction.

The harmonics come from windows of four periods with the weight `w`. Derivatives move from the position to the weight, so that

.. math:: \int w\,e^{-j\omega t}\,\ddot x\,dt = \int \frac{d^2 (w\,e^{-j\omega t})}{dt^2}\,x\,dt

holds for each motion, and a transient does not matter [2]_. A constant force has no harmonic. In a closed loop, both signals
far exceed noise at the frequency of the sweep. Half-widths of the 95 % intervals come from the scatter of the windows, and from
the error of the encoder.

References
----------
.. [1] J. Y. Yoon, D. L. Trumper, "Friction modeling, identification, and compensation based on friction hysteresis and Dahl
   resonance", Mechatronics 24(6), 2014.
.. [2] M. Shinbrot, "On the analysis of linear and nonlinear systems", Transactions of the ASME 79, 1957.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from bristle.core.least_squares import unbounded
from bristle.core.variable import unit_of
from bristle.identification.parameters import Role, names_of
from bristle.logs.log import Log

if TYPE_CHECKING:
    from bristle.core.contracts import Model
    from bristle.identification.estimate import Estimate

CYCLES = 4.0  # of a window
OF_RATE, PER_OCTAVE = 0.1, 6  # highest frequency over the sampling frequency; frequencies tried
# Least share of the sweep in the motion of a window; most common share of two windows.
PURE, OVERLAP = (0.8, 0.25)
STEPS = 1.2  # encoder steps: smallest amplitude
# Windows; ratio of frequencies; of amplitudes, between quantiles.
FEWEST, SPAN, AMPLITUDES, FADED = (15, 3.0, 1.6, (0.1, 0.9))
NODES, SHRINK = 5, 1.25  # amplitudes with their own loss; between trials of the largest amplitude
MOST_LOSS, SOFTEST = 0.25, 0.65  # of the stiffness, at the largest amplitude: loss and stiffness
DELAYS, DELAY_STEP = (-5.0, 9.0), 0.5  # samples
# Mean, deviation: g_1, g_2, g_3, e, exponent of the hold.
PRIORS = ((1.2, 1.2), (1.5, 2.0), (0.0, 1.0), (0.0, 1.0), (0.5, 0.5))
LOWEST = (1e-3, 0.0, 1e-2, DELAYS[0], 0.0, 0.0, -20.0, -20.0, -1.0)
HIGHEST = (1e3, 1e2, 1e2, DELAYS[1], 20.0, 50.0, 20.0, 20.0, 2.0)
# Windows that share a variance; fits with new weights; smallest relative error of a window.
NEAR, ROUNDS, SURE = (12, 3, 1e-3)
ENCODER = 0.11  # relative error of the gain of an encoder, rms, at an amplitude of one step
MISFIT, WIDEST = 0.15, 0.3  # of the response, rms; relative half-width of a reported stiffness
# Over standard error; relative: mass, damping, stiffness.
FACTORS, SPARE = (np.array([1.9, 1.9, 1.6]), np.array([0.002, 0.004, 0.002]))
APART, LEAST_APART = 1.5, 0.02  # of a contradiction: over the joint half-width, and relative
TINY = float(np.finfo(float).tiny)


class DahlResonance(NamedTuple):
    """Stiffness, damping and mass at the amplitude zero with 95 % half-widths; stiffness and loss over the amplitude; SI."""

    stiffness: float
    stiffness_half_width: float
    damping: float
    damping_half_width: float
    mass: float
    mass_half_width: float
    amplitudes: tuple[float, ...]
    stiffnesses: tuple[float, ...]
    losses: tuple[float, ...]

    def compared_with(
        self, plant: Model, friction: Model, estimates: Sequence[Estimate]
    ) -> tuple[Compared, ...]:
        """Return stiffness and damping of the sweep and of a fit."""
        variables = friction.component.variables
        units = (unit_of("force/length", plant.kind), unit_of("force*time/length", plant.kind))
        viscous = [
            name
            for part in (plant, friction)
            for name in names_of(Role.VISCOUS, part.component.variables)
        ]
        # Viscous friction of two directions counts half each.
        shares = dict.fromkeys(viscous, 1.0 / max(len(viscous), 1)) | dict.fromkeys(
            names_of(Role.MICRO_DAMPING, variables), 1.0
        )
        springs = [
            (item, 1.0)
            for item in estimates
            if item.unit == units[0] and item.name not in plant.values
        ]
        damping = [(item, shares[item.name]) for item in estimates if item.name in shares]
        return (
            Compared(
                "stiffness",
                units[0],
                self.stiffness,
                self.stiffness_half_width,
                *_sum_of(springs[:1]),
            ),
            Compared("damping", units[1], self.damping, self.damping_half_width, *_sum_of(damping)),
        )


class Compared(NamedTuple):
    """A quantity from the sweep and from the fit; None if the model lacks it, or if the log does not determine its half-width."""

    name: str
    unit: str
    value: float
    half_width: float
    fitted: float | None
    fitted_half_width: float | None

    @property
    def differs(self) -> bool:
        """Whether sweep and fit contradict each other."""
        if self.fitted is None or self.fitted_half_width is None:
            return False
        apart = abs(self.value - self.fitted)
        return apart > max(
            APART * math.hypot(self.half_width, self.fitted_half_width),
            LEAST_APART * abs(self.value),
        )


def _sum_of(parts: Sequence[tuple[Estimate, float]]) -> tuple[float | None, float | None]:
    """Return the sum of shares of estimates, and its half-width if the log determines each of them; None without estimates."""
    halves = [
        0.5 * share * (item.ends[1] - item.ends[0]) if item.ends else 0.0 for item, share in parts
    ]
    is_sure = parts and all(item.status in ("identified", "held") for item, _ in parts)
    return (sum(share * item.value for item, share in parts) if parts else None), (
        math.hypot(*halves) if is_sure else None
    )


class _Windows(NamedTuple):
    """Angular frequency, amplitude, response, its acceleration and velocity over position, duration; shape (window,) each."""

    omega: Any
    amplitude: Any
    response: Any
    acceleration: Any
    velocity: Any
    duration: Any

    def part(self, chosen: np.ndarray) -> _Windows:
        return _Windows._make(values[chosen] for values in self)

    @property
    def is_sweep(self) -> bool:
        """Whether the windows have enough frequencies."""
        return len(self.omega) >= FEWEST and bool(np.ptp(np.log(self.omega)) > math.log(SPAN))


def dahl_resonance(
    logs: Sequence[Log], step: float, highest: float = math.inf
) -> DahlResonance | str | None:
    """Return the contact in sweeps of small amplitude, or the reason against it; None if the logs have no such sweeps.

    `step` is that of the encoder [m or rad], and `highest` the highest frequency [Hz] at which the axis is one mass.
    """
    dt, fields = float(logs[0].sample_time), [np.empty((6, 0), complex)]
    for log in logs:
        assert log.effort is not None
        parts = log.segments or (slice(0, len(log)),)
        fields += [
            _windows_of(
                log.position.values[part], log.effort.values[part], float(log.sample_time), step
            )
            for part in parts
        ]
    omega, amplitude, *ratios, duration = np.concatenate(fields, axis=1)
    windows = _before_sliding(
        _Windows._make([omega.real, amplitude.real, *ratios, duration.real]), dt
    )
    if windows is None:
        return None
    windows = windows.part(windows.omega <= 2.0 * math.pi * highest)
    if not windows.is_sweep:
        return f"the load is coupled elastically, and the sweep has too few frequencies below {highest:.3g} Hz"
    return _Fit(windows, dt, step).result


def _windows_of(position: np.ndarray, effort: np.ndarray, dt: float, step: float) -> np.ndarray:
    """Return the windows of a stretch in which the motion is a sweep, with little overlap, shape (field, window)."""
    rows, halved = [(np.empty((6, 0), complex), np.empty(0, int), np.empty(0))], 1
    lengths = [
        math.ceil(CYCLES / OF_RATE * 2.0 ** (part / PER_OCTAVE)) for part in range(PER_OCTAVE)
    ]
    moved, pulled = position - position[:1], effort
    while moved.size >= lengths[0]:
        for length in (length for length in lengths if length <= moved.size):
            positions, efforts = (
                sliding_window_view(signal, length)[:: length // 3] for signal in (moved, pulled)
            )
            fields, share = _projected(positions, efforts, halved * dt)
            chosen = (share > PURE) & (fields[1].real > STEPS * step)
            rows.append(
                (fields[:, chosen], halved * (length // 3) * np.flatnonzero(chosen), share[chosen])
            )
        # The mean of two samples acts on both signals and leaves their ratio as it is.
        moved, pulled = (0.5 * (signal[:-1:2] + signal[1::2]) for signal in (moved, pulled))
        halved *= 2
    candidates, begin, share = (np.concatenate(parts, axis=-1) for parts in zip(*rows, strict=True))
    ends = begin + np.round(candidates[5].real / dt).astype(int)
    covered, places = np.zeros(position.size, bool), list[int]()
    for place in np.argsort(-share):
        if covered[begin[place] : ends[place]].mean() <= OVERLAP:
            covered[begin[place] : ends[place]] = True
            places.append(int(place))
    return candidates[:, sorted(places, key=begin.__getitem__)]


def _projected(
    position: np.ndarray, effort: np.ndarray, dt: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return windows, shape (field, window), and the share of the sweep in their motion, from signals of shape (window, sample)."""
    count, length = position.shape
    t, span = (np.arange(length) - 0.5 * (length - 1)) * dt, length * dt
    turn, omega = 2.0 * math.pi / span, 2.0 * math.pi * CYCLES / span
    w, w_1, w_2 = (
        0.5 + 0.5 * np.cos(turn * t),
        -0.5 * turn * np.sin(turn * t),
        -0.5 * turn**2 * np.cos(turn * t),
    )
    # Derivatives of weight times harmonic.
    tests = (
        np.stack([w, 1j * omega * w - w_1, w_2 - 2j * omega * w_1 - omega**2 * w], axis=1)
        * np.exp(-1j * omega * t)[:, None]
    )
    line = np.stack([w, w * t], axis=1) / np.array([w.sum(), (w * t) @ t])
    moved, pulled = (signal - signal[:, :1] for signal in (position, effort))
    drift = moved @ line
    moved, pulled = (
        signal - signal @ line @ np.stack([np.ones_like(t), t]) for signal in (moved, pulled)
    )
    harmonics = moved @ tests
    first = np.where(harmonics[:, 0] == 0.0, 1.0, harmonics[:, 0])
    amplitude = 2.0 * np.abs(harmonics[:, 0]) / w.sum()
    share = 0.5 * amplitude**2 * w.sum() / np.maximum(moved**2 @ w, TINY)
    ratios = pulled @ tests[:, 0] / first, harmonics[:, 2] / first, harmonics[:, 1] / first
    fields = np.stack([np.full(count, omega, complex), amplitude, *ratios, np.full(count, span)])
    return fields, np.where(np.abs(drift[:, 1]) * span > amplitude, 0.0, share)


def _before_sliding(windows: _Windows, dt: float) -> _Windows | None:
    """Return the windows with amplitudes at which the contact is a spring; None without a sweep of several amplitudes."""
    # A sweep of one amplitude fades in and out.
    while windows.is_sweep and np.ptp(np.quantile(np.log(windows.amplitude), FADED)) > math.log(
        AMPLITUDES
    ):
        _, (_, _, stiffness, change, loss) = _rough(windows, dt)
        if (
            stiffness > 0.0
            and stiffness + change > SOFTEST * stiffness
            and loss < MOST_LOSS * stiffness
        ):
            return windows
        windows = windows.part(windows.amplitude <= np.max(windows.amplitude) / SHRINK)
    return None


def _rough(windows: _Windows, dt: float) -> tuple[float, np.ndarray]:
    """Return delay, mass, damping, stiffness, and changes of stiffness and loss up to the largest amplitude, by linear least squares."""
    share, ones = windows.amplitude / np.max(windows.amplitude), np.ones_like(windows.amplitude)
    columns = np.stack([windows.acceleration, windows.velocity, ones, share, 1j * share], axis=1)
    scale, trials = np.mean(np.abs(columns), axis=0), list[tuple[float, float, np.ndarray]]()
    A = _first_weight(windows)[:, None] * columns / scale
    A = np.concatenate([A.real, A.imag])
    for delay in np.arange(*DELAYS, DELAY_STEP) * dt:
        b = _first_weight(windows) * windows.response * np.exp(1j * windows.omega * delay)
        b = np.concatenate([b.real, b.imag])
        solution = unbounded(A, b)
        trials.append((float(np.sum((A @ solution - b) ** 2)), float(delay), solution / scale))
    return min(trials, key=lambda trial: trial[0])[1:]


def _first_weight(windows: _Windows) -> np.ndarray:
    return np.sqrt(windows.duration) / (
        np.abs(windows.response) + np.median(np.abs(windows.response))
    )


class _Fit:
    """The fit of the response. Point, relative: mass, damping, stiffness, delay, g_1, g_2, g_3, e, exponent of the hold, losses."""

    def __init__(self, windows: _Windows, dt: float, step: float) -> None:
        delay, (mass, damping, stiffness, _, loss) = _rough(windows, dt)
        self.windows, self.dt, self.weight = windows, dt, _first_weight(windows)
        pace, size = float(np.exp(np.mean(np.log(windows.omega)))), np.log(windows.amplitude)
        self.scales = np.array([stiffness / pace**2, stiffness / pace, stiffness])
        self.nodes, self.pace = (
            np.linspace(np.quantile(size, 0.02), np.quantile(size, 0.98), NODES),
            windows.omega / pace,
        )
        self.hats = np.stack([np.interp(size, self.nodes, unit) for unit in np.eye(NODES)], axis=1)
        # The gain of the encoder has an error that decreases with A^-3/2 and is common to windows of one amplitude.
        self.gains = self.hats * (ENCODER * (step / windows.amplitude) ** 1.5)[:, None]
        losses = max(loss / stiffness, 0.01) * np.exp(self.nodes - self.nodes[-1])
        self.start = np.array(
            [
                *(np.array([mass, damping, stiffness]) / self.scales),
                delay / dt,
                *(mean for mean, _ in PRIORS),
                *losses,
            ]
        )
        self.bounds = np.array([*LOWEST, *np.zeros(NODES)]), np.array([*HIGHEST, *np.ones(NODES)])

    def _stiffness(self, point: np.ndarray, loss: np.ndarray) -> np.ndarray:
        """Return the stiffness at a loss, both over the scale."""
        return point[2] * (1.0 - point[4] * loss - point[5] * loss**2)

    def _response(self, point: np.ndarray) -> np.ndarray:
        loss, windows = self.hats @ point[9:], self.windows
        stiffness = self._stiffness(point, loss) + point[2] * loss * (1j - point[6] * self.pace)
        parts = (
            point[0] * windows.acceleration,
            (point[1] + point[7] * point[2] * loss) * windows.velocity,
            stiffness,
        )
        hold = point[8] * np.log(np.sinc(0.5 / np.pi * self.dt * windows.omega))
        return sum(scale * part for scale, part in zip(self.scales, parts, strict=True)) * np.exp(
            -1j * self.dt * point[3] * windows.omega - hold
        )

    def _residual(self, point: np.ndarray) -> np.ndarray:
        left = self.weight * (self._response(point) - self.windows.response)
        priors = [
            (value - mean) / deviation
            for value, (mean, deviation) in zip(point[4:9], PRIORS, strict=True)
        ]
        return np.concatenate([left.real, left.imag, priors])

    def _solved(self, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the point and the slope of the residual there."""
        from scipy.optimize import least_squares

        low, high = self.bounds
        margin = 1e-6 * (high - low)
        ended: Any = least_squares(
            self._residual,
            np.clip(start, low + margin, high - margin),
            bounds=self.bounds,
            x_scale="jac",
            max_nfev=200,
        )
        return ended.x, ended.jac

    def _reweighted(self, point: np.ndarray) -> np.ndarray:
        """Return weights from the residuals of windows of about the same frequency and amplitude."""
        left = np.abs(self._response(point) - self.windows.response) ** 2 * self.windows.duration
        place = np.log(self.windows.omega) + 1j * np.log(self.windows.amplitude)
        near = np.argsort(np.abs(place[:, None] - place), axis=1)[:, :NEAR]
        least = (SURE * np.abs(self.windows.response)) ** 2 * self.windows.duration
        return np.sqrt(self.windows.duration / (0.5 * left[near].mean(axis=1) + least))

    @property
    def result(self) -> DahlResonance | str:
        """The contact, or the reason why the sweep does not show it."""
        point, slope = self._solved(self.start)
        for _ in range(ROUNDS):
            self.weight = self._reweighted(point)
            point, slope = self._solved(point)
        misfit = math.sqrt(
            float(np.mean(np.abs(self._response(point) / self.windows.response - 1.0) ** 2))
        )
        if misfit > MISFIT:
            return (
                f"the response is not that of one mass on a spring (misfit {100.0 * misfit:.0f} %)"
            )
        widths, values = self.scales * self._errors(point, slope), self.scales * point[:3]
        if widths[2] > WIDEST * values[2]:
            return f"the sweep determines the stiffness only within {100.0 * widths[2] / values[2]:.0f} %"
        pairs = [float(number) for place in (2, 1, 0) for number in (values[place], widths[place])]
        curves = (
            np.exp(self.nodes),
            self.scales[2] * self._stiffness(point, point[9:]),
            values[2] * point[9:],
        )
        return DahlResonance._make([*pairs, *(tuple(curve.tolist()) for curve in curves)])

    def _errors(self, point: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """Return half-widths of mass, damping and stiffness, from the scatter of the windows and the error of the encoder."""
        count = len(self.weight)
        inverse = np.linalg.pinv(slope.T @ slope, rcond=1e-12)
        scores, priors = (
            slope[: 2 * count] * self._residual(point)[: 2 * count, None],
            slope[2 * count :],
        )
        scores = (scores[:count] + scores[count:]) * math.sqrt(
            count / max(count - 0.5 * len(point), 1.0)
        )
        changes = (self.weight * self._response(point))[:, None] * self.gains
        pulls = slope[: 2 * count].T @ np.concatenate([changes.real, changes.imag])
        cover = inverse @ (scores.T @ scores + priors.T @ priors + pulls @ pulls.T) @ inverse
        return FACTORS * np.sqrt(np.maximum(np.diag(cover)[:3], 0.0)) + SPARE * point[:3]
