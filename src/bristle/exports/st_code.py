"""Functions of a tree as Structured Text: what the language has no expression for becomes statements before it.

Structured Text knows no choice inside an expression, computes both sides of AND and OR, and makes no tuple of its
fields. A tuple is a structure that is handed over in place, never copied; a function that gives one writes it into the
structure of its caller, which nothing else that it was handed lies in.
"""

from __future__ import annotations

import math

from bristle.exports import tree
from bristle.exports.printing import described, needs_wide_integers, structures_of, types_in
from bristle.exports.st_expressions import BINDS, RESULT, Values, is_safe
from bristle.exports.st_parts import BELOW_ZERO, INDENT, LREAL, Names, Pou, Record, real_literal
from bristle.exports.st_parts import Array as ArrayPart
from bristle.exports.st_parts import Variable as Declared
from bristle.exports.tree import INTEGER, REAL, TRUTH, VOID, Array, Scalar, Struct, Type


class Printer:
    """Prints the functions of one unit."""

    def __init__(self, unit: tree.Unit, name: str, also: tuple[Type, ...] = (), scalar: str = LREAL) -> None:
        self.unit, self.scalar = unit, scalar
        self.integer = "LINT" if needs_wide_integers(unit) else "DINT"
        used = [*(kind for function in unit.functions for kind in types_in(function)), *also]
        self.structures = structures_of(used)
        inside = [part for kind in self.structures for _, part in kind.fields]
        self._arrays = {(kind.size, scalar) for kind in [*used, *inside] if isinstance(kind, Array)}
        self._public = Names(prefix=f"{name}_")
        self._fields = {kind: Names() for kind in self.structures}
        self._bodies: dict[int, Body] = {}
        self.helpers: set[tuple[str, str]] = set()

    def parts(self) -> tuple[list[ArrayPart | Record], list[Pou]]:
        """Return data types and functions; `helpers` then holds what they call beside each other."""
        functions = [self.body(function).pou() for function in self.unit.functions]
        arrays = [ArrayPart(self.array(size, of), max(size, 1), of) for size, of in sorted(self._arrays)]
        records = []
        for kind in self.structures:
            fields = [Declared(self.field(kind, name), self.type_name(part)) for name, part in kind.fields]
            records.append(Record(self.type_name(kind), tuple(fields or [Declared("nothing", "BOOL")])))
        return [*arrays, *records], functions

    def function(self, function: tree.Function) -> str:
        """Return the name of a function."""
        return self._public.of(("function", id(function)), function.name)

    def body(self, function: tree.Function) -> Body:
        """Return what prints a function, and knows what its arguments are called."""
        return self._bodies.setdefault(id(function), Body(self, function))

    def helper(self, name: str, scalar: str = "") -> str:
        """Return the name of a helper, and remember that it is needed, for real numbers of this type."""
        scalar = scalar or self.scalar
        self.helpers.add((name, scalar))
        return self._public.of(("helper", name, scalar), name if scalar == LREAL else f"single_{name}")

    def array(self, size: int, scalar: str = "") -> str:
        """Return the name of the type of an array."""
        scalar = scalar or self.scalar
        self._arrays.add((size, scalar))
        return self._public.of(("array", size, scalar), f"{'Numbers' if scalar == LREAL else 'Singles'}_{size}")

    def real(self, value: float) -> str:
        """Return a real number as the functions read it; -0.0, a limit from below, as one just below zero."""
        if value == 0.0 and math.copysign(1.0, value) < 0.0:
            value = -BELOW_ZERO[self.scalar]
        return real_literal(value, self.scalar)

    def narrowed(self, text: str) -> str:
        """Return what comes in, which is LREAL, as the functions take it."""
        return text if self.scalar == LREAL else f"LREAL_TO_REAL({text})"

    def widened(self, text: str) -> str:
        """Return what a function gives as what goes out, which is LREAL."""
        return text if self.scalar == LREAL else f"REAL_TO_LREAL({text})"

    def field(self, kind: Struct, name: str) -> str:
        """Return the name of a field of a tuple."""
        return self._fields[kind].of(name, f"part{name}" if name.startswith("_") else name)

    def type_name(self, kind: Type) -> str:
        """Return the name of a type."""
        if isinstance(kind, Scalar):
            return {REAL: self.scalar, INTEGER: self.integer}.get(kind, "BOOL")
        if isinstance(kind, Array):
            return self.array(kind.size)
        return self._public.of(kind, "Several" if kind.is_plain else kind.cls.__name__)


class Body(Values):
    """Prints one function."""

    def pou(self) -> Pou:
        """Return the function with its variables."""
        function = self.function
        own = self.printer.function(function)
        if isinstance(function.result, Struct):
            self._declare(RESULT, function.result, "VAR_IN_OUT")
        if not isinstance(function.result, Scalar) or function.result == VOID:
            self._line(f"{own} := TRUE;")
        self._block(function.body)
        if self.out and self.out[-1] == f"{INDENT}RETURN;":
            self.out.pop()
        returns = self.printer.type_name(function.result if isinstance(function.result, Scalar) else TRUTH)
        return Pou("FUNCTION", own, returns, tuple(self._declared.values()), tuple(self.out), described(function.description))

    # --- statements -----------------------------------------------------------------------------------------------

    def _block(self, block: list[tree.Statement]) -> None:
        for s in block:
            if isinstance(s, tree.Assign):
                self._into(self._variable_name(s.variable), s.value, s.variable.name)
            elif isinstance(s, tree.Store):
                place = f"{self._in_place(s.array)}[{self._place(s.at)}]"
                self._line(f"{place} := {self._of(s.value)};")
            elif isinstance(s, tree.Evaluate):
                self._into(self._aside(s.call.type), s.call)
            elif isinstance(s, tree.Return):
                if s.value is not None:
                    self._into(RESULT if isinstance(s.value.type, Struct) else self.printer.function(self.function), s.value)
                self._line("RETURN;")
            elif isinstance(s, tree.If):
                self._if(s)
            elif isinstance(s, (tree.For, tree.While)):
                self._for(s) if isinstance(s, tree.For) else self._while(s)
            else:
                self._line("EXIT;" if isinstance(s, tree.Break) else "CONTINUE;")

    def _if(self, s: tree.If) -> None:
        test, first, second = s.test, s.body, s.otherwise
        if not first:
            test, first, second = tree.Not(TRUTH, test), second, []
        self._line(f"IF {self._of(test)} THEN")
        self._inner(first)
        while len(second) == 1 and isinstance(second[0], tree.If) and second[0].body and is_safe(second[0].test):
            self._line(f"ELSIF {self._of(second[0].test)} THEN")
            self._inner(second[0].body)
            second = second[0].otherwise
        if second:
            self._line("ELSE")
            self._inner(second)
        self._line("END_IF;")

    def _inner(self, block: list[tree.Statement]) -> None:
        with self._inside():
            self._block(block)

    def _for(self, s: tree.For) -> None:
        """Print a loop over whole numbers as WHILE: MATIEC skips a FOR loop that has one pass."""
        counter = self._aside(INTEGER) if s.variable.name == "_" else self._variable_name(s.variable)
        last = self._one_less(s.stop)
        if not isinstance(s.stop, tree.Constant):
            held = self._aside(INTEGER)
            self._line(f"{held} := {last};")
            last = held
        self._line(f"{counter} := {self._one_less(s.start)};")
        self._line(f"WHILE {counter} < {last} DO")
        with self._inside():
            self._line(f"{counter} := {counter} + 1;")
            self._block(s.body)
        self._line("END_WHILE;")

    def _one_less(self, number: tree.Expression) -> str:
        """Return the text of a whole number, less one."""
        if isinstance(number, tree.Constant):
            return self._of(tree.Constant(INTEGER, int(number.value) - 1))
        return f"{self._of(number, BINDS['-'])} - 1"

    def _while(self, s: tree.While) -> None:
        safe = is_safe(s.test)
        self._line(f"WHILE {self._of(s.test) if safe else 'TRUE'} DO")
        with self._inside():
            if not safe:
                self._line(f"IF {self._of(tree.Not(TRUTH, s.test))} THEN")
                self._line(f"{INDENT}EXIT;")
                self._line("END_IF;")
            self._block(s.body)
        self._line("END_WHILE;")
