"""The local variables of a function of WebAssembly: a tuple is a run of them, one for each of its numbers."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import groupby

from bristle.exports.tree import Variable
from bristle.exports.wasm_binary import flat, leb, vector

__all__ = ["Locals"]


class Locals:
    """Local variables, arguments first; what runs in place of a call leaves its own to others that come after it."""

    def __init__(self, arguments: Sequence[Variable], integer: int) -> None:
        self.integer = integer
        self.kinds: list[int] = []
        self._places: dict[str, int] = {}
        self._runs: list[tuple[tuple[int, ...], int]] = []
        self._free: defaultdict[tuple[int, ...], list[int]] = defaultdict(list)
        for argument in arguments:
            self.place(argument)
        self._arguments = len(self.kinds)

    def place(self, variable: Variable) -> int:
        """Return where the numbers of a variable begin."""
        if variable.name not in self._places:
            self._places[variable.name] = self.new(flat(variable.type, self.integer))
        return self._places[variable.name]

    def numbers(self, variable: Variable) -> range:
        """Return where the numbers of a variable are."""
        first = self.place(variable)
        return range(first, first + len(flat(variable.type, self.integer)))

    def new(self, kinds: Sequence[int]) -> int:
        """Return where a new run of numbers begins."""
        free = self._free[tuple(kinds)]
        first = free.pop() if free else len(self.kinds)
        if first == len(self.kinds):
            self.kinds += kinds
        self._runs.append((tuple(kinds), first))
        return first

    @contextmanager
    def apart(self) -> Iterator[None]:
        """Let names mean other variables in this block."""
        outside = self._places, self._runs
        self._places, self._runs = {}, []
        yield
        for kinds, first in self._runs:
            self._free[kinds].append(first)
        self._places, self._runs = outside

    def declared(self) -> bytes:
        """Return what is not an argument as the format has it: how many in a row of each type."""
        runs = groupby(self.kinds[self._arguments :])
        return vector([leb(len(list(run))) + bytes([kind]) for kind, run in runs])
