r"""An elastic coupling between motor and load, identified from the frequency response of the motor before any friction model.

A motor :math:`m_1` that moves a load :math:`m_2` through a spring answers an effort `u` with the acceleration `a`

.. math:: \frac{a}{u} = \frac{1}{M}\left[1 + \kappa\,\frac{s^2}{s^2 + 2 \zeta \omega_r s + \omega_r^2}\right] e^{s \tau}, \qquad
   M = m_1 + m_2, \quad \kappa = \frac{m_2}{m_1}, \quad \omega_a = \frac{\omega_r}{\sqrt{1 + \kappa}} .

It has an antiresonance at :math:`\omega_a` and a resonance at :math:`\omega_r`. A term :math:`1/s` stands for viscous
friction. A power `h` of :math:`\sin(x)/x`, with :math:`x = \pi f \Delta t`, stands for the effort between two samples: the
recorder holds it (`h = 1`), samples it (0) or averages it (-1). The response is estimated from slides: motions in one
direction, in which friction is almost constant. Around reversals friction is neither constant nor linear, and a contact
with pre-sliding has a resonance, too.

The spectra are averaged over all slides (Welch [1]_). Bins within 2 % of a frequency share one cross-spectrum, and bins
within 8 % one variance. Noise of the effort, white, attenuates the response, as in any regression on a noisy signal. The part of
the effort that the acceleration does not explain is at least this noise: its minimum over the frequencies is the noise, and
the spectrum of the effort loses it [3]_. For each resonance the response is linear in all other parameters (variable
projection [2]_) except damping, delay and hold, which a simplex search refines. A rigid axis with a lag of second order is the
alternative. A resonance is that of the whole log, or of two parts that agree. The part with the smallest standard errors
determines its values; the scatter over the parts is the error of the model.

Up to a frequency `f` the motor feels the mass :math:`M (1 + \mu r^2 / (1 - r^2))`, with :math:`r = f / f_a` and the share
:math:`\mu` of the load in the mass. Where the excess is below 2 %, the axis is one mass.

References
----------
.. [1] P. D. Welch, "The use of fast Fourier transform for the estimation of power spectra", IEEE Transactions on Audio
   and Electroacoustics 15(2), 1967. doi:10.1109/TAU.1967.1161901
.. [2] G. H. Golub, V. Pereyra, "The differentiation of pseudo-inverses and nonlinear least squares problems whose
   variables separate", SIAM Journal on Numerical Analysis 10(2), 1973. doi:10.1137/0710036
.. [3] T. Söderström, "Errors-in-variables methods in system identification", Automatica 43(6), 2007.
   doi:10.1016/j.automatica.2006.11.025
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.identification.dataset import Alignment, effort_of
from bristle.identification.preprocessing import step_of
from bristle.logs.filters import derivative, low_passed
from bristle.logs.log import Log
from bristle.logs.turns import runs

# s: of a slide; slides; tapered share of a slide
LONGEST, SHORTEST, FEWEST, TAPER = (8.0, 0.4, 3, 1.0)
PERIODS = 4.0  # of a frequency in a slide that determines its response
# Hz: low-pass of the speed; of the top speed, and encoder steps: smallest slide.
SIDES, BRISK, STEPS = (60.0, 0.03, 10.0)
# Hz; Hz; of the sampling frequency; Hz: of an antiresonance.
SLOWEST, FASTEST, OF_RATE, LOWEST = (3.0, 500.0, 0.25, 5.0)
# Of a group of bins; of pooled variances; model error as a share of the acceleration.
WIDTH, POOLED, MISFIT = (0.02, 0.08, 0.03)
LATE, EARLY, DELAY_STEP = 12e-3, 4e-3, 1e-4  # s: search range of the delay
# Of the scan: frequency, damping; s: delays around the first.
STEP, DAMPINGS, AROUND = (0.015, (0.02, 0.08), (-6e-4, 0.0, 6e-4))
DAMPED, RATIOS = (2e-3, 0.3), (0.05, 8.0)  # damping of a resonance; load over motor
BAND = 1.5  # around antiresonance and resonance
# Of a clear resonance: squared deviation; shares; error.
LEAST_GAIN, LEAST_SHARE, LEAST_EXPLAINED, MOST_ERROR = (60.0, 0.2, 0.3, 0.02)
# Of the slides
PARTS = ((0.0, 0.5), (0.5, 1.0), (0.0, 0.34), (0.33, 0.67), (0.66, 1.0), (0.25, 0.75))
# Largest ratio of the frequency in a part to that in the whole log, and to that in another; parts.
ALIKE, AGREE, AGREEING = (1.6, 1.05, 2)
# Of the intervals: factors of the standard error, and of the scatter over the parts.
STUDENT, SPREAD = (4.0, 2.0)
SPARE, SPARE_DELAY = 0.004, 0.1  # of the intervals: smallest relative half-width; in samples
ONE_MASS = 0.02  # largest relative excess of the mass that the motor of one mass feels
HOLDS = (-1.5, 1.5)  # exponent of the hold
LEAST_CLEAN, LEAST_ROWS = 0.05, 50.0  # of the effort, power without noise; rows of a level of noise
BEHIND = 0.05  # of the mass: error of the inertia of a whole log by friction behind a spring
TINY = float(np.finfo(float).tiny)
# Places of the quantities in the values of two masses.
M_1, M_2, KAPPA, DAMPING, VISCOUS_1, VISCOUS_2, DELAY, FRICTION_1, FRICTION_2 = range(9)


class Masses(NamedTuple):
    """Motor, load, load over stiffness, damping over stiffness, and delay of the effort, with standard errors; and the stiffness."""

    values: np.ndarray
    errors: np.ndarray
    stiffness: float
    stiffness_error: float

    @property
    def damping(self) -> float:
        """Damping of the coupling [N*s/m or N*m*s/rad]."""
        return self.stiffness * float(self.values[DAMPING])

    @property
    def delay(self) -> float:
        """Delay of the effort [s]."""
        return float(self.values[DELAY])


class Elastic(NamedTuple):
    """An elastic coupling: antiresonance and resonance [Hz], load over motor, sum of the masses [kg or kg*m^2], delay of the effort [s]."""

    antiresonance: float
    antiresonance_half_width: float
    resonance: float
    resonance_half_width: float
    inertia_ratio: float
    inertia_ratio_half_width: float
    mass: float
    mass_half_width: float
    delay: float
    delay_half_width: float
    masses: Masses | str = ""  # of motor and load, or the reason why the log does not show them

    @property
    def facts(self) -> dict[str, float]:
        """Antiresonance and resonance [Hz] and the ratio of inertias, each with its 95 % half-width."""
        return dict(list(self._asdict().items())[:6])

    @property
    def load(self) -> float:
        """Mass of the load [kg or kg*m^2]."""
        return self.mass * self.inertia_ratio / (1.0 + self.inertia_ratio)

    @property
    def one_mass(self) -> float:
        """Highest frequency [Hz] at which the axis is one mass."""
        return below_resonance(self.antiresonance, self.inertia_ratio)


def below_resonance(antiresonance: float, inertia_ratio: float) -> float:
    """Return the highest frequency [Hz] at which an axis with this antiresonance [Hz] is one mass."""
    return antiresonance * math.sqrt(ONE_MASS / (inertia_ratio / (1.0 + inertia_ratio) + ONE_MASS))


def elastic_coupling(logs: Sequence[Log], axes: Sequence[Axis | None]) -> Elastic | None:
    """Return the elastic coupling that logs of one axis show, or None."""
    log, resonances = motor_spectra(logs, axes), list[_Resonance]()
    if log is None:
        return None
    of_log, time = _Search(log).resonance, np.cumsum(log.lengths) / np.sum(log.lengths)
    for start, end in PARTS:
        inside = (time > start - 1e-9) & (time < end + 1e-9)
        if np.count_nonzero(inside) >= FEWEST:
            part = _Search(
                log._replace(slides=log.slides[inside], lengths=log.lengths[inside])
            ).resonance
            if part is not None:
                resonances.append(part)
    centre = of_log or min(resonances, key=attrgetter("error"), default=None)
    if centre is None:
        return None
    resonances = [
        part
        for part in resonances
        if abs(part.values[0] - centre.values[0]) < math.log(ALIKE if of_log else AGREE)
    ]
    if of_log is None and len(resonances) < AGREEING:
        return None
    if of_log is not None:
        resonances.append(of_log)
    best = min(resonances, key=attrgetter("error"))
    weights = np.maximum([part.errors for part in resonances], 1e-6) ** -2.0
    spread = np.sqrt(
        np.sum(
            weights * (np.array([part.values for part in resonances]) - best.values) ** 2, axis=0
        )
        / np.sum(weights, axis=0)
    )
    errors = np.hypot(STUDENT * best.errors, SPREAD * spread)
    values = np.append(np.exp(best.values[:4]), 1e-3 * best.values[4])
    widths = np.append(
        values[:4] * (errors[:4] + SPARE), 1e-3 * errors[4] + SPARE_DELAY * logs[0].sample_time
    )
    return Elastic._make(
        [*(float(number) for pair in zip(values, widths, strict=True) for number in pair), ""]
    )


def one_mass(alignment: Alignment, coupling: Elastic | None) -> Alignment:
    """Return the alignment of an axis; that of an elastic axis has the more precise sum of the masses, and the delay of the response."""
    if coupling is None:
        return alignment
    mass, width = alignment.mass, alignment.mass_half_width
    if mass is None or width is None or coupling.mass_half_width < width + BEHIND * mass:
        mass, width = coupling.mass, coupling.mass_half_width
    else:
        width += ONE_MASS * mass
    alignment = replace(alignment, mass=mass, mass_half_width=width)
    late = (
        {"delay": coupling.delay, "delay_half_width": coupling.delay_half_width}
        if alignment.delay is not None
        else {}
    )
    return replace(alignment, slow=alignment.slow or coupling.one_mass, **late)


class _Resonance(NamedTuple):
    """Logarithms of antiresonance, resonance, load over motor and sum of the masses, and the delay [ms], with their standard errors."""

    values: np.ndarray
    errors: np.ndarray

    @property
    def error(self) -> float:
        return float(np.hypot(*self.errors[:2]))


class _Spectra(NamedTuple):
    """Cross spectra of acceleration and effort of each slide in groups of bins, shape (slide, group, signal, signal)."""

    frequency: np.ndarray  # of each group [Hz]
    bins: np.ndarray  # of each group
    slides: np.ndarray
    lengths: np.ndarray  # of each slide, in lengths of the transform
    highest: float  # Hz
    scale: float  # of the effort over that of the acceleration
    dt: float

    @property
    def response(self) -> _Response:
        """The response over all slides, with weights from its variance around each frequency."""
        apart = np.abs(np.subtract.outer(*[np.log(self.frequency)] * 2))
        near = (apart < POOLED).astype(float)
        rows = (
            self.lengths[:, None]
            * self.bins
            * (self.frequency * LONGEST * self.lengths[:, None] > PERIODS)
        )
        total, rows = (
            np.einsum("sg,sgij->gij", (rows > 0.0).astype(float), self.slides),
            rows.sum(axis=0),
        )
        signals, cross = (
            np.maximum(np.real(np.diagonal(total, axis1=1, axis2=2)).T, TINY),
            total[:, 1, 0],
        )
        # The part of each signal that the other one does not explain.
        left = np.maximum(signals - np.abs(cross) ** 2 / signals[::-1], 0.0) / np.maximum(
            1.0 - 1.0 / np.maximum(rows, 1.0), 0.1
        )
        weight = near @ rows / np.maximum(near @ left[0] + MISFIT**2 * (near @ signals[0]), TINY)
        coherence = 1.0 - np.clip(
            near @ (weight * left[0]) / np.maximum(near @ (weight * signals[0]), TINY), 0.0, 1.0
        )
        wide = (apart < 2.0 * POOLED).astype(float)
        levels = (wide @ left[1])[wide @ rows > LEAST_ROWS] / (wide @ rows)[
            wide @ rows > LEAST_ROWS
        ]
        clean = np.maximum(
            signals[1] - np.min(levels, initial=np.inf if levels.size else 0.0) * rows,
            LEAST_CLEAN * signals[1],
        )
        sinc = np.log(np.sinc(self.frequency * self.dt))
        square, power = weight * signals
        return _Response(
            self.frequency, square, power, weight * clean, weight * cross, rows, coherence, sinc
        )


@dataclass(frozen=True)
class _Response:
    """Weighted squares of acceleration, effort and effort without noise, their cross spectrum, rows and coherence, shape (group,)."""

    frequency: np.ndarray
    square: np.ndarray
    power: np.ndarray
    clean: np.ndarray
    cross: np.ndarray
    rows: np.ndarray
    coherence: np.ndarray
    sinc: np.ndarray  # logarithm of the gain of a hold

    @property
    def delay(self) -> float:
        """Delay of the effort [s] from the phase of the squared response, in which antiresonances cancel."""
        phase = (self.cross / np.maximum(np.abs(self.cross), TINY)) ** 2
        weight = (
            np.gradient(self.frequency) * np.where(self.coherence > 0.5, self.coherence, 0.0) ** 2
        )
        delays = np.arange(-EARLY, LATE, DELAY_STEP)
        return float(
            delays[
                np.argmax(
                    (np.exp(-4j * np.pi * np.outer(delays, self.frequency)) @ (weight * phase)).real
                )
            ]
        )

    def fitted(
        self, delay: float, *shapes: np.ndarray, hold: float = 0.0, clean: bool = False
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return factors, shape (trial, shape), and explained squares, shape (trial,), of shapes of shape (trial, group)."""
        power = (self.clean if clean else self.power) * np.exp(2.0 * hold * self.sinc)
        cross = self.cross * np.exp(hold * self.sinc - 2j * np.pi * self.frequency * delay)
        stacked = np.stack(np.broadcast_arrays(*shapes), axis=1)
        normal = np.real((stacked.conj() * power) @ np.swapaxes(stacked, 1, 2))
        right = np.real(stacked.conj() @ cross)
        scale = np.sqrt(np.maximum(np.diagonal(normal, axis1=1, axis2=2), TINY))
        normal = normal / scale[:, :, None] / scale[:, None, :] + 1e-9 * np.eye(len(shapes))
        factors = np.linalg.solve(normal, (right / scale)[..., None])[..., 0]
        return factors / scale, np.sum(factors * right / scale, axis=1)

    def left(
        self, delay: float, factors: np.ndarray, *shapes: np.ndarray, hold: float = 0.0
    ) -> np.ndarray:
        """Return the weighted squares that a fit leaves in each group, shape (group,)."""
        gain = sum(
            factor * shape[0] for factor, shape in zip(factors, shapes, strict=True)
        ) * np.exp(hold * self.sinc + 2j * np.pi * self.frequency * delay)
        return (
            self.square - 2.0 * np.real(np.conj(gain) * self.cross) + np.abs(gain) ** 2 * self.power
        )

    def elastic(self, resonance: np.ndarray, damping: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return the shapes of an elastic axis for some resonances [Hz], shape (trial, group)."""
        relative = self.frequency / resonance[:, None]
        resonant = -(relative**2) / (1.0 - relative**2 + 2j * damping[:, None] * relative)
        return np.ones((1, 1)), resonant, 1.0 / (2j * np.pi * self.frequency[None])

    def rigid(self) -> tuple[np.ndarray, ...]:
        """Return the shapes of a rigid axis with a lag."""
        relative = 2j * np.pi * self.frequency[None] / FASTEST
        return np.ones_like(relative), relative, relative**2, 1.0 / relative


class _Search:
    """The search for a resonance; a point: logarithms of resonance [Hz] and damping, delay [ms], exponent of the hold."""

    def __init__(self, spectra: _Spectra) -> None:
        self.response, self.highest, self.scale = (
            spectra.response,
            spectra.highest / 1.05,
            spectra.scale,
        )

    def _fitted(self, point: np.ndarray, *, clean: bool = True) -> tuple[np.ndarray, float]:
        shapes = self.response.elastic(np.exp(point[:1]), np.exp(point[1:2]))
        factors, squares = self.response.fitted(
            1e-3 * point[2], *shapes, hold=float(point[3]), clean=clean
        )
        return factors[0], float(squares[0])

    def _values(self, point: np.ndarray) -> np.ndarray:
        factors, _ = self._fitted(point)
        ratio = min(max(float(factors[1] / factors[0]), 1e-3), 1e3)
        mass = math.log(self.scale / max(float(factors[0]), 1e-9))
        return np.array(
            [point[0] - 0.5 * math.log(1.0 + ratio), point[0], math.log(ratio), mass, point[2]]
        )

    @property
    def _start(self) -> np.ndarray | None:
        """The best point of a scan."""
        frequencies = np.exp(np.arange(math.log(1.02 * LOWEST), math.log(self.highest), STEP))
        resonances, dampings = (
            np.repeat(frequencies, len(DAMPINGS)),
            np.tile(DAMPINGS, frequencies.size),
        )
        shapes, best, most = self.response.elastic(resonances, dampings), None, 0.0
        for delay in self.response.delay + np.array(AROUND):
            factors, squares = self.response.fitted(delay, *shapes)
            ratios = factors[:, 1] / np.where(factors[:, 0] > 0.0, factors[:, 0], np.inf)
            squares = np.where((ratios > RATIOS[0]) & (ratios < RATIOS[1]), squares, 0.0)
            place = int(np.argmax(squares))
            if squares[place] > most:
                most, best = (
                    float(squares[place]),
                    np.array(
                        [math.log(resonances[place]), math.log(dampings[place]), 1e3 * delay, 0.0]
                    ),
                )
        return best

    @property
    def resonance(self) -> _Resonance | None:
        """The resonance, if it is clear."""
        from scipy.optimize import minimize

        start, response = self._start, self.response
        if start is None:
            return None
        bounds = [
            (start[0] - 0.7, start[0] + 0.7),
            (math.log(DAMPED[0]), math.log(1.5 * DAMPED[1])),
            (-2e3 * EARLY, 2e3 * LATE),
            HOLDS,
        ]
        options = {
            "initial_simplex": np.vstack([start, start + np.diag([0.02, 0.5, 0.3, 0.3])]),
            "xatol": 1e-4,
            "fatol": 1e-3,
            "maxfev": 400,
        }
        best = np.asarray(
            minimize(
                lambda point: -self._fitted(point)[1],
                start,
                method="Nelder-Mead",
                bounds=bounds,
                options=options,
            ).x
        )
        (factors, _), values, damping = self._fitted(best), self._values(best), math.exp(best[1])
        antiresonance, resonance, ratio = np.exp(values[:3]).tolist()
        in_range = antiresonance > LOWEST and resonance < self.highest
        if not (
            in_range
            and factors[0] > 0.0
            and RATIOS[0] < ratio < RATIOS[1]
            and 1.1 * DAMPED[0] < damping < DAMPED[1]
        ):
            return None
        # Whether the resonance is clear is a question to the raw spectra, whose residual is least.
        factors, _ = self._fitted(best, clean=False)
        elastic = response.left(
            1e-3 * best[2],
            factors,
            *response.elastic(np.exp(best[:1]), np.exp(best[1:2])),
            hold=float(best[3]),
        )
        fits = [
            (delay, *response.fitted(delay, *response.rigid()))
            for delay in response.delay + np.arange(-30, 31, 3) * DELAY_STEP
        ]
        delay, factors, _ = max(fits, key=lambda fit: float(fit[2][0]))
        rigid = response.left(delay, factors[0], *response.rigid())
        band = (response.frequency > antiresonance / BAND) & (response.frequency < BAND * resonance)
        before, after, total, rows = (
            float(np.sum(part[band])) for part in (rigid, elastic, response.square, response.rows)
        )
        clear = (before - after) * rows > LEAST_GAIN * after and after < (
            1.0 - LEAST_SHARE
        ) * before
        if not clear or after > (1.0 - LEAST_EXPLAINED) * total or np.sum(elastic) > np.sum(rigid):
            return None
        errors = self._errors(best) * math.sqrt(max(after / rows, 1.0))
        return _Resonance(values, errors) if float(np.max(errors[:2])) < MOST_ERROR else None

    def _errors(self, best: np.ndarray) -> np.ndarray:
        """Return the standard errors of the values, from the curvature of the explained squares."""
        steps, curvature = np.diag([2e-3, 0.05, 0.02, 0.05]), np.empty((4, 4))
        for n, step in enumerate(steps):
            for m, step_2 in enumerate(steps):
                corners = [
                    i * j * self._fitted(best + i * step + j * step_2)[1]
                    for i in (1, -1)
                    for j in (1, -1)
                ]
                curvature[n, m] = -sum(corners) / (4.0 * step[n] * step_2[m])
        slope = np.array(
            [
                (self._values(best + step) - self._values(best - step)) / (2.0 * step[n])
                for n, step in enumerate(steps)
            ]
        )
        # The log-likelihood of complex rows is minus the squares.
        return np.sqrt(np.maximum(np.diag(slope.T @ np.linalg.pinv(curvature) @ slope), 0.0))


def starts_of_groups(frequency: np.ndarray, width: float) -> list[int]:
    """Return the first place of each group of rising frequencies, whose last exceeds its first by at most a relative width."""
    starts = [0]
    for place, hertz in enumerate(frequency.tolist()):
        if hertz > (1.0 + width) * frequency[starts[-1]]:
            starts.append(place)
    return starts


def motor_spectra(logs: Sequence[Log], axes: Sequence[Axis | None]) -> _Spectra | None:
    """Return the spectra of all slides; None if the logs have too few."""
    from scipy.signal.windows import tukey

    dt = float(logs[0].sample_time)
    highest = min(OF_RATE / dt, FASTEST)
    if highest < 2.0 * LOWEST:
        return None
    size = round(LONGEST / dt)
    frequency = np.fft.rfftfreq(size, dt)
    inside = (frequency > SLOWEST) & (frequency < highest)
    frequency = frequency[inside]
    starts = starts_of_groups(frequency, WIDTH)
    # The gain of the second derivative over that of the second difference.
    exact = (2.0 * np.pi * frequency * dt) ** 2 / (2.0 - 2.0 * np.cos(2.0 * np.pi * frequency * dt))
    slides, lengths = list[np.ndarray](), list[float]()
    for log, axis in zip(logs, axes, strict=True):
        for position, effort in _slides(log, axis):
            signals = np.stack(
                [(position[2:] - 2.0 * position[1:-1] + position[:-2]) / dt**2, effort[1:-1]]
            )
            signals = tukey(signals.shape[1], TAPER) * (
                signals - signals.mean(axis=1, keepdims=True)
            )
            spectrum = np.fft.rfft(signals, size)[:, inside]
            spectrum[0] *= exact
            slides.append(
                np.add.reduceat(
                    spectrum.conj()[:, None] * spectrum[None], starts, axis=2
                ).transpose(2, 0, 1)
            )
            lengths.append((1.0 - 0.5 * TAPER) * signals.shape[1] / size)
    if len(slides) < FEWEST:
        return None
    together, bins = np.array(slides), np.diff([*starts, frequency.size])
    scale = np.sqrt(np.maximum(np.real(np.diagonal(together.sum(axis=(0, 1)))), TINY))
    return _Spectra(
        np.add.reduceat(frequency, starts) / bins,
        bins,
        together / scale[:, None] / scale,
        np.array(lengths),
        highest,
        float(scale[1] / scale[0]),
        dt,
    )


def _slides(log: Log, axis: Axis | None) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield position and effort of each slide: a motion in one direction that is not slow."""
    dt, step = log.sample_time, step_of(log, axis)
    longest = round(LONGEST / dt)
    for part in log.segments or (slice(0, len(log)),):
        position, effort, slides = log.position.values[part], effort_of(log)[part], list[slice]()
        if position.size * dt < SHORTEST:
            continue
        smooth = low_passed(position - position[0], min(0.1 / dt, SIDES), dt)
        velocity = derivative(smooth, dt)
        least = BRISK * float(np.quantile(np.abs(velocity), 0.99))
        for run in (*runs(velocity > least), *runs(velocity < -least)):
            if abs(smooth[run.stop - 1] - smooth[run.start]) > STEPS * step:
                slides += [
                    slice(first, min(first + longest, run.stop))
                    for first in range(run.start, run.stop, longest)
                ]
        for slide in sorted(slides, key=attrgetter("start")):
            if (slide.stop - slide.start) * dt > SHORTEST:
                yield position[slide], effort[slide]
