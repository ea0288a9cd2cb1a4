"""Functions of a tree as Structured Text, with extra statements for expressions that the language lacks.

Structured Text has no choice inside an expression, evaluates both sides of AND and OR, and has no expression for a tuple.
A tuple is a structure, passed by reference and never copied. A function with a tuple as its result writes it into a
structure of the caller that contains no other argument.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager

from bristle.apps.targets.st_parts import (
    BELOW_ZERO,
    INDENT,
    LREAL,
    REAL as SINGLE,
    TEXTS,
    TRUTHS,
    Array as ArrayPart,
    Names,
    Pou,
    Record,
    Variable as Declared,
    real_literal,
    whole_literal,
)
from bristle.engine.translation import tree
from bristle.engine.translation.scope import NotExportableError
from bristle.engine.translation.tree import (
    INTEGER,
    REAL,
    TRUTH,
    VOID,
    Array,
    Scalar,
    Struct,
    Type,
    walk,
)
from bristle.exports.printing import (
    PRIMARY,
    UNARY,
    described,
    needs_wide_integers,
    structures_of,
    types_in,
    wrapped,
)

RESULT = "given_back"
# Precedence of an expression.
COMPARED = 9
BINDS = {"*": 13, "/": 13, "+": 12, "-": 12, "and": 4, "or": 3}
COMPARISONS = {"==": "=", "!=": "<>"}
IN_WORDS = {"&": "AND", "^": "XOR"}
# Names of helpers and arrays, by the type of their real numbers.
HELPERS = {LREAL: "", SINGLE: "single_"}
ARRAYS = {LREAL: "Numbers", SINGLE: "Singles"}


class Printer:
    """Prints the functions of one unit."""

    def __init__(
        self, unit: tree.Unit, name: str, also: tuple[Type, ...] = (), scalar: str = LREAL
    ) -> None:
        self.unit = unit
        self.scalar = scalar
        self.integer = "DINT"
        if needs_wide_integers(unit):
            self.integer = "LINT"
        used = [*(kind for function in unit.functions for kind in types_in(function)), *also]
        self.structures = structures_of(used)
        inside = [part for kind in self.structures for _, part in kind.fields]
        self._arrays = {(kind.size, scalar) for kind in [*used, *inside] if isinstance(kind, Array)}
        self._public = Names(prefix=f"{name}_")
        self._fields = {kind: Names() for kind in self.structures}
        self._bodies: dict[int, Body] = {}
        self.helpers: set[tuple[str, str]] = set()

    def parts(self) -> tuple[list[ArrayPart | Record], list[Pou]]:
        """Return data types and functions; `helpers` then holds the helpers that they call."""
        functions = [self.body(function).pou() for function in self.unit.functions]
        arrays = [
            ArrayPart(self.array(size, of), max(size, 1), of) for size, of in sorted(self._arrays)
        ]
        records = []
        for kind in self.structures:
            fields = [
                Declared(self.field(kind, name), self.type_name(part)) for name, part in kind.fields
            ]
            if not fields:
                fields = [Declared("nothing", "BOOL")]
            records.append(Record(self.type_name(kind), tuple(fields)))
        return [*arrays, *records], functions

    def function(self, function: tree.Function) -> str:
        """Return the name of a function."""
        return self._public.of(("function", id(function)), function.name)

    def body(self, function: tree.Function) -> Body:
        """Return the printer of a function, which knows the names of its arguments."""
        return self._bodies.setdefault(id(function), Body(self, function))

    def helper(self, name: str, scalar: str = "") -> str:
        """Return the name of a helper for real numbers of this type, and mark it as used."""
        scalar = scalar or self.scalar
        self.helpers.add((name, scalar))
        return self._public.of(("helper", name, scalar), f"{HELPERS[scalar]}{name}")

    def array(self, size: int, scalar: str = "") -> str:
        """Return the name of the type of an array."""
        scalar = scalar or self.scalar
        self._arrays.add((size, scalar))
        return self._public.of(("array", size, scalar), f"{ARRAYS[scalar]}_{size}")

    def real(self, value: float) -> str:
        """Return a real number as text; -0.0, a limit from below, becomes a number just below zero."""
        if value == 0.0 and math.copysign(1.0, value) < 0.0:
            value = -BELOW_ZERO[self.scalar]
        return real_literal(value, self.scalar)

    def narrowed(self, text: str) -> str:
        """Return an input, which is LREAL, in the type of the functions."""
        if self.scalar == LREAL:
            return text
        return f"LREAL_TO_REAL({text})"

    def widened(self, text: str) -> str:
        """Return a result of a function as an output, which is LREAL."""
        if self.scalar == LREAL:
            return text
        return f"REAL_TO_LREAL({text})"

    def field(self, kind: Struct, name: str) -> str:
        """Return the name of a field of a tuple."""
        if name.startswith("_"):
            return self._fields[kind].of(name, f"part{name}")
        return self._fields[kind].of(name, name)

    def type_name(self, kind: Type) -> str:
        """Return the name of a type."""
        if isinstance(kind, Scalar):
            return {REAL: self.scalar, INTEGER: self.integer}.get(kind, "BOOL")
        if isinstance(kind, Array):
            return self.array(kind.size)
        if kind.is_plain:
            return self._public.of(kind, "Several")
        return self._public.of(kind, kind.cls.__name__)


class Body:
    """Prints one function; statements that must precede an expression go into its lines."""

    def __init__(self, printer: Printer, function: tree.Function) -> None:
        self.printer = printer
        self.function = function
        self.out: list[str] = []
        self._names = Names([RESULT])
        self._declared: dict[str, Declared] = {}
        self._indent = INDENT
        self._count = 0
        assigned = {
            part.variable.name
            for part in walk(function.body)
            if isinstance(part, (tree.Assign, tree.For))
        }
        self.arguments = [
            self._parameter(parameter, copied=parameter.name in assigned)
            for parameter in function.parameters
        ]

    def _parameter(self, parameter: tree.Variable, *, copied: bool) -> str:
        """Declare an argument, and return its name; an argument that the function assigns is copied first."""
        section = "VAR_IN_OUT"
        if isinstance(parameter.type, Scalar):
            section = "VAR_INPUT"
        name = self._names.of(parameter.name, parameter.name)
        if not copied:
            return self._declare(name, parameter.type, section)
        original = self._declare(self._names.new(f"{name}_given"), parameter.type, section)
        self._line(f"{self._declare(name, parameter.type)} := {original};")
        return original

    def _declare(self, name: str, kind: Type, section: str = "VAR") -> str:
        self._declared.setdefault(
            name, Declared(name, self.printer.type_name(kind), section=section)
        )
        return name

    def _aside(self, kind: Type) -> str:
        """Return a new variable for an intermediate result."""
        self._count += 1
        return self._declare(self._names.new(f"aside_{self._count}"), kind)

    def _line(self, text: str) -> None:
        self.out += wrapped(f"{self._indent}{text}", self._indent)

    @contextmanager
    def _inside(self) -> Iterator[None]:
        self._indent += INDENT
        yield
        self._indent = self._indent[: -len(INDENT)]

    def _into(self, target: str, e: tree.Expression, root: str = "") -> None:
        """Assign a value to a variable; `root` is the variable, which the value may read."""
        if isinstance(e, tree.Select):
            self._choose(target, e, root)
        elif isinstance(e.type, Struct) and isinstance(e, (tree.Make, tree.Call)):
            if any(isinstance(part, tree.Variable) and part.name == root for part in walk(e)):
                self._line(f"{target} := {self._held(e)};")
            elif isinstance(e, tree.Call):
                self._line(f"{self._aside(TRUTH)} := {self._called(e, target)};")
            else:
                for (name, _), part in zip(e.type.fields, e.parts, strict=True):
                    self._into(f"{target}.{self.printer.field(e.type, name)}", part)
        else:
            self._line(f"{target} := {self._of(e)};")

    def _choose(self, target: str, e: tree.Select, root: str) -> None:
        rest: tree.Expression = e
        word = "IF"
        while isinstance(rest, tree.Select) and (word == "IF" or is_safe(rest.test)):
            self._line(f"{word} {self._of(rest.test)} THEN")
            with self._inside():
                self._into(target, rest.first, root)
            rest = rest.second
            word = "ELSIF"
        self._line("ELSE")
        with self._inside():
            self._into(target, rest, root)
        self._line("END_IF;")

    def _one_by_one(self, e: tree.Logic) -> str:
        """Evaluate truths until the result is known, and return the variable with the result."""
        target = self._aside(TRUTH)
        is_open = target
        if e.operator != "and":
            is_open = f"NOT {target}"
        self._into(target, e.parts[0])
        for part in e.parts[1:]:
            self._line(f"IF {is_open} THEN")
            self._indent += INDENT
            self._into(target, part)
        for _ in e.parts[1:]:
            self._indent = self._indent[: -len(INDENT)]
            self._line("END_IF;")
        return target

    def _held(self, e: tree.Expression) -> str:
        """Return a variable with the value of an expression."""
        aside = self._aside(e.type)
        self._into(aside, e)
        return aside

    def _of(self, e: tree.Expression, least: int = 0) -> str:
        text, binds = getattr(self, f"_{type(e).__name__.lower()}")(e)
        if binds >= least:
            return text
        return f"({text})"

    def _place(self, at: tree.Expression) -> str:
        if isinstance(at, tree.Constant) or self.printer.integer == "DINT":
            return self._of(at)
        return f"LINT_TO_DINT({self._of(at)})"

    def _constant(self, e: tree.Constant) -> tuple[str, int]:
        if e.type == TRUTH:
            return TRUTHS[bool(e.value)], PRIMARY
        if e.type == REAL:
            text = self.printer.real(float(e.value))
        else:
            text = whole_literal(int(e.value))
        if text.startswith("-"):
            return text, 0
        return text, PRIMARY

    def _variable_name(self, variable: tree.Variable) -> str:
        return self._declare(self._names.of(variable.name, variable.name), variable.type)

    def _variable(self, e: tree.Variable) -> tuple[str, int]:
        return self._variable_name(e), PRIMARY

    def _field(self, e: tree.Field) -> tuple[str, int]:
        assert isinstance(e.of.type, Struct)
        return f"{self._in_place(e.of)}.{self.printer.field(e.of.type, e.name)}", PRIMARY

    def _in_place(self, e: tree.Expression) -> str:
        """Return the name of a tuple or an array; a computed one is assigned to a variable."""
        if isinstance(e, (tree.Variable, tree.Field)):
            return self._of(e)
        return self._held(e)

    def _index(self, e: tree.Index) -> tuple[str, int]:
        return f"{self._in_place(e.array)}[{self._place(e.at)}]", PRIMARY

    def _negative(self, e: tree.Negative) -> tuple[str, int]:
        return f"-{self._of(e.of, PRIMARY)}", 0

    def _not(self, e: tree.Not) -> tuple[str, int]:
        return f"NOT {self._of(e.of, PRIMARY)}", UNARY

    def _binary(self, e: tree.Binary) -> tuple[str, int]:
        if e.operator in BINDS:
            binds = BINDS[e.operator]
            least = binds
            # Brackets mark numbers that are rounded first, though the standard does not need them: (x + C) - C.
            if isinstance(e.left, tree.Binary) and e.left.operator != e.operator and e.type == REAL:
                least = binds + 1
            left = self._of(e.left, least)
            return f"{left} {e.operator} {self._of(e.right, binds + 1)}", binds
        if e.operator in IN_WORDS:
            left, right = (f"LINT_TO_LWORD({self._of(side)})" for side in (e.left, e.right))
            return f"LWORD_TO_LINT({left} {IN_WORDS[e.operator]} {right})", PRIMARY
        right = e.right
        name = "floor_divided"
        if e.operator == "%":
            name = "floor_rest"
        if e.operator == ">>":
            if not isinstance(right, tree.Constant):
                raise NotExportableError(
                    self.function.source, None, "a shift by a variable number is not exportable"
                )
            right = tree.Constant(INTEGER, 2 ** int(right.value))
        helper = self.printer.helper(name)
        return f"{helper}(first := {self._of(e.left)}, second := {self._of(right)})", PRIMARY

    def _compare(self, e: tree.Compare) -> tuple[str, int]:
        tighter = BINDS["-"]
        operator = COMPARISONS.get(e.operator, e.operator)
        return f"{self._of(e.left, tighter)} {operator} {self._of(e.right, tighter)}", COMPARED

    def _logic(self, e: tree.Logic) -> tuple[str, int]:
        if not all(is_safe(part) for part in e.parts[1:]):
            return self._one_by_one(e), PRIMARY
        return f" {e.operator.upper()} ".join(self._of(part, UNARY) for part in e.parts), BINDS[
            e.operator
        ]

    def _select(self, e: tree.Select | tree.Make) -> tuple[str, int]:
        return self._held(e), PRIMARY

    _make = _select

    def _convert(self, e: tree.Convert) -> tuple[str, int]:
        if e.of.type == TRUTH:
            number = int
            if e.type == REAL:
                number = float
            true, false = (tree.Constant(e.type, number(value)) for value in (1, 0))
            return self._held(tree.Select(e.type, e.of, true, false)), PRIMARY
        if e.type == REAL:
            return f"{self.printer.integer}_TO_{self.printer.scalar}({self._of(e.of)})", PRIMARY
        return f"{self.printer.helper('truncated')}(number := {self._of(e.of)})", PRIMARY

    def _call(self, e: tree.Call) -> tuple[str, int]:
        if isinstance(e.type, Struct):
            return self._held(e), PRIMARY
        return self._called(e), PRIMARY

    def _called(self, e: tree.Call, target: str = "") -> str:
        names = self.printer.body(e.function).arguments
        pairs = []
        for name, parameter, argument in zip(
            names, e.function.parameters, e.arguments, strict=True
        ):
            if isinstance(parameter.type, Scalar):
                text = self._of(argument)
            else:
                text = self._in_place(argument)
            pairs.append(f"{name} := {text}")
        if target:
            pairs += [f"{RESULT} := {target}"]
        return f"{self.printer.function(e.function)}({', '.join(pairs)})"

    def _intrinsic(self, e: tree.Intrinsic) -> tuple[str, int]:
        arguments = [self._of(argument) for argument in e.arguments]
        if e.name == "sqrt":
            return f"SQRT({arguments[0]})", PRIMARY
        if e.type != INTEGER or e.name == "floor":
            name = e.name
        else:
            name = f"whole_{e.name}"
        inputs = [word.partition(":")[0] for word in TEXTS[name][1].split()]
        named = ", ".join(f"{name} := {text}" for name, text in zip(inputs, arguments, strict=True))
        return f"{self.printer.helper(name)}({named})", PRIMARY

    def pou(self) -> Pou:
        """Return the function with its variables."""
        function = self.function
        own = self.printer.function(function)
        if isinstance(function.result, Struct):
            self._declare(RESULT, function.result, "VAR_IN_OUT")
        returns = TRUTH
        if isinstance(function.result, Scalar):
            returns = function.result
        if not isinstance(function.result, Scalar) or function.result == VOID:
            self._line(f"{own} := TRUE;")
        self._block(function.body)
        if self.out and self.out[-1] == f"{INDENT}RETURN;":
            self.out.pop()
        return Pou(
            "FUNCTION",
            own,
            self.printer.type_name(returns),
            tuple(self._declared.values()),
            tuple(self.out),
            described(function.description),
        )

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
                    target = RESULT
                    if not isinstance(s.value.type, Struct):
                        target = self.printer.function(self.function)
                    self._into(target, s.value)
                self._line("RETURN;")
            elif isinstance(s, tree.If):
                self._if(s)
            elif isinstance(s, tree.For):
                self._for(s)
            elif isinstance(s, tree.While):
                self._while(s)
            elif isinstance(s, tree.Break):
                self._line("EXIT;")
            else:
                self._line("CONTINUE;")

    def _if(self, s: tree.If) -> None:
        test = s.test
        first = s.body
        second = s.otherwise
        if not first:
            test = tree.Not(TRUTH, test)
            first = second
            second = []
        self._line(f"IF {self._of(test)} THEN")
        self._inner(first)
        while (
            len(second) == 1
            and isinstance(second[0], tree.If)
            and second[0].body
            and is_safe(second[0].test)
        ):
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
        if s.variable.name == "_":
            counter = self._aside(INTEGER)
        else:
            counter = self._variable_name(s.variable)
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
        """Return the text of a whole number minus one."""
        if isinstance(number, tree.Constant):
            return self._of(tree.Constant(INTEGER, int(number.value) - 1))
        return f"{self._of(number, BINDS['-'])} - 1"

    def _while(self, s: tree.While) -> None:
        safe = is_safe(s.test)
        test = "TRUE"
        if safe:
            test = self._of(s.test)
        self._line(f"WHILE {test} DO")
        with self._inside():
            if not safe:
                self._line(f"IF {self._of(tree.Not(TRUTH, s.test))} THEN")
                self._line(f"{INDENT}EXIT;")
                self._line("END_IF;")
            self._block(s.body)
        self._line("END_WHILE;")


def is_safe(e: tree.Expression) -> bool:
    """Return whether an expression may be evaluated unnecessarily, and without a preceding statement."""
    for part in walk(e):
        divides = isinstance(part, tree.Binary) and part.operator not in ("+", "-", "*")
        calls = isinstance(part, tree.Intrinsic) and part.name not in (
            "abs",
            "min",
            "max",
            "copysign",
            "isinf",
            "isnan",
        )
        if (
            divides
            or calls
            or isinstance(part, (tree.Index, tree.Call, tree.Select, tree.Convert, tree.Make))
        ):
            return False
    return True
