"""Logs of an axis whose following error and friction are known."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from bristle.logs.log import Log

MASS = 12.0
STEP = 4e-3  # s


def sine(cycles, *, step=STEP, period=1.0, amplitude=0.05):
    """A reference that repeats: position, velocity and acceleration."""
    w = 2.0 * np.pi / period
    t = step * np.arange(round(cycles * period / step))
    return (
        amplitude * np.sin(w * t),
        amplitude * w * np.cos(w * t),
        -amplitude * w * w * np.sin(w * t),
    )


def wandering(duration, *, step=STEP):
    """A reference that never repeats."""
    t = step * np.arange(round(duration / step))
    waves = ((0.02, 6.5, 1.0), (0.03, 3.5, 2.0), (0.01, 10.6, 3.0))
    return (
        sum(a * np.sin(w * t + p) for a, w, p in waves),
        sum(a * w * np.cos(w * t + p) for a, w, p in waves),
        sum(-a * w * w * np.sin(w * t + p) for a, w, p in waves),
    )


def correlated(rng, count, correlation):
    """Noise of variance 1 that keeps its side."""
    white = rng.standard_normal(count + 500)
    return lfilter([np.sqrt(1.0 - correlation**2)], [1.0, -correlation], white)[500:]


def log(seed, motion, *, gain=1.0, friction=8.0, gravity=0.0, step=STEP, scatter=0.05, **changed):
    """A log of a motion: error and friction differ from half-cycle to half-cycle, noise keeps its side."""
    rng = np.random.default_rng(seed)
    x, v, a = motion
    half_cycle = np.cumsum(np.abs(np.diff(np.sign(v), prepend=np.sign(v[0]))) > 0)
    level = (1.0 + scatter * rng.standard_normal(half_cycle[-1] + 1))[half_cycle]
    error = gain * (2e-5 * np.tanh(v / 0.01) * level + 1e-4 * v) + 3e-6 * correlated(
        rng, x.size, 0.9
    )
    effort = MASS * a + friction * level * np.tanh(v / 0.002) + 20.0 * v + gravity
    effort += 0.8 * correlated(rng, x.size, 0.8)
    channels = {"reference": x, "position": x - error, "effort": effort} | changed
    return Log(
        time=step * np.arange(x.size),
        **{name: item for name, item in channels.items() if item is not None},
    )
