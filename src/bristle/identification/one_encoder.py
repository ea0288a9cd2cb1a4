r"""Two masses behind an elastic coupling, identified from the position of the motor and the effort alone.

Both equations of `two_encoders` contain the position of the load. The sum of the first, and of the second times

.. math:: \lambda = -\frac{m_2 s^2 + c_2 s}{1 + (t_d + c_2 / k)\, s + \kappa s^2}

does not contain it. This sum is a single equation in effort and motor position. Any position of the load satisfies it.
The position that the frequency response of the motor (`elasticity`) predicts makes the factors of the signals small: a
load that vibrates at the ends of a slide disturbs the spectra less, the closer its signals are to the true ones.

The fit, its noise and its errors are those of two encoders. The frequency response gives the start, and antiresonance
and resonance as prior knowledge. It explains the acceleration of the motor. The fit explains the effort, which friction
disturbs at low frequencies only. So the fit determines the sum of the masses from all frequencies.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import ClassVar, NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.identification.elasticity import (
    DAMPING,
    HOLDS,
    KAPPA,
    M_1,
    M_2,
    TINY,
    VISCOUS_1,
    VISCOUS_2,
    Elastic,
    Masses,
    motor_spectra,
)
from bristle.identification.preprocessing import step_of
from bristle.identification.two_encoders import (
    EFFORT,
    EXCITE,
    UNKNOWN,
    Cut,
    MassFit,
    Prior,
    Record,
    Solved,
    half_width,
    spectra_of,
)
from bristle.logs.log import Log

PAD = 3.0  # s: continuation of a record for the position of its load
CUT = Cut(longest=8.0, shortest=0.4, taper=1.0, slowest=3.0, of_rate=0.25)
HOLD = 9  # the parameter after those of two encoders: exponent of sin(x) / x
OF_WIDTH = 0.5  # standard error of a frequency of the response, as a share of its half-width
# At the start: damping of the antiresonance; viscous friction per mass [1/s]
DAMPED, RUBS = (0.03, 0.1)
ALIKE = 0.2  # largest relative difference of antiresonance and resonance of the fit from those of the response
OF_FRICTION = 2.0  # factor of the half-width of the mass of the response: error by friction at low frequencies
CONTRADICTED = 10.0  # standard errors, by which the fit without the response as prior knowledge differs from it


class OneEncoder(MassFit):
    """The fit of the effort to spectra of the motor alone."""

    lowest: ClassVar[np.ndarray] = np.array([0.0] * 4 + [-np.inf] * 5 + [HOLDS[0]])
    highest: ClassVar[np.ndarray] = np.array([np.inf] * 9 + [HOLDS[1]])

    def equations(self, point: np.ndarray) -> np.ndarray:
        """Return the factors of the signals in the equation without the load, shape (group, 1, signal)."""
        rows = super().equations(point)
        rows = rows[:, :1] + self._of_coupling(point)[:, None, None] * rows[:, 1:]
        rows[:, :, EFFORT + 1 :] *= self._held(point)[:, None, None]
        return rows

    def noise(self, point: np.ndarray) -> np.ndarray:
        """Return the variance of the residual due to the encoder, shape (group, 1, 1)."""
        s = 2j * np.pi * self.spectra.frequency
        gain = (
            self._of_coupling(point) * (1.0 + s * point[DAMPING])
            - (point[M_1] * s + point[VISCOUS_1]) * s
        )
        return (np.abs(self._held(point) * gain) ** 2 * self.spectra.noise[0, 0])[:, None, None]

    def _of_coupling(self, point: np.ndarray) -> np.ndarray:
        """Return the factor of the second equation."""
        s = 2j * np.pi * self.spectra.frequency
        load = (point[M_2] * s + point[VISCOUS_2]) * s
        return -load / (1.0 + point[DAMPING] * s + load * point[KAPPA] / point[M_2])

    def _held(self, point: np.ndarray) -> np.ndarray:
        return np.sinc(self.spectra.frequency * self.spectra.dt) ** -point[HOLD]

    def of_prior(self, point: np.ndarray) -> np.ndarray:
        """Return the logarithms of antiresonance and resonance [rad/s]."""
        return _frequencies(point)


def with_masses(
    coupling: Elastic | None, pairs: Sequence[tuple[Log, Axis | None]]
) -> Elastic | None:
    """Return a coupling with the masses of the fit and the more precise frequencies, or with the reason for missing masses."""
    if coupling is None:
        return None
    step = max(step_of(log, axis) for log, axis in pairs)
    frequencies = np.log(2.0 * np.pi * np.array([coupling.antiresonance, coupling.resonance]))
    widths = [
        coupling.antiresonance_half_width / coupling.antiresonance,
        coupling.resonance_half_width / coupling.resonance,
    ]
    motor = coupling.mass / (1.0 + coupling.inertia_ratio)
    load, kappa = coupling.mass - motor, math.exp(-2.0 * frequencies[0])
    damping, prior = (
        2.0 * DAMPED * math.sqrt(kappa),
        Prior(frequencies, OF_WIDTH * np.array(widths)),
    )
    spectra = spectra_of(_records([log for log, _ in pairs], kappa, damping), step, cut=CUT)
    if spectra is None:
        return coupling._replace(masses=f"the log has too few strokes in one direction. {EXCITE}")
    start = np.array(
        [motor, load, kappa, damping, RUBS * motor, RUBS * load, coupling.delay, 0.0, 0.0, 0.0]
    )
    solved, contradicted = _solution(
        OneEncoder(spectra, prior, np.zeros((spectra.frequency.size, 1, 1), complex)), start
    )
    masses, fitted = solved.masses, _frequencies(solved.point)
    if not np.min(masses.values[: KAPPA + 1]) > 0.0 or not np.max(
        np.abs(fitted - frequencies)
    ) < math.log1p(ALIKE):
        return coupling._replace(
            masses=f"the fit of both masses has other frequencies than the frequency response. {EXCITE}"
        )
    hertz, ratio = np.exp(fitted) / (2.0 * np.pi), float(masses.values[M_2] / masses.values[M_1])
    total, spread = (
        np.sum(masses.values[: M_2 + 1]),
        solved.error(lambda points: points[..., M_1] + points[..., M_2]),
    )
    values, errors = (
        np.array([*hertz, total]),
        np.array([*(hertz * solved.error(_frequencies)), spread]),
    )
    of_fit = zip(half_width(values, errors).tolist(), values.tolist(), strict=True)
    of_response = (
        (coupling.antiresonance_half_width, coupling.antiresonance),
        (coupling.resonance_half_width, coupling.resonance),
        (OF_FRICTION * coupling.mass_half_width, coupling.mass),
    )
    # The more precise estimate of both.
    antiresonance, resonance, mass = of_fit if contradicted else map(min, of_fit, of_response)
    return coupling._replace(
        antiresonance=antiresonance[1],
        antiresonance_half_width=antiresonance[0],
        resonance=resonance[1],
        resonance_half_width=resonance[0],
        inertia_ratio=ratio,
        inertia_ratio_half_width=half_width(
            ratio,
            ratio * float(solved.error(lambda points: np.log(points[..., M_2] / points[..., M_1]))),
        ),
        mass=mass[1],
        mass_half_width=mass[0],
        masses=masses,
    )


def _solution(fit: OneEncoder, start: np.ndarray) -> tuple[Solved, bool]:
    """Return the solution near a start, or that without prior knowledge if it contradicts this knowledge; and whether it does."""
    prior, free = fit.prior, replace(fit, prior=UNKNOWN)
    point = free.converged(start)[1]
    differs = np.abs(_frequencies(point) - prior.values)
    if np.max(differs / prior.errors) > CONTRADICTED and np.max(differs) < math.log1p(ALIKE):
        solved = free.solution(point)
        if np.max(differs / np.hypot(prior.errors, solved.error(_frequencies))) > CONTRADICTED:
            return solved, True
    return fit.solution(start), False


class Response(NamedTuple):
    """Acceleration of the motor per effort [1/kg or 1/(kg*m^2)] and its coherence over frequency [Hz], shape (group,); and of the model.

    The model is empty if the log does not show both masses.
    """

    frequency: np.ndarray
    gain: np.ndarray
    coherence: np.ndarray
    modelled: np.ndarray


def response_of(coupling: Elastic, pairs: Sequence[tuple[Log, Axis | None]]) -> Response | None:
    """Return the frequency response of the motor that logs with an elastic coupling show."""
    spectra = motor_spectra(*map(list, zip(*pairs, strict=True)))
    if spectra is None:
        return None
    response, modelled = spectra.response, np.empty(0)
    if isinstance(coupling.masses, Masses):
        s, resonance = 2j * np.pi * response.frequency, 2.0 * np.pi * coupling.resonance
        damped = s**2 + coupling.masses.values[DAMPING] * resonance**2 * s + resonance**2
        modelled = np.abs(1.0 + coupling.inertia_ratio * s**2 / damped) / coupling.mass
    gain = np.abs(response.cross) / np.maximum(response.clean, TINY) / spectra.scale
    return Response(response.frequency, gain, response.coherence, modelled)


def _frequencies(points: np.ndarray) -> np.ndarray:
    """Return the logarithms of antiresonance and resonance [rad/s] of some points, shape (..., 2)."""
    antiresonance = -0.5 * np.log(points[..., KAPPA])
    return np.stack(
        [antiresonance, antiresonance + 0.5 * np.log1p(points[..., M_2] / points[..., M_1])],
        axis=-1,
    )


def _records(logs: Sequence[Log], kappa: float, damping: float) -> list[Record]:
    """Return the stretches of logs without a gap, with the position of a load behind a coupling with this ratio and time."""
    records = list[Record]()
    for log in logs:
        assert log.effort is not None
        for part in log.segments:
            motor = log.position.values[part]
            size = min(motor.size - 1, round(PAD / log.sample_time))
            padded = np.pad(motor, size, mode="reflect", reflect_type="odd")
            line = np.linspace(padded[0], padded[-1], padded.size)
            s = 2j * np.pi * np.fft.rfftfreq(padded.size, log.sample_time)
            follows = (1.0 + damping * s) / (1.0 + damping * s + kappa * s**2)
            load = line + np.fft.irfft(follows * np.fft.rfft(padded - line), padded.size)
            records.append(
                Record(
                    motor, load[size : size + motor.size], log.effort.values[part], log.sample_time
                )
            )
    return records
