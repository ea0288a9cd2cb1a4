"""Control laws in files, with gains in the units of the drive where the axis says what these are."""

from __future__ import annotations

from itertools import product
from typing import Any

from bristle.controllers import CONTROLLERS
from bristle.core import units
from bristle.core.axis import Axis
from bristle.core.contracts import Controller, Model, make_model
from bristle.core.dimensions import Kind, exponents_of, unit_of
from bristle.core.errors import InputError
from bristle.core.variable import Variable
from bristle.files.components import component_named, number_at, parameters_in, table_at

INTEGRAL_TIME = "T_n"


def controller_of(table: Any, axis: Axis) -> Model | None:
    """Return the control law that was running on an axis; None where its file names none."""
    return None if table is None else controller_from(table, kind=axis.kind, axis=axis, path="controller")


def controller_from(table: Any, *, kind: Kind, axis: Axis | None = None, path: str, own: Controller | None = None) -> Model:
    """Return the control law of a table.

    Gains may be given in the units of the drive, such as ``k_v = "243.45 V*s/m"`` where the effort column is in
    volts: the constant of the drive turns them into SI, and gear and lead those for an angle of the motor.
    """
    entries = table_at(table, path)
    if own is None and "model" not in entries:
        raise InputError("names no model", path=path, allowed=", ".join(CONTROLLERS), mend='Write model = "cascade"')
    component = own or component_named(entries["model"], CONTROLLERS, f"{path}.model")
    by_time = (INTEGRAL_TIME,) if {"k_v", "k_i"} <= set(component.variables) else ()
    values = parameters_in(entries, component, path, beside=("model" if own is None else "file", *by_time))
    for name, value in values.items():
        values[name] = in_effort(value, component.variables[name].quantity, kind, axis, f"{path}.{name}")
    if by_time and INTEGRAL_TIME in entries:
        place, raw = f"{path}.{INTEGRAL_TIME}", entries[INTEGRAL_TIME]
        if "k_i" in values:
            raise InputError("tells the integral, and so does k_i", path=place, value=raw, mend="Keep one of them")
        if "k_v" not in values:
            raise InputError("needs the velocity gain", path=place, value=raw, mend=f"Write k_v under [{path}]")
        time = number_at(raw, Variable("time", "integral time", min=0.0), kind, place)
        gain = units.quantity(values["k_v"], component.variables["k_v"], kind, path=f"{path}.k_v")
        values["k_i"] = gain / time if time else 0.0  # a time of 0 switches the integral off
    return make_model(component, values, kind=kind, validate=True, path=path)


def in_effort(value: Any, quantity: str, kind: Kind, axis: Axis | None, path: str) -> Any:
    """Return text in the units of the drive as a number in SI, and everything else as it is.

    The effort may be told in the unit of the effort column, the movement in that of the position column: ``"A*s/rad"``
    where the current and the angle of the motor are recorded.
    """
    if not isinstance(value, str) or "force" not in (powers := exponents_of(quantity)):
        return value
    _, own_unit = units.split(value, path)
    if not own_unit or units.compatible(own_unit, unit_of(quantity, kind), path=path):
        return value
    # An inertia too may be told as what it is a product of: an effort over an acceleration.
    expanded = "*".join(f"{name}^{power:g}" for name, power in powers.items())
    forces, lengths = [(unit_of("force", kind), 1.0)], [(unit_of("length", kind), 1.0)]
    for counted, channel in ((forces, "effort"), (lengths, "position")):
        if axis is not None and (column := axis.columns.get(channel)) is not None:
            counted.append((column.base, abs(column.scale)))  # a sign in the scale is a matter of wiring; a gain has none
    if axis is not None and axis.arm is not None and kind == "translational":  # on a rotational axis N*m and rad are its own
        forces.append(("N*m", 1.0 / axis.arm))
        lengths.append(("rad", axis.arm))
    for (force, effort), (length, position) in product(forces, lengths):
        unit = unit_of(expanded, kind, force=force, length=length)
        if units.compatible(own_unit, unit, path=path):
            return units.convert(value, unit, path=path) * effort ** powers["force"] * position ** powers.get("length", 0.0)
    return value
