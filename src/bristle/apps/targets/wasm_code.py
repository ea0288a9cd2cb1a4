"""Functions of a tree as WebAssembly: instructions of the binary format, tuples as several numbers.

A tuple becomes a list of numbers: one argument, result or local variable for each. An array becomes its address in the
memory. Every other node of the tree becomes one instruction.
"""

import struct
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import groupby
from typing import Any

from bristle.core.exponent import BITS_OF_ONE, BITS_OF_ROUNDER, INTEGER_IN_LAST_BITS, OF_MANTISSA
from bristle.engine.translation import tree
from bristle.engine.translation.scope import NotExportableError
from bristle.engine.translation.tree import (
    INTEGER,
    REAL,
    TRUTH,
    VOID,
    Array,
    Struct,
    Type,
    Variable,
)
from bristle.exports.cycle import LARGEST

# Names with their bytes: sections, types, the type of a block without a result, instructions, arithmetic by type and operator.
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
OP = {
    name: bytes.fromhex(code)
    for name, code in zip(TABLE.split()[::2], TABLE.split()[1::2], strict=True)
}


def emitted(*parts: str | bytes) -> bytes:
    """Return the bytes of instructions, given by names, and of their operands."""
    return b"".join(OP[part] if isinstance(part, str) else part for part in parts)


MORE = 128  # the bit of a byte that another byte follows


def leb(value: int) -> bytes:
    """Return a count in the encoding of the format: seven bits a byte, the lowest first."""
    parts = bytearray()
    while value >= MORE:
        parts.append(value % MORE | MORE)
        value >>= 7
    parts.append(value)
    return bytes(parts)


def signed_leb(value: int) -> bytes:
    """Return an integer in the encoding of the format."""
    parts = bytearray()
    # The last byte repeats the sign in its highest bit.
    while not -64 <= value < 64:
        parts.append(value % MORE | MORE)
        value >>= 7
    parts.append(value % MORE)
    return bytes(parts)


def vector(parts: Sequence[bytes]) -> bytes:
    """Return a vector in the encoding of the format: the count, then each element."""
    return leb(len(parts)) + b"".join(parts)


def flat(kind: Type, integer: str) -> list[str]:
    """Return the machine types of the numbers of a value; `integer` is the type of whole numbers."""
    if isinstance(kind, Struct):
        return [number for _, part in kind.fields for number in flat(part, integer)]
    if isinstance(kind, Array) or kind == TRUTH:
        return ["i32"]
    if kind == VOID:
        return []
    return [_number(kind, integer)]


def _number(kind: Type, integer: str) -> str:
    """Return the machine type of a number."""
    if kind == REAL:
        return "f64"
    return integer


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
        if len(gives) == 1:
            return OP[gives[0]]
        return signed_leb(self.index((), gives))


class Locals:
    """Local variables, arguments first; later inlined calls reuse the variables of earlier ones."""

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
        """Return the index of the first number of a variable."""
        if variable.name not in self._places:
            self._places[variable.name] = self.new(flat(variable.type, self.integer))
        return self._places[variable.name]

    def numbers(self, variable: Variable) -> range:
        """Return the indices of the numbers of a variable."""
        first = self.place(variable)
        return range(first, first + len(flat(variable.type, self.integer)))

    def new(self, kinds: Sequence[str]) -> int:
        """Return the first index of a new run of numbers."""
        free = self._free[tuple(kinds)]
        if free:
            first = free.pop()
        else:
            first = len(self.kinds)
        if first == len(self.kinds):
            self.kinds += kinds
        self._runs.append((tuple(kinds), first))
        return first

    @contextmanager
    def apart(self) -> Iterator[None]:
        """Use a separate scope of names in this block."""
        outside = self._places, self._runs
        self._places = {}
        self._runs = []
        yield
        for kinds, first in self._runs:
            self._free[kinds].append(first)
        self._places, self._runs = outside

    def declared(self) -> bytes:
        """Return the non-argument variables in the encoding of the format: run lengths of each type."""
        runs = groupby(self.kinds[self._arguments :])
        return vector([leb(len(list(run))) + OP[kind] for kind, run in runs])


_ROUNDER = ("f64.const", struct.pack("<d", INTEGER_IN_LAST_BITS))
_FRACTION = ("i64.const", signed_leb(52))
_MANTISSA = signed_leb(OF_MANTISSA)
_UNIT = signed_leb(BITS_OF_ONE)
IN_BITS = {
    "power_of_two": emitted(*_ROUNDER, "f64+", "bits", *_FRACTION, "shift_left", "number"),
    "mantissa": emitted("bits", "i64.const", _MANTISSA, "and", "i64.const", _UNIT, "or", "number"),
    "exponent": emitted(
        "bits",
        *_FRACTION,
        "shift_right",
        "i64.const",
        signed_leb(BITS_OF_ROUNDER),
        "or",
        "number",
        *_ROUNDER,
        "f64-",
    ),
}
"""Instructions for the parts of a number, equivalent to `bristle.core.exponent`."""


LESS = {"min": "<", "max": ">"}


class Code:
    """The code of one function, including that of its inlined functions, which have no index."""

    def __init__(
        self, function: tree.Function, numbers: Mapping[int, int], types: Types, integer: str
    ) -> None:
        self.function = function
        self.numbers = numbers
        self.types = types
        self.integer = integer
        self.out = bytearray()
        self.locals = Locals(function.parameters, integer)
        self.depth = 0
        self.end = 0
        self.loops: list[tuple[int, int]] = []

    def body(self) -> bytes:
        """Return the function in the encoding of the format: size, variables, instructions."""
        self._ended(self.function)
        content = self.locals.declared() + bytes(self.out)
        return leb(len(content)) + content

    def _ended(self, function: tree.Function) -> None:
        """Write the body of a function; only its returns leave it, if it gives a value."""
        self._put(function.body)
        if function.result != VOID:
            self._put("unreachable")
        self._put("end")

    def _put(self, *parts: Any) -> None:
        """Write a sequence of instruction names, raw bytes, and nodes of a tree."""
        for part in parts:
            if isinstance(part, list):
                self._put(*part)
            elif isinstance(part, tree.Node):
                getattr(self, f"_{type(part).__name__.lower()}")(part)
            else:
                self.out += emitted(part)
                self.depth += (part in ("block", "loop", "if")) - (part == "end")

    def _get(self, first: int, count: int = 1) -> None:
        self._put(*(emitted("get", leb(place)) for place in range(first, first + count)))

    def _set(self, first: int, count: int = 1) -> None:
        self._put(*(emitted("set", leb(place)) for place in reversed(range(first, first + count))))

    def _assign(self, s: tree.Assign) -> None:
        self._put(s.value)
        self._set(self.locals.place(s.variable), len(flat(s.variable.type, self.integer)))

    def _store(self, s: tree.Store) -> None:
        self._put(*self._address(s.array, s.at), s.value, "store")

    def _evaluate(self, s: tree.Evaluate) -> None:
        self._put(s.call, *["drop"] * len(flat(s.call.type, self.integer)))

    def _return(self, s: tree.Return) -> None:
        if s.value is not None:
            self._put(s.value)
        if self.end:
            self._put("br", leb(self.depth - self.end))
        else:
            self._put("return")

    def _if(self, s: tree.If) -> None:
        self._put(s.test, "if", "empty", s.body)
        if s.otherwise:
            self._put("else", s.otherwise)
        self._put("end")

    def _while(self, s: tree.While) -> None:
        self._put("block", "empty", "loop", "empty", s.test, "eqz", "br_if", leb(1))
        self._round(s.body, 1)
        self._put("br", leb(0), "end", "end")

    def _for(self, s: tree.For) -> None:
        place = leb(self.locals.place(s.variable))
        counted = emitted("get", place)
        kept = emitted("set", place)
        self._put(s.start, kept, "block", "empty", "loop", "empty", counted, s.stop)
        self._put(f"{self.integer}<", "eqz", "br_if", leb(1), "block", "empty")
        self._round(s.body, 2)
        self._put(
            "end",
            counted,
            f"{self.integer}.const",
            signed_leb(1),
            f"{self.integer}+",
            kept,
            "br",
            leb(0),
            "end",
            "end",
        )

    def _round(self, body: list[tree.Statement], blocks: int) -> None:
        """Write one round of a loop, `blocks` levels inside the block that a break leaves."""
        self.loops.append((self.depth - blocks, self.depth))
        self._put(body)
        self.loops.pop()

    def _break(self, s: tree.Break) -> None:
        self._put("br", leb(self.depth - self.loops[-1][0]))

    def _continue(self, s: tree.Continue) -> None:
        self._put("br", leb(self.depth - self.loops[-1][1]))

    def _constant(self, e: tree.Constant) -> None:
        if e.type == REAL:
            self._put("f64.const", struct.pack("<d", float(e.value)))
        else:
            (kind,) = flat(e.type, self.integer)
            self._put(f"{kind}.const", signed_leb(int(e.value)))

    def _variable(self, e: tree.Variable) -> None:
        self._get(self.locals.place(e), len(flat(e.type, self.integer)))

    def _field(self, e: tree.Field) -> None:
        first = self._first_of(e)
        if first is None:
            assert isinstance(e.of.type, Struct)
            numbers = flat(e.of.type, self.integer)
            self._put(e.of)
            first = self.locals.new(numbers)
            self._set(first, len(numbers))
            first += self._offset(e.of.type, e.name)
        self._get(first, len(flat(e.type, self.integer)))

    def _first_of(self, e: tree.Expression) -> int | None:
        """Return the first index of a tuple in variables; None for a computed tuple."""
        if isinstance(e, tree.Variable):
            return self.locals.place(e)
        if isinstance(e, tree.Field) and isinstance(e.of.type, Struct):
            first = self._first_of(e.of)
            if first is None:
                return None
            return first + self._offset(e.of.type, e.name)
        return None

    def _offset(self, kind: Struct, name: str) -> int:
        return sum(len(flat(part, self.integer)) for _, part in kind.fields[: kind.place(name)])

    def _index(self, e: tree.Index) -> None:
        self._put(*self._address(e.array, e.at), "load")

    def _address(self, array: tree.Expression, at: tree.Expression) -> list[Any]:
        wrapped = []
        if self.integer == "i64":
            wrapped = ["wrap"]
        return [array, at, *wrapped, "i32.const", signed_leb(8), "i32*", "i32+"]

    def _negative(self, e: tree.Negative) -> None:
        if e.type == REAL:
            self._put(e.of, "negate")
        else:
            self._put(f"{self.integer}.const", signed_leb(0), e.of, f"{self.integer}-")

    def _not(self, e: tree.Not) -> None:
        self._put(e.of, "eqz")

    def _binary(self, e: tree.Binary | tree.Compare) -> None:
        operation = f"{_number(e.left.type, self.integer)}{e.operator}"
        if operation not in OP:
            raise NotExportableError(
                self.function.source,
                None,
                f"{e.operator} of variable whole numbers is not exportable",
            )
        self._put(e.left, e.right, operation)

    _compare = _binary

    def _logic(self, e: tree.Logic) -> None:
        self._put(e.parts[0])
        for part in e.parts[1:]:
            if e.operator == "or":
                ways = ("i32.const", signed_leb(1), "else", part)
            else:
                ways = (part, "else", "i32.const", signed_leb(0))
            self._put("if", "i32", *ways, "end")

    def _select(self, e: tree.Select) -> None:
        self._put(e.test)
        self._put(
            "if", self.types.block(flat(e.type, self.integer)), e.first, "else", e.second, "end"
        )

    def _convert(self, e: tree.Convert) -> None:
        operation = b""
        if self.integer == "i64":
            operation = "widen"
        if e.type == REAL:
            operation = f"{self.integer}.real"
            if e.of.type == TRUTH:
                operation = "i32.real"
        elif e.type == INTEGER and e.of.type == REAL:
            operation = f"{self.integer}.truncate"
        self._put(e.of, operation)

    def _call(self, e: tree.Call) -> None:
        self._put(*e.arguments)
        if id(e.function) in self.numbers:
            self._put("call", leb(self.numbers[id(e.function)]))
        else:
            self._run(e.function)

    def _run(self, function: tree.Function) -> None:
        """Inline a function whose arguments are on the stack; its variables are reused afterwards."""
        outside = self.end
        with self.locals.apart():
            for place in reversed(
                [n for parameter in function.parameters for n in self.locals.numbers(parameter)]
            ):
                self._set(place)
            self._put("block", self.types.block(flat(function.result, self.integer)))
            self.end = self.depth
            self._ended(function)
        self.end = outside

    def _make(self, e: tree.Make) -> None:
        self._put(*e.parts)

    def _intrinsic(self, e: tree.Intrinsic) -> None:
        if e.name in ("min", "max"):
            self._least(e)
            return
        self._put(*e.arguments)
        if e.name == "floor":
            self._put("floor", f"{self.integer}.truncate")
        elif e.name in ("isinf", "isnan"):
            x = leb(self.locals.new(["f64"]))
            self._put("tee", x)
            if e.name == "isnan":
                self._put("get", x, "f64!=")
            else:
                self._put("abs", "f64.const", struct.pack("<d", LARGEST), "f64>")
        elif e.name not in IN_BITS and e.type != REAL:
            raise NotExportableError(
                self.function.source, None, f"{e.name} of whole numbers is not exportable"
            )
        else:
            self._put(IN_BITS.get(e.name, e.name))

    def _least(self, e: tree.Intrinsic) -> None:
        """Write ``b if b < a else a``, or with ``>``: as in Python, also for NaN and zeros."""
        kind = flat(e.type, self.integer)
        places = a, b = [leb(self.locals.new(kind)) for _ in range(2)]
        for place, argument in zip(places, e.arguments, strict=True):
            self._put(argument, "set", place)
        operation = f"{_number(e.type, self.integer)}{LESS[e.name]}"
        self._put("get", b, "get", a, "get", b, "get", a, operation, "select")
