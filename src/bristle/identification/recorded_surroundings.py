"""Whether a log tells what the slots of a friction model depend on."""

from __future__ import annotations

import numpy as np

from bristle.core import units
from bristle.core.contracts import FrictionModel
from bristle.core.errors import InputError
from bristle.core.surroundings import Surrounding
from bristle.friction.slots import slot_needing
from bristle.identification.dataset import Dataset

__all__ = ["refuse_unrecorded"]

ALIKE = 1e-9  # of two scales of a unit that are one


def refuse_unrecorded(component: FrictionModel, dataset: Dataset) -> None:
    """Refuse a log that lacks a channel which a slot depends on, or holds something else under its name.

    Raises
    ------
    InputError
        With the channel, and what to write in the axis file.
    """
    for surrounding in component.surroundings:
        name = surrounding.name
        if name in dataset.segments[0].surroundings and all(name in part.surroundings for part in dataset.segments):
            _refuse_another(surrounding, dataset)
        elif surrounding.is_recorded:
            slot, written = slot_needing(component, name), _written(surrounding, dataset)
            raise InputError(
                f"has no {name}, which +{slot} needs", path="log",
                mend=f"Name its column under [columns] of the axis file: {name} = {written}, or drop +{slot}",
            )  # fmt: skip


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
    if not (units.compatible(unit, wanted) and abs(units.factor(unit, wanted) - 1.0) < ALIKE):
        raise InputError(
            "is of another quantity than the slot takes it for", path=f"{place}.unit", value=unit, allowed=allowed,
            mend="Mend the unit in the axis file, or the channel in the file of the slot",
        )  # fmt: skip
    usual = float(np.median(np.concatenate([segment.surroundings[name] for segment in dataset.segments])))
    if not variable.min <= usual <= variable.max:
        raise InputError(
            "is out of range, in the middle of its values", path=place, value=usual,
            allowed=variable.allowed(dataset.kind), mend=f"Is its unit right? It is {variable.description}",
        )  # fmt: skip
