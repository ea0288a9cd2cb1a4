"""An axis in its drive, simulated apart from the package: spring-sliders, a current loop, a delay, an encoder, cogging.

Friction is a row of spring-sliders with a Stribeck curve over them, stepped by the classical slider rule at 40 substeps
of a sample, semi-implicit in velocity. The drive is a cascade, P over PI, with a velocity from encoder differences; its
current follows with a first-order lag, exactly discretised. No code of `bristle` is used here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numba import njit

__all__ = ["Gains", "Recorded", "Rig", "drawn", "motion"]

SUBSTEPS, SLIDERS = 40, 24
Law = Callable[[int, float], float]


@dataclass(frozen=True)
class Gains:
    """A cascade: position [1/s], velocity [N*s/m or N*m*s/rad], integral of velocity [N/m or N*m/rad]."""

    k_p: float
    k_v: float
    k_i: float = 0.0
    k_ff: float = 0.0


@dataclass(frozen=True)
class Rig:
    """True values of an axis and its drive, in SI units of the axis."""

    mass: float
    coulomb: float
    static: float
    stribeck: float
    viscous: float
    reach: float
    gravity: float = 0.0
    cogging: float = 0.0
    pitch: float = 0.01
    resolution: float = 1e-7
    lag: float = 0.0
    delay: int = 0
    dt: float = 1e-3
    limit: float = math.inf
    scale: np.ndarray = field(default_factory=lambda: np.ones(2))

    def run(self, gains: Gains, reference: np.ndarray, fed: np.ndarray | None = None) -> Recorded:
        """Follow a reference; `fed` is added to the command of each sample. The axis begins at rest, in balance."""
        fed = np.zeros(reference.size) if fed is None else fed
        q, u = _run(
            reference,
            fed,
            self.dt,
            np.array([gains.k_p, gains.k_v, gains.k_i, gains.k_ff]),
            self._numbers,
            self.delay,
            self.scale,
            SLIDERS,
            SUBSTEPS,
        )
        return Recorded(reference, q, u)

    def follow(self, law: Law, reference: np.ndarray) -> Recorded:
        """Follow a reference with any law, called once a sample: ``law(k, position as read)`` gives the effort."""
        position, efforts, bent = (
            np.empty(reference.size),
            np.empty(reference.size),
            np.zeros(SLIDERS),
        )
        moving, numbers = np.array([reference[0], 0.0, self.gravity]), self._numbers
        commands = np.full(reference.size + self.delay, self.gravity)
        for k in range(reference.size):
            position[k] = self.resolution * math.floor(moving[0] / self.resolution + 0.5)
            commands[k + self.delay] = efforts[k] = law(k, position[k])
            _advance(moving, bent, commands[k], self.dt, numbers, self.scale, SUBSTEPS)
        return Recorded(reference, position, efforts)

    @property
    def _numbers(self) -> np.ndarray:
        return np.array(
            [
                self.mass,
                self.coulomb,
                self.static,
                self.stribeck,
                self.viscous,
                self.reach,
                self.gravity,
                self.cogging,
                self.pitch,
                self.resolution,
                self.lag,
                self.limit,
            ]
        )


@dataclass(frozen=True)
class Recorded:
    """What a drive records: reference, position as read, effort as commanded."""

    reference: np.ndarray
    position: np.ndarray
    effort: np.ndarray

    @property
    def error(self) -> float:
        """Following error, peak to peak, behind the first half second or twentieth."""
        error = (self.reference - self.position)[self.reference.size // 20 :]
        return float(np.ptp(error))

    @property
    def rms(self) -> float:
        """Root mean square of the effort."""
        return float(np.sqrt(np.mean(self.effort[self.reference.size // 20 :] ** 2)))


@njit(cache=True)
def _advance(moving, bent, command, dt, rig, scale, substeps):
    """Move the axis over a sample: `moving` is position, velocity and effort of the drive, `bent` the sliders."""
    M, F_C, F_S, v_S, F_v, reach, gravity, cogging, pitch, _, lag, _ = rig
    h, sliders = dt / substeps, bent.size
    decay = math.exp(-h / lag) if lag > 0.0 else 0.0
    x, v, drive = moving
    for _ in range(substeps):
        drive = command + (drive - command) * decay
        way = scale[0] if v > 0.0 else scale[1]
        level = way * (F_C + (F_S - F_C) * math.exp(-((v / v_S) ** 2)))
        friction, stiffness = 0.0, 0.0
        for j in range(sliders):
            most = 2.0 * (j + 1) / (sliders + 1) * reach  # limits of deflection, spread evenly
            bent[j] += v * h
            if abs(bent[j]) > most:
                bent[j] = math.copysign(most, bent[j])
            else:
                stiffness += level / sliders / most
            friction += level / sliders * bent[j] / most
        pull = gravity + cogging * math.sin(2.0 * math.pi * x / pitch)
        damping = 2.0 * 0.3 * math.sqrt(stiffness * M) + F_v
        # Implicit in the stiff part: springs and damping act on the velocity at the end of the step.
        v = (v + h * (drive - friction - pull) / M) / (
            1.0 + h * damping / M + h * h * stiffness / M
        )
        x += h * v
    moving[0], moving[1], moving[2] = x, v, drive


@njit(cache=True)
def _run(reference, fed, dt, gains, rig, delay, scale, sliders, substeps):
    k_p, k_v, k_i, k_ff = gains
    gravity, count, limit = rig[6], rig[9], rig[11]
    n = reference.size
    position, efforts, bent = np.empty(n), np.empty(n), np.zeros(sliders)
    commands = np.zeros(n + delay + 1)
    commands[:delay] = gravity
    moving = np.array([reference[0], 0.0, gravity])
    q_last, r_last, integral = reference[0], reference[0], gravity - fed[0]
    for k in range(n):
        q = count * math.floor(moving[0] / count + 0.5) if count > 0.0 else moving[0]
        wanted = k_p * (reference[k] - q) + k_ff * (reference[k] - r_last) / dt
        error = wanted - (q - q_last) / dt
        free = k_v * error + integral + fed[k]
        effort = min(limit, max(-limit, free))
        if effort == free or error * free < 0.0:
            integral += k_i * error * dt
        q_last, r_last = q, reference[k]
        position[k], efforts[k] = q, effort
        commands[k + delay] = effort
        _advance(moving, bent, commands[k], dt, rig, scale, substeps)
    return position, efforts


def motion(rig: Rig, duration: float, seed: int, reach: float, speed: float) -> np.ndarray:
    """Return a smooth reference: sines of several sizes, with small ones that stay within pre-sliding."""
    rng, t = np.random.default_rng(seed), rig.dt * np.arange(round(duration / rig.dt))
    slow = speed / reach
    large = np.sin(slow * t + 0.3) + 0.35 * np.sin(2.7 * slow * t + rng.uniform(0.0, 6.0))
    shape = 0.5 + 0.5 * np.sin(2.0 * math.pi * t / duration * 2.0 + rng.uniform(0.0, 6.0))
    small = 3.0 * rig.reach * np.sin(9.0 * slow * t)
    x = reach * large * shape + small
    return (x - x[0]) * np.minimum(1.0, (t / 0.5) ** 2)


def drawn(seed: int) -> Rig:
    """Return an axis drawn from a seed."""
    rng = np.random.default_rng(seed)
    mass, dt = float(10.0 ** rng.uniform(0.5, 2.3)), float(rng.choice([2.5e-4, 5e-4, 1e-3]))
    coulomb = float(mass * 10.0 ** rng.uniform(-0.2, 0.5))
    side = float(rng.uniform(0.9, 1.1))
    return Rig(
        mass=mass,
        coulomb=coulomb,
        static=coulomb * float(rng.uniform(1.0, 1.35)),
        stribeck=float(10.0 ** rng.uniform(-2.7, -2.0)),
        viscous=coulomb * float(rng.uniform(0.5, 4.0)),
        reach=float(10.0 ** rng.uniform(-5.5, -4.7)),
        gravity=float(rng.choice([0.0, 0.0, 3.0])) * mass,
        cogging=float(rng.choice([0.0, 0.05])) * coulomb,
        resolution=float(rng.choice([1e-7, 2.5e-7])),
        dt=dt,
        scale=np.array([side, 2.0 - side]),
    )
