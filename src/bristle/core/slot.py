"""`Slot`: the descriptor of a slot by which friction varies with a channel of a log, ours or a person's own."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

from bristle.core.axis import COLUMNS
from bristle.core.documented import Documented
from bristle.core.errors import InputError
from bristle.core.kernel import kernels
from bristle.core.surroundings import OF_MOTION, Surrounding
from bristle.core.variable import OF_SLOTS

FRICTION, LEVEL = "friction", "level"
EXCITATION = OF_SLOTS[-1]
TAKES = ("channel", "p")
CHANNELS = {name: surrounding for name, surrounding in OF_MOTION.items() if name in COLUMNS}
"""What `Motion` holds of a log: the effort that passes on is no channel of it."""


class Stateless(NamedTuple):
    """A slot remembers nothing."""


@dataclass(frozen=True, kw_only=True)
class Slot(Documented):
    r"""A slot: a factor of friction, by an equation of its own, of one channel of a log.

    .. math::
        F = g(c)\,F_\text{model} \qquad\text{or}\qquad F = F_\text{model} + (g(c) - 1)\,(F_\text{model} - F_v v)

    ``factor(c, p) -> g`` is a kernel of the channel in SI and the parameters of the slot. All of them have a default,
    and with these it is 1 for every value of the channel. Those that are to be identified say so:
    ``excitation="channel"``; the others are held at their default.

    Parameters
    ----------
    channel : Surrounding or str
        What it depends on: a further channel of the log, or ``"position"``, ``"load"`` or ``"temperature"``.
    factor : callable
        The kernel.
    of : {"friction", "level"}
        What the factor multiplies: all of the friction, or what of it is not viscous.

    Raises
    ------
    InputError
        If there is no such channel, or it multiplies something else.
    """

    channel: Any
    factor: Callable[..., Any]
    of: str = FRICTION
    State: type = Stateless

    family: ClassVar[str] = "slot"

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.channel, str) and self.channel in CHANNELS:
            object.__setattr__(self, "channel", CHANNELS[self.channel])
        if not isinstance(self.channel, Surrounding):
            place, allowed = f"channel of {self.name}", f"{', '.join(CHANNELS)}, or one of your own"
            mend = 'Write channel=Surrounding("humidity", Variable("1", "relative humidity"), usual=0.5)'
            raise InputError("is no channel of a log", path=place, value=self.channel, allowed=allowed, mend=mend)
        if self.of not in (FRICTION, LEVEL):
            raise InputError("is none of the choices", path=f"of, of {self.name}", value=self.of, allowed=f"{FRICTION}, {LEVEL}")

    @property
    def neutral(self) -> Any:
        """The parameters with which nothing varies."""
        return self.Parameters()

    @property
    def identified(self) -> tuple[str, ...]:
        """The parameters that a log is to tell."""
        return tuple(name for name, variable in self.variables.items() if variable.excitation)


def refuse_unfit(slot: Slot) -> None:
    """Refuse a slot that has not the form of one: no model runs."""
    for name, variable in slot.variables.items():
        if name not in slot.defaults:
            mend = "Give each parameter the default with which friction does not vary"
            raise InputError("has no default", path=f"Parameters.{name}", mend=mend)
        if slot.is_array(name) or variable.choices:
            raise InputError("is no number", path=f"Parameters.{name}", mend="A slot takes numbers")
        if variable.excitation not in ("", EXCITATION):
            message, place, allowed = "is not what a slot needs of a log", f"excitation of {name}", f'"{EXCITATION}", or empty'
            raise InputError(message, path=place, value=variable.excitation, allowed=allowed)
    if not slot.identified:
        mend = f'Write Variable(..., excitation="{EXCITATION}") for what is to be identified'
        raise InputError("has no parameter that a log could tell", path="Parameters", mend=mend)
    if slot.factor not in kernels():
        raise InputError("is not a kernel", path="factor", mend="Decorate it with @kernel from bristle.core")
    count = len(inspect.signature(slot.factor).parameters)
    if count != len(TAKES):
        raise InputError(f"takes {count} arguments", path="factor", allowed=f"factor({', '.join(TAKES)})")
