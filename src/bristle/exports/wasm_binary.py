"""The binary format of WebAssembly: numbers of instructions and types, and how counts and lists are written."""

from __future__ import annotations

import struct
from collections.abc import Sequence

from bristle.core.exponent import BITS_OF_ONE, BITS_OF_ROUNDER, INTEGER_IN_LAST_BITS, OF_MANTISSA
from bristle.exports.types import REAL, TRUTH, VOID, Array, Struct, Type

__all__ = [
    "AND",
    "BLOCK",
    "BR",
    "BR_IF",
    "CALL",
    "COPYSIGN",
    "DROP",
    "ELSE",
    "EMPTY",
    "END",
    "EQZ",
    "F64",
    "FLOOR",
    "GET",
    "I32",
    "I64",
    "IF",
    "INTEGERS_32",
    "INTEGERS_64",
    "IN_BITS",
    "LARGEST",
    "LOAD",
    "LOOP",
    "NEGATE",
    "ONE_NUMBER",
    "OR",
    "REALS",
    "REAL_FROM_32",
    "REAL_FROM_64",
    "REINTERPRET_TO_F64",
    "REINTERPRET_TO_I64",
    "RETURN",
    "SELECT",
    "SET",
    "SHIFT_LEFT",
    "SHIFT_RIGHT",
    "STORE",
    "TEE",
    "TRUNCATE_32",
    "TRUNCATE_64",
    "UNREACHABLE",
    "WIDER",
    "WRAP",
    "Types",
    "flat",
    "leb",
    "signed_leb",
    "vector",
]

I32, I64, F64 = 0x7F, 0x7E, 0x7C
BLOCK, LOOP, IF, ELSE, END, BR, BR_IF, RETURN, CALL, SELECT = 0x02, 0x03, 0x04, 0x05, 0x0B, 0x0C, 0x0D, 0x0F, 0x10, 0x1B
UNREACHABLE, DROP, EMPTY, GET, SET, TEE, LOAD, STORE = 0x00, 0x1A, 0x40, 0x20, 0x21, 0x22, 0x2B, 0x39
EQZ, WRAP, REINTERPRET_TO_I64, REINTERPRET_TO_F64 = 0x45, 0xA7, 0xBD, 0xBF
SHIFT_LEFT, SHIFT_RIGHT, AND, OR = 0x86, 0x88, 0x83, 0x84
REALS = {"+": 0xA0, "-": 0xA1, "*": 0xA2, "/": 0xA3, "==": 0x61, "!=": 0x62, "<": 0x63, ">": 0x64, "<=": 0x65, ">=": 0x66}
INTEGERS_32 = {
    "+": 0x6A,
    "-": 0x6B,
    "*": 0x6C,
    "&": 0x71,
    "^": 0x73,
    ">>": 0x75,
    "==": 0x46,
    "!=": 0x47,
    "<": 0x48,
    ">": 0x4A,
    "<=": 0x4C,
    ">=": 0x4E,
}
INTEGERS_64 = {
    "+": 0x7C,
    "-": 0x7D,
    "*": 0x7E,
    "&": 0x83,
    "^": 0x85,
    ">>": 0x87,
    "==": 0x51,
    "!=": 0x52,
    "<": 0x53,
    ">": 0x55,
    "<=": 0x57,
    ">=": 0x59,
}
ONE_NUMBER = {"abs": 0x99, "sqrt": 0x9F}
FLOOR, NEGATE, COPYSIGN = 0x9C, 0x9A, 0xA6
TRUNCATE_32, TRUNCATE_64 = (0xFC, 0x02), (0xFC, 0x06)
REAL_FROM_32, REAL_FROM_64, WIDER = 0xB7, 0xB9, 0xAC
LARGEST = 1.7976931348623157e308


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


def flat(kind: Type, integer: int) -> list[int]:
    """Return the numbers that a value is, by their types in the machine."""
    if isinstance(kind, Struct):
        return [number for _, part in kind.fields for number in flat(part, integer)]
    if isinstance(kind, Array) or kind == TRUTH:
        return [I32]
    return [] if kind == VOID else [F64 if kind == REAL else integer]


class Types:
    """The types of functions and blocks of a module, each once."""

    def __init__(self) -> None:
        self.listed: list[tuple[tuple[int, ...], tuple[int, ...]]] = []

    def index(self, takes: Sequence[int], gives: Sequence[int]) -> int:
        """Return the number of a type."""
        pair = (tuple(takes), tuple(gives))
        if pair not in self.listed:
            self.listed.append(pair)
        return self.listed.index(pair)

    def block(self, gives: Sequence[int]) -> bytes:
        """Return the type of a block."""
        if not gives:
            return bytes([EMPTY])
        return bytes([gives[0]]) if len(gives) == 1 else signed_leb(self.index((), gives))


def _bits_and(*codes: int | bytes) -> bytes:
    """Return the instructions that take a number to its bits, do something, and take the bits back."""
    inner = b"".join(code if isinstance(code, bytes) else bytes([code]) for code in codes)
    return bytes([REINTERPRET_TO_I64]) + inner + bytes([REINTERPRET_TO_F64])


_CONSTANT, _BITS = b"\x44" + struct.pack("<d", INTEGER_IN_LAST_BITS), b"\x42"
IN_BITS = {
    "power_of_two": _CONSTANT + bytes([REALS["+"]]) + _bits_and(_BITS + signed_leb(52), SHIFT_LEFT),
    "mantissa": _bits_and(_BITS + signed_leb(OF_MANTISSA), AND, _BITS + signed_leb(BITS_OF_ONE), OR),
    "exponent": _bits_and(_BITS + signed_leb(52), SHIFT_RIGHT, _BITS + signed_leb(BITS_OF_ROUNDER), OR) + _CONSTANT + bytes([REALS["-"]]),
}
"""Instructions for the parts of a number, as `bristle.core.exponent` reads them."""
