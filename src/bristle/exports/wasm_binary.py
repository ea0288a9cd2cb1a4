"""The binary format of WebAssembly: codes of instructions and types, how counts and lists are written, local variables."""

import struct
from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import groupby

from bristle.core.exponent import BITS_OF_ONE, BITS_OF_ROUNDER, INTEGER_IN_LAST_BITS, OF_MANTISSA
from bristle.exports.tree import REAL, TRUTH, VOID, Array, Struct, Type, Variable

# Names with their bytes: sections, types, the type of a block that gives nothing, instructions, arithmetic by type and operator.
TABLE = """
types 01 functions 03 memories 05 exports 07 code 0A data 0B
i32 7F i64 7E f64 7C empty 40
unreachable 00 block 02 loop 03 if 04 else 05 end 0B br 0C br_if 0D return 0F call 10 drop 1A select 1B
get 20 set 21 tee 22 load 2B0300 store 390300 i32.const 41 i64.const 42 f64.const 44
eqz 45 wrap A7 widen AC i32.truncate FC02 i64.truncate FC06 i32.real B7 i64.real B9 bits BD number BF
abs 99 negate 9A floor 9C sqrt 9F copysign A6 and 83 or 84 shift_left 86 shift_right 88
f64== 61 f64!= 62 f64< 63 f64> 64 f64<= 65 f64>= 66 f64+ A0 f64- A1 f64* A2 f64/ A3
i32== 46 i32!= 47 i32< 48 i32> 4A i32<= 4C i32>= 4E i32+ 6A i32- 6B i32* 6C i32& 71 i32^ 73 i32>> 75
i64== 51 i64!= 52 i64< 53 i64> 55 i64<= 57 i64>= 59 i64+ 7C i64- 7D i64* 7E i64& 83 i64^ 85 i64>> 87
"""
OP = {name: bytes.fromhex(code) for name, code in zip(TABLE.split()[::2], TABLE.split()[1::2], strict=True)}


def emitted(*parts: str | bytes) -> bytes:
    """Return the bytes of instructions by their names, and of what they are given."""
    return b"".join(OP[part] if isinstance(part, str) else part for part in parts)


def leb(value: int) -> bytes:
    """Return a count as the format has it: seven bits a byte, the lowest first."""
    parts = bytearray()
    while True:
        value, low = value >> 7, value & 127
        parts.append(low | (128 if value else 0))
        if not value:
            return bytes(parts)


def signed_leb(value: int) -> bytes:
    """Return an integer as the format has it."""
    parts = bytearray()
    while True:
        value, low = value >> 7, value & 127
        ends = (value == 0 and not low & 64) or (value == -1 and low & 64)
        parts.append(low if ends else low | 128)
        if ends:
            return bytes(parts)


def vector(parts: Sequence[bytes]) -> bytes:
    """Return several things as the format has them: how many, then each."""
    return leb(len(parts)) + b"".join(parts)


def flat(kind: Type, integer: str) -> list[str]:
    """Return the numbers that a value is, by their types in the machine; `integer` is that of whole numbers."""
    if isinstance(kind, Struct):
        return [number for _, part in kind.fields for number in flat(part, integer)]
    if isinstance(kind, Array) or kind == TRUTH:
        return ["i32"]
    return [] if kind == VOID else ["f64" if kind == REAL else integer]


class Types:
    """The types of functions and blocks of a module, each once."""

    def __init__(self) -> None:
        self.listed: list[tuple[tuple[str, ...], tuple[str, ...]]] = []

    def index(self, takes: Sequence[str], gives: Sequence[str]) -> int:
        """Return the number of a type."""
        pair = (tuple(takes), tuple(gives))
        if pair not in self.listed:
            self.listed.append(pair)
        return self.listed.index(pair)

    def block(self, gives: Sequence[str]) -> bytes:
        """Return the type of a block."""
        if not gives:
            return OP["empty"]
        return OP[gives[0]] if len(gives) == 1 else signed_leb(self.index((), gives))


class Locals:
    """Local variables, arguments first; what runs in place of a call leaves its own to others that come after it."""

    def __init__(self, arguments: Sequence[Variable], integer: str) -> None:
        self.integer = integer
        self.kinds: list[str] = []
        self._places: dict[str, int] = {}
        self._runs: list[tuple[tuple[str, ...], int]] = []
        self._free: defaultdict[tuple[str, ...], list[int]] = defaultdict(list)
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

    def new(self, kinds: Sequence[str]) -> int:
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
        return vector([leb(len(list(run))) + OP[kind] for kind, run in runs])


_ROUNDER = ("f64.const", struct.pack("<d", INTEGER_IN_LAST_BITS))
_FRACTION = ("i64.const", signed_leb(52))
_MANTISSA, _UNIT = signed_leb(OF_MANTISSA), signed_leb(BITS_OF_ONE)
IN_BITS = {
    "power_of_two": emitted(*_ROUNDER, "f64+", "bits", *_FRACTION, "shift_left", "number"),
    "mantissa": emitted("bits", "i64.const", _MANTISSA, "and", "i64.const", _UNIT, "or", "number"),
    "exponent": emitted("bits", *_FRACTION, "shift_right", "i64.const", signed_leb(BITS_OF_ROUNDER), "or", "number", *_ROUNDER, "f64-"),
}
"""Instructions for the parts of a number, as `bristle.core.exponent` reads them."""
