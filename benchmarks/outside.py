"""Simulated axes whose friction belongs to no model of bristle, on a stated motion with an encoder and noise.

Elements slip at limits that fall with a lagged speed, each at a speed of its own (``shape``). The level varies along the
axis (``place``) or falls while the axis warms up (``drift``), and viscous friction rises with a root of the speed
(``root``). ``all`` combines these causes. The simulation shares no code with bristle.
"""

from __future__ import annotations

import numpy as np

from bristle.core import Axis
from bristle.logs.log import Channel, Log

__all__ = ["AXIS", "KINDS", "record"]

KINDS = ("shape", "place", "drift", "root", "all")
SAMPLE_TIME, SECONDS, MASS, ENCODER, NOISE = 1e-3, 20.0, 3.0, 1e-7, 0.05  # [s, s, kg, m, N]
AXIS = Axis(kind="translational", resolution=ENCODER)
# Largest amplitude [m], frequencies [Hz]
SINES = ((10e-3, 0.1, 0.4), (2e-3, 0.4, 1.0), (60e-6, 1.0, 3.0), (8e-6, 2.0, 5.0))


def record(kind: str, seed: int, number: int) -> Log:
    """Return a record of the axis with this seed; records with other numbers have other motions and noise."""
    rng, drawn = np.random.default_rng((seed, number)), np.random.default_rng((seed, 1000))
    time = SAMPLE_TIME * np.arange(round(SECONDS / SAMPLE_TIME))
    x, v, a = np.zeros((3, time.size))
    for amplitude, low, high in (*SINES, *SINES):
        w, phase, size = (
            2.0 * np.pi * rng.uniform(low, high),
            rng.uniform(0.0, 2.0 * np.pi),
            amplitude * rng.uniform(0.4, 1.0),
        )
        x += size * np.sin(w * time + phase)
        v += size * w * np.cos(w * time + phase)
        a -= size * w * w * np.sin(w * time + phase)
    effort = MASS * a + _friction(kind, time, x, v, drawn) + NOISE * rng.standard_normal(time.size)
    return Log(
        time=Channel(time, "s", "t"),
        position=Channel(ENCODER * np.round(x / ENCODER), "m", "x"),
        effort=Channel(effort, "N", "u"),
        sample_time=SAMPLE_TIME,
        segments=(slice(0, time.size),),
    )


def _friction(
    kind: str, time: np.ndarray, x: np.ndarray, v: np.ndarray, drawn: np.random.Generator
) -> np.ndarray:
    """Return the friction force along a motion [N]."""
    reach = np.geomspace(0.5e-6, 40e-6, 15)
    level, shares = 20.0 * drawn.uniform(0.8, 1.2), drawn.dirichlet(np.full(reach.size, 1.5))
    falls, fall, lag = (
        1e-3 * 10.0 ** drawn.uniform(-0.3, 0.7, reach.size),
        drawn.uniform(0.2, 0.6),
        drawn.uniform(2e-3, 8e-3),
    )
    wave, period, phase = (
        drawn.uniform(0.05, 0.2),
        drawn.uniform(4e-3, 9e-3),
        drawn.uniform(0.0, 2.0 * np.pi),
    )
    warm, viscous, root = (
        drawn.uniform(0.05, 0.15),
        drawn.uniform(30.0, 150.0),
        drawn.uniform(0.4, 0.7),
    )
    force, deflection, lagged, stiffness = (
        np.zeros(time.size),
        np.zeros(reach.size),
        0.0,
        shares * level / reach,
    )
    for k, way in enumerate(np.diff(x, prepend=x[0])):
        lagged += (abs(v[k]) - lagged) * SAMPLE_TIME / lag
        limit = (
            reach * (1.0 + fall * (np.exp(-((lagged / falls) ** 2)) - 0.5))
            if kind in ("shape", "all")
            else reach
        )
        deflection = np.clip(deflection + way, -limit, limit)
        force[k] = stiffness @ deflection
    if kind in ("place", "all"):
        force *= 1.0 + wave * np.sin(2.0 * np.pi * x / period + phase)
    if kind in ("drift", "all"):
        force *= 1.0 + warm * np.exp(-time / 12.0)
    if kind in ("root", "all"):
        force += 0.3 * viscous * np.sign(v) * (np.abs(v) / 0.05) ** root
    return force + viscous * v
