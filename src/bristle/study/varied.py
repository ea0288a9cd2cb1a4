"""The experiment of one run: that of the file, with the values and the seed of the run.

What it means is said by the file: the values are written into its tables, and these are read as any experiment. Where
they are plain parameters of its models, they are set in the models that were read, which takes a hundredth of the time;
that both ways lead to the same is looked at for the first and the last run of each study.
"""

import copy
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from functools import partial, reduce
from typing import Any, TypeVar

import numpy as np

from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.experiment import Effort, Experiment, Variant
from bristle.core.random_numbers import SEED_MAX
from bristle.core.values import check_relations, check_value, coerced, looked_at, numbers_of
from bristle.files.components import key_of
from bristle.files.experiment import experiment_from
from bristle.study.plan import Block, Study
from bristle.study.values import sections_of

T = TypeVar("T")
FIELDS = ("plant", "friction", "table", "controller", "sensor", "reference")
_FIELD = {"table_friction": "table"}  # of a variant, where it is not the section of the file
SEEDED = ("sensor", "friction", "table")


class Varied:
    """What makes the experiments of a study."""

    def __init__(self, study: Study) -> None:
        self.study = study
        self._direct = _placed(study)
        if self._direct is not None and not self._agrees():
            self._direct = None

    @property
    def is_direct(self) -> bool:
        """Whether values are set in the models that were read."""
        return self._direct is not None

    def experiment(self, values: Mapping[str, Any], seed: int) -> Experiment:
        """Return the experiment of a run."""
        if self._direct is not None:
            return _changed(self.study.experiment, self.models(values, seed))
        base = self._by_tables(values)
        return _changed(base, [_seeds(variant, {}, seed) for variant in base.variants])

    def models(self, values: Mapping[str, Any], seed: int, fields: Sequence[str] = FIELDS) -> list[dict[str, Model]]:
        """Return by variant the models that a run changes, by field, where values are set in them."""
        changes = []
        for variant, sections in zip(self.study.experiment.variants, self._direct or (), strict=True):
            changed = {
                field: with_changes(getattr(variant, field), {name: values[path] for path, name in names.items()}, section)
                for section, names in sections.items()
                if (field := _FIELD.get(section, section)) in fields
            }
            changes.append(_seeds(variant, changed, seed, fields))
        return changes

    def models_by_place(
        self, values: Mapping[str, np.ndarray], seeds: Sequence[int], fields: Sequence[str]
    ) -> dict[int, list[dict[str, Model]]]:
        """Return the `models` of several runs by their place, of those whose values are all in range."""
        changed: dict[int, list[dict[str, Model]]] = {place: [] for place in range(len(seeds))}
        for variant, sections in zip(self.study.experiment.variants, self._direct or (), strict=True):
            models = {
                field: with_columns(getattr(variant, field), {name: values[path] for path, name in sections[section].items()}, section)
                for section in sections
                if (field := _FIELD.get(section, section)) in fields
            }
            for place in list(changed):
                own = {field: model for field, column in models.items() if (model := column[place]) is not None}
                if len(own) < len(models):
                    del changed[place]
                else:
                    changed[place].append(_seeds(variant, own, seeds[place], fields))
        return changed

    def _by_tables(self, values: Mapping[str, Any]) -> Experiment:
        tables = copy.deepcopy(dict(self.study.tables))
        for path, value in values.items():
            *sections, key = path.split(".")
            reduce(lambda table, section: table.setdefault(section, {}), sections, tables)[key] = value
        experiment = experiment_from(tables, self.study.sources.folder / "experiment.toml", self.study.sources)
        variants = tuple(replace(variant, run=replace(variant.run, seeds=1)) for variant in experiment.variants)
        return replace(self.study.experiment, variants=variants)

    def _agrees(self) -> bool:
        """Return whether both ways lead to the same, for the first and the last run."""
        for number in {0, self.study.count - 1}:
            values = row_of(self.study.values(Block(number, number + 1)), 0)
            try:
                ways = _changed(self.study.experiment, self.models(values, 0)), self._by_tables(values)
                if not all(map(_alike, ways[0].variants, ways[1].variants)):
                    return False
            except InputError:  # a draw out of range tells nothing of the two ways
                continue
        return True


def row_of(values: Mapping[str, np.ndarray], place: int) -> dict[str, Any]:
    """Return what one run is made with, out of the values of several: numbers, names and lists of Python."""
    return {path: column[place].tolist() for path, column in values.items()}


def with_changes(model: Model, changes: Mapping[str, Any], path: str) -> Model:
    """Return a model with some parameters changed, of which those are held to their ranges, and all to its relations.

    As `Model.with_values` does, which looks at every parameter again.
    """
    component, variables = model.component, model.component.variables
    numbers = numbers_of(component, model.parameters)
    for name, raw in changes.items():
        place = f"{path}.{key_of(name)}"
        numbers[name] = looked_at(partial(coerced, component, name, variables[name]), raw, place, model.kind)
        check_value(component, name, variables[name], numbers[name], model.kind, place)
    parameters = component.assemble(numbers)
    check_relations(component, parameters, path)
    return Model(component, parameters, model.kind)


def with_columns(model: Model, columns: Mapping[str, np.ndarray], path: str) -> list[Model | None]:
    """Return `with_changes` for each row of some columns; None where that refuses.

    Plain numbers are looked at by their column: where the smallest and the largest are in range, all are.
    """
    component, numbers = model.component, numbers_of(model.component, model.parameters)
    are_in_range = all(_is_in_range(model, name, column, path) for name, column in columns.items())
    models: list[Model | None] = []
    for row in zip(*(column.tolist() for column in columns.values()), strict=True):
        changes = dict(zip(columns, row, strict=True))
        try:
            parameters = component.assemble(numbers | changes) if are_in_range else None
            if parameters is not None and all(relation.holds(parameters) for relation in component.relations):
                models.append(Model(component, parameters, model.kind))
            else:
                models.append(with_changes(model, changes, path))
        except Exception:  # noqa: BLE001  (the run by itself tells why)
            models.append(None)
    return models


def _is_in_range(model: Model, name: str, column: np.ndarray, path: str) -> bool:
    """Return whether a column holds floating numbers for a parameter that is one, each of them in its range."""
    component, variable = model.component, model.component.variables[name]
    is_plain = not (variable.choices or component.is_integer(name) or component.is_array(name))
    if not (is_plain and column.ndim == 1 and column.dtype == float and np.all(np.isfinite(column))):
        return False
    try:
        for number in (float(column.min()), float(column.max())):
            value = coerced(component, name, variable, number, path, model.kind)
            check_value(component, name, variable, value, model.kind, path)
    except InputError:
        return False
    return True


def _placed(study: Study) -> tuple[dict[str, dict[str, str]], ...] | None:
    """Return for each variant, by section, which parameter each dotted key is; None where one is no parameter."""
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
            model = sections_of(variant).get(keys[0]) if len(keys) == 2 else None
            name = None if model is None else next((n for n in model.component.variables if key_of(n) == keys[1]), None)
            if name is None:
                return None
            sections.setdefault(keys[0], {})[path] = name
        places.append(sections)
    return tuple(places)


def _overridden(override: Any, keys: Sequence[str]) -> bool:
    """Return whether a variant says itself what stands under these keys."""
    for key in keys:
        if not isinstance(override, Mapping):
            return False
        if "model" in override or "file" in override:
            return True
        if key not in override:
            return False
        override = override[key]
    return True


def _seeds(variant: Variant, changed: dict[str, Model], seed: int, fields: Sequence[str] = SEEDED) -> dict[str, Model]:
    """Return the changed models with the random numbers of a run: its seed is added to those of the file."""
    for name in SEEDED:
        model = changed.get(name, getattr(variant, name)) if name in fields else None
        if model is not None and "seed" in model.component.variables:
            changed[name] = with_changes(model, {"seed": (int(model.values["seed"]) + seed) % SEED_MAX}, name)
    return changed


def _changed(experiment: Experiment, changes: Sequence[Mapping[str, Model]]) -> Experiment:
    variants = zip(experiment.variants, changes, strict=True)
    return _with(experiment, variants=tuple(_with(variant, **changed) for variant, changed in variants))


def _with(item: T, **changed: Any) -> T:
    """Return a copy with other models of the same components: what was looked at once need not be in each run."""
    copied = copy.copy(item)
    for name, value in changed.items():
        object.__setattr__(copied, name, value)
    return copied


def _alike(first: Variant, second: Variant) -> bool:
    """Return whether two variants are the same, of efforts and disturbances sample by sample."""
    for field in fields(Variant):
        pair = getattr(first, field.name), getattr(second, field.name)
        if isinstance(pair[0], Effort) and isinstance(pair[1], Effort):
            pair = pair[0].values, pair[1].values
        if isinstance(pair[0], np.ndarray) and isinstance(pair[1], np.ndarray):
            if not np.array_equal(*pair):
                return False
        elif pair[0] is not pair[1] and pair[0] != pair[1]:
            return False
    return True
