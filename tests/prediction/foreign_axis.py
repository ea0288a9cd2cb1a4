"""A servo axis in a P position loop with a PI velocity loop, by a simulator that is not the package's.

Semi-implicit steps: the velocity from the forces, then the position from the new velocity. Friction is a bristle that
deflects, with a level that falls with speed.
"""

from collections import namedtuple

import numpy as np

from bristle.logs.log import Channel, Log

__all__ = ["TABLE", "VERTICAL", "Axis", "moves", "recorded"]


# A mass with friction, its drive and its encoder, in SI.
Axis = namedtuple(
    "Axis",
    (
        "mass",
        "weight",
        "coulomb",
        "static",
        "stribeck",
        "viscous",
        "stiffness",
        "damping",
        "k_p",
        "k_v",
        "k_i",
        "k_ff",
        "count",
    ),
)
VERTICAL = Axis(38.0, 210.0, 30.0, 38.0, 6e-3, 120.0, 3e6, 2e3, 60.0, 8000.0, 2e5, 1.0, 2e-7)
TABLE = Axis(120.0, 0.0, 45.0, 60.0, 1e-2, 300.0, 6e6, 6e3, 45.0, 2.2e4, 0.0, 0.0, 1e-7)
STEPS = 40  # in a sample


def moves(
    duration: float = 9.0, dt: float = 1e-3, stroke: float = 0.08, seed: int = 3
) -> np.ndarray:
    """Return moves of several lengths and speeds with rests between them, the corners rounded [m]."""
    generator = np.random.default_rng(seed)
    pieces, at = [np.zeros(round(0.3 / dt))], 0.0
    while sum(piece.size for piece in pieces) < duration / dt:
        to = float(generator.uniform(-stroke, stroke))
        count = round(abs(to - at) / float(10.0 ** generator.uniform(-2.0, -0.8)) / dt) + 80
        share = np.clip((np.arange(count) - 40.0) / (count - 80.0), 0.0, 1.0)
        share = np.convolve(
            np.pad(share, 40, mode="edge"), np.hanning(41) / np.hanning(41).sum(), mode="same"
        )
        pieces += [at + (to - at) * share[40:-40], np.full(round(0.08 / dt), to)]
        at = to
    return np.concatenate(pieces)[: round(duration / dt)]


def recorded(
    axis: Axis,
    reference: np.ndarray,
    dt: float = 1e-3,
    *,
    delay: int = 0,
    noise: float = 0.3,
    first: int = 0,
    jitter: float = 0.0,
    seed: int = 5,
    pulses: np.ndarray | None = None,
    limit: float = np.inf,
) -> Log:
    """Return the log of an axis that has rested before, from a sample on; its effort acts until the next one.

    `pulses` are added to what the law asks for, and `limit` bounds the sum.
    """
    trembles = np.random.default_rng(1000 + seed).normal(0.0, jitter, reference.size)
    added = np.zeros(reference.size) if pulses is None else pulses
    h, x, v, z, integral = dt / STEPS, float(reference[0]), 0.0, 0.0, axis.weight
    before, queue = axis.count * round(x / axis.count), [axis.weight] * delay
    positions, efforts = np.empty(reference.size), np.empty(reference.size)
    steps = np.diff(reference, prepend=reference[0])
    for k, wanted in enumerate(reference):
        read = axis.count * round((x + trembles[k]) / axis.count)
        error = axis.k_p * (wanted - read) + (axis.k_ff * steps[k] - (read - before)) / dt
        integral += axis.k_i * error * dt
        before = read
        queue.append(min(max(axis.k_v * error + integral + added[k], -limit), limit))
        effort = queue.pop(0)
        positions[k], efforts[k] = read, effort
        for _ in range(STEPS):
            level = axis.coulomb + (axis.static - axis.coulomb) * np.exp(
                -((v / axis.stribeck) ** 2)
            )
            # The deflection implicitly: explicitly it would be unstable when the axis slides.
            z = (z + h * v) / (1.0 + h * axis.stiffness * abs(v) / level)
            rate = v - axis.stiffness * abs(v) * z / level
            friction = axis.stiffness * z + axis.damping * rate + axis.viscous * v
            v += h * (effort - axis.weight - friction) / axis.mass
            x += h * v
    message = np.random.default_rng(seed).normal(0.0, noise, reference.size) + efforts
    part = slice(first, None)
    return Log(
        time=Channel(dt * np.arange(reference.size - first), "s", "t"),
        position=Channel(positions[part], "m", "q"),
        effort=Channel(message[part], "N", "u"),
        reference=Channel(reference[part], "m", "r"),
        sample_time=dt,
        injected=() if pulses is None else (Channel(pulses[part], "N", "pulses"),),
        segments=(slice(0, reference.size - first),),
    )
