"""One block of a study: the experiment of each run, its simulation, and its stored columns.

By default, bristle writes the values of a run into the tables of the file and reads them like any experiment. If all values are
parameters of models, bristle sets them in the loaded models, a hundred times faster. It compares both ways for the first and
the last run of each study.
"""

import copy
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import reduce
from typing import Any, TypeVar

import numpy as np

from bristle.apps.study.plan import Block, Metric, Study, steps_of
from bristle.apps.study.store import OK
from bristle.apps.study.values import sections_of
from bristle.core import (
    SEED_MAX,
    BristleError,
    Experiment,
    InputError,
    Model,
    Status,
    Variant,
    error_text,
)
from bristle.engine import WORTH_LANES, run_batch
from bristle.files import experiment_from, key_of, with_changes, with_columns
from bristle.simulation import SimulationResult, simulate

T = TypeVar("T")
FIELDS = ("plant", "friction", "table", "controller", "sensor", "reference")
# Field of a variant, if it differs from the section of the file.
_FIELD = {"table_friction": "table"}
SEEDED = ("sensor", "friction", "table")


class Varied:
    """Builder of the experiments of a study."""

    def __init__(self, study: Study) -> None:
        self.study = study
        self._direct = _placed(study)
        if self._direct is not None and not self._agrees():
            self._direct = None

    @property
    def is_direct(self) -> bool:
        """Whether values are set in the loaded models."""
        return self._direct is not None

    def experiment(self, values: Mapping[str, Any], seed: int) -> Experiment:
        """Return the experiment of a run."""
        if self._direct is not None:
            return _changed(self.study.experiment, self.models(values, seed))
        base = self._by_tables(values)
        return _changed(base, [_seeds(variant, {}, seed) for variant in base.variants])

    def models(
        self, values: Mapping[str, Any], seed: int, fields: Sequence[str] = FIELDS
    ) -> list[dict[str, Model]]:
        """Return, by variant, the changed models of a run by field, if values are set directly."""
        changes = []
        for variant, sections in zip(
            self.study.experiment.variants, self._direct or (), strict=True
        ):
            changed = {
                field: with_changes(
                    getattr(variant, field),
                    {name: values[path] for path, name in names.items()},
                    section,
                )
                for section, field, names in _within(fields, sections)
            }
            changes.append(_seeds(variant, changed, seed, fields))
        return changes

    def models_by_place(
        self, values: Mapping[str, np.ndarray], seeds: Sequence[int], fields: Sequence[str]
    ) -> dict[int, list[dict[str, Model]]]:
        """Return the `models` of several runs by place, without runs that have a value out of range."""
        changed: dict[int, list[dict[str, Model]]] = {place: [] for place in range(len(seeds))}
        for variant, sections in zip(
            self.study.experiment.variants, self._direct or (), strict=True
        ):
            models = {
                field: with_columns(
                    getattr(variant, field),
                    {name: values[path] for path, name in names.items()},
                    section,
                )
                for section, field, names in _within(fields, sections)
            }
            for place in list(changed):
                own = {
                    field: model
                    for field, column in models.items()
                    if (model := column[place]) is not None
                }
                if len(own) < len(models):
                    del changed[place]
                else:
                    changed[place].append(_seeds(variant, own, seeds[place], fields))
        return changed

    def _by_tables(self, values: Mapping[str, Any]) -> Experiment:
        tables = copy.deepcopy(dict(self.study.tables))
        for path, value in values.items():
            *sections, key = path.split(".")
            reduce(lambda table, section: table.setdefault(section, {}), sections, tables)[key] = (
                value
            )
        experiment = experiment_from(
            tables, self.study.sources.folder / "experiment.toml", self.study.sources
        )
        variants = tuple(
            replace(variant, run=replace(variant.run, seeds=1)) for variant in experiment.variants
        )
        return replace(self.study.experiment, variants=variants)

    def _agrees(self) -> bool:
        """Return whether both ways give the same first and last run."""
        for number in {0, self.study.count - 1}:
            values = row_of(self.study.values(Block(number, number + 1)), 0)
            try:
                ways = (
                    _changed(self.study.experiment, self.models(values, 0)),
                    self._by_tables(values),
                )
                if not all(map(Variant.is_like, ways[0].variants, ways[1].variants)):
                    return False
            except InputError:  # a draw out of range cannot compare the two ways
                continue
        return True


def _within(
    fields: Sequence[str], sections: Mapping[str, dict[str, str]]
) -> Iterator[tuple[str, str, dict[str, str]]]:
    """Yield the sections whose models belong to some fields of a variant: section, field and parameters by dotted key."""
    for section, names in sections.items():
        field = _FIELD.get(section, section)
        if field in fields:
            yield section, field, names


def row_of(values: Mapping[str, np.ndarray], place: int) -> dict[str, Any]:
    """Return the values of one run as Python objects, from the arrays of several runs."""
    return {path: column[place].tolist() for path, column in values.items()}


def _placed(study: Study) -> tuple[dict[str, dict[str, str]], ...] | None:
    """Return, for each variant and section, the parameter behind each dotted key; None if a key is not a parameter."""
    paths = list(study.units)
    overrides = study.tables.get("compare", {})
    places = []
    for variant in study.experiment.variants:
        sections: dict[str, dict[str, str]] = {}
        own = overrides.get(variant.name, {})
        for path in paths:
            keys = path.split(".")
            if keys[0] == "compare":
                if keys[1] != variant.name:
                    continue
                keys = keys[2:]
            elif _overridden(own, keys):
                continue
            name = _parameter(variant, keys)
            if name is None:
                return None
            sections.setdefault(keys[0], {})[path] = name
        places.append(sections)
    return tuple(places)


def _parameter(variant: Variant, keys: Sequence[str]) -> str | None:
    """Return the parameter of a model behind the key of a section; None for other values."""
    if len(keys) != 2:
        return None
    model = sections_of(variant).get(keys[0])
    if model is None:
        return None
    return next((name for name in model.component.variables if key_of(name) == keys[1]), None)


def _overridden(override: Any, keys: Sequence[str]) -> bool:
    """Return whether a variant overrides a value under these keys."""
    for key in keys:
        if not isinstance(override, Mapping):
            return False
        if "model" in override or "file" in override:
            return True
        if key not in override:
            return False
        override = override[key]
    return True


def _seeds(
    variant: Variant, changed: dict[str, Model], seed: int, fields: Sequence[str] = SEEDED
) -> dict[str, Model]:
    """Return the changed models with the seeds of a run: the seed of the run is added to those of the file."""
    for name in SEEDED:
        if name not in fields:
            continue
        model = changed.get(name, getattr(variant, name))
        if model is not None and "seed" in model.component.variables:
            changed[name] = with_changes(
                model, {"seed": (int(model.values["seed"]) + seed) % SEED_MAX}, name
            )
    return changed


def _changed(experiment: Experiment, changes: Sequence[Mapping[str, Model]]) -> Experiment:
    variants = zip(experiment.variants, changes, strict=True)
    return _with(
        experiment, variants=tuple(_with(variant, **changed) for variant, changed in variants)
    )


def _with(item: T, **changed: Any) -> T:
    """Return a copy with other models of the same components, without repeating the checks."""
    copied = copy.copy(item)
    for name, value in changed.items():
        object.__setattr__(copied, name, value)
    return copied


REFUSED = "refused"  # bristle refused the values of the run
RAISED = "raised"  # a model raised an exception
FAILED = (Status.NOT_FINITE.name.lower(), REFUSED, RAISED)  # statuses of runs without numbers

MODELS = ("plant", "friction")
REASON = 300  # letters


class Simulator:
    """Simulator of the runs of a study, in this process."""

    def __init__(self, study: Study, *, batches: bool = True) -> None:
        self.study = study
        self.varied = Varied(study)
        self._in_lanes = steps_of(study.experiment) * study.count >= WORTH_LANES
        self.in_batches = batches and self.varied.is_direct and fits_a_batch(study.experiment)

    def run(self, number: int) -> SimulationResult:
        """Return one run of the study, with its signals."""
        block = Block(number, number + 1)
        values = row_of(self.study.values(block), 0)
        with warnings.catch_warnings(action="ignore"):
            return simulate(self.varied.experiment(values, self.study.seeds(block)[0]))

    def columns(self, block: Block) -> dict[str, Any]:
        """Return the stored columns of a block, each of shape (run,)."""
        values = self.study.values(block)
        seeds = self.study.seeds(block)
        status = [OK] * block.count
        reason = [""] * block.count
        metrics = {metric.column: np.full(block.count, np.nan) for metric in self.study.metrics}
        batched: set[int] = set()
        with warnings.catch_warnings(action="ignore"):
            if self.in_batches:
                batched = self._batched(values, seeds, metrics)
            for place in (place for place in range(block.count) if place not in batched):
                status[place], reason[place] = self._serial(
                    place, row_of(values, place), seeds[place], metrics
                )
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

    def _serial(
        self, place: int, row: Mapping[str, Any], seed: int, metrics: Mapping[str, np.ndarray]
    ) -> tuple[str, str]:
        """Simulate one run; return its status and the reason."""
        try:
            result = simulate(self.varied.experiment(row, seed))
        except MemoryError:
            raise
        except BristleError as error:
            return REFUSED, error_text(error)[:REASON]
        except Exception as error:  # noqa: BLE001  (a model of a person's own may raise anything, and its row reports it)
            return RAISED, f"{type(error).__name__}: {error_text(error)}"[:REASON]
        for metric in self.study.metrics:
            metrics[metric.column][place] = metric.of(result.variants[metric.variant])
        worst = max(result.variants.values(), key=lambda variant: variant.status)
        if worst.status is Status.OK:
            return OK, ""
        sentence = worst.status.sentence
        if len(result.variants) > 1:
            sentence = f"{worst.name}: {sentence}"
        return worst.status.name.lower(), sentence

    def _batched(
        self,
        values: Mapping[str, np.ndarray],
        seeds: Sequence[int],
        metrics: Mapping[str, np.ndarray],
    ) -> set[int]:
        """Simulate several runs in batches; return the successful ones. The caller repeats the others one by one."""
        changes = self.varied.models_by_place(values, seeds, MODELS)
        places = np.array(list(changes), dtype=int)
        well = np.ones(len(places), dtype=bool)
        for index, variant in enumerate(self.study.experiment.variants):
            own = [metric for metric in self.study.metrics if metric.variant == variant.name]
            effort = np.zeros(0)
            if variant.effort is not None:
                effort = variant.effort.values
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
    """Return whether several runs can be simulated in one batch: by effort, on one mass, in constant steps, without turning points."""
    for variant in experiment.variants:
        run, friction = variant.run, variant.friction.component
        if variant.effort is None or variant.plant.component.screw is not None:
            return False
        if (
            variant.disturbance is not None
            or variant.start is not None
            or run.tolerance
            or run.delay
            or run.current_lag
        ):
            return False
        if (
            "lost" in friction.State._fields
            or friction.new_memory(variant.friction.parameters).size > 0
        ):
            return False
    return True


def metrics_of_batch(
    variant: Variant,
    effort: np.ndarray,
    changes: Sequence[Mapping[str, Model]],
    metrics: Sequence[Metric],
    in_lanes: bool,
) -> tuple[dict[str, np.ndarray], list[Status]]:
    """Return the metrics of one variant in several runs, by column, and the status of each run."""
    run = variant.run
    effort = np.clip(effort, -run.effort_limit, run.effort_limit)
    # An open loop starts at rest.
    x, v, _ = variant.reference.component.sample(np.zeros(1), variant.reference.parameters)
    plant, friction = (_of_each_run(variant, changes, field) for field in MODELS)
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
    # Contiguous, so that sums match those of a single run.
    position = np.ascontiguousarray(trace.position[:, judged])
    return {metric.column: metric.along(position, applied) for metric in metrics}, list(
        trace.status
    )


def _of_each_run(
    variant: Variant, changes: Sequence[Mapping[str, Model]], field: str
) -> Model | list[Model]:
    """Return the model of each run under a field; the model of the variant if it does not vary."""
    if any(field in changed for changed in changes):
        return [changed[field] for changed in changes]
    return getattr(variant, field)
