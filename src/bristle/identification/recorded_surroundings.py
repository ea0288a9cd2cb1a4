"""Whether a log tells what the slots of a friction model depend on."""

from __future__ import annotations

import numpy as np

from bristle.core import units
from bristle.core.contracts import FrictionModel
from bristle.core.errors import InputError
from bristle.core.surroundings import Surrounding
from bristle.friction.slots import slot_needing
from bristle.identification.dataset import Dataset

__all__ = ["holds", "refuse_unrecorded"]

ALIKE = 1e-9  # of two scales of a unit that are one


def holds(dataset: Dataset, surrounding: Surrounding) -> bool:
    """Return whether a log has this channel, and of this quantity."""
    return _has(dataset, surrounding) and _is_of_its_quantity(dataset, surrounding)


def refuse_unrecorded(component: FrictionModel, dataset: Dataset) -> None:
    """Refuse a log that lacks a channel which a slot depends on, or holds something else under its name.

    Raises
    ------
    InputError
        With the channel, and what to write in the axis file.
    """
    for surrounding in component.surroundings:
        name = surrounding.name
        if _has(dataset, surrounding):
            _refuse_another(surrounding, dataset)
        elif surrounding.is_recorded:
            slot, written = slot_needing(component, name), _written(surrounding, dataset)
            raise InputError(
                f"has no {name}, which +{slot} needs", path="log",
                mend=f"Name its column under [columns] of the axis file: {name} = {written}, or drop +{slot}",
            )  # fmt: skip


def _has(dataset: Dataset, surrounding: Surrounding) -> bool:
    return all(surrounding.name in segment.surroundings for segment in dataset.segments)


def _is_of_its_quantity(dataset: Dataset, surrounding: Surrounding) -> bool:
    unit, in_si = dataset.units.get(surrounding.name, ""), surrounding.variable.unit(dataset.kind)
    return not surrounding.is_own or (units.compatible(unit, in_si) and abs(units.factor(unit, in_si) - 1.0) < ALIKE)


def _written(surrounding: Surrounding, dataset: Dataset) -> str:
    """Return what to write in the axis file for a channel."""
    unit = surrounding.variable.unit(dataset.kind)
    return f'{{ column = "...", unit = "{"%" if unit == "1" else unit}" }}' if surrounding.is_own else "..."


def _refuse_another(surrounding: Surrounding, dataset: Dataset) -> None:
    """Refuse a channel of another quantity, or most of whose values nothing of this quantity has."""
    name, variable = surrounding.name, surrounding.variable
    wanted, unit = variable.unit(dataset.kind), dataset.units.get(name, "")
    place, allowed = f"columns.{name}", f"{variable.description}, in {wanted} or a multiple of it"
    if not surrounding.is_own:
        return
    if not _is_of_its_quantity(dataset, surrounding):
        raise InputError(
            "is of another quantity than the slot takes it for", path=f"{place}.unit", value=unit, allowed=allowed,
            mend="Mend the unit in the axis file, or the channel in the file of the slot, if that is yours",
        )  # fmt: skip
    usual = float(np.median(np.concatenate([segment.surroundings[name] for segment in dataset.segments])))
    if not variable.min <= usual <= variable.max:
        raise InputError(
            "is out of range, in the middle of its values", path=place, value=usual,
            allowed=variable.allowed(dataset.kind), mend=f"Is its unit right? It is {variable.description}",
        )  # fmt: skip
