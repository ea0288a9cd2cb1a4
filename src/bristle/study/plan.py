"""`Study`: what is varied, how often, and what is kept, as data; and the values of each of its runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from math import prod
from typing import Any

import numpy as np

from bristle.core.content import Origin
from bristle.core.experiment import Experiment
from bristle.core.lazy import cached_property
from bristle.files.sources import Sources
from bristle.study.metrics import Metric
from bristle.study.sampling import Sampling, seed_of_run
from bristle.study.values import Cause, Target

BLOCK_MOST = 4096
BLOCK_STEPS = 10_000_000  # of the integration: about a second or two
BLOCKS_LEAST = 32  # so that cores have something to share, and little is lost with one


@dataclass(frozen=True)
class Block:
    """Runs that are simulated, written and lost together."""

    first: int
    last: int

    @property
    def count(self) -> int:
        """How many runs it has."""
        return self.last - self.first

    @property
    def file(self) -> str:
        """Name of its file."""
        return f"{self.first:010d}.parquet"


@dataclass(frozen=True, eq=False)
class Study:
    """Many runs of an experiment.

    Parameters
    ----------
    name : str
        Name of the study.
    experiment : Experiment
        The experiment as it stands, with one run for each variant.
    tables : mapping
        Its tables, into which the values of a run are written.
    sources : Sources
        What reads the files that they name: all of them are read already.
    seed : int
        Seed of the study.
    sampling : Sampling
        How draws fill their space.
    causes : tuple of Cause
        What is drawn.
    grid : tuple of (Target, tuple)
        Values that each draw is made with, all combinations of them.
    metrics : tuple of Metric
        What is kept; what is largest in the first of them is worst.
    worst : int
        Of how many of the worst runs the signals are kept, too.
    block : int
        Runs in a block.
    described : mapping
        What the study says, as text and numbers: two are the same where these are.
    origins : mapping of str to tuple of Origin
        The files that it was made from.
    """

    name: str
    experiment: Experiment
    tables: Mapping[str, Any]
    sources: Sources
    seed: int
    sampling: Sampling
    causes: tuple[Cause, ...]
    grid: tuple[tuple[Target, tuple[Any, ...]], ...]
    metrics: tuple[Metric, ...]
    worst: int
    block: int
    described: Mapping[str, Any]
    origins: Mapping[str, tuple[Origin, ...]]

    @cached_property
    def points(self) -> tuple[dict[str, Any], ...]:
        """The points of the grid: values by dotted key; one without values where there is no grid."""
        names = [target.path for target, _ in self.grid]
        return tuple(dict(zip(names, values, strict=True)) for values in product(*(values for _, values in self.grid)))

    @property
    def count(self) -> int:
        """Runs in all."""
        return self.sampling.count * prod(len(values) for _, values in self.grid)

    @property
    def blocks(self) -> tuple[Block, ...]:
        """The runs in blocks."""
        return tuple(Block(first, min(first + self.block, self.count)) for first in range(0, self.count, self.block))

    def seeds(self, block: Block) -> list[int]:
        """Return the seeds of the runs of a block."""
        return [seed_of_run(self.seed, number) for number in range(block.first, block.last)]

    def values(self, block: Block) -> dict[str, np.ndarray]:
        """Return what the runs of a block are made with, by dotted key in SI; shape (run,) or (run, element)."""
        numbers = np.arange(block.first, block.last)
        draws, points = np.divmod(numbers, len(self.points))
        drawn = self.sampling.numbers(int(draws[0]), int(draws[-1]) + 1)[draws - draws[0]]
        values: dict[str, np.ndarray] = {}
        for place, cause in enumerate(self.causes):
            values |= cause.values(drawn[:, place])
        for target, _ in self.grid:
            values[target.path] = np.array([self.points[point][target.path] for point in points])
        return values

    @property
    def units(self) -> dict[str, str]:
        """Unit in SI of each value that runs are made with, by dotted key; empty for names and pure numbers."""
        units: dict[str, str] = {}
        for cause in self.causes:
            units |= cause.units
        return units | {target.path: target.unit for target, _ in self.grid}


def block_for(runs: int, experiment: Experiment) -> int:
    """Return how many runs make a block: a function of the study alone, so that any number of workers makes the same."""
    return max(1, min(BLOCK_MOST, BLOCK_STEPS // max(steps_of(experiment), 1), -(-runs // BLOCKS_LEAST)))


def steps_of(experiment: Experiment) -> int:
    """Return the steps of the integration of one run."""
    runs = [variant.run for variant in experiment.variants]
    return sum(round(run.duration / run.sample_time) * max(run.substeps, 1) for run in runs)
