"""What keeps two logs of one motion from being the same: noise, encoder, the level of friction, what a model lacks.

What a model lacks is added to a replicate of a log block by block, each with a sign drawn by chance (wild bootstrap
[1]_).

References
----------
.. [1] A. C. Cameron, J. B. Gelbach, D. L. Miller, "Bootstrap-based improvements for inference with clustered errors",
   Review of Economics and Statistics 90(3), 2008. doi:10.1162/rest.90.3.414
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from bristle.core.contracts import FrictionModel, Model
from bristle.core.packing import pack
from bristle.core.values import numbers_of
from bristle.engine.motion import in_turns
from bristle.friction.level import TRANSMITTED
from bristle.friction.slots import OFFSET
from bristle.identification.dataset import Dataset, Segment

__all__ = ["Disturbance", "correlation_time", "disturbance_of", "force_with_scatter", "scaled", "signs"]

ROUNDING = 0.37  # of an encoder step: what the robust measure of noise says of rounding alone
BLOCKS = 40  # of a segment, in which what the model lacks keeps its sign
LEAST = 0.05  # of the level: friction does not vanish on any half-cycle


class Disturbance(NamedTuple):
    """Causes of a disturbance, each with its size."""

    scatter: float
    noise: float
    resolution: float
    jitter: float = 0.0
    unexplained: float = 0.0


def disturbance_of(dataset: Dataset, scatter: float) -> Disturbance:
    """Return what disturbs a log: its encoder, its noise, and a scatter that is known from elsewhere."""
    # Rounding alone looks like noise, too.
    jitter = max(dataset.noise**2 - (ROUNDING * dataset.resolution) ** 2, 0.0) ** 0.5
    return Disturbance(scatter, dataset.effort_noise, dataset.resolution, jitter)


def signs(count: int, rng: np.random.Generator) -> np.ndarray:
    """Return a sign for each of several blocks of samples: what is left over keeps its course, not its side."""
    blocks = np.minimum(np.arange(count) * BLOCKS // count, BLOCKS - 1)
    return rng.choice([-1.0, 1.0], BLOCKS)[blocks]


def correlation_time(residual: np.ndarray, row_time: float, unexplained: float) -> float:
    """Return how long what a model lacks keeps its side [s]; of the residual, each half-cycle has its own level.

    All that does not average out over a block is put down to it; longer than a block it is not followed. `unexplained`
    is the root mean square of what the model lacks, in the unit of the residual.
    """
    slow = float(np.mean([np.mean(part) ** 2 for part in np.array_split(residual, BLOCKS)]))
    share = min(slow / unexplained**2, 1.0) if unexplained > 0.0 else 0.0
    return share * row_time * residual.size / BLOCKS


def scaled(component: FrictionModel, values: Mapping[str, float], level: float) -> dict[str, float]:
    """Return the values of a model with its forces scaled, the constant offset left as it is."""
    forces = (
        name
        for name, variable in component.variables.items()
        if (variable.quantity == "force" and variable.excitation and variable is not OFFSET) or variable == TRANSMITTED
    )
    return dict(values) | {name: level * values[name] for name in forces}


def force_with_scatter(
    friction: Model,
    segment: Segment,
    starts: Sequence[int],
    dt: float,
    scatter: float,
    rng: np.random.Generator,
    transmitted: np.ndarray | None = None,
) -> np.ndarray:
    """Return the force of friction whose level is drawn anew at each reversal [N or N*m], shape (sample,), unfiltered.

    `starts` are the first samples of half-cycles, `scatter` is the standard deviation of the level as a share of it.
    """
    levels = np.maximum(1.0 + scatter * rng.standard_normal(len(starts)), LEAST)
    mean = pack(friction.parameters)
    component = friction.component
    doubled = pack(component.assemble(scaled(component, numbers_of(component, friction.parameters), 2.0)))
    # A parameter may be infinite; that of a force differs.
    rise = np.subtract(doubled, mean, out=np.zeros_like(mean), where=doubled != mean)
    first = segment.first_cycle
    turns = [0, *(first + start for start in starts[1:])]
    parameters = mean + (levels[:, None] - 1.0) * rise
    signals = segment.signals(dt, transmitted)
    return in_turns(friction, parameters, dt=dt, starts=turns, **signals)[first:]
