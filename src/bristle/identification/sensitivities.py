"""The friction force of each row and its derivatives by parameters, integrated forward along the motion, in blocks."""

import math
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from bristle.core.contracts import FrictionModel, Model
from bristle.core.cores import abreast
from bristle.core.edge import vector
from bristle.core.errors import InputWarning
from bristle.core.packing import pack
from bristle.core.tangent import DIRECTIONS
from bristle.engine.contact import state_at
from bristle.engine.derivatives import TangentRun
from bristle.engine.filtered_rows import Block
from bristle.engine.instance import warn_of_lost
from bristle.engine.translation.scope import NotExportableError
from bristle.identification.dataset import Dataset, Segment

STEP = 1e-4  # of a parameter: packed numbers of a model are nearly linear in it
NUDGE = 1e-4  # of the state of a contact, from -1 to 1, towards 0
DIFFERENCE = float(np.sqrt(np.finfo(float).eps))  # of a parameter, for differences
BLOCK = 2**15  # samples in a block

ModelOf = Callable[[Mapping[str, float]], Model]
Contacts = Sequence[float | None]
# The effort transmitted to the load along a segment, shape (sample,), and its derivatives, shape (sample, parameter).
Transmitted = Callable[[Segment], tuple[np.ndarray, np.ndarray]]


class Perturbed:
    """A model, and copies with one parameter slightly larger or smaller."""

    def __init__(
        self, model_of: ModelOf, values: Mapping[str, float], names: Sequence[str]
    ) -> None:
        self.model, self.count = model_of(values), len(names)
        # Parameters of another component do not change this one.
        self.places = [
            place for place, name in enumerate(names) if name in self.model.component.variables
        ]
        self._pairs = list[tuple[Model, Model, float]]()
        for name in map(names.__getitem__, self.places):
            step = STEP * (abs(values[name]) or 1.0)
            high, low = (
                model_of({**values, name: values[name] + change}) for change in (step, -step)
            )
            self._pairs.append((high, low, 2.0 * step))

    def slopes(self, numbers: Callable[[Model], np.ndarray]) -> np.ndarray:
        """Return the derivative of numbers of the model by each parameter, shape (number, parameter)."""
        slopes = np.zeros((numbers(self.model).size, self.count))
        with np.errstate(invalid="ignore"):
            for place, (high, low, width) in zip(self.places, self._pairs, strict=True):
                slopes[:, place] = (numbers(high) - numbers(low)) / width
        # An infinite number of both does not change.
        return np.nan_to_num(slopes, copy=False, nan=0.0)

    def parameters(self) -> np.ndarray:
        """Return the derivative of the packed parameters."""
        return self.slopes(lambda near: pack(near.parameters))


def warn_of_differences(component: FrictionModel, error: NotExportableError) -> None:
    """Warn about a law that is differentiated by differences, with the reason."""
    warnings.warn(
        f"bristle differentiates {component.name} by finite differences: {error}",
        InputWarning,
        stacklevel=3,
    )


class FrictionRows(NamedTuple):
    """The friction of each row [N or N*m], its derivatives by the initial contact, (row,) or None, and by parameters, (row, name)."""

    force: np.ndarray
    by_contact: np.ndarray | None
    by_parameters: np.ndarray


def friction_rows(
    model_of: ModelOf,
    values: Mapping[str, float],
    names: Sequence[str],
    dataset: Dataset,
    contacts: Contacts,
    transmitted: Transmitted | None = None,
) -> FrictionRows:
    """Return the friction of each row with its derivatives; the initial contact is between -1 and 1, or virgin."""
    perturbed, rows, stood = (
        Perturbed(model_of, values, names),
        list[np.ndarray](),
        any(place is not None for place in contacts),
    )
    model, dt, count = perturbed.model, dataset.sample_time, stood + len(names)
    of_model = _led(perturbed.parameters(), stood)
    for segment, place in zip(dataset.segments, contacts, strict=True):
        of_state = _led(
            perturbed.slopes(lambda near, place=place: pack(_begun(near, place))), stood
        )
        if place is not None:
            of_state[:, 0] = (
                pack(state_at(model, place)) - pack(state_at(model, _inside(place)))
            ) / (place - _inside(place))
        acting = None if transmitted is None else transmitted(segment)
        parts = list[np.ndarray]()
        # The force passes the filters as the last direction, in a separate run if the others are full.
        for first in range(0, count + 1, DIRECTIONS):
            now, left = slice(first, first + DIRECTIONS), count - first
            run = TangentRun(
                model,
                of_model[:, now],
                _begun(model, place),
                of_state[:, now],
                acts=acting is not None,
            )
            moved = None if acting is None else (acting[0], _led(acting[1], stood)[:, now])
            if left or not count:
                blocks = _blocks(run, segment, dt, moved, left)
            else:
                force = segment.friction(model, dt, place, None if acting is None else acting[0])
                blocks = iter([(segment.time.size, partial(_alone, force))])
            parts.append(dataset.rows_of_tangents(blocks, segment.time.size))
            warn_of_lost(run.part)
        rows.append((parts[0] if len(parts) == 1 else np.hstack(parts))[:, : count + 1])
    stacked = (rows[0] if len(rows) == 1 else np.concatenate(rows))[dataset.in_motion]
    return FrictionRows(stacked[:, -1], stacked[:, 0] if stood else None, stacked[:, stood:count])


def _alone(force: np.ndarray, out: np.ndarray) -> None:
    """Write a force as the first direction."""
    out[:] = 0.0
    out[:, 0] = force


def _blocks(
    run: TangentRun,
    segment: Segment,
    dt: float,
    acting: tuple[np.ndarray, np.ndarray] | None,
    place_of_force: int,
) -> Iterator[Block]:
    """Yield the blocks of the tangents of the force along a segment; one direction contains the force."""

    def write(samples: slice, out: np.ndarray) -> None:
        signals = segment.part(samples, dt, None if acting is None else acting[0])
        moved = {} if acting is None else {"transmitted": acting[1][samples]}
        force = run.along(
            vector(signals.pop("v"), "v"), dt, vector(signals.pop("x"), "x"), signals, out, moved
        )
        if place_of_force < DIRECTIONS:
            out[:, place_of_force] = force

    if segment.first_cycle:
        write(slice(0, segment.first_cycle), np.empty((segment.first_cycle, DIRECTIONS)))
    count = segment.time.size
    for first, last in pairwise(np.linspace(0, count, -(-count // BLOCK) + 1).astype(int).tolist()):
        yield last - first, partial(write, slice(first, last))


def by_differences(
    force: Callable[[Mapping[str, float], Contacts], np.ndarray],
    values: Mapping[str, float],
    names: Sequence[str],
    contacts: Contacts,
) -> FrictionRows:
    """Return the `friction_rows` of a law without derivatives, from differences of the force of each row."""

    def column(name: str) -> np.ndarray:
        step = DIFFERENCE * (abs(values[name]) or 1.0)
        return (base - force({**values, name: values[name] - step}, contacts)) / step

    base, by_contact = force(values, contacts), None
    if any(place is not None for place in contacts):
        by_contact = base - force(
            values, [None if place is None else _inside(place) for place in contacts]
        )
    return FrictionRows(
        base, by_contact, np.reshape(abreast(column)(names), (len(names), base.size)).T
    )


def _led(columns: np.ndarray, count: int) -> np.ndarray:
    """Return derivatives, shape (number, direction), after `count` directions of zeros."""
    led = np.zeros((len(columns), count + columns.shape[1]))
    led[:, count:] = columns
    return led


def _begun(model: Model, place: float | None) -> Any:
    """Return the state of a friction model before a segment."""
    return (
        model.component.initial_state(model.parameters) if place is None else state_at(model, place)
    )


def _inside(place: float) -> float:
    """Return a contact state slightly nearer to 0."""
    return place - math.copysign(NUDGE, place)
