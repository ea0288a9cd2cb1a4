"""Functions of a tree as WebAssembly: instructions of the binary format, tuples as several numbers.

A tuple is what it holds, number by number: an argument each, a result each, a local variable each. An array is where it
begins in the memory. Everything else is one instruction of the machine for one node of the tree.
"""

import struct
from collections.abc import Mapping

from bristle.exports import tree
from bristle.exports.cycle import LARGEST
from bristle.exports.scope import NotExportableError
from bristle.exports.tree import INTEGER, REAL, TRUTH, VOID, Struct
from bristle.exports.wasm_binary import IN_BITS, OP, Locals, Types, emitted, flat, leb, signed_leb


class Code:
    """The code of one function, and in it that of the functions that have no number: they run where they are called."""

    def __init__(self, function: tree.Function, numbers: Mapping[int, int], types: Types, integer: str) -> None:
        self.function, self.numbers, self.types, self.integer = function, numbers, types, integer
        self.out = bytearray()
        self.locals = Locals(function.parameters, integer)
        self.depth, self.end = 0, 0
        self.loops: list[tuple[int, int]] = []

    def body(self) -> bytes:
        """Return the function as the format has it: its size, its variables, its instructions."""
        self._block(self.function.body)
        if self.function.result != VOID:
            self._emit("unreachable")
        self._emit("end")
        content = self.locals.declared() + bytes(self.out)
        return leb(len(content)) + content

    def _emit(self, *parts: str | bytes) -> None:
        self.out += emitted(*parts)
        self.depth += sum(part in ("block", "loop", "if") for part in parts) - parts.count("end")

    def _get(self, first: int, count: int = 1) -> None:
        for place in range(first, first + count):
            self._emit("get", leb(place))

    def _set(self, first: int, count: int = 1) -> None:
        for place in reversed(range(first, first + count)):
            self._emit("set", leb(place))

    def _block(self, block: list[tree.Statement]) -> None:
        for statement in block:
            getattr(self, f"_do_{type(statement).__name__.lower()}")(statement)

    def _do_assign(self, s: tree.Assign) -> None:
        self._of(s.value)
        self._set(self.locals.place(s.variable), len(flat(s.variable.type, self.integer)))

    def _do_store(self, s: tree.Store) -> None:
        self._address(s.array, s.at)
        self._of(s.value)
        self._emit("store")

    def _do_evaluate(self, s: tree.Evaluate) -> None:
        self._of(s.call)
        self._emit(*["drop"] * len(flat(s.call.type, self.integer)))

    def _do_return(self, s: tree.Return) -> None:
        if s.value is not None:
            self._of(s.value)
        self._emit(*(("br", leb(self.depth - self.end)) if self.end else ("return",)))

    def _do_if(self, s: tree.If) -> None:
        self._of(s.test)
        self._emit("if", "empty")
        self._block(s.body)
        if s.otherwise:
            self._emit("else")
            self._block(s.otherwise)
        self._emit("end")

    def _do_while(self, s: tree.While) -> None:
        self._emit("block", "empty", "loop", "empty")
        self._of(s.test)
        self._emit("eqz", "br_if", leb(1))
        self.loops.append((self.depth - 1, self.depth))
        self._block(s.body)
        self.loops.pop()
        self._emit("br", leb(0), "end", "end")

    def _do_for(self, s: tree.For) -> None:
        place = self.locals.place(s.variable)
        self._of(s.start)
        self._set(place)
        self._emit("block", "empty", "loop", "empty")
        self._get(place)
        self._of(s.stop)
        self._emit(f"{self.integer}<", "eqz", "br_if", leb(1), "block", "empty")
        self.loops.append((self.depth - 2, self.depth))
        self._block(s.body)
        self.loops.pop()
        self._emit("end")
        self._get(place)
        self._emit(f"{self.integer}.const", signed_leb(1), f"{self.integer}+")
        self._set(place)
        self._emit("br", leb(0), "end", "end")

    def _do_break(self, s: tree.Break) -> None:
        self._emit("br", leb(self.depth - self.loops[-1][0]))

    def _do_continue(self, s: tree.Continue) -> None:
        self._emit("br", leb(self.depth - self.loops[-1][1]))

    def _of(self, e: tree.Expression) -> None:
        getattr(self, f"_{type(e).__name__.lower()}")(e)

    def _constant(self, e: tree.Constant) -> None:
        if e.type == REAL:
            self._emit("f64.const", struct.pack("<d", float(e.value)))
        else:
            self._emit("i32.const" if e.type == TRUTH else f"{self.integer}.const", signed_leb(int(e.value)))

    def _variable(self, e: tree.Variable) -> None:
        self._get(self.locals.place(e), len(flat(e.type, self.integer)))

    def _field(self, e: tree.Field) -> None:
        first = self._first_of(e)
        if first is None:
            assert isinstance(e.of.type, Struct)
            numbers = flat(e.of.type, self.integer)
            self._of(e.of)
            first = self.locals.new(numbers)
            self._set(first, len(numbers))
            first += self._offset(e.of.type, e.name)
        self._get(first, len(flat(e.type, self.integer)))

    def _first_of(self, e: tree.Expression) -> int | None:
        """Return where the numbers of a tuple begin that lies in variables; None for one that is computed."""
        if isinstance(e, tree.Variable):
            return self.locals.place(e)
        if isinstance(e, tree.Field) and isinstance(e.of.type, Struct):
            first = self._first_of(e.of)
            return None if first is None else first + self._offset(e.of.type, e.name)
        return None

    def _offset(self, kind: Struct, name: str) -> int:
        return sum(len(flat(part, self.integer)) for _, part in kind.fields[: kind.place(name)])

    def _index(self, e: tree.Index) -> None:
        self._address(e.array, e.at)
        self._emit("load")

    def _address(self, array: tree.Expression, at: tree.Expression) -> None:
        self._of(array)
        self._of(at)
        if self.integer == "i64":
            self._emit("wrap")
        self._emit("i32.const", signed_leb(8), "i32*", "i32+")

    def _negative(self, e: tree.Negative) -> None:
        if e.type == REAL:
            self._of(e.of)
            self._emit("negate")
        else:
            self._emit(f"{self.integer}.const", signed_leb(0))
            self._of(e.of)
            self._emit(f"{self.integer}-")

    def _not(self, e: tree.Not) -> None:
        self._of(e.of)
        self._emit("eqz")

    def _binary(self, e: tree.Binary | tree.Compare) -> None:
        operation = f"{'f64' if e.left.type == REAL else self.integer}{e.operator}"
        if operation not in OP:
            raise NotExportableError(self.function.source, None, f"{e.operator} of whole numbers that are not known here")
        self._of(e.left)
        self._of(e.right)
        self._emit(operation)

    _compare = _binary

    def _logic(self, e: tree.Logic) -> None:
        self._of(e.parts[0])
        for part in e.parts[1:]:
            self._emit("if", "i32")
            if e.operator == "or":
                self._emit("i32.const", signed_leb(1), "else")
                self._of(part)
            else:
                self._of(part)
                self._emit("else", "i32.const", signed_leb(0))
            self._emit("end")

    def _select(self, e: tree.Select) -> None:
        self._of(e.test)
        self._emit("if", self.types.block(flat(e.type, self.integer)))
        self._of(e.first)
        self._emit("else")
        self._of(e.second)
        self._emit("end")

    def _convert(self, e: tree.Convert) -> None:
        self._of(e.of)
        if e.type == INTEGER and e.of.type == REAL:
            self._emit(f"{self.integer}.truncate")
        elif e.type == REAL:
            self._emit("i32.real" if e.of.type == TRUTH else f"{self.integer}.real")
        elif self.integer == "i64":
            self._emit("widen")

    def _call(self, e: tree.Call) -> None:
        for argument in e.arguments:
            self._of(argument)
        if id(e.function) in self.numbers:
            self._emit("call", leb(self.numbers[id(e.function)]))
        else:
            self._run(e.function)

    def _run(self, function: tree.Function) -> None:
        """Run a function here, its arguments being there: its variables are free for others after it."""
        outside = self.end
        with self.locals.apart():
            for place in reversed([n for parameter in function.parameters for n in self.locals.numbers(parameter)]):
                self._set(place)
            self._emit("block", self.types.block(flat(function.result, self.integer)))
            self.end = self.depth
            self._block(function.body)
            if function.result != VOID:
                self._emit("unreachable")
            self._emit("end")
        self.end = outside

    def _make(self, e: tree.Make) -> None:
        for part in e.parts:
            self._of(part)

    def _intrinsic(self, e: tree.Intrinsic) -> None:
        if e.name in ("min", "max"):
            self._least(e)
            return
        for argument in e.arguments:
            self._of(argument)
        if e.name == "floor":
            self._emit("floor", f"{self.integer}.truncate")
        elif e.name in ("isinf", "isnan"):
            x = leb(self.locals.new(["f64"]))
            largest = ("abs", "f64.const", struct.pack("<d", LARGEST), "f64>")
            self._emit("tee", x, *(("get", x, "f64!=") if e.name == "isnan" else largest))
        elif e.name in IN_BITS:
            self._emit(IN_BITS[e.name])
        elif e.type == REAL:
            self._emit(e.name)
        else:
            raise NotExportableError(self.function.source, None, f"{e.name} of whole numbers")

    def _least(self, e: tree.Intrinsic) -> None:
        """Give ``b if b < a else a``, or with ``>``: what Python gives, for NaN and zeros too."""
        kind = flat(e.type, self.integer)
        a, b = self.locals.new(kind), self.locals.new(kind)
        for place, argument in zip((a, b), e.arguments, strict=True):
            self._of(argument)
            self._set(place)
        for place in (b, a, b, a):
            self._get(place)
        self._emit(f"{'f64' if e.type == REAL else self.integer}{'<' if e.name == 'min' else '>'}", "select")
