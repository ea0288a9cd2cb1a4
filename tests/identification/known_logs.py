"""Logs with known truth: a prescribed motion, and the effort that it took."""

from typing import NamedTuple

import numpy as np

from bristle import controllers, plants, sensors
from bristle.core import Axis, Model
from bristle.engine import force_along, run_closed_loop
from bristle.logs.log import Channel, Log

# The treatment is stated in full: least squares of the log as it comes, before which nothing is looked for.
STATED = Axis(seeks_delay=False, cutoff=100.0, method="inverse_dynamics")


class Motion(NamedTuple):
    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray


def sines(
    duration=10.0,
    dt=1e-3,
    amplitudes=(0.02, 0.008, 0.004),
    frequencies=(0.5, 1.7, 3.1),
    phases=(0, 1, 2),
):
    t = dt * np.arange(round(duration / dt))
    q, v, a = np.zeros((3, t.size))
    for amplitude, frequency, phase in zip(amplitudes, frequencies, phases, strict=True):
        w = 2.0 * np.pi * frequency
        q += amplitude * np.sin(w * t + phase)
        v += amplitude * w * np.cos(w * t + phase)
        a -= amplitude * w * w * np.sin(w * t + phase)
    return Motion(t, q, v, a)


def strokes(repeats=5, dt=1e-3, length=0.05, move=1.0, dwell=0.8):
    """Back and forth with a rest at either end: a motion with a jerk limit."""
    s = np.linspace(0.0, 1.0, round(move / dt), endpoint=False)
    present = length * (s - np.sin(2.0 * np.pi * s) / (2.0 * np.pi))
    rest = np.full(round(dwell / dt), length)
    q = np.tile(np.concatenate([present, rest, length - present, 0.0 * rest]), repeats)
    v = np.gradient(q, dt)
    return Motion(dt * np.arange(q.size), q, v, np.gradient(v, dt))


def log_of(
    motion: Motion, effort: np.ndarray, *, step: float = 0.0, kind="translational", segments=()
) -> Log:
    """A log of a motion, its position rounded to the step of an encoder."""
    position = np.round(motion.position / step) * step if step else motion.position
    units = ("m", "N") if kind == "translational" else ("rad", "N*m")
    return Log(
        time=Channel(motion.time, "s", "t"),
        position=Channel(position, units[0], "q"),
        effort=Channel(effort, units[1], "u"),
        sample_time=float(motion.time[1] - motion.time[0]),
        segments=segments or (slice(0, motion.time.size),),
        kind=kind,
    )


TRUTH = {"M": 12.0, "F_v": 30.0, "F_C": 8.0, "offset": 1.5}


def sliding_effort(
    motion: Motion, seed: int = 0, noise: float = 0.3, **changes: float
) -> np.ndarray:
    """Effort of an axis with Coulomb and viscous friction of the truth, changed here and there, with white noise."""
    truth = TRUTH | changes
    side = np.where(motion.velocity < 0.0, -1.0, 1.0)
    friction = truth["F_C"] * side + truth["F_v"] * motion.velocity + truth["offset"]
    scatter = np.random.default_rng(seed).normal(0.0, noise, motion.time.size)
    return truth["M"] * motion.acceleration + friction + scatter


def sliding_log(seed: int = 0, noise: float = 0.3, **changes: float) -> Log:
    """A log of sines with Coulomb and viscous friction."""
    phases = np.random.default_rng(1000 + seed).uniform(0.0, 2.0 * np.pi, 3)
    motion = sines(phases=tuple(phases))
    return log_of(motion, sliding_effort(motion, seed, noise, **changes))


def slow_log(
    model: Model,
    *,
    M: float = 12.0,
    noise: float = 0.05,
    step: float = 1e-7,
    duration: float = 20.0,
) -> Log:
    """A log of slow sines with many reversals, friction by a model that is run ten times as fine as the log."""
    fine, dt = 10, 1e-3
    motion = sines(duration, dt / fine, (6e-3, 6e-4, 2e-4), (0.25, 1.7, 3.1))
    friction = force_along(model, motion.velocity, dt / fine, motion.position)
    scatter = np.random.default_rng(1).normal(0.0, noise, motion.time[::fine].size)
    coarse = Motion(*(item[::fine] for item in motion))
    return log_of(coarse, M * coarse.acceleration + friction[::fine] + scatter, step=step)


def virgin_curve(values: dict, x: np.ndarray, level: str = "F_C") -> np.ndarray:
    """Force of elements that slip, along a displacement that begins with all of them unloaded."""
    return np.minimum(np.outer(x, values["k_i"]), np.asarray(values["nu_i"]) * values[level]).sum(
        axis=1
    )


def held_log(model: Model, *, M: float = 28.0, noise: float = 0.3, duration: float = 16.0) -> Log:
    """A log of a sampled loop, which holds each effort until its next sample, on slow sines."""
    motion, dt = sines(duration, 1e-3, (6e-3, 2e-3, 6e-4), (0.25, 0.9, 1.7), (0, 0, 0)), 1e-3
    law = controllers.cascade(k_p=60.0, k_v=7000.0, k_i=2e5)
    desired = np.stack(
        [motion.position, motion.velocity, motion.acceleration, np.zeros(motion.time.size)]
    )
    trace = run_closed_loop(
        plants.inertia(M=M), model, law, sensors.encoder(resolution=1e-7), desired, dt, steps=50
    )
    reached = Motion(motion.time, trace.measured, motion.velocity, motion.acceleration)
    scatter = np.random.default_rng(3).normal(0.0, noise, motion.time.size)
    return log_of(reached, trace.command + scatter)
