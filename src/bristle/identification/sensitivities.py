"""How the friction force of each row changes with parameters of its model: forward along the recorded motion."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.packing import pack
from bristle.engine.contact import state_at
from bristle.engine.derivatives import force_with_derivatives
from bristle.identification.dataset import Dataset

STEP = 1e-4  # of a parameter: the numbers that a model is made of are linear in it, or nearly so


def friction_derivatives(
    model_of: Callable[[Mapping[str, float]], Model],
    values: Mapping[str, float],
    names: Sequence[str],
    dataset: Dataset,
    contacts: Sequence[float | None] | None = None,
) -> np.ndarray:
    """Return the derivative of the friction force of each row by each of these parameters, shape (row, parameter).

    `contacts` is where the contact stood before each segment, from -1 to 1; virgin where that is not known.
    """
    model, beside = model_of(values), [_beside(model_of, values, name) for name in names]
    tangents, parts = _slopes(lambda near: pack(near.parameters), beside), list[np.ndarray]()
    for segment, place in zip(dataset.segments, contacts or (None,) * len(dataset.segments), strict=True):
        signals = segment.signals(dataset.sample_time)
        _, derivatives = force_with_derivatives(
            model,
            tangents,
            signals.pop("v"),
            dataset.sample_time,
            signals.pop("x"),
            state=_begun(model, place),
            state_tangents=_slopes(lambda near, place=place: pack(_begun(near, place)), beside),
            around=signals,
        )
        parts.append(derivatives[segment.first_cycle :])
    return dataset.rows_of_derivatives(parts)


def _begun(model: Model, place: float | None) -> Any:
    """Return the state of a friction model before a segment."""
    return model.component.initial_state(model.parameters) if place is None else state_at(model, place)


def _beside(model_of: Callable[[Mapping[str, float]], Model], values: Mapping[str, float], name: str) -> tuple[Model, Model, float]:
    """Return the model with one parameter a little larger, and smaller, and by how much they differ."""
    step = STEP * (abs(values[name]) or 1.0)
    high, low = (model_of({**values, name: values[name] + change}) for change in (step, -step))
    return high, low, 2.0 * step


def _slopes(numbers: Callable[[Model], np.ndarray], beside: Sequence[tuple[Model, Model, float]]) -> np.ndarray:
    """Return the derivative of numbers of a model by each of several parameters, shape (number, parameter)."""
    with np.errstate(invalid="ignore"):
        columns = [(numbers(high) - numbers(low)) / width for high, low, width in beside]
    return np.nan_to_num(np.stack(columns, axis=1), nan=0.0)  # what is infinite in both does not change
