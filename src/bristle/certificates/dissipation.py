"""Dissipation: whether friction takes energy out of closed cycles.

The contact goes around random closed cycles, small and large, slow and fast, until it has settled on each; the work
done on it in the last round must not be negative.
"""

from __future__ import annotations

import numpy as np

from bristle.certificates.certificate import Certificate
from bristle.certificates.quasi_static import Holding
from bristle.core.contracts import Model
from bristle.core.typography import number
from bristle.engine import force_along

__all__ = ["dissipation"]

SEED = 20260
CYCLES = 200
SAMPLES = 400
ROUNDS = 4
QUADRATURE = 1e-6  # what summing forces over steps leaves open


def dissipation(model: Model, holding: Holding, is_magnet: bool) -> Certificate:
    """Return the least share of the work, over random closed cycles, that friction keeps."""
    generator = np.random.default_rng(SEED)
    scale = holding.distance or 1e-6
    side = -1.0 if is_magnet else 1.0
    least = min(side * _share_kept(model, _random_cycle(generator, scale), _duration(generator)) for _ in range(CYCLES))
    passed = least >= -QUADRATURE
    advice = f"No cycle of {CYCLES} gives energy back"
    if not passed:
        advice = (
            f"A closed cycle returns {number(-100.0 * least, digits=3)} % of its work: see passive for what to change"
        )
    return Certificate(True, least, "1", 0.0, passed, advice)


def _random_cycle(generator: np.random.Generator, scale: float) -> np.ndarray:
    """Return positions around a closed path of three harmonics, 0.1 to 100 times as wide as pre-sliding."""
    phase = 2.0 * np.pi * np.arange(SAMPLES + 1) / SAMPLES
    x = sum(
        generator.normal() / k * np.sin(k * phase + generator.uniform(0.0, 2.0 * np.pi))
        for k in generator.choice(np.arange(1, 9), 3, replace=False)
    )
    return scale * 10.0 ** generator.uniform(-1.0, 2.0) * (x - x[0])


def _duration(generator: np.random.Generator) -> float:
    return float(10.0 ** generator.uniform(-3.0, 3.0))


def _share_kept(model: Model, x: np.ndarray, duration: float) -> float:
    step = np.tile(np.diff(x), ROUNDS)
    dt = duration / SAMPLES
    force = force_along(model, step / dt, dt, np.tile(x[1:], ROUNDS))
    work = (force * step)[-SAMPLES:]
    total = float(np.sum(np.abs(work)))
    return float(np.sum(work)) / total if total > 0.0 else 0.0
