r"""How far a sampled loop is from instability.

At the crossover :math:`|L(e^{j\omega T})| = 1` the phase margin is :math:`180° + \arg L`; where :math:`L` crosses the
negative real axis the gain margin is :math:`1/|L|`. The peak of the sensitivity :math:`1/|1 + L|` says how much the
loop amplifies what it is disturbed by.

References
----------
.. [1] K. J. Astrom, R. M. Murray, "Feedback Systems", 2nd ed., Princeton University Press, 2021, section 10.3.
   ISBN 978-0-691-19398-4
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bristle.stability.sampled_loop import SampledLoop

__all__ = ["Margins", "margins_of"]

Quantity = Callable[[np.ndarray], np.ndarray]

POINTS = 2000
LOWEST = 1e-6  # of the Nyquist frequency
HALVINGS = 50


class Margins(NamedTuple):
    """Margins of a sampled loop; None where the open loop does not cross over."""

    phase: float | None
    gain: float | None
    crossover: float | None
    delay: float | None
    sensitivity: float


def margins_of(loop: SampledLoop) -> Margins:
    """Return the margins of a loop."""
    nyquist = math.pi / loop.sample_time
    omega = np.geomspace(LOWEST * nyquist, nyquist, POINTS)
    response = loop.response(omega)
    unstable = loop.is_unstable
    crossovers = [(_phase_margin(loop, w), w) for w in _crossings(loop, omega, response, _excess)]
    # A spring makes the loop cross over twice; a stable one is as near to -180 degrees from either side.
    phase, crossover = min(crossovers, key=lambda crossing: crossing[0] if unstable else abs(crossing[0]), default=(None, None))
    turns = [float(loop.response(np.array([w]))[0].real) for w in _crossings(loop, omega, response, _imaginary)]
    gains = [-1.0 / real for real in (*turns, float(response[-1].real)) if real < 0.0]
    return Margins(
        phase=phase if phase is None or unstable else abs(phase),
        gain=_nearest(gains, unstable),
        crossover=crossover,
        delay=_delay_margin(crossovers, loop.sample_time, unstable),
        sensitivity=float(np.max(1.0 / np.abs(1.0 + response))),
    )


def _delay_margin(crossovers: list[tuple[float, float]], sample_time: float, unstable: bool) -> float | None:
    """Return the delay [samples] that brings a crossover to -180 degrees, from above it in a stable loop."""
    delays = [math.radians(phase if unstable else phase % 360.0) / (omega * sample_time) for phase, omega in crossovers]
    return min(delays, default=None)


def _nearest(gains: list[float], unstable: bool) -> float | None:
    """Return the gain at which the loop changes: above the present one if it is stable, below it if it is not."""
    if unstable:
        return max((gain for gain in gains if gain < 1.0), default=None)
    return min((gain for gain in gains if gain > 1.0), default=None)


def _phase_margin(loop: SampledLoop, omega: float) -> float:
    return math.degrees(np.angle(-loop.response(np.array([omega]))[0]))


def _excess(response: np.ndarray) -> np.ndarray:
    return np.abs(response) - 1.0


def _imaginary(response: np.ndarray) -> np.ndarray:
    return np.imag(response)


def _crossings(loop: SampledLoop, omega: np.ndarray, response: np.ndarray, of: Quantity) -> list[float]:
    """Return the frequencies [rad/s] at which a quantity of the open loop changes its sign, all bisected at once."""
    values = of(response)
    at = np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0.0)
    low, high, side = omega[at], omega[at + 1], np.sign(values[at])
    for _ in range(HALVINGS):
        middle = np.sqrt(low * high)
        same_side = np.sign(of(loop.response(middle))) == side if middle.size else np.zeros(0, dtype=bool)
        low, high = np.where(same_side, middle, low), np.where(same_side, high, middle)
    return np.sqrt(low * high).tolist()
