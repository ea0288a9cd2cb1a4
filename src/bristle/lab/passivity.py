"""What a page looks at to tell whether friction can give back more than it was given.

Where a bound is known that no parameter moves, or one condition decides, that is said; for bristles the least viscous
coefficient is searched, by a function of the module, as `bristle.certificates.passive` searches it.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Sequence
from typing import Any

from bristle.certificates.passive import let_go
from bristle.core.contracts import Model
from bristle.core.kernel import kernel
from bristle.exports.build import Builder
from bristle.exports.scope import defined
from bristle.exports.subject import Subject
from bristle.exports.tree import REAL, Function
from bristle.friction import (
    bouc_wen,
    channel_slots_of,
    coulomb,
    coulomb_viscous,
    dahl,
    elastoplastic,
    gms,
    lugre,
    maxwell_slip,
    preisach_lugre,
    reformed_dahl,
    stribeck,
    viscous,
)
from bristle.friction.level import LEVELS
from bristle.friction.lugre import micro_damping, stribeck_force
from bristle.friction.preisach_lugre import slip_law
from bristle.friction.slip_law import slip
from bristle.friction.slots import variations_of

SIDES = {"forward": "_pos", "backward": "_neg"}
CONDITIONS = {
    bouc_wen.Parameters: (["beta"], ">=", ["0.5"], "its hysteresis gives energy back at every speed"),
    gms.Parameters: (
        ["F_C"],
        ">=",
        ["F_S"],
        "an element that slips regains its static force without moving, unless static and Coulomb friction are equal",
    ),
}
NEVER = {reformed_dahl.Parameters: "charged by short strokes and let go in a long one it gives back more"}
TEXT = """
def release(x, dt, p):
    if x > 0.0:
        return of_bristles(x, dt, {forward}{inner})
    return of_bristles(-x, dt, {backward}{inner})
"""


@kernel
def of_lugre(v, q, p):
    """Return the viscous coefficient that bristles with the force `q` along the motion ask for at a speed."""
    return let_go(v, q, q / stribeck_force(v, p), micro_damping(v, p))


@kernel
def of_elastoplastic(v, q, p):
    """Return the same for bristles of constant micro-damping."""
    return let_go(v, q, q / stribeck_force(v, p), p.sigma_1)


@kernel
def of_preisach_lugre(v, q, p):
    """Return the same for a slip law."""
    return let_go(v, q, slip(q / stribeck_force(v, p), slip_law(p)), micro_damping(v, p))


BRISTLES = {lugre.Parameters: of_lugre, elastoplastic.Parameters: of_elastoplastic, preisach_lugre.Parameters: of_preisach_lugre}


def passivity_of(model: Model) -> dict[str, Any] | None:
    """Return what decides whether a model is passive, by direction; None where no condition is known."""
    # Of a level that rises none is known, nor of what rises with a channel.
    if channel_slots_of(model.component) or not set(LEVELS).isdisjoint(variations_of(model.component)):
        return None
    names, inner = model.component.variables, type(inner_of(model.parameters)[0])
    sided = any(name.endswith(tuple(SIDES.values())) for name in names)

    sides = list(SIDES.values()) if sided else [""]
    dampings = [of_side(["sigma_2"], side, names) for side in sides], [of_side(["F_v"], side, names) for side in sides]
    present = next((rows for rows in dampings if rows[0][0] in names), [[""]] * len(sides))
    rows: dict[str, Any] = {"present": [row[0] for row in present]}
    if inner in BRISTLES:
        scales = ("F_S", "v_S", "sigma_1")
        return rows | {"bristles": [dict(zip(scales, of_side(scales, side, names), strict=True)) for side in sides]}
    if inner in NEVER:
        return rows | {"never": NEVER[inner]}
    if inner in CONDITIONS:
        left, sign, right, because = CONDITIONS[inner]
        pairs = [{"left": of_side(left, side, names), "sign": sign, "right": of_side(right, side, names)} for side in sides]
        return rows | {"conditions": pairs, "because": because}
    return rows if inner in [module.Parameters for module in (coulomb, viscous, coulomb_viscous, stribeck, dahl, maxwell_slip)] else None


def of_side(names: Sequence[str], side: str, known: Container[str]) -> list[str]:
    """Return names of parameters with the ending of a direction, where there are such."""
    return [name + side if name + side in known else name for name in names]


def release_of(subject: Subject) -> dict[str, Callable[[Builder], Function]]:
    """Return what builds the function of the module in which the least viscous coefficient is searched."""
    inner, path = inner_of(subject.model.parameters)
    if type(inner) not in BRISTLES:
        return {}
    sides = {side: f"p.{side}" if side in subject.model.parameters._fields else "p" for side in SIDES}
    text = TEXT.format(inner=path, **sides)
    function = defined("release", text, {"__name__": __name__, "of_bristles": BRISTLES[type(inner)]})
    return {"release": lambda builder: builder.function(function, [REAL, REAL, subject.parameters])}


def inner_of(p: Any) -> tuple[Any, str]:
    """Return the parameters of one direction, inside of layers that vary it, and how they are reached from there."""
    p, path = _layer(p, "forward") or p, ""
    while (layer := _layer(p, "inner")) is not None:
        p, path = layer, path + ".inner"
    return p, path


def _layer(p: Any, name: str) -> Any:
    """Return the parameters under this name; None where it is a number, as a model of a person's own may call one."""
    layer = getattr(p, name, None)
    return layer if hasattr(layer, "_fields") else None
