"""``bristle models``: list of models, with parameters and units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from bristle.cli.options import Json, holds_own, loaded_code, own_model, print_json
from bristle.cli.terminal import say, say_laid_out, show_table

if TYPE_CHECKING:
    from bristle.core import Component, Variable

EXAMPLE = """Example:
  bristle models lugre+asymmetry"""


def models(
    name: Annotated[
        str | None,
        typer.Argument(metavar="[NAME]", help="Show the equations and parameters of this model."),
    ] = None,
    as_json: Json = False,
) -> None:
    """List models, with parameters and units.

    Lists friction models, hysteresis operators, plants, controllers, sensors and references. With NAME, shows the
    equations and parameters of one model. NAME can also be your own file, such as my_slot.py.
    """
    if name is None:
        chosen = _families()
    else:
        chosen = _selected(name)
    if as_json:
        entries = [
            _described(family, member) for family, members in chosen.items() for member in members
        ]
        print_json({"models": entries})
    elif name is None:
        _show_families(chosen)
    else:
        _show_one(next(member for members in chosen.values() for member in members))


def _families() -> dict[str, list[Component]]:
    from bristle.models import controllers, friction, hysteresis, plants, references, sensors

    registries: dict[str, Any] = {
        "friction": friction.MODELS,
        "hysteresis": hysteresis.OPERATORS,
        "plant": plants.PLANTS,
        "controller": controllers.CONTROLLERS,
        "sensor": sensors.SENSORS,
        "reference": references.REFERENCES,
        "slot": friction.CHANNEL_SLOTS,
    }
    return {family: list(registry.values()) for family, registry in registries.items()}


def _selected(name: str) -> dict[str, list[Component]]:
    from bristle.core import InputError, did_you_mean
    from bristle.models import friction, plants

    if holds_own(name) and "+" in name:
        return {"friction": [own_model(name, "NAME").inner]}
    if holds_own(name):  # a file without a base model: a slot, a model, a law or a sensor
        from bristle.files import load_checked

        described = loaded_code([name], load_checked)[0][0]
        return {described.family: [described]}
    base, plus, slots = name.removeprefix("+").partition("+")
    family_of = {
        member.name: family for family, members in _families().items() for member in members
    }
    named = {member.name: member for members in _families().values() for member in members}
    if base not in named:
        raise InputError(
            "is not a known model",
            path="NAME",
            value=name,
            mend=f"{did_you_mean(base, named)} For a list type: bristle models".lstrip(),
        )
    chosen: Any = named[base]
    if plus and family_of[base] == "plant":
        # Examples of terms that can be repeated.
        return {"plant": [plants.find(name, ("motor_6_cos", "known_NAME"), "NAME")]}
    if plus and family_of[base] != "friction":
        raise InputError(
            f"a {family_of[base]} has no slots", path="NAME", value=name, mend=f"Write {base}"
        )
    if plus:
        chosen = friction.with_slots(chosen, slots.split("+"), "NAME")
    return {family_of[base]: [chosen]}


def _described(family: str, component: Component) -> dict[str, Any]:
    from bristle.files import key_of
    from bristle.report.messages import picked

    return {
        **picked(component, "name", "description", "reference"),
        "family": family,
        "equations": list(component.equations),
        "relations": [relation.condition for relation in component.relations],
        "channels": [channel.name for channel in component.channels_needed],
        "parameters": {
            key_of(name): picked(variable, "description", "quantity", "min", "max", "directional")
            | {
                "unit": variable.unit("translational"),
                "unit_rotational": variable.unit("rotational"),
                "default": component.defaults.get(name),
                "array": component.is_array(name),
                "choices": list(variable.choices),
            }
            for name, variable in component.variables.items()
        },
    }


def _show_families(families: dict[str, list[Component]]) -> None:
    from bristle.files import key_of
    from bristle.models.friction import PARAMETERS_OF_SLOTS, WHAT_SLOTS_DO
    from bristle.report.table import Table

    for family, members in families.items():
        if family == "slot":  # listed with all slots, below
            continue
        rows = [
            (member.name, ", ".join(key_of(name) for name in member.variables), member.description)
            for member in members
        ]
        show_table(Table(family.capitalize(), ("Name", "Parameters", "Description"), rows))
    rows = [
        (f"+{name}", ", ".join(PARAMETERS_OF_SLOTS[name]), what)
        for name, what in WHAT_SLOTS_DO.items()
    ]
    show_table(Table("Slots", ("Name", "Parameters", "Description"), rows))
    say(
        "Every friction model accepts an offset. Write slots after its name: built-in slots, or your own file, such as "
        "+my_slot.py. Plants accept the terms +gravity, +cogging and +known."
    )


def _show_one(component: Component) -> None:
    from bristle.core import typeset
    from bristle.files import key_of
    from bristle.report.table import Table

    say_laid_out(component.laid_out)
    rows = []
    for name, variable in component.variables.items():
        default = component.defaults.get(name, "")
        if not isinstance(default, str):
            default = f"{default:g}"
        rows.append(
            {
                "Parameter": key_of(name),
                "Meaning": variable.description,
                "Unit": typeset(variable.unit("translational")),
                "Unit, rotational": typeset(variable.unit("rotational")),
                "Allowed": _range(variable),
                "Default": default,
            }
        )
    show_table(Table.of(f"{component.name}: {component.description}", rows))
    for relation in component.relations:
        needs = "Needs"
        if relation.advisory:
            needs = "Should have"
        say(f"{needs} {relation.condition}.")
    for channel in component.channels_needed:
        say(
            f"Needs channel {channel.name} of the log: {channel.variable.description}, {channel.variable.allowed()}; "
            f"{channel.usual:g} by default."
        )
    if component.reference:
        say(f"Source: {component.reference}")


def _range(variable: Variable) -> str:
    """Return the allowed range without the unit, which has a separate column."""
    if variable.quantity == "1":
        return variable.allowed()
    return variable.allowed().removesuffix(f" {variable.unit()}").removesuffix(" in")
