"""A simulated axis that shares no code with bristle, around a control law of bristle: friction and integration of its own."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit

DT, STEPS = 5e-4, 5  # [s] sample time; integration steps in a sample
M = 631.65  # [kg]
GAINS: dict[str, Any] = {"J": M, "lambda_": 150.0, "K_1": 150.0, "cutoff": 400.0}
RESOLUTION, NOISE, LAG = 0.125e-6, 0.01e-6, 2e-4  # [m] of the encoder; [m]; [s] of the current loop
BRISTLES, SLIDERS = 0, 1


@dataclass
class Friction:
    """Bristles (Dahl, LuGre) or sliders (Maxwell slip with Stribeck limits that differ by direction)."""

    kind: int
    numbers: tuple[float, ...]  # rise of the static level, v_S, sigma_1, sigma_2, offset, side
    k: np.ndarray  # [N/m] of each element
    limit: np.ndarray  # [N] of each element


def dahl(F_C: float = 42.7, sigma_0: float = 18e6) -> Friction:
    """Return Dahl's friction."""
    return Friction(BRISTLES, (0.0, 1.0, 0.0, 0.0, 0.0, 0.0), np.array([sigma_0]), np.array([F_C]))


def lugre() -> Friction:
    """Return LuGre friction."""
    return Friction(
        BRISTLES, (0.18, 4e-4, 5e4, 4737.0, 6.3, 0.0), np.array([36e6]), np.array([42.7])
    )


def sliders(seed: int, count: int = 20) -> Friction:
    """Return an axis of a fleet: elements, level, asymmetry and offset differ from seed to seed."""
    generator = np.random.default_rng(seed)
    reach = 7e-6 * np.sort(generator.uniform(0.03, 1.0, count))  # [m]
    limit = generator.uniform(0.6, 1.4, count)
    limit *= 42.7 * generator.uniform(0.8, 1.2) / np.sum(limit)
    stiffness = limit / reach
    stiffness *= min(1.0, 18e6 / float(np.sum(stiffness)))
    return Friction(
        SLIDERS,
        (0.18, 4e-4, 5e4, 4737.0, generator.uniform(0.0, 12.0), generator.uniform(0.1, 0.4)),
        stiffness,
        limit,
    )


@njit(cache=False)
def advanced(
    kind, numbers, k, limit, force, x, v, acting, coming, follows, h, steps
):  # pragma: no cover
    """Return position, velocity, acting effort and friction after a sample; `force` of the elements changes in place."""
    rise, v_S, sigma_1, sigma_2, offset, side = numbers
    total = 0.0
    for _ in range(steps):
        acting += follows * (coming - acting)
        level, total = 1.0 + rise * np.exp(-((v / v_S) ** 2)), offset + sigma_2 * v
        sticking, whole = 0.0, 0.0
        for i in range(k.size):
            most = level * limit[i]
            if kind == BRISTLES:
                end = most * np.sign(v)
                force[i] = end + (force[i] - end) * np.exp(-k[i] * abs(v) * h / most)
                total += force[i] + sigma_1 * (v - abs(v) / most * force[i])
            else:
                tried = force[i] + k[i] * v * h
                force[i] = min((1.0 + side) * most, max(-(1.0 - side) * most, tried))
                total += force[i]
                whole += k[i]
                sticking += k[i] * (force[i] == tried)
        if kind == SLIDERS:
            total += sticking / whole * sigma_1 * v
        v += h * (acting - total) / M
        x += h * v
    return x, v, acting, total


@dataclass
class Run:
    """Signals of a run, an element per sample."""

    error: np.ndarray  # [m] desired minus true position
    measured: np.ndarray  # [m]
    effort: np.ndarray  # [N] command of the law
    friction: np.ndarray  # [N]
    position: np.ndarray  # [m]
    states: list[Any]

    def peak(self, first: float = 1.0, last: float = np.inf) -> float:
        """Return the following error peak to peak between two times [m]."""
        t = DT * np.arange(self.error.size)
        return float(np.ptp(self.error[(t >= first) & (t < last)]))


def follow(law: Any, friction: Friction, desired: np.ndarray, seed: int, lag: float = LAG) -> Run:
    """Run a control law along position, velocity, acceleration and feedforward, shape (4, sample)."""
    from bristle.core.contracts import Reference

    generator, component, p = np.random.default_rng(10_000 + seed), law.component, law.parameters
    x, v, acting, coming, h = float(desired[0, 0]), float(desired[1, 0]), 0.0, 0.0, DT / STEPS
    force, states, state, rows = np.zeros(friction.k.size), [], None, []
    noise, follows = NOISE * generator.standard_normal(desired.shape[1]), 1.0 - math.exp(-h / lag)
    for wanted, wrong in zip(desired.T.tolist(), noise.tolist(), strict=True):
        measured = RESOLUTION * round((x + wrong) / RESOLUTION)
        if state is None:
            state = component.start(measured, v, wanted[2], DT, p)
        effort, state = component.step(state, Reference(*wanted), measured, DT, p)
        states.append(state)
        place = x
        x, v, acting, total = advanced(
            friction.kind,
            friction.numbers,
            friction.k,
            friction.limit,
            force,
            x,
            v,
            acting,
            coming,
            follows,
            h,
            STEPS,
        )
        rows.append((wanted[0] - place, measured, effort, total, place))
        coming = effort  # a delay of one sample
    error, read, command, total, position = np.array(rows).T
    return Run(error, read, command, total, position, states)


def harmonic(parts: list[tuple[float, float, float]], duration: float) -> np.ndarray:
    """Return a desired motion from amplitudes [m], frequencies [Hz] and phases, which starts at rest; shape (4, sample)."""
    t = DT * np.arange(round(duration / DT))
    ease, rows = np.clip(t / 1.0, 0.0, 1.0), np.zeros((4, t.size))
    for amplitude, frequency, phase in parts:
        rows[0] += amplitude * np.sin(2.0 * np.pi * frequency * t + phase)
    rows[0] = (rows[0] - rows[0, 0]) * ease**3 * (10.0 - 15.0 * ease + 6.0 * ease**2)
    rows[1] = np.gradient(rows[0], DT)
    rows[2] = np.gradient(rows[1], DT)
    return rows
