"""`Fleet`: many logs, each identified by itself with one model, as data: a study of which each log is a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from bristle.core.axis import Axis
from bristle.core.content import Content
from bristle.core.contracts import FrictionModel
from bristle.core.errors import InputError
from bristle.core.lazy import cached_property
from bristle.core.variable import Kind, Variable
from bristle.identification.request import prior_knowledge_of
from bristle.study.plan import Block

__all__ = ["ENDS", "Fleet", "LogFile", "Quantity"]

ENDS = ("lower", "upper")


@dataclass(frozen=True)
class LogFile:
    """A log of a fleet."""

    place: str
    folder: str
    name: str
    checksum: str
    time: float | None = None
    axis: int = 0

    @property
    def identity(self) -> tuple[str, str, str]:
        """What tells it from any other log."""
        return self.folder, self.name, self.checksum


class Quantity(NamedTuple):
    """What a row holds of each log: dotted name, SI unit, meaning."""

    column: str
    unit: str
    description: str


@dataclass(frozen=True, eq=False)
class Fleet:
    """Many logs, each identified by itself."""

    name: str
    logs: tuple[LogFile, ...]
    axes: tuple[Axis | None, ...]
    kind: Kind
    model: FrictionModel
    options: Mapping[str, Any]
    readers: tuple[Content, ...]
    size_limit: int
    described: Mapping[str, Any]

    @property
    def count(self) -> int:
        """How many logs there are."""
        return len(self.logs)

    @property
    def blocks(self) -> tuple[Block, ...]:
        """Each log by itself: so a fleet can grow, and a log that ends its process takes no other with it."""
        return tuple(Block(number, number + 1) for number in range(self.count))

    @cached_property
    def parameters(self) -> dict[str, Quantity]:
        """The parameters that have columns, by their name: those of the plant first."""
        plant = prior_knowledge_of(self.axes[0], None, None, self.kind).plant
        named = _named("plant", plant.variables, self.kind)
        arrays = {name for name in self.model.variables if self.model.is_array(name)}
        friction = {name: variable for name, variable in self.model.variables.items() if name not in arrays}
        return named | _named("friction", friction, self.kind)

    def following(self, listed: Sequence[Mapping[str, Any]]) -> Fleet:
        """Return the fleet with the logs that its folder lists already at the numbers that they have there."""
        named = {log.identity: log for log in self.logs}
        places = {(log.folder, log.name): log for log in self.logs}
        logs = []
        for entry in listed:
            past = LogFile("", entry["folder"], entry["log"], entry["sha256"], entry["time"])
            log = named.pop(past.identity, None)
            if log is None and (past.folder, past.name) in places:
                place = places[past.folder, past.name].place
                raise InputError(
                    "is in this fleet already, with another content",
                    path=place,
                    mend="Give it another name, or name another folder for the fleet",
                )
            logs.append(past if log is None else log)
        return replace(self, logs=(*logs, *named.values()))


def _named(section: str, variables: Mapping[str, Variable], kind: Kind) -> dict[str, Quantity]:
    return {
        name: Quantity(f"{section}.{name}", "" if variable.quantity == "1" else variable.unit(kind), variable.description)
        for name, variable in variables.items()
        if not variable.choices
    }
