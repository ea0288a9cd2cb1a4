"""How often the loops of a unit go round at most: what bounds the time of a step on a target."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from bristle.exports.c_code import described
from bristle.exports.tree import Constant, For, Statement, Unit, While, blocks_of

__all__ = ["Loop", "loops_of"]


class Loop(NamedTuple):
    """A loop: the function that it stands in, what that is for, and its most rounds in words."""

    function: str
    description: str
    most: str


class Looping(Protocol):
    """What has functions and a memory: a model, or a law with one."""

    @property
    def unit(self) -> Unit:
        """All functions."""
        ...

    @property
    def memory_size(self) -> int:
        """Numbers in the memory."""
        ...


def loops_of(subject: Looping) -> list[Loop]:
    """Return the loops of the functions of a model or a law."""
    loops = []
    for function in subject.unit.functions:
        for loop in _loops(function.body):
            loops.append(Loop(function.name, described(function.description), _most(loop, subject)))
    return loops


def _loops(block: list[Statement]) -> list[For | While]:
    loops: list[For | While] = []
    for statement in block:
        if isinstance(statement, (For, While)):
            loops.append(statement)
        for inner in blocks_of(statement):
            loops += _loops(inner)
    return loops


def _most(loop: For | While, subject: Looping) -> str:
    if isinstance(loop, For):
        bounds = (loop.start, loop.stop)
        if all(isinstance(bound, Constant) for bound in bounds):
            return str(int(bounds[1].value) - int(bounds[0].value))  # type: ignore[attr-defined]
        return "the number that it is handed"
    return f"{subject.memory_size // 4}, half of the turning points remembered"
