"""Dissipation: whether friction takes energy out of closed cycles.

The contact goes around random closed cycles, small and large, slow and fast, until it has settled on each; the work
done on it in the last round must not be negative. Where it is, the cycle is repeated in finer steps: what summing over
steps alone has made vanishes then.
"""

from typing import NamedTuple

import numpy as np

from bristle.certificates.certificate import Certificate, OperatorParameters
from bristle.certificates.quasi_static import CREEP, Holding
from bristle.core.contracts import Model
from bristle.core.typography import number
from bristle.engine import force_along

SEED = 20260
CYCLES, SAMPLES = 200, 400
ROUNDS = 4
ROUNDING = 1e-9
REACHES = np.geomspace(1e-9, 1e3, 49)  # m or rad


class Loop(NamedTuple):
    """A symmetric loop: how far it reaches [m or rad], what share of the work stays in the contact, and its sense.

    That of an operator may be magnetic: the output lags behind the input, where that of friction runs ahead.
    """

    reach: float
    share: float
    is_magnetic: bool


def fattest_loop(model: Model) -> Loop:
    """Return the symmetric loop of which the largest share stays, or is gained: it tells the scale and the sense."""
    phase = np.linspace(0.0, 2.0 * np.pi, SAMPLES + 1)
    shares = [(reach, _share_kept(model, reach * np.sin(phase), reach / CREEP)) for reach in REACHES.tolist()]
    reach, share = max(shares, key=lambda loop: abs(loop[1]))
    return Loop(reach, share, isinstance(model.parameters, OperatorParameters) and share < -ROUNDING)


def dissipation(model: Model, holding: Holding, loop: Loop) -> Certificate:
    """Return the least share of the work, over random closed cycles, that the contact keeps."""
    generator = np.random.default_rng(SEED)
    scale = holding.distance or loop.reach
    sense = -1.0 if loop.is_magnetic else 1.0
    least = min(_share_of_random_cycle(model, generator, scale, sense) for _ in range(CYCLES))
    passed = least >= -ROUNDING
    advice = f"No cycle of {CYCLES} gives energy back"
    if not passed:
        advice = f"A closed cycle returns {number(-100.0 * least, digits=3)} % of its work: see passive for what to change"
    return Certificate(True, least, "1", 0.0, passed, advice)


def _share_of_random_cycle(model: Model, generator: np.random.Generator, scale: float, sense: float) -> float:
    """Return the share of the work that stays, over a closed path of three harmonics, 0.1 to 100 times as wide."""
    orders = generator.choice(np.arange(1, 9), 3, replace=False)
    heights, phases = generator.normal(size=3) / orders, generator.uniform(0.0, 2.0 * np.pi, 3)
    width, speed = scale * 10.0 ** generator.uniform(-1.0, 2.0), 10.0 ** generator.uniform(-6.0, 2.0)

    def share(samples: int) -> float:
        turn = 2.0 * np.pi * np.arange(samples + 1) / samples
        x = width * (heights @ np.sin(np.outer(orders, turn) + phases[:, None]))
        return sense * _share_kept(model, x, float(np.sum(np.abs(np.diff(x)))) / speed)

    coarse = share(SAMPLES)
    if coarse >= -ROUNDING:
        return coarse
    fine = share(8 * SAMPLES)
    return fine if fine < 0.5 * coarse else 0.0


def _share_kept(model: Model, x: np.ndarray, duration: float) -> float:
    """Return what part of the work along a closed path stays, in the last of some rounds."""
    step = np.tile(np.diff(x), ROUNDS)
    dt = duration / (x.size - 1)
    force = force_along(model, step / dt, dt, np.tile(x[1:], ROUNDS))
    work = (force * step)[1 - x.size :]
    total = float(np.sum(np.abs(work)))
    return float(np.sum(work)) / total if total > 0.0 else 0.0
