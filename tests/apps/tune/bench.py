"""An axis simulated without bristle: a motor with one of four kinds of friction, a PID loop, and a guard, sample by sample.

It is the machine of the tests and benchmarks of `bristle tune`: friction is integrated in 50 steps a sample by its own code
(Maxwell slip with a Stribeck fall, LuGre, Dahl, asperities that snap), the loop knows only the encoder, and the guard adds the
feedforward to the effort of the loop as the component of a real controller does.
"""

import math
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numba import njit

KINDS = ("maxwell_slip", "lugre", "dahl", "asperities")
SUBSTEPS = 50
NAMES = [
    "kind",
    "mass",
    "load",
    "spring",
    "damper",
    "coulomb",
    "rise",
    "stribeck",
    "asymmetry",
    "viscous",
    "reach",
    "damping",
    "gravity",
    "cogging",
    "pitch",
    "lag",
    "delay",
    "resolution",
    "noise",
    "sample_time",
    "p",
    "i",
    "d",
    "inertia",
    "limit",
    "warm_up",
    "heat",
]


@dataclass
class Plant:
    """Parameters of an axis and its loop, in SI units; `load` 0 is one mass."""

    kind: int = 0
    mass: float = 25.0
    load: float = 0.0
    spring: float = 0.0
    damper: float = 0.0
    coulomb: float = 34.0
    rise: float = 0.35
    stribeck: float = 3e-3
    asymmetry: float = 0.04
    viscous: float = 150.0
    reach: float = 60e-6
    damping: float = 0.0
    gravity: float = 0.0
    cogging: float = 0.0
    pitch: float = 0.01
    lag: float = 0.0
    delay: int = 1
    resolution: float = 1e-7
    noise: float = 0.0
    sample_time: float = 1e-3
    p: float = 0.0
    i: float = 0.0
    d: float = 0.0
    inertia: float = 0.0
    limit: float = 400.0
    warm_up: float = 0.0  # share by which friction falls with time
    heat: float = 300.0  # time constant of the warm-up [s]

    def values(self) -> np.ndarray:
        return np.array([float(getattr(self, name)) for name in NAMES])


@dataclass(frozen=True)
class Motion:
    """A motion to and fro: positions of one cycle [m]."""

    cycle: np.ndarray
    sample_time: float = 1e-3

    def played(self, cycles: int, rest: int = 200) -> np.ndarray:
        return np.concatenate([np.zeros(rest), np.tile(self.cycle, cycles), np.zeros(rest)])


def log_uniform(r: np.random.Generator, low: float, high: float) -> float:
    return float(math.exp(r.uniform(math.log(low), math.log(high))))


def drawn_plant(r: np.random.Generator, seed: int) -> Plant:
    """Return a random axis with its loop, tuned by rule."""
    log = partial(log_uniform, r)
    mass, coulomb = log(8, 80), log(15, 120)
    plant = Plant(
        kind=seed % 4,
        mass=mass,
        coulomb=coulomb,
        rise=float(r.uniform(0, 0.5)),
        stribeck=log(1e-3, 8e-3),
        asymmetry=float(r.uniform(-0.12, 0.12)),
        viscous=float(coulomb * r.uniform(1, 8)),
        reach=log(8e-6, 120e-6),
        lag=log(2e-4, 1e-3),
        delay=int(r.integers(0, 4)),
        resolution=log(5e-8, 2e-6),
        noise=float(coulomb * r.uniform(0, 0.01)),
    )
    if plant.kind == 1:
        plant.damping = 0.3 * math.sqrt(3 * coulomb / plant.reach * mass)
    if plant.kind == 2 or seed % 5 == 0:
        plant.gravity, plant.cogging = (
            float(r.uniform(-1, 1) * coulomb),
            float(coulomb * r.uniform(0.05, 0.2)),
        )
        plant.pitch = float(r.choice([0.005, 0.01, 0.02]))
    late = (plant.delay + 1.5) * plant.sample_time + plant.lag
    crossover = 0.5 / late
    if seed % 3 == 0:
        plant.load, plant.mass, first = 0.6 * mass, 0.4 * mass, float(r.uniform(120, 250))
        reduced = plant.load * plant.mass / mass
        plant.spring = (2 * math.pi * first) ** 2 * reduced
        plant.damper = 0.2 * math.sqrt(plant.spring * reduced)
        crossover = min(crossover, 0.12 * 2 * math.pi * first)
    plant.p, plant.i, plant.d = (
        0.4 * mass * crossover**2,
        0.4 * mass * crossover**3 / 20,
        mass * crossover,
    )
    plant.inertia, plant.limit = 0.97 * mass, coulomb * 4 + abs(plant.gravity) + 6 * mass
    return plant


def cycle_of(
    amplitude: float, period: float, dwell: float, sample_time: float = 1e-3
) -> np.ndarray:
    """Return a motion to and fro with rests at its ends, of twice this amplitude."""
    half, rest = round(period / 2 / sample_time), round(dwell / sample_time)
    t = np.arange(half) / half
    rise = (
        (1 - np.cos(math.pi * t)) / 2 if rest == 0 else t - np.sin(2 * math.pi * t) / (2 * math.pi)
    )
    return 2 * amplitude * np.concatenate([rise, np.ones(rest), 1 - rise, np.zeros(rest)])


def drawn(seed: int) -> tuple[Plant, Motion]:
    """Return a random axis and the motion of its user."""
    r = np.random.default_rng([20261127, seed])
    plant = drawn_plant(r, seed)
    # The motion is large beside the error of the loop, as on a machine in use.
    amplitude, period, dwell = (
        log_uniform(r, 0.5e-3, 8e-3),
        float(r.uniform(1.2, 3.0)),
        0.15 * float(r.uniform() < 0.5),
    )
    # The loop breaks the axis away over this distance of the reference.
    distance = plant.coulomb / plant.p + plant.reach
    amplitude = max(amplitude, 12 * plant.coulomb / plant.p)
    # Within a tenth of a second of a reversal, the reference covers twice this distance.
    period = min(period, max(2 * math.pi * math.sqrt(amplitude / (400 * distance)), 0.8))
    amplitude = min(max(amplitude, 400 * distance * (period / (2 * math.pi)) ** 2), 15e-3)
    return plant, Motion(cycle_of(amplitude, period, dwell, plant.sample_time))


@dataclass
class Guard:
    """The sum of loop and feedforward with a ramp, and watchdogs that remove the feedforward and end the motion."""

    following_error: float = math.inf
    effort: float = math.inf
    low: float = -math.inf
    high: float = math.inf
    slew: float = 2.0
    gain: float = 0.0
    offset: float = 0.0
    freezes_at: float = math.inf  # sample from which the encoder keeps its value
    reaches_motor: bool = True  # whether the drive applies the test effort and the feedforward


@dataclass
class Bench:
    """A running axis: its state persists from one record to the next."""

    plant: Plant
    seed: int = 1
    guard: Guard = field(default_factory=Guard)
    state: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        r = np.random.default_rng([self.seed, 7])
        count = 64 if self.plant.kind == 3 else 24
        if self.plant.kind == 3:
            travel, limit = (
                self.plant.reach * (0.05 + r.uniform(size=count)),
                np.exp(1.2 * (r.uniform(size=count) + r.uniform(size=count) - 1)),
            )
        else:
            travel, limit = (
                self.plant.reach * 60.0 ** (np.arange(count) / (count - 1) - 1.0),
                np.ones(count),
            )
        limit = limit * self.plant.coulomb / limit.sum()
        stiff = (1.0 if self.plant.kind == 3 else 1.35) * limit / travel
        springs = np.zeros(count)
        if self.plant.kind == 3:
            limit, stiff = 1.8 * limit, 1.8 * stiff
            springs = 0.3 * limit * (r.uniform(size=count) - 0.5)
        # x v x_load v_load effort z wander gain integral error time previous-reference previous-velocity
        self.values, self.springs, self.limits, self.stiff = np.zeros(13), springs, limit, stiff
        self.late, self.random = np.zeros(16), np.array([np.uint32(self.seed * 2654435761 % 2**32)])

    def play(
        self, reference: np.ndarray, feed: np.ndarray, *, feed_is_truth: bool = False
    ) -> tuple[np.ndarray, int, int]:
        """Return rows (position, effort, true position, friction, gain), their number, and the reason of the guard: 0 for none."""
        g = self.guard
        limits = np.array(
            [
                g.following_error,
                g.effort,
                g.low,
                g.high,
                g.slew,
                g.gain,
                g.offset,
                g.reaches_motor,
                g.freezes_at,
            ]
        )
        out = np.zeros((reference.size, 5))
        count, why = _play(
            self.plant.values(), limits, reference, feed, feed_is_truth, self.values, self.springs, self.limits, self.stiff, self.late,
            self.random, out,
        )  # fmt: skip
        if why:
            g.gain = g.offset = 0.0
        return out[:count], count, why


@njit(cache=True)
def _uniform(state: np.ndarray) -> float:
    state[0] = np.uint32(state[0] * np.uint32(1664525) + np.uint32(1013904223))
    return (state[0] >> np.uint32(8)) / 16777216.0


@njit(cache=True)
def _play(par, guard, reference, feed, feed_is_truth, x, s, limit, stiff, late, random, out):
    kind, mass, load, spring, damper, coulomb, rise, stribeck, asymmetry, viscous = par[:10]
    reach, damping, gravity, cogging, pitch, lag, delay, resolution, noise, T = par[10:20]
    kp, ki, kd, inertia, top, warm, heat = par[20:27]
    n, dt, friction = s.size, T / 50, 0.0
    for k in range(reference.size):
        if k < guard[8] or k == 0:
            position = math.floor(x[0] / resolution + 0.5) * resolution
        error = reference[k] - position
        velocity = (reference[k] - x[11]) / T
        acceleration = (velocity - x[12]) / T
        rate = (error - x[9]) / T
        x[11], x[12], x[9] = reference[k], velocity, error
        x[8] += ki * error * T
        x[8] = min(max(x[8], -top), top)
        loop = min(max(kp * error + x[8] + kd * rate + inertia * acceleration, -top), top)
        x[7] += min(max(guard[5] - x[7], -guard[4] * T), guard[4] * T)
        given = friction if feed_is_truth else feed[k]
        total = loop + x[7] * given + guard[6]
        if abs(error) > guard[0]:
            return k, 1
        if abs(total) > guard[1]:
            return k, 2
        if position < guard[2] or position > guard[3]:
            return k, 3
        for j in range(15, 0, -1):
            late[j] = late[j - 1]
        late[0] = total if guard[7] else loop
        command = late[int(delay)]
        share_of_lag = 1 - math.exp(-dt / lag) if lag > 0 else 1.0
        x[6] += -x[6] * T / 0.5 + noise * math.sqrt(2 * T / 0.5) * 3.46 * (_uniform(random) - 0.5)
        x[10] += T
        level = 1.0 - warm * (1.0 - math.exp(-x[10] / heat))
        out[k, 0], out[k, 1], out[k, 2], out[k, 4] = (
            position,
            total,
            x[2] if load > 0 else x[0],
            x[7],
        )
        for _ in range(50):
            v = x[1]
            dx, a = v * dt, abs(v)
            side = 1 + asymmetry if v >= 0 else 1 - asymmetry
            x[4] += share_of_lag * (command - x[4])
            share = 1 + rise / (1 + (v / stribeck) * (v / stribeck))
            force = 0.0
            if kind == 0:
                for j in range(n):
                    most = limit[j] * share
                    s[j] = min(
                        max(s[j] + stiff[j] * dx, -(1 - asymmetry) * most), (1 + asymmetry) * most
                    )
                    force += s[j]
            elif kind == 1:
                stiffness, g = 3.0 * coulomb / reach, coulomb * share * side
                z = (x[5] + dx) / (1 + a * dt * stiffness / g)
                force = stiffness * z + damping * (z - x[5]) / dt
                x[5] = z
            elif kind == 2:
                stiffness, g = 3.0 * coulomb / reach, coulomb * side
                x[5] = (x[5] + dx) / (1 + a * dt * stiffness / g)
                force = stiffness * x[5]
            else:
                for j in range(n):
                    most = limit[j] * (1 + rise * 0.5 / (1 + a / stribeck))
                    s[j] += stiff[j] * dx
                    if s[j] > (1 + asymmetry) * most:
                        s[j] = -0.1 * _uniform(random) * most
                    elif s[j] < -(1 - asymmetry) * most:
                        s[j] = 0.1 * _uniform(random) * most
                    force += s[j]
            friction = (
                level * force
                + viscous * v
                + gravity
                + x[6]
                + cogging * math.sin(2 * math.pi * x[0] / pitch)
            )
            if load > 0:
                link = spring * (x[0] - x[2]) + damper * (v - x[3])
                x[3] += dt * link / load
                x[2] += x[3] * dt
                x[1] += dt * (x[4] - friction - link) / mass
            else:
                x[1] += dt * (x[4] - friction) / mass
            x[0] += x[1] * dt
        out[k, 3] = friction
    return reference.size, 0
