r"""Legs: moves from rest to rest at a speed, with acceleration and jerk kept within limits, one after the other.

A leg has at most seven phases of constant jerk :math:`j`: the acceleration rises to :math:`a`, stays, falls to zero;
the leg cruises at :math:`v`; then the same with the opposite sign. If a leg is too short for its speed or its
acceleration, the jerk is kept and the others are lowered. Without a jerk limit it is a trapezoid of velocity.
"""

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from bristle.core import Variable, amount, guarded, many

Samples = tuple[np.ndarray, np.ndarray, np.ndarray]


class Legs(NamedTuple):
    """Phases of constant jerk, and their `end` [s]: the start of each and the motion there in SI, each of shape (phase,)."""

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    jerk: np.ndarray
    end: float

    def sample(self, t: np.ndarray) -> Samples:
        """Return position, velocity and acceleration at the times `t` [s]; at rest before and after."""
        tau = np.clip(t, 0.0, self.end)
        phase = np.maximum(np.searchsorted(self.time, tau, side="right") - 1, 0)
        tau = tau - self.time[phase]
        a, j = self.acceleration[phase], self.jerk[phase]
        inside = (t >= 0.0) & (t < self.end)
        return (
            self.position[phase] + tau * (self.velocity[phase] + tau * (0.5 * a + tau * j / 6.0)),
            np.where(inside, self.velocity[phase] + tau * (a + 0.5 * tau * j), 0.0),
            np.where(inside, a + tau * j, 0.0),
        )


@guarded(
    points=many(amount(Variable("length", "end of a leg"))),
    velocity=amount(
        Variable("length/time", "largest velocity", min=0.0), exclusive=True, endless=True
    ),
    acceleration=amount(
        Variable("length/time^2", "largest acceleration", min=0.0), exclusive=True, endless=True
    ),
    jerk=amount(Variable("length/time^3", "largest jerk", min=0.0), exclusive=True, endless=True),
)
def legs_through(
    points: Iterable[float], velocity: float, acceleration: float, jerk: float = math.inf
) -> Legs:
    """Return the motion from 0 through these points [m or rad], each of them a turning point or a stop.

    Parameters
    ----------
    points : iterable of float
        End of each leg.
    velocity, acceleration, jerk : float
        Limits of every leg [m/s, m/s^2, m/s^3, or with rad].
    """
    rows, at, now = [], 0.0, 0.0
    for point in points:
        phases = _leg(abs(point - at), velocity, acceleration, jerk)
        side, x, v = math.copysign(1.0, point - at), 0.0, 0.0
        for duration, a, j in phases:
            rows.append((now, at + side * x, side * v, side * a, side * j))
            x += duration * (v + duration * (0.5 * a + duration * j / 6.0))
            v += duration * (a + 0.5 * duration * j)
            now += duration
        at = point
    rows.append((now, at, 0.0, 0.0, 0.0))
    return Legs(*np.array(rows).T, end=now)


def _leg(
    distance: float, velocity: float, acceleration: float, jerk: float
) -> list[tuple[float, float, float]]:
    """Return the phases of a leg: the duration of each [s], its acceleration at the start, and its jerk."""
    if distance == 0.0:
        return []
    peak = min(velocity, _fastest(distance, acceleration, jerk))
    rise = min(acceleration / jerk, math.sqrt(peak / jerk))
    top = jerk * rise if rise > 0.0 else acceleration
    # Rounding must not make the duration of a phase negative.
    steady = max(peak / top - rise, 0.0)
    cruise = max(distance / peak - (2.0 * rise + steady), 0.0)
    change = jerk if rise > 0.0 else 0.0
    phases = [
        (rise, 0.0, change),
        (steady, top, 0.0),
        (rise, top, -change),
        (cruise, 0.0, 0.0),
        (rise, 0.0, -change),
        (steady, -top, 0.0),
        (rise, -top, change),
    ]
    return [phase for phase in phases if phase[0] > 0.0]


def _fastest(distance: float, acceleration: float, jerk: float) -> float:
    """Return the speed [m/s or rad/s] that a leg without a cruise reaches."""
    rise = acceleration / jerk
    peak = 0.5 * acceleration * (math.sqrt(rise * rise + 4.0 * distance / acceleration) - rise)
    if peak >= acceleration * rise:
        return peak
    return (0.25 * distance * distance * jerk) ** (1.0 / 3.0)
