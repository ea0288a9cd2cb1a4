"""Tables of files: their required keys, missing values, and the components and control laws that they name."""

import keyword
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

from bristle.core import TEXT, Axis, InputError, Variable, did_you_mean, units
from bristle.core.contracts import Component, Controller, Model, make_model
from bristle.core.dimensions import KINDS, Kind, exponents_of, unit_of
from bristle.models.controllers import CONTROLLERS


def key_of(name: str) -> str:
    """Return the key of a parameter in files: without the underscore that Python needs after ``lambda``."""
    return name[:-1] if name.endswith("_") and keyword.iskeyword(name[:-1]) else name


def table_at(value: Any, path: str) -> dict[str, Any]:
    """Return a value of a file that must be a table."""
    if not isinstance(value, dict):
        raise InputError(
            "must be a table", path=path, value=value, mend=f"Write [{path}] on a separate line"
        )
    return value


def check_keys(table: Mapping[str, Any], expected: Iterable[str], path: str) -> None:
    """Refuse an unknown key and suggest a similar key."""
    names = list(expected)
    for key in table:
        if key not in names:
            full = f"{path}.{key}" if path else key
            raise InputError(
                "unknown key",
                path=full,
                allowed=f"keys: {', '.join(names)}",
                mend=did_you_mean(key, names),
            )


def check_schema(data: Mapping[str, Any]) -> None:
    """Refuse a file without ``schema = 1``."""
    if "schema" not in data:
        raise InputError("is missing", path="schema", mend="Write schema = 1 on the first line")
    if type(data["schema"]) is not int or data["schema"] != 1:
        mend = (
            "Update bristle if a newer version wrote the file"
            if type(data["schema"]) is int
            else "Write schema = 1"
        )
        raise InputError(
            "is a schema that this version of bristle cannot read",
            path="schema",
            value=data["schema"],
            allowed="1",
            mend=mend,
        )


def name_of(data: Mapping[str, Any], source: Path) -> str:
    """Return the name in a file, or else the name of the file without its extension."""
    return TEXT(data.get("name", source.stem), "name", None)


def component_named(name: Any, registry: Mapping[str, Component], path: str) -> Any:
    """Return the component with this name."""
    if isinstance(name, str) and name in registry:
        return registry[name]
    raise InputError(
        "there is no such model",
        path=path,
        value=name,
        allowed=", ".join(registry),
        mend=did_you_mean(name, registry),
    )


def parameters_in(
    table: Mapping[str, Any], component: Component, path: str, *, beside: tuple[str, ...] = ()
) -> dict[str, Any]:
    """Return the parameters of a table by their names in code."""
    names = {key_of(name): name for name in component.variables}
    check_keys(table, (*beside, *names), path)
    return {names[key]: value for key, value in table.items() if key in names}


def model_from(
    table: Any,
    registry: Mapping[str, Component],
    *,
    kind: Kind,
    path: str,
    default: str = "",
    find: Callable[[str, Iterable[str], str], Component] | None = None,
    own: Component | None = None,
) -> Model:
    """Return the component that a table names, with the parameters of the table."""
    component = own or _component_in(table, registry, path, default, find)
    values = parameters_in(table, component, path, beside=("model" if own is None else "file",))
    return make_model(component, values, kind=kind, validate=True, path=path)


def _component_in(
    table: Any, registry: Mapping[str, Component], path: str, default: str = "", find: Any = None
) -> Any:
    named = table_at(table, path).get("model", default)
    if named == "" and "model" not in table:
        mend = (
            "Name your own law in an experiment file"
            if "file" in table
            else f'Write model = "..." under [{path}]'
        )
        raise InputError("names no model", path=path, allowed=", ".join(registry), mend=mend)
    if find is not None and isinstance(named, str) and "+" in named:
        return find(named, table, f"{path}.model")
    return component_named(named, registry, f"{path}.model")


def number_at(raw: Any, variable: Variable, kind: Kind, path: str) -> float:
    """Return a value of a file as a finite number in SI, in the range of its variable."""
    value = units.quantity(raw, variable, kind, path=path)
    variable.validate(value, path, kind)
    return value


FILL_IN = "?"  # placeholder in a file for a value that the user has to fill in


def open_in(tables: Any, path: str = "") -> Iterator[str]:
    """Yield the keys of tables whose values are not filled in."""
    if isinstance(tables, Mapping):
        for key, value in tables.items():
            yield from open_in(value, f"{path}.{key}" if path else str(key))
    elif tables == FILL_IN:
        yield path


def refuse_open(tables: Mapping[str, Any]) -> None:
    """Refuse a file with a value that is not filled in."""
    if keys := list(open_in(tables)):
        more = f" Also fill in {', '.join(keys[1:])}" if len(keys) > 1 else ""
        raise InputError(
            "is not filled in",
            path=keys[0],
            value=FILL_IN,
            mend=f"The comment on this line explains the value.{more}",
        )


def numbers_in(
    table: Mapping[str, Any],
    variables: Mapping[str, Variable],
    kind: Kind,
    path: str,
    *,
    needs: Iterable[str] = (),
    integers: Iterable[str] = (),
) -> dict[str, Any]:
    """Return the given quantities of a table in SI units; those in `needs` are required, and some are whole numbers."""
    for name in needs:
        if name not in table:
            raise InputError(
                f"needs {name}",
                path=path,
                mend=f"Write {name} ({variables[name].description}) under [{path}]",
            )
    values: dict[str, Any] = {}
    for name, variable in variables.items():
        if (key := key_of(name)) in table:
            values[name] = number_at(table[key], variable, kind, f"{path}.{key}")
    for name in values.keys() & set(integers):
        if not values[name].is_integer():
            raise InputError("must be a whole number", path=f"{path}.{name}", value=table[name])
        values[name] = int(values[name])
    return values


def choice_at(
    table: Mapping[str, Any],
    key: str,
    choices: Sequence[str],
    path: str,
    fault: str,
    usual: str | None = None,
) -> str:
    """Return the choice at a key of a table; if it is missing, the usual choice, or else the first."""
    value = table.get(key, usual or choices[0])
    if value not in choices:
        raise InputError(fault, path=f"{path}.{key}", value=value, allowed=" or ".join(choices))
    return value


def kind_at(value: Any, path: str, kinds: Sequence[Kind] = KINDS) -> Kind:
    """Return a kind of axis."""
    if value not in kinds:
        raise InputError("unknown kind of axis", path=path, value=value, allowed=" or ".join(kinds))
    return value


INTEGRAL_TIME = "T_n"


def controller_from(
    table: Any, *, kind: Kind, axis: Axis | None = None, path: str, own: Controller | None = None
) -> Model:
    """Return the control law of a table; gains may be in units of the drive, such as ``k_v = "243.45 V*s/m"``, or of the motor."""
    entries, component = table_at(table, path), own or _component_in(table, CONTROLLERS, path)
    by_time = (INTEGRAL_TIME,) if {"k_v", "k_i"} <= set(component.variables) else ()
    values = parameters_in(
        entries, component, path, beside=("model" if own is None else "file", *by_time)
    )
    for name, value in values.items():
        values[name] = in_effort(
            value, component.variables[name].quantity, kind, axis, f"{path}.{name}"
        )
    if by_time and INTEGRAL_TIME in entries:
        place, raw = f"{path}.{INTEGRAL_TIME}", entries[INTEGRAL_TIME]
        if "k_i" in values:
            raise InputError(
                "sets the integral gain, but k_i sets it too",
                path=place,
                value=raw,
                mend="Keep only one",
            )
        if "k_v" not in values:
            raise InputError(
                "needs the velocity gain", path=place, value=raw, mend=f"Write k_v under [{path}]"
            )
        time = number_at(raw, Variable("time", "integral time", min=0.0), kind, place)
        gain = units.quantity(values["k_v"], component.variables["k_v"], kind, path=f"{path}.k_v")
        values["k_i"] = gain / time if time else 0.0  # a time of 0 switches the integral off
    return make_model(component, values, kind=kind, validate=True, path=path)


def in_effort(value: Any, quantity: str, kind: Kind, axis: Axis | None, path: str) -> Any:
    """Convert text in units of the effort and position columns, such as ``"A*s/rad"``, to SI units; return everything else unchanged."""
    if not isinstance(value, str) or "force" not in (powers := exponents_of(quantity)):
        return value
    _, own_unit = units.split(value, path)
    if not own_unit or units.compatible(own_unit, unit_of(quantity, kind), path=path):
        return value
    # An inertia may also be given as an effort divided by an acceleration.
    expanded = "*".join(f"{name}^{power:g}" for name, power in powers.items())
    forces, lengths = [(unit_of("force", kind), 1.0)], [(unit_of("length", kind), 1.0)]
    for counted, channel in ((forces, "effort"), (lengths, "position")):
        if axis is not None and (column := axis.columns.get(channel)) is not None:
            # A negative scale reflects the wiring; a gain has no sign.
            counted.append((column.base, abs(column.scale)))
    # N*m and rad are the units of a rotational axis.
    if axis is not None and axis.arm is not None and kind == "translational":
        forces.append(("N*m", 1.0 / axis.arm))
        lengths.append(("rad", axis.arm))
    for (force, effort), (length, position) in product(forces, lengths):
        unit = unit_of(expanded, kind, force=force, length=length)
        if units.compatible(own_unit, unit, path=path):
            return (
                units.convert(value, unit, path=path)
                * effort ** powers["force"]
                * position ** powers.get("length", 0.0)
            )
    return value
