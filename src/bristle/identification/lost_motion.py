r"""Play and stiffness of a drive from its lost motion: the difference of motor and load over the force between them.

With the masses known, the motor shows the force on the coupling up to its own friction,

.. math:: u - m_1 \ddot x_1 = F_1 + k D_g(x_1 - x_2 - c) + d\,\frac{d}{dt} D_g(x_1 - x_2 - c) .

Elements that slip after different distances, a viscous term and terms that fade with the speed stand for any friction
:math:`F_1`. They are projected off, and so are the stiffness and the friction of the nut :math:`c_T` (variable projection
[1]_): only the play `g` and the centre `c` remain. The side `z` of the nut, from -1 to 1, changes over the shortest distance.
Play is a stretch without force after a reversal. No friction has this shape: after a reversal its slope only falls. The nut
lowers the slope while the coupling relaxes, and raises it while the coupling winds up. Last, non-negative elements over the
stretch :math:`D_g` show the hysteresis of the coupling itself.

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
from bristle.core.least_squares import apart_from, non_negative
from bristle.core.variable import Kind
from bristle.engine.motion import along
from bristle.identification.elasticity import DAMPING, M_1, Masses
from bristle.identification.two_encoders import FACTOR, Record
from bristle.logs.filters import ahead, derivative, low_passed
from bristle.models.friction import maxwell_slip

# Of the sampling frequency; Hz; samples dropped at the ends.
CUTOFF, HIGHEST, ROWS_PER_PERIOD, EDGE = (0.12, 150.0, 2.5, 200)
# m: of elements; encoder steps; m: to which angles are scaled
DISTANCES, SMALLEST, STROKE = ((1e-6, 3e-6, 1e-5, 3e-5, 1e-4), 1.5, 0.2)
SIGN, FADES = 0.003, (0.03, 0.1, 0.3)  # of the top speed: width of the sign; decays of friction
# Of the scan: play [m]; shares of the range; of the search.
WIDEST, TRIALS, SIDEWAYS, EVALUATIONS = (1e-4, 9, 0.1, 80)
NUDGE, BLOCKS = 3e-3, 20  # of the range; of the errors
CLEAR = 0.05  # reduction of the squared residual by play
# Of the range of the twist: distances after which elements of the coupling slip.
STRETCHES = (0.05, 0.15, 0.3)


class Hysteresis(NamedTuple):
    """Width of the loop of a coupling [N or N*m], its standard error, stiffness in large and small motions, and loss per cycle [J]."""

    width: float
    error: float
    large: float
    small: float
    loss: float
    elements: tuple[tuple[float, float], ...] = ()  # force and distance of each

    def pull(self, stretch: np.ndarray, dt: float) -> np.ndarray:
        """Return the force of the coupling without damping along its stretch, shape (sample,)."""
        return self.large * stretch + sum(
            force * element(stretch, dt, reach) for force, reach in self.elements
        )


class LostMotion(NamedTuple):
    """Play and its centre [m or rad], stiffness, friction of the nut, standard errors, and the share of the residual by play."""

    play: float
    play_error: float
    centre: float
    stiffness: float
    stiffness_error: float
    gain: float
    nut: float = 0.0
    nut_error: float = math.inf
    nut_is_masked: bool = False
    nut_reach: float = math.inf
    hysteresis: Hysteresis | None = None

    @property
    def clear(self) -> bool:
        """Whether the log shows play."""
        return self.gain > CLEAR

    @property
    def nut_as_known(self) -> tuple[float, float]:
        """Friction of the nut and its standard error, 0 if not clear."""
        return (self.nut, self.nut_error) if self.nut_is_clear else (0.0, 0.0)

    @property
    def nut_is_clear(self) -> bool:
        """Whether the interval of the friction of the nut excludes zero."""
        return self.nut > FACTOR * self.nut_error

    def nut_share(self, record: Record) -> np.ndarray:
        """Return friction of the nut per force of the coupling along a record, shape (sample,); 0 if not clear."""
        return (
            self.nut * _side(record, self.nut_reach)
            if self.nut_is_clear
            else np.zeros(record.motor.size)
        )

    def dead(self, twist: np.ndarray) -> np.ndarray:
        """Return the stretch of the coupling at a difference of motor and load."""
        return (
            stretched(twist, self.play, self.centre) if self.clear or self.nut_is_clear else twist
        )


def stretched(twist: np.ndarray, play: float, centre: float) -> np.ndarray:
    """Return the part of a difference of positions beyond the dead zone."""
    apart = twist - centre
    return apart - np.clip(apart, -0.5 * play, 0.5 * play)


def _cutoff(dt: float) -> float:
    return min(CUTOFF / dt, HIGHEST)


def _side(record: Record, reach: float) -> np.ndarray:
    """Return the side of a nut along a record, from -1 to 1, shape (sample,)."""
    return element(
        low_passed(record.motor - record.motor[0], _cutoff(record.dt), record.dt), record.dt, reach
    )


def element(x: np.ndarray, dt: float, reach: float) -> np.ndarray:
    """Return the force of an element that slips after the distance `reach`, from -1 to 1, shape (sample,)."""
    return along(
        maxwell_slip(F_C=1.0, k_i=[1.0 / reach], nu_i=[1.0]),
        dt=dt,
        v=np.diff(x, prepend=x[:1]) / dt,
        x=x,
    )


def lost_motion(
    records: Sequence[Record], step: float, masses: Masses, kind: Kind = "translational"
) -> LostMotion:
    """Return the play and the stiffness that records show, given the masses."""
    scale = (
        1.0
        if kind == "translational"
        else max(float(np.ptp(record.motor)) for record in records) / STROKE
    )
    return _Rows(tuple(records), step, masses, scale).estimate


@dataclass(frozen=True)
class _Rows:
    """Decimated rows of the equation of the motor, apart from friction of the motor."""

    records: tuple[Record, ...]
    step: float
    masses: Masses
    scale: float

    def _decimated(self, record: Record, signal: np.ndarray) -> np.ndarray:
        cutoff = _cutoff(record.dt)
        passed = low_passed(signal, cutoff, record.dt)
        edge = min(EDGE, passed.shape[-1] // 10)
        return passed[
            ...,
            edge : passed.shape[-1] - edge : max(
                round(1.0 / (ROWS_PER_PERIOD * cutoff * record.dt)), 1
            ),
        ]

    @cached_property
    def _basis(self) -> np.ndarray:
        """An orthonormal basis of the effort that friction of the motor can explain, shape (row, column)."""
        parts = list[np.ndarray]()
        for number, record in enumerate(self.records):
            x = low_passed(record.motor - record.motor[0], _cutoff(record.dt), record.dt)
            speed = derivative(x, record.dt)
            top = float(np.quantile(np.abs(speed), 0.99))
            constants = [
                np.full(x.size, float(place == number)) for place in range(len(self.records))
            ]
            elements = [element(x, record.dt, self._reach(distance)) for distance in DISTANCES]
            fading = [
                np.tanh(speed / (SIGN * top)) * np.exp(-np.abs(speed) / (share * top))
                for share in FADES
            ]
            parts.append(self._decimated(record, np.stack([*constants, speed, *elements, *fading])))
        columns = np.concatenate(parts, axis=1).T
        return np.linalg.qr(
            columns / np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
        )[0]

    @cached_property
    def _acceleration(self) -> np.ndarray:
        """The acceleration of the motor, apart from friction, shape (row,)."""
        parts = list[np.ndarray]()
        for record in self.records:
            x = low_passed(record.motor - record.motor[0], _cutoff(record.dt), record.dt)
            parts.append(self._decimated(record, derivative(derivative(x, record.dt), record.dt)))
        return apart_from(self._basis, np.concatenate(parts))

    @cached_property
    def _force(self) -> np.ndarray:
        """The effort without that of the mass of the motor, apart from friction, shape (row,)."""
        parts = [
            self._decimated(record, ahead(record.effort, self.masses.delay / record.dt))
            for record in self.records
        ]
        return (
            apart_from(self._basis, np.concatenate(parts))
            - self.masses.values[M_1] * self._acceleration
        )

    @cached_property
    def _sides(self) -> tuple[np.ndarray, ...]:
        """The side of the nut along each record, from -1 to 1, shape (sample,)."""
        return tuple(_side(record, self._reach()) for record in self.records)

    def _reach(self, distance: float = DISTANCES[0]) -> float:
        return max(distance * self.scale, SMALLEST * self.step)

    def _pulls(self, play: float, centre: float, count: int) -> np.ndarray:
        """Return the `_raw_pulls` apart from friction of the motor."""
        return apart_from(self._basis, self._raw_pulls(play, centre, count))

    def _raw_pulls(self, play: float, centre: float, count: int) -> np.ndarray:
        """Return the force of a coupling of stiffness 1 and, for a `count` of 2, of a nut with it, shape (row, `count`)."""
        parts = list[np.ndarray]()
        for number, record in enumerate(self.records):
            stretch = low_passed(
                stretched(record.motor - record.load, play, centre), _cutoff(record.dt), record.dt
            )
            force = stretch + self.masses.values[DAMPING] * derivative(stretch, record.dt)
            nut = [self._sides[number] * np.abs(force)] if count > 1 else []
            parts.append(self._decimated(record, np.stack([force, *nut])))
        return np.concatenate(parts, axis=1).T

    def _fitted(
        self, play: float, centre: float, count: int
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the stiffness and, for a `count` of 2, its product with the friction of the nut; the residual; and the pulls."""
        pulls = self._pulls(play, centre, count)
        factors = self._factors(pulls)
        return factors, self._force - pulls @ factors, pulls

    def _factors(self, columns: np.ndarray) -> np.ndarray:
        """Return the non-negative factors of columns of different units that explain the force."""
        scale = np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
        return np.asarray(non_negative(columns / scale, self._force) / scale)

    def _cost(self, place: np.ndarray, count: int) -> float:
        residual = self._fitted(abs(float(place[0])), float(place[1]), count)[1]
        return float(residual @ residual)

    def _best(self, count: int, middle: float, span: float) -> _Place:
        """Return play and centre of the smallest residual, and the centre of the smallest residual without play."""
        from scipy.optimize import minimize

        plays, sides = (
            np.linspace(0.0, 1.0, TRIALS) * min(span, WIDEST * self.scale),
            np.array([-SIDEWAYS, 0.0, SIDEWAYS]),
        )
        scanned = [
            np.array([play, middle + side * span]) / span
            for play in plays.tolist()
            for side in sides.tolist()
        ]
        start = min(scanned, key=lambda point: self._cost(span * point, count))
        options = {
            "initial_simplex": start + np.array([[0.0, 0.0], [0.1, 0.0], [0.0, 0.05]]),
            "maxfev": EVALUATIONS,
            "xatol": 1e-3,
            "fatol": 0.0,
        }
        search = minimize(
            lambda point: self._cost(span * point, count),
            start,
            method="Nelder-Mead",
            options=options,
        )
        play, centre = abs(float(search.x[0])) * span, float(search.x[1]) * span
        return _Place(
            play,
            centre,
            float(search.fun),
            min(self._cost(np.array([0.0, place]), count) for place in (middle, centre)),
        )

    @cached_property
    def estimate(self) -> LostMotion:
        """The play of the smallest residual, and the stiffness and the nut with this play or, if it is not clear, without play."""
        ends = np.array(
            [np.quantile(record.motor - record.load, [0.005, 0.995]) for record in self.records]
        )
        low, high = float(ends[:, 0].min()), float(ends[:, 1].max())
        middle, span = 0.5 * (low + high), max(high - low, np.finfo(float).tiny)
        with_nut = self._estimated(2, middle, span)
        if with_nut.nut_is_clear:
            return with_nut._replace(hysteresis=self._hysteresis(with_nut, 2, span))
        without = self._estimated(1, middle, span)
        return without._replace(
            hysteresis=self._hysteresis(without, 1, span),
            nut=with_nut.nut,
            nut_error=with_nut.nut_error,
            nut_is_masked=with_nut.nut_is_masked,
        )

    def _hysteresis(self, lost: LostMotion, count: int, span: float) -> Hysteresis | None:
        """Return the hysteresis of the coupling, or None if its elements do not explain enough of the squared residual."""
        play = lost.play if lost.clear or lost.nut_is_clear else 0.0
        _, before, pulls = self._fitted(play, lost.centre, count)
        reaches, parts = (
            [max(share * span, SMALLEST * self.step) for share in STRETCHES],
            list[np.ndarray](),
        )
        for record in self.records:
            stretch = low_passed(
                stretched(record.motor - record.load, play, lost.centre),
                _cutoff(record.dt),
                record.dt,
            )
            parts.append(
                self._decimated(
                    record, np.stack([element(stretch, record.dt, reach) for reach in reaches])
                )
            )
        elements = apart_from(self._basis, np.concatenate(parts, axis=1).T)
        columns = np.concatenate([pulls, elements], axis=1)
        factors = self._factors(columns)
        residual, forces = self._force - columns @ factors, factors[count:]
        if float(before @ before) <= (1.0 + CLEAR) * float(residual @ residual):
            return None
        width, large = 2.0 * float(forces.sum()), float(factors[0])
        errors = _errors(np.column_stack([pulls, elements @ forces / width]), residual)
        loss = 4.0 * float(forces @ np.maximum(0.5 * (span - play) - np.array(reaches), 0.0))
        held = tuple(zip(forces.tolist(), reaches, strict=True))
        return Hysteresis(
            width,
            float(errors[-1]),
            large,
            large + float(np.sum(forces / np.array(reaches))),
            loss,
            held,
        )

    def _estimated(self, count: int, middle: float, span: float) -> LostMotion:
        """Return the estimate with friction of the nut (`count` is 2) or without it (1)."""
        found = self._best(count, middle, span)
        gain = found.without_play / max(found.square, np.finfo(float).tiny) - 1.0
        # A small play resembles friction of the nut: estimate both together.
        has_play = count > 1 or gain > CLEAR
        play, centre = (found.play, found.centre) if has_play else (0.0, found.centre)
        factors, residual, pulls = self._fitted(play, centre, count)
        slopes = [pulls]
        if has_play:
            nudge = NUDGE * span
            less = max(play - nudge, 0.0)
            wider, narrower = (
                self._pulls(width, centre, count) @ factors for width in (play + nudge, less)
            )
            right, left = (
                self._pulls(play, place, count) @ factors
                for place in (centre + nudge, centre - nudge)
            )
            slopes += [
                ((wider - narrower) / (play + nudge - less))[:, None],
                ((right - left) / (2.0 * nudge))[:, None],
            ]
        errors = _errors(np.concatenate(slopes, axis=1), residual)
        pull = pulls[:, 0]
        by_mass = float(pull @ self._acceleration) / max(float(pull @ pull), np.finfo(float).tiny)
        stiffness, error = (
            float(factors[0]),
            math.hypot(float(errors[0]), by_mass * float(self.masses.errors[M_1])),
        )
        play_error = float(errors[-2]) if has_play else math.inf
        least = max(stiffness, float(np.finfo(float).tiny))
        if count == 1:
            return LostMotion(found.play, play_error, centre, stiffness, error, gain)
        # The error if the nut resembled neither friction of the bearings nor the force of the coupling.
        alone = float(_errors(self._raw_pulls(play, centre, count)[:, 1:], residual)[0])
        nut = (
            float(factors[1]) / least,
            float(errors[1]) / least,
            float(errors[1]) > math.sqrt(2.0) * alone,
            self._reach(),
        )
        return LostMotion(found.play, play_error, centre, stiffness, error, gain, *nut)


class _Place(NamedTuple):
    """Play and centre of the smallest squared residual, and that residual without play."""

    play: float
    centre: float
    square: float
    without_play: float


def _errors(slopes: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """Return standard errors that hold for residuals correlated within blocks of time."""
    scale = np.linalg.norm(slopes, axis=0)
    slopes = slopes / scale
    inverse = np.linalg.pinv(slopes.T @ slopes)
    sums = [
        part.T @ left
        for part, left in zip(
            np.array_split(slopes, BLOCKS), np.array_split(residual, BLOCKS), strict=True
        )
    ]
    return np.sqrt(np.sum((np.array(sums) @ inverse) ** 2, axis=0)) / scale
