"""Functions of a tree as WebAssembly: instructions of the binary format, tuples as several numbers.

A tuple is what it holds, number by number: an argument each, a result each, a local variable each. An array is where it
begins in the memory. Everything else is one instruction of the machine for one node of the tree.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping

from bristle.exports.scope import NotExportableError
from bristle.exports.tree import (
    Assign,
    Binary,
    Break,
    Call,
    Compare,
    Constant,
    Continue,
    Convert,
    Evaluate,
    Expression,
    Field,
    For,
    Function,
    If,
    Index,
    Intrinsic,
    Logic,
    Make,
    Negative,
    Not,
    Return,
    Select,
    Statement,
    Store,
    Variable,
    While,
)
from bristle.exports.types import INTEGER, REAL, TRUTH, VOID, Struct
from bristle.exports.wasm_binary import (
    BLOCK,
    BR,
    BR_IF,
    CALL,
    COPYSIGN,
    DROP,
    ELSE,
    EMPTY,
    END,
    EQZ,
    F64,
    FLOOR,
    GET,
    I32,
    I64,
    IF,
    IN_BITS,
    INTEGERS_32,
    INTEGERS_64,
    LARGEST,
    LOAD,
    LOOP,
    NEGATE,
    ONE_NUMBER,
    REAL_FROM_32,
    REAL_FROM_64,
    REALS,
    RETURN,
    SELECT,
    SET,
    STORE,
    TEE,
    TRUNCATE_32,
    TRUNCATE_64,
    UNREACHABLE,
    WIDER,
    WRAP,
    Types,
    flat,
    leb,
    signed_leb,
)
from bristle.exports.wasm_locals import Locals

__all__ = ["Code"]


class Code:
    """The code of one function, and in it that of the functions that have no number: they run where they are called."""

    def __init__(self, function: Function, numbers: Mapping[int, int], types: Types, integer: int) -> None:
        self.function, self.numbers, self.types, self.integer = function, numbers, types, integer
        self.integers = INTEGERS_32 if integer == I32 else INTEGERS_64
        self.out = bytearray()
        self.locals = Locals(function.parameters, integer)
        self.depth, self.end = 0, 0
        self.loops: list[tuple[int, int]] = []

    def body(self) -> bytes:
        """Return the function as the format has it: its size, its variables, its instructions."""
        self._block(self.function.body)
        if self.function.result != VOID:
            self.out.append(UNREACHABLE)
        self.out.append(END)
        content = self.locals.declared() + bytes(self.out)
        return leb(len(content)) + content

    def _emit(self, *codes: int | bytes) -> None:
        for code in codes:
            self.out += code if isinstance(code, bytes) else bytes([code])

    def _get(self, first: int, count: int = 1) -> None:
        for place in range(first, first + count):
            self._emit(GET, leb(place))

    def _set(self, first: int, count: int = 1) -> None:
        for place in reversed(range(first, first + count)):
            self._emit(SET, leb(place))

    def _block(self, block: list[Statement]) -> None:
        for statement in block:
            getattr(self, f"_do_{type(statement).__name__.lower()}")(statement)

    def _do_assign(self, s: Assign) -> None:
        self._of(s.value)
        self._set(self.locals.place(s.variable), len(flat(s.variable.type, self.integer)))

    def _do_store(self, s: Store) -> None:
        self._address(s.array, s.at)
        self._of(s.value)
        self._emit(STORE, leb(3), leb(0))

    def _do_evaluate(self, s: Evaluate) -> None:
        self._of(s.call)
        self._emit(*[DROP] * len(flat(s.call.type, self.integer)))

    def _do_return(self, s: Return) -> None:
        if s.value is not None:
            self._of(s.value)
        self._emit(*((BR, leb(self.depth - self.end)) if self.end else (RETURN,)))

    def _do_if(self, s: If) -> None:
        self._of(s.test)
        self._emit(IF, EMPTY)
        self.depth += 1
        self._block(s.body)
        if s.otherwise:
            self._emit(ELSE)
            self._block(s.otherwise)
        self.depth -= 1
        self._emit(END)

    def _do_while(self, s: While) -> None:
        self._emit(BLOCK, EMPTY, LOOP, EMPTY)
        self.depth += 2
        self._of(s.test)
        self._emit(EQZ, BR_IF, leb(1))
        self.loops.append((self.depth - 1, self.depth))
        self._block(s.body)
        self.loops.pop()
        self.depth -= 2
        self._emit(BR, leb(0), END, END)

    def _do_for(self, s: For) -> None:
        place = self.locals.place(s.variable)
        self._of(s.start)
        self._set(place)
        self._emit(BLOCK, EMPTY, LOOP, EMPTY)
        self.depth += 2
        self._get(place)
        self._of(s.stop)
        self._emit(self.integers["<"], EQZ, BR_IF, leb(1), BLOCK, EMPTY)
        self.depth += 1
        self.loops.append((self.depth - 2, self.depth))
        self._block(s.body)
        self.loops.pop()
        self._emit(END)
        self._get(place)
        self._integer(1)
        self._emit(self.integers["+"])
        self._set(place)
        self.depth -= 3
        self._emit(BR, leb(0), END, END)

    def _do_break(self, s: Break) -> None:
        self._emit(BR, leb(self.depth - self.loops[-1][0]))

    def _do_continue(self, s: Continue) -> None:
        self._emit(BR, leb(self.depth - self.loops[-1][1]))

    def _of(self, e: Expression) -> None:
        getattr(self, f"_{type(e).__name__.lower()}")(e)

    def _integer(self, value: int) -> None:
        self._emit(0x41 if self.integer == I32 else 0x42, signed_leb(value))

    def _real(self, value: float) -> None:
        self._emit(0x44, struct.pack("<d", value))

    def _constant(self, e: Constant) -> None:
        if e.type == REAL:
            self._real(float(e.value))
        elif e.type == TRUTH:
            self._emit(0x41, signed_leb(int(e.value)))
        else:
            self._integer(int(e.value))

    def _variable(self, e: Variable) -> None:
        self._get(self.locals.place(e), len(flat(e.type, self.integer)))

    def _field(self, e: Field) -> None:
        first = self._first_of(e.of)
        if first is None:
            numbers = flat(e.of.type, self.integer)
            self._of(e.of)
            first = self.locals.new(numbers)
            self._set(first, len(numbers))
        assert isinstance(e.of.type, Struct)
        self._get(first + _offset(e.of.type, e.name, self.integer), len(flat(e.type, self.integer)))

    def _first_of(self, e: Expression) -> int | None:
        """Return where the numbers of a tuple begin that lies in variables; None for one that is computed."""
        if isinstance(e, Variable):
            return self.locals.place(e)
        if isinstance(e, Field) and isinstance(e.of.type, Struct):
            first = self._first_of(e.of)
            return None if first is None else first + _offset(e.of.type, e.name, self.integer)
        return None

    def _index(self, e: Index) -> None:
        self._address(e.array, e.at)
        self._emit(LOAD, leb(3), leb(0))

    def _address(self, array: Expression, at: Expression) -> None:
        self._of(array)
        self._of(at)
        if self.integer == I64:
            self._emit(WRAP)
        self._emit(0x41, signed_leb(8), INTEGERS_32["*"], INTEGERS_32["+"])

    def _negative(self, e: Negative) -> None:
        if e.type == REAL:
            self._of(e.of)
            self._emit(NEGATE)
        else:
            self._integer(0)
            self._of(e.of)
            self._emit(self.integers["-"])

    def _not(self, e: Not) -> None:
        self._of(e.of)
        self._emit(EQZ)

    def _binary(self, e: Binary) -> None:
        table = REALS if e.type == REAL else self.integers
        if e.operator not in table:
            raise NotExportableError(self.function.source, None, f"{e.operator} of whole numbers that are not known here")
        self._of(e.left)
        self._of(e.right)
        self._emit(table[e.operator])

    def _compare(self, e: Compare) -> None:
        self._of(e.left)
        self._of(e.right)
        self._emit((REALS if e.left.type == REAL else self.integers)[e.operator])

    def _logic(self, e: Logic) -> None:
        self._of(e.parts[0])
        for part in e.parts[1:]:
            self._emit(IF, I32)
            self.depth += 1
            self._truth_or(part if e.operator == "and" else None, 1)
            self._emit(ELSE)
            self._truth_or(None if e.operator == "and" else part, 0)
            self.depth -= 1
            self._emit(END)

    def _truth_or(self, part: Expression | None, answer: int) -> None:
        if part is None:
            self._emit(0x41, signed_leb(answer))
        else:
            self._of(part)

    def _select(self, e: Select) -> None:
        self._of(e.test)
        self._emit(IF, self.types.block(flat(e.type, self.integer)))
        self.depth += 1
        self._of(e.first)
        self._emit(ELSE)
        self._of(e.second)
        self.depth -= 1
        self._emit(END)

    def _convert(self, e: Convert) -> None:
        self._of(e.of)
        narrow = self.integer == I32
        if e.type == INTEGER and e.of.type == REAL:
            self._emit(*(TRUNCATE_32 if narrow else TRUNCATE_64))
        elif e.type == REAL:
            self._emit(REAL_FROM_32 if narrow or e.of.type == TRUTH else REAL_FROM_64)
        elif not narrow:
            self._emit(WIDER)

    def _call(self, e: Call) -> None:
        for argument in e.arguments:
            self._of(argument)
        if id(e.function) in self.numbers:
            self._emit(CALL, leb(self.numbers[id(e.function)]))
        else:
            self._run(e.function)

    def _run(self, function: Function) -> None:
        """Run a function here, its arguments being there: its variables are free for others after it."""
        outside = self.end
        with self.locals.apart():
            for place in reversed([n for parameter in function.parameters for n in self.locals.numbers(parameter)]):
                self._set(place)
            self._emit(BLOCK, self.types.block(flat(function.result, self.integer)))
            self.depth += 1
            self.end = self.depth
            self._block(function.body)
            if function.result != VOID:
                self._emit(UNREACHABLE)
            self.depth -= 1
            self._emit(END)
        self.end = outside

    def _make(self, e: Make) -> None:
        for part in e.parts:
            self._of(part)

    def _intrinsic(self, e: Intrinsic) -> None:
        if e.name in ("min", "max"):
            self._least(e)
            return
        for argument in e.arguments:
            self._of(argument)
        if e.name in ONE_NUMBER and e.type == REAL:
            self._emit(ONE_NUMBER[e.name])
        elif e.name == "copysign":
            self._emit(COPYSIGN)
        elif e.name == "floor":
            self._emit(FLOOR, *(TRUNCATE_32 if self.integer == I32 else TRUNCATE_64))
        elif e.name in ("isinf", "isnan"):
            self._is(e.name)
        else:
            self._in_bits(e.name)

    def _least(self, e: Intrinsic) -> None:
        """Give ``b if b < a else a``, or with ``>``: what Python gives, for NaN and zeros too."""
        kind = flat(e.type, self.integer)
        a, b = self.locals.new(kind), self.locals.new(kind)
        for place, argument in zip((a, b), e.arguments, strict=True):
            self._of(argument)
            self._set(place)
        for place in (b, a, b, a):
            self._get(place)
        table = REALS if e.type == REAL else self.integers
        self._emit(table["<" if e.name == "min" else ">"], SELECT)

    def _is(self, name: str) -> None:
        x = self.locals.new([F64])
        self._emit(TEE, leb(x))
        if name == "isnan":
            self._get(x)
            self._emit(REALS["!="])
        else:
            self._emit(ONE_NUMBER["abs"])
            self._real(LARGEST)
            self._emit(REALS[">"])

    def _in_bits(self, name: str) -> None:
        if name not in IN_BITS:
            raise NotExportableError(self.function.source, None, f"{name} of whole numbers")
        self._emit(IN_BITS[name])


def _offset(kind: Struct, name: str, integer: int) -> int:
    place = kind.place(name)
    return sum(len(flat(part, integer)) for _, part in kind.fields[:place])
