r"""Where the delay of a loop comes from, and the bandwidth that it leaves.

A held effort lags by half a sample, the computation by whole ones, the current by its time constant, and the velocity
by what it takes to estimate it. To a crossover far below all of them they are one delay, :math:`T_\text{tot}`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bristle.core.contracts import Model
from bristle.core.experiment import Variant
from bristle.core.least_squares import unbounded
from bristle.stability.linear_system import LARGE, linear_law

__all__ = ["Delays", "delays_of", "velocity_delay"]

LOW, HIGH, POINTS = 0.005, 0.05, 40  # band of the fit, in Nyquist frequencies


class Delays(NamedTuple):
    """The parts of the delay of a loop [s]."""

    hold: float
    computation: float
    drive: float
    velocity: float

    @property
    def total(self) -> float:
        """All of them [s]."""
        return sum(self)


def delays_of(variant: Variant) -> Delays:
    """Return where the delay of a loop comes from."""
    run = variant.run
    return Delays(
        hold=0.5 * run.sample_time,
        computation=run.delay * run.sample_time,
        drive=run.current_lag,
        velocity=velocity_delay(variant.controller, run.sample_time),
    )


def velocity_delay(controller: Model, dt: float) -> float:
    r"""Return by how much the velocity lags on which a law acts [s].

    The law is fitted, where it is slow, by :math:`-k_p - k_i/s - k_d s\,e^{-sT}`.
    """
    law = linear_law(controller, dt, LARGE)
    omega = np.geomspace(LOW, HIGH, POINTS) * np.pi / dt
    response = -law.response(np.exp(1j * omega * dt))
    # e^{-sT} is 1 - sT there, so that k_d T stands beside the square of the frequency in the real part.
    _, lagging = unbounded(np.stack((np.ones(POINTS), omega**2), axis=1), np.real(response))
    _, k_d = unbounded(np.stack((-1.0 / omega, omega), axis=1), np.imag(response))
    return float(lagging / k_d) if k_d > 0.0 else 0.0
