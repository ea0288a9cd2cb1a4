"""A sampled control loop as one linear system, with every delay that it has."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bristle.stability.linear_system import LinearSystem

__all__ = ["ON_THE_CIRCLE", "SampledLoop"]

ON_THE_CIRCLE = 1e-6  # a double pole at 1, of a body that nothing holds, is found this far from it


@dataclass(frozen=True)
class SampledLoop:
    """A plant and the law that controls it.

    Parameters
    ----------
    plant : LinearSystem
        From the effort applied, held over a sample, to the position measured.
    law : LinearSystem
        From the position measured to the effort commanded.
    delay : int
        Samples from a measurement to the effort computed from it.
    sample_time : float
        Sample time [s].
    """

    plant: LinearSystem
    law: LinearSystem
    delay: int
    sample_time: float

    @property
    def matrix(self) -> np.ndarray:
        """What one sample does to the states of plant, delay line and law, without those that take no part."""
        full, entered = self._system()
        linked = full != 0.0
        read = np.zeros(entered.size, dtype=bool)
        read[: self.plant.C.size] = self.plant.C != 0.0
        read[entered.size - self.law.C.size :] |= self.law.C != 0.0
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

    def _system(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the matrix of all states, and which of them a disturbance enters first."""
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
        entered = np.concatenate((plant.B != 0.0, np.zeros(d, dtype=bool), law.B != 0.0))
        return full, entered


def _reached(linked: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Return which states are reached from some of them; ``linked[i, j]`` says that `j` acts on `i`."""
    reached = first
    for _ in range(first.size):
        reached = reached | (linked[:, reached].any(axis=1))
    return reached
