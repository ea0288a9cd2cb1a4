"""`Study`: varied values, counts and stored metrics, as data; the values of each run, and the metrics."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import reduce
from itertools import product
from math import prod
from typing import Any

import numpy as np

from bristle.apps.study.values import Cause, Target
from bristle.core import (
    SEED_MAX,
    Experiment,
    InputError,
    Origin,
    Status,
    cached_property,
    did_you_mean,
    unit_of,
)
from bristle.files import Sources
from bristle.simulation import Statistics, VariantResult

STATISTICS = tuple(field.name for field in fields(Statistics))
LENGTHS = (
    "following_error",
    "true_error",
    "by_direction.forward",
    "by_direction.backward",
    "motion",
)
EFFORTS = {"effort.rms": "effort_rms", "effort.peak": "effort_peak"}
# Metrics of a variant by dotted name.
METRICS = (*(f"{group}.{name}" for group in LENGTHS for name in STATISTICS), *EFFORTS)

SHORT = {
    "following_error": "following error",
    "true_error": "true error",
    "by_direction.forward": "following error forward",
    "by_direction.backward": "following error backward",
    "motion": "position",
    "peak_to_peak": "peak to peak",
}


@dataclass(frozen=True)
class Metric:
    """A quantity that bristle stores for each run."""

    column: str
    variant: str
    name: str
    unit: str

    @property
    def described(self) -> str:
        """Description in words, with its variant if the column names it."""
        group, _, statistic = self.name.rpartition(".")
        words = f"{SHORT.get(group, group)}, {SHORT.get(statistic, statistic)}"
        if self.column == self.name:
            return words
        return f"{self.variant}: {words}"

    def of(self, result: VariantResult) -> float:
        """Return the value of the metric in a run; NaN if the run diverged."""
        if result.status is Status.NOT_FINITE:
            return float("nan")
        if self.name in EFFORTS:
            return float(getattr(result, EFFORTS[self.name]))
        group, _, statistic = self.name.rpartition(".")
        if group.startswith("by_direction."):
            return float(getattr(result.by_direction[group.partition(".")[2]], statistic))
        return float(reduce(getattr, (group, statistic), result))

    def along(self, position: np.ndarray, effort: np.ndarray) -> np.ndarray:
        """Return the metric of open loops, shape (run,), from their evaluated part, shape (run, sample), to the bit as `of`."""
        group, _, statistic = self.name.rpartition(".")
        if self.name == "effort.peak":
            return np.max(np.abs(effort), axis=1, initial=0.0)
        if group not in ("motion", "effort"):  # open loops have no reference
            return np.full(len(position), np.nan)
        rows = effort
        if group == "motion":
            rows = position
        if statistic == "peak_to_peak":
            return rows.max(axis=1) - rows.min(axis=1)
        if statistic == "rms":
            return np.sqrt(np.mean(rows * rows, axis=1))
        return getattr(rows, statistic)(axis=1)  # of the same name in numpy: min, max, mean, std


def usual_metrics(experiment: Experiment) -> tuple[str, ...]:
    """Return the default metrics of a study."""
    # Open loops have no reference.
    if all(variant.effort is not None for variant in experiment.variants):
        return ("motion.peak_to_peak", "effort.rms")
    return ("following_error.peak_to_peak", "effort.rms")


def metrics_from(names: Sequence[object], experiment: Experiment, path: str) -> tuple[Metric, ...]:
    """Return the metrics with these names; a name without a variant stands for all variants."""
    metrics: list[Metric] = []
    variants = [variant.name for variant in experiment.variants]
    for place, name in enumerate(names):
        at = f"{path}[{place}]"
        if not isinstance(name, str):
            raise InputError(
                "must be the name of a metric", path=at, value=name, mend='Write "effort.rms"'
            )
        chosen = variants
        metric = name
        for variant in variants:
            if name.startswith(f"{variant}."):
                chosen = [variant]
                metric = name.removeprefix(f"{variant}.")
        if metric not in METRICS:
            raise InputError(
                "is not a metric of a run",
                path=at,
                value=name,
                allowed=f"{', '.join(LENGTHS)}, each with .{', .'.join(STATISTICS)}; {', '.join(EFFORTS)}",
                mend=did_you_mean(metric, METRICS),
            )
        unit = unit_of("length", experiment.kind)
        if metric in EFFORTS:
            unit = unit_of("force", experiment.kind)
        if len(variants) == 1:
            metrics.append(Metric(metric, variants[0], metric, unit))
        else:
            metrics += [Metric(f"{variant}.{metric}", variant, metric, unit) for variant in chosen]
    columns = [metric.column for metric in metrics]
    for column in columns:
        if columns.count(column) > 1:
            raise InputError("is named twice", path=path, value=column)
    return tuple(metrics)


SAMPLINGS = ("random", "latin_hypercube", "sobol")
PER_COUNT = 4  # numbers per count of the generator
SMALLEST = 2.0**-54  # half the spacing of the numbers of the generator, which begin at 0


@dataclass(frozen=True)
class Sampling:
    """Method that fills the space of the draws."""

    method: str
    seed: int
    names: tuple[str, ...]
    rows: int
    indices: bool = False

    @property
    def per_row(self) -> int:
        """Draws from one point."""
        if self.indices:
            return len(self.names) + 2
        return 1

    @property
    def count(self) -> int:
        """Total count of draws."""
        return self.rows * self.per_row

    def numbers(self, first: int, last: int) -> np.ndarray:
        """Return the numbers of the draws in [`first`, `last`), shape (draw, cause)."""
        if not self.indices:
            return self._points(first, last)
        row = first // self.per_row
        width = len(self.names)
        pairs = self._points(row, -(-last // self.per_row))
        own = pairs[:, :width]
        second = pairs[:, width:]
        exchanged = [np.where(np.arange(width) == place, second, own) for place in range(width)]
        draws = np.stack((own, second, *exchanged), axis=1).reshape(-1, width)
        return draws[first - row * self.per_row : last - row * self.per_row]

    def checksum(self) -> str:
        """Return a checksum of numbers that another release of a library could draw differently; empty if no library draws."""
        if self.method == "random":
            return ""
        return hashlib.sha256(self._all.tobytes()).hexdigest()

    @property
    def _dimensions(self) -> tuple[str, ...]:
        return (
            *self.names,
            *(f"{name} of the second point" for name in self.names if self.indices),
        )

    def _points(self, first: int, last: int) -> np.ndarray:
        """Return points; random points come from a separate stream for each seed and name."""
        # An additional cause leaves the others unchanged, and each block of runs draws its numbers independently.
        if self.method != "random":
            return self._all[first:last]
        points = np.empty((last - first, len(self._dimensions)))
        begin = first // PER_COUNT
        for place, name in enumerate(self._dimensions):
            key = int.from_bytes(
                hashlib.sha256(f"{self.seed} {name}".encode()).digest()[:16], "little"
            )
            generator = np.random.Generator(np.random.Philox(key=key, counter=begin))
            points[:, place] = generator.random(last - begin * PER_COUNT)[
                first - begin * PER_COUNT :
            ]
        return np.maximum(points, SMALLEST)

    @cached_property
    def _all(self) -> np.ndarray:
        from scipy.stats import qmc

        if not self.names:
            return np.empty((self.rows, 0))
        if self.method == "latin_hypercube":
            method = qmc.LatinHypercube
        else:
            method = qmc.Sobol
        # Later releases call it rng, and take both.
        generator: Any = {"seed": np.random.default_rng(self.seed)}
        points = method(len(self._dimensions), **generator).random(self.rows)
        return np.clip(points, SMALLEST, 1.0 - SMALLEST)


def seed_of_run(seed: int, number: int) -> int:
    """Return the seed of a run, a function of only the seed of the study and the number of the run.

    Examples
    --------
    >>> seed_of_run(7, 4711), seed_of_run(7, 4712), seed_of_run(8, 4711)
    (708275689, 1655017973, 360334804)
    """
    letters = hashlib.sha256(f"{seed} {number}".encode()).digest()
    return int.from_bytes(letters[:8], "little") % SEED_MAX


BLOCK_MOST = 4096


@dataclass(frozen=True)
class Block:
    """Runs that are simulated, written and lost together."""

    first: int
    last: int

    @property
    def count(self) -> int:
        """Count of runs."""
        return self.last - self.first

    @property
    def file(self) -> str:
        """Name of the file."""
        return f"{self.first:010d}.parquet"


@dataclass(frozen=True, eq=False)
class Study:
    """Many runs of an experiment.

    Parameters
    ----------
    name : str
        Name of the study.
    experiment : Experiment
        The base experiment, with one run for each variant.
    tables : mapping
        Tables of the experiment, into which bristle writes the values of a run.
    sources : Sources
        Reader of the files named in `tables`, which are already loaded.
    seed : int
        Seed of the study.
    sampling : Sampling
        Method that fills the space of the draws.
    causes : tuple of Cause
        Drawn quantities.
    grid : tuple of (Target, tuple)
        Grid of values; bristle runs each draw with all combinations.
    metrics : tuple of Metric
        Stored metrics; the worst run has the largest first metric.
    block : int
        Number of runs in a block.
    described : mapping
        Description of the study as text and numbers: equal descriptions mean equal studies.
    origins : mapping of str to tuple of Origin
        Source files of the study.
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
    block: int
    described: Mapping[str, Any]
    origins: Mapping[str, tuple[Origin, ...]]

    @cached_property
    def points(self) -> tuple[dict[str, Any], ...]:
        """Points of the grid: values by dotted key; without a grid a single empty point."""
        names = [target.path for target, _ in self.grid]
        return tuple(
            dict(zip(names, values, strict=True))
            for values in product(*(values for _, values in self.grid))
        )

    @property
    def count(self) -> int:
        """Total count of runs."""
        return self.sampling.count * prod(len(values) for _, values in self.grid)

    @property
    def blocks(self) -> tuple[Block, ...]:
        """The runs in blocks."""
        return tuple(
            Block(first, min(first + self.block, self.count))
            for first in range(0, self.count, self.block)
        )

    def seeds(self, block: Block) -> list[int]:
        """Return the seeds of the runs of a block."""
        return [seed_of_run(self.seed, number) for number in range(block.first, block.last)]

    def values(self, block: Block) -> dict[str, np.ndarray]:
        """Return the values of the runs of a block, by dotted key in SI; shape (run,) or (run, element)."""
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
    def columns(self) -> dict[str, dict[str, str]]:
        """Role of each column of a block, and its unit in SI."""
        probe = self.values(self.blocks[0])
        grid = {target.path for target, _ in self.grid}
        columns = {
            name: {"role": "run", "unit": ""} for name in ("run", "seed", "status", "reason")
        }
        for path, unit in self.units.items():
            shape = probe[path].shape[1:]
            names = [path]
            if shape:
                names = [f"{path}[{element}]" for element in range(shape[0])]
            role = "drawn"
            if path in grid:
                role = "grid"
            columns |= {name: {"role": role, "unit": unit} for name in names}
        for metric in self.metrics:
            columns[metric.column] = {
                "role": "metric",
                "unit": metric.unit,
                "description": metric.described,
            }
        return columns

    @property
    def units(self) -> dict[str, str]:
        """SI unit of each varied value, by dotted key; empty for names and pure numbers."""
        units: dict[str, str] = {}
        for cause in self.causes:
            units |= cause.units
        return units | {target.path: target.unit for target, _ in self.grid}


def block_for(runs: int, experiment: Experiment) -> int:
    """Return the count of runs in a block: it depends only on the study, so that any number of workers gives the same blocks."""
    # A block takes a second or two; 32 blocks share well over cores, and a lost block costs little.
    return max(1, min(BLOCK_MOST, 10_000_000 // max(steps_of(experiment), 1), -(-runs // 32)))


def steps_of(experiment: Experiment) -> int:
    """Return the steps of the integration of one run."""
    runs = [variant.run for variant in experiment.variants]
    return sum(round(run.duration / run.sample_time) * max(run.substeps, 1) for run in runs)
