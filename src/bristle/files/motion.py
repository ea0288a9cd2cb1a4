"""`write_motion`: a motion as a CSV file that a drive can follow, in the units of the axis."""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

from bristle.core import units
from bristle.core.axis import Axis, Column
from bristle.core.variable import unit_of
from bristle.logs.table import split_unit

__all__ = ["motion_columns", "write_motion"]

DIGITS = "%.12g"
QUANTITIES = {"time": "time", "position": "length", "velocity": "length/time", "acceleration": "length/time^2"}
PER = {"velocity": "/s", "acceleration": "/s^2"}


def motion_columns(axis: Axis) -> dict[str, tuple[str, float]]:
    """Return the heads of the columns of a motion, and by what each number in SI is divided there.

    Position is in the unit and with the sign of the reference in the logs of the axis, or else of their position;
    velocity and acceleration are its derivatives, unless the logs have a velocity of their own.

    Parameters
    ----------
    axis : Axis
        Its columns.
    """
    given = axis.columns
    position = given.get("reference") or given.get("position")
    found = {}
    for name, quantity in QUANTITIES.items():
        own = position if name == "position" else given.get(name)
        if own is not None:
            unit = own.unit or own.base
            found[name] = (f"{split_unit(own.name)[0]} [{unit}]", _factor(own))
        elif name in PER and position is not None:
            found[name] = (f"{name} [{position.unit or position.base}{PER[name]}]", _factor(position))
        else:
            found[name] = (f"{name} [{unit_of(quantity, axis.kind)}]", 1.0)
    return found


def _factor(column: Column) -> float:
    unit = column.unit or column.base
    return column.scale * (units.factor(unit, column.base) if unit != column.base else 1.0)


def write_motion(path: str | os.PathLike[str], axis: Axis, signals: Mapping[str, np.ndarray]) -> None:
    """Write a motion as CSV.

    Parameters
    ----------
    path : path-like
        The file.
    axis : Axis
        Whose units and names of columns it has.
    signals : mapping of str to ndarray, shape (sample,)
        ``time`` [s], ``position``, ``velocity`` and ``acceleration`` in SI.
    """
    columns = motion_columns(axis)
    table = np.column_stack([signals[name] / factor for name, (_, factor) in columns.items()])
    header = ",".join(head for head, _ in columns.values())
    np.savetxt(path, table, fmt=DIGITS, delimiter=",", header=header, comments="", encoding="utf-8")
