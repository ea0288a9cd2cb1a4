"""Models with changed values: by name, or by columns of many runs."""

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from bristle.core import InputError, Model
from bristle.core.values import check_relations, check_value, coerced, looked_at, numbers_of
from bristle.files.components import key_of


def with_changes(model: Model, changes: Mapping[str, Any], path: str) -> Model:
    """Return a model with changed parameters; check their ranges and all relations.

    The result equals `Model.with_values`, which checks every parameter again.
    """
    component, variables = model.component, model.component.variables
    numbers = numbers_of(component, model.parameters)
    for name, raw in changes.items():
        place = f"{path}.{key_of(name)}"
        numbers[name] = looked_at(
            partial(coerced, component, name, variables[name]), raw, place, model.kind
        )
        check_value(component, name, variables[name], numbers[name], model.kind, place)
    parameters = component.assemble(numbers)
    check_relations(component, parameters, path)
    return Model(component, parameters, model.kind)


def with_columns(model: Model, columns: Mapping[str, np.ndarray], path: str) -> list[Model | None]:
    """Return the result of `with_changes` for each row of `columns`; None for a row that it refuses.

    Columns of plain numbers are checked by their smallest and largest values.
    """
    component, numbers = model.component, numbers_of(model.component, model.parameters)
    are_in_range = all(_is_in_range(model, name, column, path) for name, column in columns.items())
    models: list[Model | None] = []
    for row in zip(*(column.tolist() for column in columns.values()), strict=True):
        changes = dict(zip(columns, row, strict=True))
        try:
            parameters = component.assemble(numbers | changes) if are_in_range else None
            if parameters is not None and all(
                relation.holds(parameters) for relation in component.relations
            ):
                models.append(Model(component, parameters, model.kind))
            else:
                models.append(with_changes(model, changes, path))
        except Exception:  # noqa: BLE001  (the single run reports the reason)
            models.append(None)
    return models


def _is_in_range(model: Model, name: str, column: np.ndarray, path: str) -> bool:
    """Return whether a column has floating-point numbers for a floating-point parameter, all within its range."""
    component, variable = model.component, model.component.variables[name]
    is_plain = not (variable.choices or component.is_integer(name) or component.is_array(name))
    if not (
        is_plain and column.ndim == 1 and column.dtype == float and np.all(np.isfinite(column))
    ):
        return False
    try:
        for number in (float(column.min()), float(column.max())):
            value = coerced(component, name, variable, number, path, model.kind)
            check_value(component, name, variable, value, model.kind, path)
    except InputError:
        return False
    return True
