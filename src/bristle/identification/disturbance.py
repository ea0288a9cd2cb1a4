"""What disturbs a log, as its rows tell it: noise and encoder, and how long what a model lacks keeps its side."""

from __future__ import annotations

import numpy as np

from bristle.identification.dataset import Dataset
from bristle.identification.problem import Disturbance

__all__ = ["disturbance_of", "lasting_of", "signs_of"]

ROUNDING = 0.37  # of an encoder step: what the robust measure of noise says of rounding alone
BLOCKS = 40  # of a segment, in which what the model lacks keeps its sign


def disturbance_of(dataset: Dataset, scatter: float) -> Disturbance:
    """Return what disturbs a log: its encoder, its noise, and a scatter that is known from elsewhere."""
    # Rounding alone looks like noise, too.
    jitter = max(dataset.noise**2 - (ROUNDING * dataset.resolution) ** 2, 0.0) ** 0.5
    return Disturbance(scatter, dataset.effort_noise, dataset.resolution, jitter)


def signs_of(count: int, rng: np.random.Generator) -> np.ndarray:
    """Return a sign for each of several blocks of samples: what is left over keeps its course, not its side."""
    blocks = np.minimum(np.arange(count) * BLOCKS // count, BLOCKS - 1)
    return rng.choice([-1.0, 1.0], BLOCKS)[blocks]


def lasting_of(residual: np.ndarray, row_time: float, unexplained: float) -> float:
    """Return how long what a model lacks keeps its side [s].

    All that does not average out over a block is put down to it; longer than a block it is not followed.

    Parameters
    ----------
    residual : ndarray, shape (row,)
        What the model leaves over, each half-cycle at its own level.
    row_time : float
        Time from row to row [s].
    unexplained : float
        Root mean square of what the model lacks, in the unit of the residual.
    """
    slow = float(np.mean([np.mean(part) ** 2 for part in np.array_split(residual, BLOCKS)]))
    share = min(slow / unexplained**2, 1.0) if unexplained > 0.0 else 0.0
    return share * row_time * residual.size / BLOCKS
