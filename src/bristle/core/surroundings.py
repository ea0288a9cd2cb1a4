"""Surroundings of a contact besides its motion: load, temperature and further channels for slots."""

import keyword
from collections import namedtuple
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Annotated, Any

from bristle.core.axis import COLUMNS
from bristle.core.dispatch import chosen_by_fields
from bristle.core.errors import InputError
from bristle.core.lazy import once
from bristle.core.motion import NOTHING_TRANSMITTED, Motion
from bristle.core.packing import kernel_of
from bristle.core.variable import Variable, variables_of

RESERVED = {
    "v",
    "x",
    "dt",
    "p",
    "q",
    "axis",
    "memory",
    "state",
    "motion",
    "move",
    "step",
    "lasting",
    "input",
    "force",
}
"""Reserved words of the contract of a model, which must not be names of channels."""


@dataclass(frozen=True)
class Surrounding:
    """A further channel of a log for a slot of friction.

    Parameters
    ----------
    name : str
        Name under ``[columns]`` of the axis file.
    variable : Variable
        Quantity, description and range.
    usual : float
        Default value in SI units.

    Raises
    ------
    InputError
        If the name is invalid or belongs to another channel, or if the usual value is out of range.

    Examples
    --------
    >>> Surrounding("humidity", Variable("1", "relative humidity", min=0.0, max=1.0), usual=0.5).name
    'humidity'
    """

    name: str
    variable: Variable
    usual: float

    def __post_init__(self) -> None:
        name = self.name
        if (
            not isinstance(name, str)
            or not (name.isascii() and name.isidentifier())
            or keyword.iskeyword(name)
            or name.startswith("_")
            or name in RESERVED
        ):
            raise InputError(
                "is not a valid name of a channel",
                path="channel",
                value=name,
                allowed="a word, such as humidity",
            )
        if not isinstance(self.variable, Variable):
            raise InputError(
                "needs a Variable",
                path=f"channel {name}",
                value=type(self.variable).__name__,
                mend='Write Surrounding("humidity", Variable("1", "relative humidity"), usual=0.5)',
            )
        if (name in COLUMNS or name in Motion._fields) and variables_of(Motion).get(
            self.field
        ) != self.variable:
            raise InputError(
                "is already the name of a channel of bristle",
                path="channel",
                value=name,
                mend=f'Write channel="{name}" to use this channel, or choose another name',
            )
        self.variable.validate(self.usual, f"usual value of {name}")

    @property
    def field(self) -> str:
        """Field of a motion with its value."""
        return "x" if self.name == "position" else self.name

    @property
    def is_own(self) -> bool:
        """Whether it is not a field of `Motion`."""
        return self.field not in Motion._fields

    @property
    def is_recorded(self) -> bool:
        """Whether a log must have its channel; the transmitted effort follows from the plant."""
        return self.is_own or (self.name in COLUMNS and self.field == self.name)


OF_MOTION: dict[str, Surrounding] = {
    name: Surrounding(name, variables_of(Motion)[name], usual)
    for name, usual in Motion._field_defaults.items()
} | {"position": Surrounding("position", variables_of(Motion)["x"], 0.0)}
"""Fields of `Motion` for the surroundings and the position, by name."""


def motion_with(surroundings: Iterable[Surrounding]) -> Any:
    """Return a class of motions with these surroundings; `Motion` if its fields suffice."""
    own: dict[str, Surrounding] = {}
    for surrounding in surroundings:
        if surrounding.is_own and own.setdefault(surrounding.name, surrounding) != surrounding:
            raise InputError(
                "has different descriptions in two slots",
                path=f"channel {surrounding.name}",
                mend="Use the same Variable and usual value in both slots, or different names",
            )
    return _motion_with(tuple(own.values())) if own else Motion


@once
def _motion_with(own: tuple[Surrounding, ...]) -> Any:
    fields = variables_of(Motion) | {surrounding.name: surrounding.variable for surrounding in own}
    usual = [*Motion._field_defaults.values(), *(surrounding.usual for surrounding in own)]
    motion: Any = namedtuple("Motion", fields, defaults=usual, module=__name__)
    motion.__annotations__ = {name: Annotated[float, variable] for name, variable in fields.items()}
    _classes[motion._fields] = motion
    return motion


_classes: dict[tuple[str, ...], Any] = {Motion._fields: Motion}


@once
def _with_velocity(
    name: str, fields: tuple[str, ...], transmitted: str = "motion.transmitted"
) -> Callable[..., Any]:
    values = [
        "v",
        *(transmitted if field == "transmitted" else f"motion.{field}" for field in fields[1:]),
    ]
    return kernel_of(
        f"{name}(v, motion)",
        [f"return Motion({', '.join(values)})"],
        {"__name__": __name__, "Motion": _classes[fields]},
    )


def at_rest(v, motion):
    """Return a motion at rest in the same place, on the side of the zero `v`, without transmitted effort."""
    return motion._replace(v=v, transmitted=NOTHING_TRANSMITTED)


def on_side(v, motion):
    """Return a motion with another velocity `v`, such as the zero of a side, in the same surroundings."""
    return motion._replace(v=v)


chosen_by_fields(
    at_rest, lambda fields: _with_velocity("motion_at_rest", fields, repr(NOTHING_TRANSMITTED))
)
chosen_by_fields(on_side, lambda fields: _with_velocity("motion_on_side", fields))


@once
def reader_of(surrounding: Surrounding) -> Callable[[Any], float]:
    """Return ``read(motion) -> float``: the value in a motion, or else the usual value."""
    name, field, usual = surrounding.name, surrounding.field, float(surrounding.usual)
    # As text, because the compiler and other targets need a plain expression; exported functions have this module name.
    recorded, silent = (
        kernel_of(f"{name}_{case}(motion)", [f"return {expression}"], {"__name__": __name__})
        for case, expression in (("recorded", f"motion.{field}"), ("usual", repr(usual)))
    )

    def read(motion):
        return getattr(motion, field, usual)

    return chosen_by_fields(read, lambda fields: recorded if field in fields else silent)
