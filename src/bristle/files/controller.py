"""Control laws in files, with gains in the units of the drive where the axis says what these are."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any

from bristle.controllers import CONTROLLERS
from bristle.core import units
from bristle.core.axis import Axis, Column
from bristle.core.contracts import Model, make_model
from bristle.core.dimensions import Kind, exponents_of, unit_of
from bristle.core.errors import InputError
from bristle.files.components import component_named, parameters_in, table_at

__all__ = ["controller_from", "controller_of", "in_effort"]


def controller_of(table: Any, axis: Axis) -> Model | None:
    """Return the control law that was running on an axis; None where its file names none.

    Gains may be given in the units of the drive, such as ``k_v = "243.45 V*s/m"`` where the effort column is in
    volts: the constant of the drive turns them into SI, and gear and lead those for an angle of the motor.

    Raises
    ------
    InputError
        With the path of the key that does not fit, its value and what is allowed.
    """
    if table is None:
        return None
    return controller_from(table, kind=axis.kind, columns=axis.columns, path="controller")


def controller_from(table: Any, *, kind: Kind, columns: Mapping[str, Column], path: str) -> Model:
    """Return the control law of a table.

    Parameters
    ----------
    table : object
        ``model = "cascade"`` and its parameters.
    kind : {"translational", "rotational"}
        Kind of axis.
    columns : mapping of str to Column
        Columns of the axis by channel: what one unit of the drive is in SI.
    path : str
        Key of the table, for messages.

    Raises
    ------
    InputError
        With the path of the key that does not fit, its value and what is allowed.
    """
    entries = table_at(table, path)
    if "model" not in entries:
        raise InputError("names no model", path=path, allowed=", ".join(CONTROLLERS), mend='Write model = "cascade"')
    component = component_named(entries["model"], CONTROLLERS, f"{path}.model")
    values = parameters_in(entries, component, path, beside=("model",))
    for name, value in values.items():
        values[name] = in_effort(value, component.variables[name].quantity, kind, columns, f"{path}.{name}")
    return make_model(component, values, kind=kind, validate=True, path=path)


def in_effort(value: Any, quantity: str, kind: Kind, columns: Mapping[str, Column], path: str) -> Any:
    """Return text in the units of the drive as a number in SI, and everything else as it is.

    The effort may be told in the unit of the effort column, the movement in that of the position column: ``"A*s/rad"``
    where the current and the angle of the motor are recorded.

    Parameters
    ----------
    value : object
        What a person wrote, such as ``"243.45 V*s/m"``.
    quantity : str
        What it is, such as ``"force*time/length"``.
    kind : {"translational", "rotational"}
        Kind of axis.
    columns : mapping of str to Column
        Columns of the axis by channel: what one unit of the drive is in SI.
    path : str
        Where the value stands, for messages.
    """
    if not isinstance(value, str) or "force" not in exponents_of(quantity):
        return value
    _, own_unit = units.split(value, path)
    if not own_unit or units.compatible(own_unit, unit_of(quantity, kind), path=path):
        return value
    for unit, factor in _units_of_drive(quantity, kind, columns):
        if units.compatible(own_unit, unit, path=path):
            return units.convert(value, unit, path=path) * factor
    return value


def _units_of_drive(quantity: str, kind: Kind, columns: Mapping[str, Column]) -> Iterator[tuple[str, float]]:
    """Yield each unit in which a quantity may be told, and SI for one of it."""
    powers = exponents_of(quantity)
    # An inertia too may be told as what it is a product of: an effort over an acceleration.
    expanded = "*".join(f"{name}^{power:g}" for name, power in powers.items())
    forces, lengths = _counted("force", columns.get("effort"), kind), _counted("length", columns.get("position"), kind)
    for (force, effort), (length, position) in product(forces, lengths):
        factor = effort ** powers["force"] * position ** powers.get("length", 0.0)
        yield unit_of(expanded, kind, force=force, length=length), factor


def _counted(name: str, column: Column | None, kind: Kind) -> list[tuple[str, float]]:
    """Return the units in which an effort or a position is counted, and SI for one of each."""
    in_si = [(unit_of(name, kind), 1.0)]
    # A sign in the scale is a matter of wiring; a gain has none.
    return in_si if column is None else [*in_si, (column.base, abs(column.scale))]
