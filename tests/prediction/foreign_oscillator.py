"""An oscillator with a hysteretic spring, by a simulator that is not the package's, driven by a sum of sines."""

import numpy as np

from bristle.logs.log import Channel, Log

__all__ = ["AXIS_STEP", "recorded"]

DT, STEPS = 1e-3, 30  # in a sample
MASS, STIFFNESS, DAMPING = 2.0, 5e4, 10.0
# Of the hysteretic force: stiffness, largest value, slip that depends on direction.
RISE, LEVEL, SHARE = (4e5, 30.0, 0.6)
AXIS_STEP = 1e-6


def recorded(
    seed: int,
    *,
    noise: float = 8e-6,
    step: float = AXIS_STEP,
    duration: float = 2.0,
    force: int = 0,
) -> Log:
    """Return the log of an oscillator that has rested before, its position read with noise and in steps [m].

    `seed` is that of the noise, `force` that of the sines.
    """
    time, phases = DT * np.arange(round(duration / DT)), np.random.default_rng(force)
    push = np.zeros(time.size)
    for frequency in np.arange(1.0, 30.0):
        push += np.sin(2.0 * np.pi * frequency * time + phases.uniform(0.0, 2.0 * np.pi))
    push *= 60.0 / np.std(push) * np.clip(time / 0.2, 0.0, 1.0)
    h, x, v, f = DT / STEPS, 0.0, 0.0, 0.0
    position = np.empty(time.size)
    for k, pushed in enumerate(push.tolist()):
        position[k] = x
        for _ in range(STEPS):
            turned = SHARE if v * f > 0.0 else -SHARE
            f += h * v * RISE * (1.0 - (f / LEVEL) ** 2 * (1.0 - SHARE + turned))
            v += h * (pushed - STIFFNESS * x - DAMPING * v - f) / MASS
            x += h * v
    position += np.random.default_rng(seed).normal(0.0, noise, time.size)
    return Log(
        time=Channel(time, "s", "t"),
        position=Channel(step * np.round(position / step), "m", "q"),
        effort=Channel(push, "N", "u"),
        sample_time=DT,
        segments=(slice(0, time.size),),
    )
