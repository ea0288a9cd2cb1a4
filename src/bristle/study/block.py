"""One block of a study: its runs simulated, and what is kept of them as columns."""

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.errors import BristleError, told_by
from bristle.core.experiment import Experiment, Variant
from bristle.core.status import Status
from bristle.core.variable import variables_of
from bristle.engine import run_batch
from bristle.engine.batch import WORTH_LANES
from bristle.simulation import SimulationResult, simulate
from bristle.study.plan import Block, Metric, Study, steps_of
from bristle.study.store import OK
from bristle.study.varied import Varied, row_of

REFUSED, RAISED = "refused", "raised"
NAMES = {
    Status.OK: OK,
    Status.SOLVE_INACCURATE: "solve_inaccurate",
    Status.TOLERANCE_MISSED: "tolerance_missed",
    Status.MEMORY_OVERFLOW: "memory_overflow",
    Status.NOT_FINITE: "not_finite",
}
FAILED = (NAMES[Status.NOT_FINITE], REFUSED, RAISED)  # the statuses of runs that have no numbers

MODELS = ("plant", "friction")
REASON = 300  # letters


class Simulator:
    """What simulates the runs of a study, in this process."""

    def __init__(self, study: Study, *, batches: bool = True) -> None:
        self.study, self.varied = study, Varied(study)
        self._in_lanes = steps_of(study.experiment) * study.count >= WORTH_LANES
        self.in_batches = batches and self.varied.is_direct and fits_a_batch(study.experiment)

    def run(self, number: int) -> SimulationResult:
        """Return one run of the study, with its signals."""
        block = Block(number, number + 1)
        values = row_of(self.study.values(block), 0)
        with warnings.catch_warnings(action="ignore"):
            return simulate(self.varied.experiment(values, self.study.seeds(block)[0]))

    def columns(self, block: Block) -> dict[str, Any]:
        """Return what is kept of a block, by column, each of shape (run,)."""
        values, seeds = self.study.values(block), self.study.seeds(block)
        status, reason = [OK] * block.count, [""] * block.count
        metrics = {metric.column: np.full(block.count, np.nan) for metric in self.study.metrics}
        with warnings.catch_warnings(action="ignore"):
            batched = self._batched(values, seeds, metrics) if self.in_batches else set()
            for place in (place for place in range(block.count) if place not in batched):
                status[place], reason[place] = self._serial(place, row_of(values, place), seeds[place], metrics)
        return {
            "run": np.arange(block.first, block.last),
            "seed": np.array(seeds),
            "status": status,
            "reason": reason,
            **{path: column for path, column in values.items() if column.ndim == 1},
            # Lists become a column for each element.
            **{
                f"{path}[{element}]": numbers
                for path, column in values.items()
                if column.ndim > 1
                for element, numbers in enumerate(column.T)
            },
            **metrics,
        }

    def _serial(self, place: int, row: Mapping[str, Any], seed: int, metrics: Mapping[str, np.ndarray]) -> tuple[str, str]:
        """Simulate one run; return how it ended, and why."""
        try:
            result = simulate(self.varied.experiment(row, seed))
        except MemoryError:
            raise
        except BristleError as error:
            return REFUSED, told_by(error)[:REASON]
        except Exception as error:  # noqa: BLE001  (a model of a person's own may raise anything: told, not lost)
            return RAISED, f"{type(error).__name__}: {told_by(error)}"[:REASON]
        for metric in self.study.metrics:
            metrics[metric.column][place] = metric.of(result.variants[metric.variant])
        worst = max(result.variants.values(), key=lambda variant: variant.status)
        if worst.status is Status.OK:
            return OK, ""
        sentence = worst.status.sentence
        return NAMES[worst.status], sentence if len(result.variants) == 1 else f"{worst.name}: {sentence}"

    def _batched(self, values: Mapping[str, np.ndarray], seeds: Sequence[int], metrics: Mapping[str, np.ndarray]) -> set[int]:
        """Simulate runs many at once; return those that ended well: of the others each is told by itself."""
        changes = self.varied.models_by_place(values, seeds, MODELS)
        places = np.array(list(changes), dtype=int)
        well = np.ones(len(places), dtype=bool)
        for index, variant in enumerate(self.study.experiment.variants):
            own = [metric for metric in self.study.metrics if metric.variant == variant.name]
            effort = np.zeros(0) if variant.effort is None else variant.effort.values
            size = max(1, 4_000_000 // max(effort.size, 1))  # records of some tens of megabytes
            for first in range(0, len(places), size):
                part = slice(first, first + size)
                models = [changes[place][index] for place in places[part].tolist()]
                numbers, ends = metrics_of_batch(variant, effort, models, own, self._in_lanes)
                well[part] &= np.array([end is Status.OK for end in ends])
                for name, column in numbers.items():
                    metrics[name][places[part]] = column
        return set(places[well].tolist())


def fits_a_batch(experiment: Experiment) -> bool:
    """Return whether runs of an experiment can be simulated many at once.

    They can where a given effort drives one mass in steps of one length, without lag or delay, and the friction model
    keeps no turning points, whose overflow would have to be told.
    """
    for variant in experiment.variants:
        run, friction = variant.run, variant.friction.component
        if variant.effort is None or variant.plant.component.screw is not None:
            return False
        if variant.disturbance is not None or variant.start is not None or run.tolerance or run.delay or run.current_lag:
            return False
        if "lost" in variables_of(friction.State) or friction.new_memory(variant.friction.parameters).size > 0:
            return False
    return True


def metrics_of_batch(
    variant: Variant, effort: np.ndarray, changes: Sequence[Mapping[str, Model]], metrics: Sequence[Metric], in_lanes: bool
) -> tuple[dict[str, np.ndarray], list[Status]]:
    """Return the metrics of one variant in several runs, by column, and how each ended."""
    run = variant.run
    effort = np.clip(effort, -run.effort_limit, run.effort_limit)
    x, v, _ = variant.reference.component.sample(np.zeros(1), variant.reference.parameters)  # an open loop begins at rest
    plant, friction = (
        [changed[field] for changed in changes] if any(field in changed for changed in changes) else getattr(variant, field)
        for field in MODELS
    )
    trace = run_batch(
        plant,
        friction,
        effort,
        run.sample_time,
        steps=run.substeps,
        x=np.full(len(changes), float(x[0])),
        v=float(v[0]),
        threads=1,
        in_lanes=in_lanes,
    )
    judged = slice(min(round(run.settle / run.sample_time), effort.size), None)
    applied = np.broadcast_to(effort, trace.position.shape)[:, judged]
    position = np.ascontiguousarray(trace.position[:, judged])  # sums of one run in the order of a run by itself
    return {metric.column: metric.along(position, applied) for metric in metrics}, list(trace.status)
