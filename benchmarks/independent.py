"""A simulated axis that shares no code with bristle: friction and integration in numpy, around a control law of bristle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

DT, STEPS = 5e-4, 8  # [s] sample time; integration steps in a sample
M = 631.65  # [kg]
GAINS = {"J": M, "lambda_": 150.0, "K_1": 150.0, "cutoff": 400.0}
RESOLUTION, NOISE, LAG = 0.125e-6, 0.01e-6, 2e-4  # [m] of the encoder; [m]; [s] of the current loop


@dataclass
class Sliders:
    """Maxwell slip with Stribeck limits that differ by direction: stiffness and limit of each element."""

    k: np.ndarray  # [N/m]
    limit: np.ndarray  # [N]
    side: float = 0.3  # share by which the limit is larger forward and smaller backward
    rise: float = 0.18  # share by which the static limit exceeds the sliding limit
    v_S: float = 4e-4  # [m/s]
    sigma_1: float = 5e4  # [N*s/m]
    sigma_2: float = 4737.0  # [N*s/m]
    offset: float = 6.3  # [N]

    def __post_init__(self) -> None:
        self.force, self.whole = np.zeros(self.k.size), float(np.sum(self.k))

    def advance(self, v: float, dt: float) -> float:
        """Return the force [N] after a step at a velocity."""
        level = 1.0 + self.rise * np.exp(-((v / self.v_S) ** 2))
        limit = self.limit * level
        tried = self.force + self.k * (v * dt)
        self.force = np.clip(tried, -(1.0 - self.side) * limit, (1.0 + self.side) * limit)
        sticking = float(np.sum(self.k[self.force == tried])) / self.whole
        return float(np.sum(self.force)) + sticking * self.sigma_1 * v + self.sigma_2 * v + self.offset


@dataclass
class Dahl:
    """Dahl's friction, in closed form over each step."""

    F_C: float  # [N]
    sigma_0: float  # [N/m]
    force: float = 0.0

    def advance(self, v: float, dt: float) -> float:
        """Return the force [N] after a step at a velocity."""
        end = self.F_C * np.sign(v)
        self.force = end + (self.force - end) * np.exp(-self.sigma_0 * abs(v) * dt / self.F_C)
        return float(self.force)


@dataclass
class LuGre:
    """LuGre friction, with an exact step of the bristles."""

    F_C: float  # [N]
    F_S: float  # [N]
    v_S: float  # [m/s]
    sigma_0: float  # [N/m]
    sigma_1: float  # [N*s/m]
    sigma_2: float  # [N*s/m]
    z: float = 0.0

    def advance(self, v: float, dt: float) -> float:
        """Return the force [N] after a step at a velocity."""
        curve = self.F_C + (self.F_S - self.F_C) * np.exp(-((v / self.v_S) ** 2))
        end = curve / self.sigma_0 * np.sign(v)
        self.z = end + (self.z - end) * np.exp(-self.sigma_0 * abs(v) * dt / curve)
        return float(self.sigma_0 * self.z + self.sigma_1 * (v - self.sigma_0 * abs(v) / curve * self.z) + self.sigma_2 * v)


def sliders(seed: int, count: int = 20) -> Sliders:
    """Return an axis of a fleet: elements, level and asymmetry differ from seed to seed."""
    generator = np.random.default_rng(seed)
    reach = 7e-6 * np.sort(generator.uniform(0.03, 1.0, count))  # [m]
    limit = generator.uniform(0.6, 1.4, count)
    limit *= 42.7 * generator.uniform(0.8, 1.2) / np.sum(limit)
    stiffness = limit / reach
    return Sliders(stiffness * min(1.0, 18e6 / np.sum(stiffness)), limit, side=generator.uniform(0.1, 0.4), offset=generator.uniform(0.0, 12.0))


@dataclass
class Run:
    """Signals of a run, an element per sample."""

    error: np.ndarray  # [m] desired minus true position
    measured: np.ndarray  # [m]
    effort: np.ndarray  # [N] command of the law
    friction: np.ndarray  # [N]
    velocity: np.ndarray  # [m/s]
    states: list[Any]
    desired: np.ndarray

    def peak(self, first: float = 0.0, last: float = np.inf) -> float:
        """Return the following error peak to peak between two times [m]."""
        t = DT * np.arange(self.error.size)
        return float(np.ptp(self.error[(t >= first) & (t < last)]))


def follow(law: Any, friction: Any, desired: np.ndarray, seed: int, lag: float = LAG) -> Run:
    """Run a control law along position, velocity, acceleration and feedforward, shape (4, sample)."""
    from bristle.core.contracts import Reference

    generator, component, p = np.random.default_rng(10_000 + seed), law.component, law.parameters
    x, v, acting, coming, h = float(desired[0, 0]), float(desired[1, 0]), 0.0, 0.0, DT / STEPS
    follows = 1.0 - np.exp(-h / lag)
    count = desired.shape[1]
    rows, states, state = np.empty((5, count)), [], None
    for k in range(count):
        measured = RESOLUTION * round((x + NOISE * generator.standard_normal()) / RESOLUTION)
        if state is None:
            state = component.start(measured, v, float(desired[2, 0]), DT, p)
        effort, state = component.step(state, Reference(*(float(value) for value in desired[:, k])), measured, DT, p)
        states.append(state)
        rows[:3, k], rows[4, k] = (desired[0, k] - x, measured, effort), v
        for _ in range(STEPS):
            acting += follows * (coming - acting)
            force = friction.advance(v, h)
            # The velocity meets the force that it makes: the step is stable with a stiff contact.
            v += h * (acting - force) / M
            x += h * v
        rows[3, k] = force
        coming = effort  # a delay of one sample
    return Run(rows[0], rows[1], rows[2], rows[3], rows[4], states, desired)


def harmonic(parts: list[tuple[float, float, float]], duration: float) -> np.ndarray:
    """Return a desired motion from amplitudes [m], frequencies [Hz] and phases, starting at rest; shape (4, sample)."""
    t = DT * np.arange(round(duration / DT))
    ease, rows = np.clip(t / 1.0, 0.0, 1.0), np.zeros((4, t.size))
    window = ease**3 * (10.0 - 15.0 * ease + 6.0 * ease**2)
    for amplitude, frequency, phase in parts:
        rows[0] += amplitude * np.sin(2.0 * np.pi * frequency * t + phase)
    rows[0] = (rows[0] - rows[0, 0]) * window
    rows[1] = np.gradient(rows[0], DT)
    rows[2] = np.gradient(rows[1], DT)
    return rows
