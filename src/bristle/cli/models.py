"""``bristle models``: what there is, with parameters and units."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bristle.cli.options import Json
from bristle.cli.terminal import say, say_laid_out, show_table

if TYPE_CHECKING:
    from bristle.core import Component, Variable

__all__ = ["EXAMPLE", "models"]

EXAMPLE = """Example:
  bristle models lugre+asymmetry"""


def models(
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help="Show the equations and parameters of this one.")
    ] = None,
    as_json: Json = False,
) -> None:
    """List models, with parameters and units.

    Friction models, hysteresis operators, plants, controllers, sensors and references; with NAME, the equations and
    parameters of one.
    """
    from bristle.files.summary import as_json as json_text

    chosen = _families() if name is None else _one(name)
    if as_json:
        entries = [_described(family, one) for family, members in chosen.items() for one in members]
        sys.stdout.write(json_text({"models": entries}))
    elif name is None:
        _show_families(chosen)
    else:
        _show_one(next(one for members in chosen.values() for one in members))


def _families() -> dict[str, list[Component]]:
    from bristle import controllers, friction, hysteresis, plants, references, sensors

    registries = (
        friction.MODELS, hysteresis.OPERATORS, plants.PLANTS, controllers.CONTROLLERS, sensors.SENSORS,
        references.REFERENCES,
    )  # fmt: skip
    names = ("friction", "hysteresis", "plant", "controller", "sensor", "reference")
    return {family: list(registry.values()) for family, registry in zip(names, registries, strict=True)}


def _one(name: str) -> dict[str, list[Component]]:
    from bristle import friction
    from bristle.core import InputError
    from bristle.core.errors import did_you_mean

    base, plus, slots = name.partition("+")
    family_of = {one.name: family for family, members in _families().items() for one in members}
    named = {one.name: one for members in _families().values() for one in members}
    if base not in named:
        mend = f"{did_you_mean(base, named)} All of them: bristle models".lstrip()
        raise InputError("there is no such model", path="NAME", value=name, mend=mend)
    one: Any = named[base]
    if plus and family_of[base] != "friction":
        raise InputError(f"a {family_of[base]} takes no slots", path="NAME", value=name, mend=f"Write {base}")
    if plus:
        one = friction.with_slots(one, slots.split("+"), "NAME")
    return {family_of[base]: [one]}


def _described(family: str, one: Component) -> dict[str, Any]:
    from bristle.files.components import key_of

    return {
        "name": one.name,
        "family": family,
        "description": one.description,
        "reference": one.reference,
        "equations": list(one.equations),
        "relations": [relation.condition for relation in one.relations],
        "parameters": {
            key_of(name): {
                "description": variable.description,
                "quantity": variable.quantity,
                "unit": variable.unit("translational"),
                "unit_rotational": variable.unit("rotational"),
                "min": variable.min,
                "max": variable.max,
                "default": one.defaults.get(name),
                "array": one.is_array(name),
                "choices": list(variable.choices),
                "directional": variable.directional,
            }
            for name, variable in one.variables.items()
        },
    }


def _show_families(families: dict[str, list[Component]]) -> None:
    from bristle.files.components import key_of
    from bristle.report.table import Table

    for family, members in families.items():
        rows = [(one.name, ", ".join(key_of(name) for name in one.variables), one.description) for one in members]
        show_table(Table(family.capitalize(), ("Name", "Parameters", "What it is"), rows))
    say(
        "Every friction model takes an offset, and slots behind its name: +asymmetry for parameters by direction of "
        "motion; +position, +periodic, +load, +temperature for friction that varies."
    )


def _show_one(one: Component) -> None:
    from bristle.core.docstring import REFERENCE, laid_out
    from bristle.core.typography import typeset
    from bristle.files.components import key_of
    from bristle.report.table import Table

    explained = [part for part in one.explanation if part.kind != REFERENCE]
    say_laid_out(lambda width: laid_out(explained, width))
    rows = [
        (
            key_of(name),
            variable.description,
            typeset(variable.unit("translational")),
            typeset(variable.unit("rotational")),
            _range(variable),
            _default(one, name),
        )
        for name, variable in one.variables.items()
    ]
    heads = ("Parameter", "Meaning", "Unit", "Unit, rotational", "Allowed", "Default")
    show_table(Table(f"{one.name}: {one.description}", heads, rows))
    for relation in one.relations:
        say(f"{'Should have' if relation.advisory else 'Needs'} {relation.condition}.")
    if one.reference:
        say(f"Source: {one.reference}")


def _default(one: Component, name: str) -> str:
    value = one.defaults.get(name, "")
    return value if isinstance(value, str) else f"{value:g}"


def _range(variable: Variable) -> str:
    """Return the allowed range without the unit, which stands in a column of its own."""
    if variable.quantity == "1":
        return variable.allowed()
    return variable.allowed().removesuffix(f" {variable.unit()}").removesuffix(" in")
