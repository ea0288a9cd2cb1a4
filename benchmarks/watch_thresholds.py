"""Make the table of `bristle.fleet.false_alarms`: ``python -m benchmarks.watch_thresholds [RUNS]``.

Innovations of healthy axes are simulated, as independent normal numbers that are cut as those of an axis are, with an
observation a day and a constant level, and the largest likelihood ratio over both courses and all onsets is followed.
"""

from __future__ import annotations

import sys

import numpy as np

from bristle.fleet.change import largest_ratios
from bristle.fleet.false_alarms import RATES
from bristle.fleet.innovations import CLIP, FEWEST, Innovations

OBSERVATIONS, CHUNK, SEED = 1000, 100, 20


def largest(runs: int, seed: int = SEED, observations: int = OBSERVATIONS) -> np.ndarray:
    """Return the largest ratio of each run until each observation, shape (run, observation)."""
    innovations = Innovations(np.ones((observations, 1)), np.ones(observations))
    generator = np.random.default_rng(seed)
    tops = []
    for _ in range(0, runs, CHUNK):
        scores = np.clip(generator.standard_normal((observations, CHUNK)), -CLIP, CLIP)
        scores[: 1 + FEWEST] = 0.0  # so many observations have no innovation yet
        sizes = largest_ratios(innovations, np.arange(observations, dtype=float), scores)
        tops.append(np.maximum.accumulate(sizes, axis=0).T)
    return np.concatenate(tops)


def thresholds(tops: np.ndarray) -> list[float]:
    """Return the threshold of each rate: what the share exp(-rate * observations) of the runs stays below."""
    horizons = [min(tops.shape[1], round(1.0 / rate)) for rate in RATES]
    return [float(np.quantile(tops[:, horizon - 1], np.exp(-rate * horizon))) for rate, horizon in zip(RATES, horizons, strict=True)]


if __name__ == "__main__":
    found = thresholds(largest(int(sys.argv[1]) if len(sys.argv) > 1 else 20_000))
    print("RATES =", RATES)
    print("THRESHOLDS =", tuple(round(value, 2) for value in found))
