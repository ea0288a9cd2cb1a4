r"""Play and stiffness of a drive from its lost motion: the difference of motor and load over the force between them.

With the masses known, the motor shows the force on the coupling up to its own friction,

.. math:: u - m_1 \ddot x_1 = F_1 + k D_g(x_1 - x_2 - c) + d\,\frac{d}{dt} D_g(x_1 - x_2 - c) .

Elements that slip after different distances, a viscous term and terms that fade with the speed stand for any friction
:math:`F_1`. They are projected off, and so is the stiffness (variable projection [1]_): only the play `g` and the centre `c` remain.
Play is a stretch without force after a reversal. No friction has this shape: after a reversal its slope only falls.

References
----------
.. [1] G. H. Golub, V. Pereyra, "The differentiation of pseudo-inverses and nonlinear least squares problems whose
   variables separate", SIAM Journal on Numerical Analysis 10(2), 1973. doi:10.1137/0710036
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bristle.core.lazy import cached_property
from bristle.core.least_squares import apart_from
from bristle.core.variable import Kind
from bristle.engine.motion import along
from bristle.friction import maxwell_slip
from bristle.identification.two_encoders import DAMPING, M_1, Masses, Record
from bristle.logs.filters import ahead, derivative, low_passed

CUTOFF, HIGHEST, ROWS_PER_PERIOD, EDGE = 0.12, 150.0, 2.5, 200  # of the sampling frequency; Hz; samples dropped at the ends
DISTANCES, SMALLEST, STROKE = (1e-6, 3e-6, 1e-5, 3e-5, 1e-4), 1.5, 0.2  # m: of elements; encoder steps; m: to which angles are scaled
SIGN, FADES = 0.003, (0.03, 0.1, 0.3)  # of the top speed: width of the sign; decays of friction
WIDEST, TRIALS, SIDEWAYS, EVALUATIONS = 1e-4, 9, 0.1, 80  # of the scan: play [m]; shares of the range; of the search
NUDGE, BLOCKS = 3e-3, 20  # of the range; of the errors
CLEAR = 0.05  # reduction of the squared residual by play


class LostMotion(NamedTuple):
    """Play and its centre [m or rad], stiffness, standard errors, and the share of the squared residual that play explains."""

    play: float
    play_error: float
    centre: float
    stiffness: float
    stiffness_error: float
    gain: float

    @property
    def clear(self) -> bool:
        """Whether the log shows play."""
        return self.gain > CLEAR

    def dead(self, twist: np.ndarray) -> np.ndarray:
        """Return the stretch of the coupling at a difference of motor and load."""
        return stretched(twist, self.play, self.centre) if self.clear else twist


def stretched(twist: np.ndarray, play: float, centre: float) -> np.ndarray:
    """Return the part of a difference of positions beyond the dead zone."""
    apart = twist - centre
    return apart - np.clip(apart, -0.5 * play, 0.5 * play)


def lost_motion(records: Sequence[Record], step: float, masses: Masses, kind: Kind = "translational") -> LostMotion:
    """Return the play and the stiffness that records show, given the masses."""
    scale = 1.0 if kind == "translational" else max(float(np.ptp(record.motor)) for record in records) / STROKE
    return _Rows(tuple(records), step, masses, scale).estimate


@dataclass(frozen=True)
class _Rows:
    """Decimated rows of the equation of the motor, apart from friction of the motor."""

    records: tuple[Record, ...]
    step: float
    masses: Masses
    scale: float

    def _decimated(self, record: Record, signal: np.ndarray) -> np.ndarray:
        cutoff = self._cutoff(record.dt)
        passed = low_passed(signal, cutoff, record.dt)
        edge = min(EDGE, passed.shape[-1] // 10)
        return passed[..., edge : passed.shape[-1] - edge : max(round(1.0 / (ROWS_PER_PERIOD * cutoff * record.dt)), 1)]

    def _cutoff(self, dt: float) -> float:
        return min(CUTOFF / dt, HIGHEST)

    @cached_property
    def _basis(self) -> np.ndarray:
        """An orthonormal basis of the effort that friction of the motor can explain, shape (row, column)."""
        parts = list[np.ndarray]()
        for number, record in enumerate(self.records):
            dt, x = record.dt, low_passed(record.motor - record.motor[0], self._cutoff(record.dt), record.dt)
            speed = derivative(x, dt)
            top = float(np.quantile(np.abs(speed), 0.99))
            constants = [np.full(x.size, float(place == number)) for place in range(len(self.records))]
            elements = [
                along(maxwell_slip(F_C=1.0, k_i=[1.0 / reach], nu_i=[1.0]), dt=dt, v=np.diff(x, prepend=x[:1]) / dt, x=x)
                for reach in (max(distance * self.scale, SMALLEST * self.step) for distance in DISTANCES)
            ]
            fading = [np.tanh(speed / (SIGN * top)) * np.exp(-np.abs(speed) / (share * top)) for share in FADES]
            parts.append(self._decimated(record, np.stack([*constants, speed, *elements, *fading])))
        columns = np.concatenate(parts, axis=1).T
        return np.linalg.qr(columns / np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny))[0]

    @cached_property
    def _acceleration(self) -> np.ndarray:
        """The acceleration of the motor, apart from friction, shape (row,)."""
        parts = list[np.ndarray]()
        for record in self.records:
            x = low_passed(record.motor - record.motor[0], self._cutoff(record.dt), record.dt)
            parts.append(self._decimated(record, derivative(derivative(x, record.dt), record.dt)))
        return apart_from(self._basis, np.concatenate(parts))

    @cached_property
    def _force(self) -> np.ndarray:
        """The effort without that of the mass of the motor, apart from friction, shape (row,)."""
        parts = [self._decimated(record, ahead(record.effort, self.masses.delay / record.dt)) for record in self.records]
        return apart_from(self._basis, np.concatenate(parts)) - self.masses.values[M_1] * self._acceleration

    def _pull(self, play: float, centre: float) -> np.ndarray:
        """Return the force of a coupling of stiffness 1, apart from friction of the motor, shape (row,)."""
        parts = list[np.ndarray]()
        for record in self.records:
            stretch = low_passed(stretched(record.motor - record.load, play, centre), self._cutoff(record.dt), record.dt)
            parts.append(self._decimated(record, stretch + self.masses.values[DAMPING] * derivative(stretch, record.dt)))
        return apart_from(self._basis, np.concatenate(parts))

    def _fitted(self, play: float, centre: float) -> tuple[float, np.ndarray, np.ndarray]:
        """Return the stiffness, the residual and the pull of a unit stiffness."""
        pull = self._pull(play, centre)
        stiffness = float(pull @ self._force) / max(float(pull @ pull), np.finfo(float).tiny)
        return stiffness, self._force - stiffness * pull, pull

    def _cost(self, play: float, centre: float) -> float:
        residual = self._fitted(abs(play), centre)[1]
        return float(residual @ residual)

    @cached_property
    def estimate(self) -> LostMotion:
        """The play of the smallest residual, and the stiffness with this play or, if it is not clear, without play."""
        from scipy.optimize import minimize

        ends = np.array([np.quantile(record.motor - record.load, [0.005, 0.995]) for record in self.records])
        low, high = float(ends[:, 0].min()), float(ends[:, 1].max())
        middle, span = 0.5 * (low + high), max(high - low, np.finfo(float).tiny)
        plays, sides = np.linspace(0.0, 1.0, TRIALS) * min(span, WIDEST * self.scale), np.array([-SIDEWAYS, 0.0, SIDEWAYS])
        scanned = [np.array([play, middle + side * span]) / span for play in plays.tolist() for side in sides.tolist()]
        start = min(scanned, key=lambda point: self._cost(*(span * point)))
        options = {
            "initial_simplex": start + np.array([[0.0, 0.0], [0.1, 0.0], [0.0, 0.05]]),
            "maxfev": EVALUATIONS,
            "xatol": 1e-3,
            "fatol": 0.0,
        }
        search = minimize(lambda point: self._cost(*(span * point)), start, method="Nelder-Mead", options=options)
        play, centre = abs(float(search.x[0])) * span, float(search.x[1]) * span
        stiffness, residual, pull = self._fitted(0.0, middle)
        square = float(residual @ residual)
        gain = min(square, self._cost(0.0, centre)) / max(float(search.fun), np.finfo(float).tiny) - 1.0
        slopes = [pull]
        if gain > CLEAR:
            stiffness, residual, pull = self._fitted(play, centre)
            nudge = NUDGE * span
            less = max(play - nudge, 0.0)
            slopes = [
                pull,
                stiffness * (self._pull(play + nudge, centre) - self._pull(less, centre)) / (play + nudge - less),
                stiffness * (self._pull(play, centre + nudge) - self._pull(play, centre - nudge)) / (2.0 * nudge),
            ]
        errors = _errors(np.stack(slopes, axis=1), residual)
        by_mass = float(pull @ self._acceleration) / max(float(pull @ pull), np.finfo(float).tiny)
        error = math.hypot(float(errors[0]), by_mass * float(self.masses.errors[M_1]))
        return LostMotion(play, float(errors[1]) if gain > CLEAR else math.inf, centre, stiffness, error, gain)


def _errors(slopes: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """Return standard errors that hold for residuals correlated within blocks of time."""
    scale = np.linalg.norm(slopes, axis=0)
    slopes = slopes / scale
    inverse = np.linalg.pinv(slopes.T @ slopes)
    sums = [part.T @ left for part, left in zip(np.array_split(slopes, BLOCKS), np.array_split(residual, BLOCKS), strict=True)]
    return np.sqrt(np.sum((np.array(sums) @ inverse) ** 2, axis=0)) / scale
