"""What a parameter is, told from its quantity and from what a log must contain to show it: no name is asked for."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum

from bristle.core.variable import Variable
from bristle.friction.slots import OFFSET

__all__ = ["Role", "acts_in_sliding", "constant_of", "name_of", "names_of", "offset_of"]

SLIDES = ("sliding", "stribeck", "presliding")


class Role(Enum):
    """Quantity and excitation of the parameters that are treated in a way of their own."""

    INERTIA = ("mass", "acceleration")
    VISCOUS = ("force*time/length", "speed")
    LEVEL = ("force", "sliding")
    BREAK_AWAY = ("force", "stribeck")
    FALL = ("length/time", "stribeck")
    STIFFNESS = ("force/length", "presliding")

    def fits(self, variable: Variable) -> bool:
        """Return whether this is such a parameter; the constant part of friction is no level."""
        return (variable.quantity, variable.excitation) == self.value and variable != OFFSET


def names_of(role: Role | Variable, variables: Mapping[str, Variable]) -> list[str]:
    """Return the parameters of a role, or those that are one and the same `Variable`."""
    return [
        name
        for name, variable in variables.items()
        if (role.fits(variable) if isinstance(role, Role) else variable == role)
    ]


def acts_in_sliding(variable: Variable) -> bool:
    """Return whether a parameter is a force that friction only reaches where it slides, however the log shows it."""
    return variable.quantity == "force" and variable.excitation in SLIDES and variable != OFFSET


def name_of(role: Role | Variable, variables: Mapping[str, Variable]) -> str | None:
    """Return the first parameter of a role; None where there is none."""
    return next(iter(names_of(role, variables)), None)


def offset_of(variables: Mapping[str, Variable], values: Mapping[str, float]) -> float:
    """Return the constant part of friction [N or N*m]; 0 where a model has none."""
    name = name_of(OFFSET, variables)
    return 0.0 if name is None else values.get(name, 0.0)


def constant_of(variables: Mapping[str, Variable], values: Mapping[str, float]) -> float:
    """Return what of a friction is no friction [N or N*m]: its constant part, or half of what two levels differ by."""
    levels = [values[name] for name in names_of(Role.LEVEL, variables)]
    halves = 0.5 * (levels[0] - levels[1]) if len(levels) > 1 else 0.0
    return offset_of(variables, values) + halves
