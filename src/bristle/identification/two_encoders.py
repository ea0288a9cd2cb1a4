r"""Two masses behind an elastic coupling, identified from the positions of motor and load and the effort.

.. math::
    u(t + \tau) = m_1 \ddot x_1 + m_2 \ddot x_2 + F_1 + F_2 + c_T |f_s| \operatorname{sgn} \dot x_1, \qquad
    \delta + t_d \dot\delta = \kappa \ddot x_2 + F_2 / k, \qquad \delta = D_g(x_1 - x_2), \quad \kappa = m_2 / k, \quad t_d = d / k

Both equations hold in slides, motions of both masses in one direction. There, friction is a constant, a viscous term and a
term that fades with the speed. The taper of a slide removes the constant. The friction of a nut grows with the force
:math:`f_s = k \delta` of the coupling. Its coefficient comes from the lost motion: in slides it resembles a larger load.
Encoder noise disturbs all regressors: with the covariance :math:`N` of the noise of both encoders, which the highest
frequencies show, the covariance of the residuals is a function of the parameters,

.. math:: \min_\theta \sum_f e(f)^H C(\theta, f)^{-1} e(f), \qquad C = H(\theta)\, N\, H(\theta)^H + Q,

the maximum-likelihood estimate of errors in variables [1]_. `Q` is the covariance of the residuals that the encoders do
not explain. Frequencies at which noise dominates an equation do not determine it. The second equation has the
displacement as its unit, so that a smaller stiffness does not shrink its residual. Standard errors come from a jackknife
over blocks of slides.

References
----------
.. [1] R. Pintelon, J. Schoukens, "System Identification: A Frequency Domain Approach", 2nd ed., Wiley, 2012, chapter 8.
   doi:10.1002/9781118287422
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, ClassVar, NamedTuple, cast

import numpy as np

from bristle.core.errors import InputError
from bristle.core.least_squares import normal
from bristle.identification.elasticity import (
    DAMPING,
    DELAY,
    FRICTION_1,
    FRICTION_2,
    KAPPA,
    M_1,
    M_2,
    TINY,
    VISCOUS_1,
    VISCOUS_2,
    Masses,
    starts_of_groups,
)
from bristle.logs.filters import low_passed
from bristle.logs.turns import runs

# Hz: low-pass of speeds; of the top speed, and encoder steps: smallest slide.
SIDES, FADING, BRISK, STEPS = (60.0, 150.0, 0.03, 30.0)
FADES = 0.1  # of the top speed: decay of friction that fades
FASTEST, NOISE_BAND = 500.0, (0.42, 0.49)  # Hz; of the sampling frequency
# Of a group of bins; of pooled variances; Hz: highest frequency of the first fit.
WIDTH, POOLED, SEARCHED = (0.04, 0.15, 80.0)
# Share of noise above which a frequency counts less; least residual, of the signal.
NOISY, FLOOR = (0.15, 1e-5)
LATE, EARLY, DELAY_STEP = 8e-3, 4e-3, 2.5e-4  # s: search range of the delay
# Estimates of `Q`; steps; blocks of the jackknife; slides.
PASSES, STEPS_OF_FIT, BLOCKS, FEWEST = (4, 15, 20, 6)
NUDGE = 1e-5  # of a parameter, for a derivative
SIGNALS = 10
EFFORT, A_1, A_2, V_1, V_2, TWIST, TWIST_RATE, FADING_1, FADING_2, NUT = range(SIGNALS)

EXCITE = "Record long strokes with noise or a chirp around antiresonance and resonance"
# Of the intervals: factor of the standard error, smallest relative half-width.
FACTOR, SPARE = (4.0, 0.004)

Dead = Callable[[np.ndarray], np.ndarray]


class Cut(NamedTuple):
    """Slides and their band: longest and shortest [s], tapered share, lowest frequency [Hz], highest of the sampling frequency."""

    longest: float = 1.0
    shortest: float = 0.2
    taper: float = 0.3
    slowest: float = 2.0
    of_rate: float = 0.4


BOTH = Cut()


class Record(NamedTuple):
    """A stretch without a gap: positions of motor and load, effort, and sample time."""

    motor: np.ndarray
    load: np.ndarray
    effort: np.ndarray
    dt: float


class Prior(NamedTuple):
    """Quantities of a fit and the friction of the nut per force of the coupling, from another method, with their standard errors."""

    values: np.ndarray = np.zeros(0)
    errors: np.ndarray = np.zeros(0)
    nut: float = 0.0
    nut_error: float = 0.0

    @property
    def moved(self) -> list[Prior]:
        """The same with each quantity larger by its standard error."""
        values = [self._replace(values=self.values + step) for step in np.diag(self.errors)]
        return [
            *values,
            *([self._replace(nut=self.nut + self.nut_error)] if self.nut_error else []),
        ]


UNKNOWN = Prior()


class Solved(NamedTuple):
    """A solution, the solutions without a block of slides each, and those with a prior that differs by its standard error."""

    point: np.ndarray
    blocks: np.ndarray
    moved: np.ndarray

    def error(self, value: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """Return the standard error of a function of points, from a jackknife and from the priors, which all blocks share."""
        values, count = value(self.blocks), len(self.blocks)
        squares = (count - 1) / count * np.sum((values - values.mean(axis=0)) ** 2, axis=0)
        return np.sqrt(squares + np.sum((value(self.moved) - value(self.point)) ** 2, axis=0))

    @property
    def masses(self) -> Masses:
        """The masses and the stiffness with their standard errors."""

        def stiffness(points: np.ndarray) -> np.ndarray:
            return points[..., M_2] / points[..., KAPPA]

        return Masses(
            self.point,
            self.error(np.asarray),
            float(stiffness(self.point)),
            float(self.error(stiffness)),
        )


@dataclass(frozen=True)
class Spectra:
    """Cross spectra of each slide in groups of bins, shape (slide, group, signal, signal)."""

    frequency: np.ndarray
    bins: np.ndarray
    slides: np.ndarray
    lengths: np.ndarray
    noise: np.ndarray
    dt: float

    def total(self, without: slice | None = None) -> np.ndarray:
        """Return the mean spectra of the slides, for the power of one sample of a taper."""
        used = np.ones(self.lengths.size, dtype=bool)
        if without is not None:
            used[without] = False
        return np.asarray(self.slides[used].sum(axis=0) / self.lengths[used].sum())


def half_width(value: Any, error: Any) -> Any:
    """Return the half-width of the 95 % interval of a value with a standard error."""
    return FACTOR * error + SPARE * abs(value)


def masses_of(
    records: Sequence[Record], step: float, dead: Dead | None = None, prior: Prior = UNKNOWN
) -> Masses | None:
    """Return the masses and the coupling that some records show, or None without twist; `dead` is the dead zone of a known play."""
    twisted = max(float(np.ptp(record.motor - record.load)) for record in records) > step
    spectra = spectra_of(records, step, dead) if twisted else None
    if spectra is None:
        return None
    fit = MassFit(spectra, prior, np.zeros((spectra.frequency.size, 2, 2), complex))
    return fit.solution(fit.first(spectra.total())).masses


def _slides(record: Record, step: float, cut: Cut) -> Iterator[slice]:
    """Yield the motions of both masses in one direction."""
    dt = record.dt
    speeds = [
        np.gradient(low_passed(x - x[0], min(SIDES, 0.1 / dt), dt), dt)
        for x in (record.motor, record.load)
    ]
    least = BRISK * float(np.quantile(np.abs(speeds[0]), 0.99))
    for side in (1.0, -1.0):
        for run in runs((side * speeds[0] > least) & (side * speeds[1] > least)):
            size = run.stop - run.start
            if (
                size * dt < cut.shortest
                or abs(record.motor[run.stop - 1] - record.motor[run.start]) < STEPS * step
            ):
                continue
            ends = (
                np.linspace(run.start, run.stop, max(math.ceil(size * dt / cut.longest), 1) + 1)
                .astype(int)
                .tolist()
            )
            yield from (slice(max(a, 1), min(b, record.motor.size - 1)) for a, b in pairwise(ends))


def _signals(record: Record, dead: Dead | None) -> np.ndarray:
    """Return the regressors, shape (signal, sample); the first and the last sample are invalid."""
    dt = record.dt
    twist = record.motor - record.load
    twist = twist if dead is None else dead(twist)
    rows = np.zeros((SIGNALS, twist.size))
    rows[EFFORT], rows[TWIST] = record.effort, twist
    for x, second, first in (
        (record.motor, A_1, V_1),
        (record.load, A_2, V_2),
        (twist, None, TWIST_RATE),
    ):
        rows[first, 1:-1] = (x[2:] - x[:-2]) / (2.0 * dt)
        if second is not None:
            rows[second, 1:-1] = (x[2:] - 2.0 * x[1:-1] + x[:-2]) / dt**2
    for x, row in ((record.motor, FADING_1), (record.load, FADING_2)):
        speed = np.gradient(low_passed(x - x[0], min(FADING, 0.2 / dt), dt), dt)
        top = max(float(np.quantile(np.abs(speed), 0.99)), TINY)
        rows[row] = np.sign(speed) * np.exp(-np.abs(speed) / (FADES * top))
    rows[NUT] = np.sign(rows[FADING_1]) * np.abs(twist)
    return rows


def spectra_of(
    records: Sequence[Record], step: float, dead: Dead | None = None, cut: Cut = BOTH
) -> Spectra | None:
    """Return the spectra of all slides; None if there are too few."""
    from scipy.signal.windows import tukey

    dt = records[0].dt
    size = round(cut.longest / dt) + 2
    hertz = np.fft.rfftfreq(size, dt)
    high = (hertz > NOISE_BAND[0] / dt) & (hertz < NOISE_BAND[1] / dt)
    inside = (hertz > cut.slowest) & (hertz < min(cut.of_rate / dt, FASTEST))
    frequency = hertz[inside]
    starts = starts_of_groups(frequency, WIDTH)
    # The gain of exact derivatives over those of differences.
    turn, turn_high = 2.0 * np.pi * frequency * dt, 2.0 * np.pi * hertz[high] * dt
    exact = np.ones((SIGNALS, turn.size))
    exact[[A_1, A_2]], exact[[V_1, V_2, TWIST_RATE]] = (
        turn**2 / (2.0 - 2.0 * np.cos(turn)),
        turn / np.sin(turn),
    )
    slides, lengths, noise = list[np.ndarray](), list[float](), np.zeros((2, 2))
    for record in records:
        signals = _signals(record, dead)
        for part in sorted(_slides(record, step, cut), key=lambda part: part.start):
            rows, taper = signals[:, part], tukey(part.stop - part.start, cut.taper)
            rows = taper * (rows - rows.mean(axis=1, keepdims=True))
            spectrum = np.fft.rfft(rows, size)
            ends = spectrum[A_1 : A_2 + 1, high] * dt**2 / (2.0 - 2.0 * np.cos(turn_high))
            noise += np.real(ends @ ends.conj().T) / turn_high.size
            spectrum = spectrum[:, inside] * exact
            slides.append(
                np.add.reduceat(
                    spectrum[:, None] * spectrum[None].conj(), starts, axis=2
                ).transpose(2, 0, 1)
            )
            lengths.append(float(np.sum(taper**2)))
    if len(slides) < FEWEST:
        return None
    bins = np.diff([*starts, frequency.size])
    return Spectra(
        np.add.reduceat(frequency, starts) / bins,
        bins,
        np.array(slides),
        np.array(lengths),
        noise / sum(lengths),
        dt,
    )


@dataclass(frozen=True)
class MassFit:
    """The fit of both equations to spectra, with the covariance of the residuals that encoder noise leaves unexplained."""

    spectra: Spectra
    prior: Prior
    left: np.ndarray
    lowest: ClassVar[np.ndarray] = np.array([0.0] * 3 + [-np.inf] * 6)  # of the parameters
    highest: ClassVar[np.ndarray] = np.full(9, np.inf)

    def converged(self, point: np.ndarray) -> tuple[MassFit, np.ndarray]:
        """Return the fit with the residuals of its solution near a point, and this solution."""
        fit, total = self, self.spectra.total()
        for _ in range(PASSES):
            fit = replace(fit, left=fit.unexplained(point, total))
            point = fit.solved(point, total, STEPS_OF_FIT)
        return fit, point

    def solution(self, point: np.ndarray) -> Solved:
        """Return the solution near a point, with those of a jackknife over blocks of slides."""
        spectra, total = self.spectra, self.spectra.total()
        fit, point = self.converged(point)
        count = min(BLOCKS, spectra.lengths.size)
        ends = np.linspace(0, spectra.lengths.size, count + 1).astype(int)
        blocks = [fit.solved(point, spectra.total(slice(a, b)), 3) for a, b in pairwise(ends)]
        moved = [replace(fit, prior=prior).solved(point, total, 3) for prior in self.prior.moved]
        return Solved(point, np.array(blocks), np.reshape(moved, (-1, point.size)))

    def first(self, total: np.ndarray) -> np.ndarray:
        """Return the linear least-squares fit of the equations of the motor and of the sum, with the best delay."""
        frequency, power = self.spectra.frequency, np.real(total[:, EFFORT, EFFORT])
        weight = np.where(frequency < SEARCHED, self.spectra.bins / np.maximum(power, TINY), 0.0)
        places = ((A_1, None, TWIST, TWIST_RATE, V_1, None), (A_1, A_2, None, None, V_1, V_2))
        gram, crossed = np.zeros((6, 6)), np.zeros((6, frequency.size), complex)
        for columns in places:
            for row, a in enumerate(columns):
                if a is None:
                    continue
                crossed[row] += weight * total[:, a, EFFORT]
                for column, b in enumerate(columns):
                    gram[row, column] += (
                        0.0 if b is None else float(np.real(weight @ total[:, a, b]))
                    )
        delays = np.arange(-EARLY, LATE, DELAY_STEP)
        rights = np.real(np.exp(-2j * np.pi * np.outer(delays, frequency)) @ crossed.T)
        solutions = normal(np.broadcast_to(gram, (delays.size, 6, 6)), rights, rcond=1e-12)
        best = int(np.argmax(np.sum(rights * solutions, axis=1)))
        motor, load, k, d, *viscous = solutions[best].tolist()
        least = 0.05 * (motor + load)
        motor, load = max(motor, least), max(load, least)
        if not (least > 0.0 and k > load * (2.0 * np.pi * BOTH.slowest) ** 2):
            raise InputError(
                "has no antiresonance in the band of the log", path="the fit of both masses"
            )
        return np.array([motor, load, load / k, max(d / k, 0.0), *viscous, delays[best], 0.0, 0.0])

    def equations(self, point: np.ndarray) -> np.ndarray:
        """Return the factors of the signals in both equations, shape (group, 2, signal)."""
        turn = 2.0 * np.pi * self.spectra.frequency
        rows = np.zeros((turn.size, 2, SIGNALS), complex)
        rows[:, 0, EFFORT] = np.exp(1j * turn * point[DELAY])
        for signal, number in (
            (A_1, M_1),
            (A_2, M_2),
            (V_1, VISCOUS_1),
            (V_2, VISCOUS_2),
            (FADING_1, FRICTION_1),
            (FADING_2, FRICTION_2),
        ):
            rows[:, 0, signal] = -point[number]
        softness = point[KAPPA] / point[M_2]
        rows[:, 0, NUT] = -self.prior.nut / softness
        rows[:, 1, A_2], rows[:, 1, V_2], rows[:, 1, FADING_2] = (
            -point[KAPPA],
            -point[VISCOUS_2] * softness,
            -point[FRICTION_2] * softness,
        )
        rows[:, 1, TWIST], rows[:, 1, TWIST_RATE] = 1.0, point[DAMPING]
        return rows

    def noise(self, point: np.ndarray) -> np.ndarray:
        """Return the covariance of the residuals due to both encoders, shape (group, 2, 2)."""
        s = 2j * np.pi * self.spectra.frequency
        spring, gains = 1.0 + s * point[DAMPING], np.zeros((s.size, 2, 2), complex)
        gains[:, 0, 0], gains[:, 0, 1] = (
            -(point[M_1] * s + point[VISCOUS_1]) * s,
            -(point[M_2] * s + point[VISCOUS_2]) * s,
        )
        gains[:, 1, 0] = spring
        gains[:, 1, 1] = (
            -(point[KAPPA] * s + point[VISCOUS_2] * point[KAPPA] / point[M_2]) * s - spring
        )
        return gains @ self.spectra.noise @ gains.conj().transpose(0, 2, 1)

    def unexplained(self, point: np.ndarray, total: np.ndarray) -> np.ndarray:
        """Return the covariance of the residuals that encoder noise does not explain, larger where noise dominates."""
        spectra, rows, noise = self.spectra, self.equations(point), self.noise(point)
        mean = total / spectra.bins[:, None, None]
        close = np.abs(np.subtract.outer(*[np.log(spectra.frequency)] * 2)) < POOLED
        near = close * spectra.bins / (close @ spectra.bins)[:, None]
        residual = rows @ mean @ rows.conj().transpose(0, 2, 1)
        pooled = np.einsum("gh,hij->gij", near, residual - noise)
        inertial = rows[:, 0, A_1 : A_2 + 1]
        signal = np.real(
            np.einsum(
                "gi,gij,gj->g", inertial, mean[:, A_1 : A_2 + 1, A_1 : A_2 + 1], inertial.conj()
            )
        )
        displaced = np.maximum(
            point[KAPPA] ** 2 * np.real(mean[:, A_2, A_2]), np.real(mean[:, TWIST, TWIST])
        )
        left = np.zeros_like(pooled)
        for place, (signals, power) in enumerate(
            ((EFFORT, signal), (TWIST, displaced))[: rows.shape[1]]
        ):
            left[:, place, place] = np.maximum(
                np.real(pooled[:, place, place]),
                FLOOR * (near @ np.real(mean[:, signals, signals])),
            )
            own = np.real(noise[:, place, place])
            left[:, place, place] += 10.0 * own * (own / np.maximum(power, TINY) / NOISY) ** 4
        if rows.shape[1] == 1:
            return left
        most = 0.9 * np.sqrt(np.real(left[:, 0, 0] * left[:, 1, 1]))
        left[:, 0, 1] = pooled[:, 0, 1] * np.minimum(
            1.0, most / np.maximum(np.abs(pooled[:, 0, 1]), TINY)
        )
        left[:, 1, 0] = left[:, 0, 1].conj()
        return left

    def solved(self, point: np.ndarray, total: np.ndarray, steps: int) -> np.ndarray:
        """Return the point of the smallest cost near a point; masses and their ratio to the stiffness stay positive."""
        from scipy.optimize import least_squares

        diagonal = np.real(np.einsum("gii->gi", total))
        root = np.linalg.cholesky(
            total + np.einsum("gi,ij->gij", 1e-12 * diagonal, np.eye(SIGNALS))
        ) * math.sqrt(self.spectra.lengths.size)
        sides = 0.1 * point[M_1 : M_2 + 1]
        # Smallest units of the parameters.
        spare = np.concatenate([[1e-9, 1e-9, 1e-12, 1e-4], sides, [1e-4], sides, [0.3]])[
            : point.size
        ]
        unit, nudges = np.maximum(np.abs(point), spare), NUDGE * np.eye(point.size)
        bounds = self.lowest / unit, self.highest / unit

        def residual(x: np.ndarray) -> np.ndarray:
            return self._whitened(unit * x, root)

        def slope(x: np.ndarray) -> np.ndarray:
            return np.stack(
                [residual(x + nudge) - residual(x - nudge) for nudge in nudges], axis=1
            ) / (2.0 * NUDGE)

        ended = least_squares(
            residual, point / unit, jac=cast(Any, slope), bounds=bounds, ftol=1e-7, max_nfev=steps
        )
        return unit * ended.x

    def of_prior(self, point: np.ndarray) -> np.ndarray:
        """Return the quantities that a prior knows: the stiffness."""
        return point[[M_2]] / point[KAPPA]

    def _whitened(self, point: np.ndarray, root: np.ndarray) -> np.ndarray:
        """Return the residuals of unit variance, and those of the prior."""
        white = np.linalg.cholesky(self.noise(point) + self.left)
        residual = np.linalg.solve(white, self.equations(point) @ root)
        of_prior = (
            (self.of_prior(point) - self.prior.values) / self.prior.errors
            if self.prior.values.size
            else []
        )
        return np.concatenate([residual.real.ravel(), residual.imag.ravel(), of_prior])
