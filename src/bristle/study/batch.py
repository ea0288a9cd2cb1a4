"""Open loops of one mass, many in one call of the engine: to the bit what `simulate` returns of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from bristle.core.contracts import Model
from bristle.core.experiment import Experiment, Variant
from bristle.core.status import Status
from bristle.core.variable import variables_of
from bristle.engine import run_batch
from bristle.study.metrics import Metric

__all__ = ["MODELS", "fits_a_batch", "metrics_of_batch"]

MODELS = ("plant", "friction")
SAMPLES_AT_ONCE = 4_000_000  # of all runs together, so that their records stay in some tens of megabytes


def fits_a_batch(experiment: Experiment) -> bool:
    """Return whether runs of an experiment can be simulated many at once.

    They can where a given effort drives one mass in steps of one length, without lag or delay, and the friction model
    keeps no turning points, whose overflow would have to be told.
    """
    return all(_fits(variant) for variant in experiment.variants)


def _fits(variant: Variant) -> bool:
    run = variant.run
    return (
        variant.effort is not None
        and variant.plant.component.screw is None
        and variant.disturbance is None
        and variant.start is None
        and not (run.tolerance or run.delay or run.current_lag)
        and not _forgets(variant.friction)
    )


def _forgets(model: Model) -> bool:
    """Return whether the state of a model counts what its memory had no room for."""
    return "lost" in variables_of(model.component.State) or model.component.new_memory(model.parameters).size > 0


def metrics_of_batch(
    variant: Variant, changes: Sequence[Mapping[str, Model]], metrics: Sequence[Metric], in_lanes: bool | None = None
) -> tuple[dict[str, np.ndarray], list[Status]]:
    """Return the metrics of one variant in several runs, by column, and how each ended."""
    count = 0 if variant.effort is None else variant.effort.values.size
    size = max(1, SAMPLES_AT_ONCE // max(count, 1))
    parts = [_of_part(variant, changes[first : first + size], metrics, in_lanes) for first in range(0, len(changes), size)]
    columns = {metric.column: np.concatenate([part[0][metric.column] for part in parts]) for metric in metrics}
    return columns, [status for part in parts for status in part[1]]


def _of_part(
    variant: Variant, changes: Sequence[Mapping[str, Model]], metrics: Sequence[Metric], in_lanes: bool | None
) -> tuple[dict[str, np.ndarray], list[Status]]:
    run, driven = variant.run, np.zeros(0) if variant.effort is None else variant.effort.values
    effort = np.clip(driven, -run.effort_limit, run.effort_limit)
    x, v = _begin(variant)
    trace = run_batch(
        _models("plant", variant, changes),
        _models("friction", variant, changes),
        effort,
        run.sample_time,
        steps=run.substeps,
        x=np.full(len(changes), x),
        v=v,
        threads=1,
        in_lanes=in_lanes,
    )
    judged = slice(min(round(run.settle / run.sample_time), effort.size), None)
    applied = np.broadcast_to(effort, trace.position.shape)[:, judged]
    position = np.ascontiguousarray(trace.position[:, judged])  # sums of one run in the order of a run by itself
    columns = {metric.column: metric.along(position, applied) for metric in metrics}
    return columns, list(trace.status)


def _models(field: str, variant: Variant, changes: Sequence[Mapping[str, Model]]) -> Model | list[Model]:
    if not any(field in changed for changed in changes):
        return getattr(variant, field)
    return [changed[field] for changed in changes]


def _begin(variant: Variant) -> tuple[float, float]:
    """Return where the reference of an open loop begins, which is at rest."""
    position, velocity, _ = variant.reference.component.sample(np.zeros(1), variant.reference.parameters)
    return float(position[0]), float(velocity[0])
