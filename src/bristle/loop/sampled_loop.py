"""A sampled control loop as one linear system, with every delay that it has."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from bristle.loop.linear_system import LinearSystem

PHASE_ENOUGH, GAIN_ENOUGH = 30.0, 2.0  # [deg], and a factor: what is usual as the least of both margins
POINTS, HALVINGS = 2000, 50  # of frequencies at which the open loop is asked, and between two of them
LOWEST = 1e-6  # of the Nyquist frequency
ON_THE_CIRCLE = 1e-6  # a double pole at 1, of a body that nothing holds, is found this far from it


@dataclass(frozen=True)
class SampledLoop:
    """A plant and the law that controls it."""

    plant: LinearSystem  # from the effort applied, held over a sample, to the position measured
    law: LinearSystem  # from the position measured to the effort commanded
    delay: int  # samples from a measurement to the effort computed from it
    sample_time: float  # [s]

    @property
    def matrix(self) -> np.ndarray:
        """What one sample does to the states of plant, delay line and law, without those that take no part."""
        plant, law = self.plant, self.law
        n, m, d = plant.B.size, law.B.size, self.delay
        full = np.zeros((n + d + m, n + d + m))
        full[:n, :n] = plant.A
        full[n + d :, n + d :] = law.A
        full[n + d :, :n] = np.outer(law.B, plant.C)
        command = np.concatenate((law.D * plant.C, np.zeros(d), law.C))
        if d:
            full[:n, n + d - 1] = plant.B
            full[n + 1 : n + d, n : n + d - 1] = np.eye(d - 1)
            full[n] = command
        else:
            full[:n] += np.outer(plant.B, command)
        # Which states a disturbance enters first, and which are read.
        entered = np.concatenate((plant.B != 0.0, np.zeros(d, dtype=bool), law.B != 0.0))
        read = np.concatenate((plant.C != 0.0, np.zeros(d, dtype=bool), law.C != 0.0))
        linked = full != 0.0
        part = _reached(linked, entered) & _reached(linked.T, read)
        return full[np.ix_(part, part)]

    @property
    def poles(self) -> np.ndarray:
        """Poles of the closed loop, the largest one first."""
        poles = np.linalg.eigvals(self.matrix)
        return poles[np.argsort(-np.abs(poles), kind="stable")]

    @property
    def spectral_radius(self) -> float:
        """Absolute value of the largest pole: above 1 a disturbance grows from sample to sample."""
        return float(np.max(np.abs(self.poles), initial=0.0))

    @property
    def is_unstable(self) -> bool:
        """Whether a pole lies outside the unit circle."""
        return self.spectral_radius > 1.0 + ON_THE_CIRCLE

    def response(self, omega: np.ndarray) -> np.ndarray:
        """Return the open loop, from the effort to the effort that answers it, less its sign, at `omega` [rad/s]."""
        z = np.exp(1j * omega * self.sample_time)
        return -self.law.response(z) * z ** float(-self.delay) * self.plant.response(z)

    def with_gain(self, factor: float) -> SampledLoop:
        """Return the loop with a law that answers `factor` times as strongly."""
        law = self.law
        return replace(self, law=LinearSystem(law.A, law.B, factor * law.C, factor * law.D))


def _reached(linked: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Return which states are reached from some of them; ``linked[i, j]`` says that `j` acts on `i`."""
    reached = first
    for _ in range(first.size):
        reached = reached | (linked[:, reached].any(axis=1))
    return reached


class Margins(NamedTuple):
    r"""Margins of a sampled loop; None where the open loop does not cross over.

    At the crossover :math:`|L(e^{j\omega T})| = 1` the phase margin is :math:`180° + \arg L`; where :math:`L` crosses the
    negative real axis the gain margin is :math:`1/|L|` [1]_. The peak of the sensitivity is that of :math:`1/|1 + L|`.

    References
    ----------
    .. [1] K. J. Astrom, R. M. Murray, "Feedback Systems", 2nd ed., Princeton University Press, 2021, section 10.3.
       ISBN 978-0-691-19398-4
    """

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
    crossovers = [
        (math.degrees(np.angle(-loop.response(np.array([w]))[0])), w)
        for w in _crossings(loop, omega, response, lambda response: np.abs(response) - 1.0)
    ]
    # A spring makes the loop cross over twice; a stable one is as near to -180 degrees from either side.
    phase, crossover = min(crossovers, key=lambda crossing: crossing[0] if unstable else abs(crossing[0]), default=(None, None))
    turns = [float(loop.response(np.array([w]))[0].real) for w in _crossings(loop, omega, response, np.imag)]
    gains = [-1.0 / real for real in (*turns, float(response[-1].real)) if real < 0.0]
    # The delay that brings a crossover to -180 degrees, from above it in a stable loop.
    delays = [math.radians(phase if unstable else phase % 360.0) / (w * loop.sample_time) for phase, w in crossovers]
    return Margins(
        phase=phase if phase is None or unstable else abs(phase),
        # The loop changes at a larger gain if it is stable, at a smaller one if it is not.
        gain=max((g for g in gains if g < 1.0), default=None) if unstable else min((g for g in gains if g > 1.0), default=None),
        crossover=crossover,
        delay=min(delays, default=None),
        sensitivity=float(np.max(1.0 / np.abs(1.0 + response))),
    )


def _crossings(loop: SampledLoop, omega: np.ndarray, response: np.ndarray, of: Callable[[np.ndarray], np.ndarray]) -> list[float]:
    """Return the frequencies [rad/s] at which a quantity of the open loop changes its sign, all bisected at once."""
    values = of(response)
    at = np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0.0)
    low, high, side = omega[at], omega[at + 1], np.sign(values[at])
    for _ in range(HALVINGS):
        middle = np.sqrt(low * high)
        same_side = np.sign(of(loop.response(middle))) == side if middle.size else np.zeros(0, dtype=bool)
        low, high = np.where(same_side, middle, low), np.where(same_side, high, middle)
    return np.sqrt(low * high).tolist()
