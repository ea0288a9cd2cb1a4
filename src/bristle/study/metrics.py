"""What is kept of a run: numbers out of what ``bristle run --json`` tells of a variant, by their dotted names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import reduce

import numpy as np

from bristle.core.errors import InputError, did_you_mean
from bristle.core.experiment import Experiment
from bristle.core.status import Status
from bristle.core.variable import unit_of
from bristle.simulation.result import Statistics, VariantResult

STATISTICS = tuple(field.name for field in fields(Statistics))
LENGTHS = ("following_error", "true_error", "by_direction.forward", "by_direction.backward", "motion")
EFFORTS = {"effort.rms": "effort_rms", "effort.peak": "effort_peak"}
METRICS = (*(f"{group}.{name}" for group in LENGTHS for name in STATISTICS), *EFFORTS)  # the numbers of a variant by dotted name

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
    """A number that is kept of each run."""

    column: str
    variant: str
    name: str
    unit: str

    @property
    def described(self) -> str:
        """What it is, in words, with its variant where the column names it."""
        group, _, statistic = self.name.rpartition(".")
        words = f"{SHORT.get(group, group)}, {SHORT.get(statistic, statistic)}"
        return words if self.column == self.name else f"{self.variant}: {words}"

    def of(self, result: VariantResult) -> float:
        """Return the number of a run; NaN for one that left the finite numbers."""
        if result.status is Status.NOT_FINITE:
            return float("nan")
        if self.name in EFFORTS:
            return float(getattr(result, EFFORTS[self.name]))
        group, _, statistic = self.name.rpartition(".")
        if group.startswith("by_direction."):
            return float(getattr(result.by_direction[group.partition(".")[2]], statistic))
        return float(reduce(getattr, (group, statistic), result))

    def along(self, position: np.ndarray, effort: np.ndarray) -> np.ndarray:
        """Return the number of several open loops, shape (run,), from what is judged of them, shape (run, sample).

        To the bit what `of` returns of each by itself.
        """
        group, _, statistic = self.name.rpartition(".")
        if self.name == "effort.peak":
            return np.max(np.abs(effort), axis=1, initial=0.0)
        if group not in ("motion", "effort"):  # nothing follows a reference
            return np.full(len(position), np.nan)
        rows = position if group == "motion" else effort
        if statistic == "peak_to_peak":
            return rows.max(axis=1) - rows.min(axis=1)
        if statistic == "rms":
            return np.sqrt(np.mean(rows * rows, axis=1))
        return getattr(rows, statistic)(axis=1)  # of the same name in numpy: min, max, mean, std


def usual_metrics(experiment: Experiment) -> tuple[str, ...]:
    """Return what is kept where a study does not say."""
    is_open = all(variant.effort is not None for variant in experiment.variants)
    return ("motion.peak_to_peak" if is_open else "following_error.peak_to_peak", "effort.rms")


def metrics_from(names: Sequence[object], experiment: Experiment, path: str) -> tuple[Metric, ...]:
    """Return the metrics of these names, of each variant where a name says none."""
    metrics: list[Metric] = []
    variants = [variant.name for variant in experiment.variants]
    for place, name in enumerate(names):
        at = f"{path}[{place}]"
        if not isinstance(name, str):
            raise InputError("must be the name of a metric", path=at, value=name, mend='Write "effort.rms"')
        chosen, metric = variants, name
        for variant in variants:
            if name.startswith(f"{variant}."):
                chosen, metric = [variant], name.removeprefix(f"{variant}.")
        if metric not in METRICS:
            raise InputError(
                "is no metric of a run",
                path=at,
                value=name,
                allowed=f"{', '.join(LENGTHS)}, each with .{', .'.join(STATISTICS)}; {', '.join(EFFORTS)}",
                mend=did_you_mean(metric, METRICS),
            )
        unit = unit_of("force" if metric in EFFORTS else "length", experiment.kind)
        metrics += [Metric(metric if len(variants) == 1 else f"{variant}.{metric}", variant, metric, unit) for variant in chosen]
    columns = [metric.column for metric in metrics]
    for column in columns:
        if columns.count(column) > 1:
            raise InputError("is named twice", path=path, value=column)
    return tuple(metrics)
