"""`Slot`: descriptor of a slot of bristle or of the user, by which friction varies with a channel of a log."""

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
"""Channels of a log in `Motion`; the transmitted effort is not a channel."""


class Stateless(NamedTuple):
    """State of a slot, always empty."""


@dataclass(frozen=True, kw_only=True)
class Slot(Documented):
    r"""A slot: a factor of friction that depends on a channel of a log.

    .. math::
        F = g(c)\,F_\text{model} \qquad\text{or}\qquad F = F_\text{model} + (g(c) - 1)\,(F_\text{model} - F_v v)

    ``factor(c, p) -> g`` is a kernel of the channel in SI units and the parameters of the slot. All parameters have
    defaults, for which the factor is 1 for every value of the channel. Parameters with ``excitation="channel"`` are
    identified; the others keep their default.

    Parameters
    ----------
    channel : Surrounding or str
        Its channel: a further channel of the log, or ``"position"``, ``"load"`` or ``"temperature"``.
    factor : callable
        The kernel.
    of : {"friction", "level"}
        Part of the friction that the factor multiplies: all of it, or only its non-viscous part.

    Raises
    ------
    InputError
        If the channel or `of` is invalid.
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
            raise InputError(
                "is not a channel of a log",
                path=f"channel of {self.name}",
                value=self.channel,
                allowed=f"{', '.join(CHANNELS)}, or a further channel",
                mend='Write channel=Surrounding("humidity", Variable("1", "relative humidity"), usual=0.5)',
            )
        if self.of not in (FRICTION, LEVEL):
            raise InputError(
                "is not a valid choice",
                path=f"argument `of` of {self.name}",
                value=self.of,
                allowed=f"{FRICTION}, {LEVEL}",
            )

    @property
    def neutral(self) -> Any:
        """Parameters for a factor of 1."""
        return self.Parameters()

    @property
    def identified(self) -> tuple[str, ...]:
        """Parameters to identify from a log."""
        return tuple(name for name, variable in self.variables.items() if variable.excitation)


def refuse_unfit(slot: Slot) -> None:
    """Refuse a slot of invalid form, without running a model."""
    for name, variable in slot.variables.items():
        if name not in slot.defaults:
            raise InputError(
                "has no default",
                path=f"Parameters.{name}",
                mend="Give each parameter a default with which the channel does not change the friction",
            )
        if slot.is_array(name) or variable.choices:
            raise InputError(
                "is not a number",
                path=f"Parameters.{name}",
                mend="Use only numbers as parameters of a slot",
            )
        if variable.excitation not in ("", EXCITATION):
            raise InputError(
                "is not an excitation for a slot",
                path=f"excitation of {name}",
                value=variable.excitation,
                allowed=f'"{EXCITATION}", or empty',
            )
    if not slot.identified:
        raise InputError(
            "has no parameter to identify from a log",
            path="Parameters",
            mend=f'Write Variable(..., excitation="{EXCITATION}") for each parameter to identify',
        )
    if slot.factor not in kernels():
        raise InputError(
            "is not a kernel", path="factor", mend="Decorate factor with @kernel from bristle.core"
        )
    count = len(inspect.signature(slot.factor).parameters)
    if count != len(TAKES):
        raise InputError(
            f"takes {count} arguments", path="factor", allowed=f"factor({', '.join(TAKES)})"
        )
