"""What has a value in Structured Text, and what must be done before it.

The language has no choice inside an expression, computes both sides of AND and OR, and makes no tuple of its fields:
each becomes statements, which end in a variable.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from bristle.exports import tree
from bristle.exports.printing import PRIMARY, UNARY, wrapped
from bristle.exports.scope import NotExportableError
from bristle.exports.st_helpers import TEXTS
from bristle.exports.st_parts import INDENT, Names, whole_literal
from bristle.exports.st_parts import Variable as Declared
from bristle.exports.tree import INTEGER, REAL, TRUTH, Scalar, Struct, Type, walk

if TYPE_CHECKING:
    from bristle.exports.st_code import Printer

RESULT = "given_back"
# How tightly an expression binds.
COMPARED = 9
BINDS = {"*": 13, "/": 13, "+": 12, "-": 12, "and": 4, "or": 3}
COMPARISONS = {"==": "=", "!=": "<>"}
IN_WORDS = {"&": "AND", "^": "XOR"}


class Values:
    """Prints what has a value, in one function; what must stand before it goes into the lines of the function."""

    def __init__(self, printer: Printer, function: tree.Function) -> None:
        self.printer, self.function = printer, function
        self.out: list[str] = []
        self._names = Names([RESULT])
        self._declared: dict[str, Declared] = {}
        self._indent = INDENT
        self._count = 0
        assigned = {part.variable.name for part in walk(function.body) if isinstance(part, (tree.Assign, tree.For))}
        self.arguments = [self._parameter(parameter, copied=parameter.name in assigned) for parameter in function.parameters]

    # --- variables ------------------------------------------------------------------------------------------------

    def _parameter(self, parameter: tree.Variable, *, copied: bool) -> str:
        """Declare an argument, and return its name; one that is given another value inside is copied first."""
        section = "VAR_INPUT" if isinstance(parameter.type, Scalar) else "VAR_IN_OUT"
        name = self._names.of(parameter.name, parameter.name)
        if not copied:
            return self._declare(name, parameter.type, section)
        original = self._declare(self._names.new(f"{name}_given"), parameter.type, section)
        self._line(f"{self._declare(name, parameter.type)} := {original};")
        return original

    def _declare(self, name: str, kind: Type, section: str = "VAR") -> str:
        self._declared.setdefault(name, Declared(name, self.printer.type_name(kind), section=section))
        return name

    def _aside(self, kind: Type) -> str:
        """Return a new variable for what stands before a statement."""
        self._count += 1
        return self._declare(self._names.new(f"aside_{self._count}"), kind)

    def _line(self, text: str) -> None:
        self.out += wrapped(f"{self._indent}{text}", self._indent)

    @contextmanager
    def _inside(self) -> Iterator[None]:
        self._indent += INDENT
        yield
        self._indent = self._indent[: -len(INDENT)]

    # --- a value into a variable ----------------------------------------------------------------------------------

    def _into(self, target: str, e: tree.Expression, root: str = "") -> None:
        """Put a value into a variable; `root` is the variable, which what is computed may look at."""
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
            rest, word = rest.second, "ELSIF"
        self._line("ELSE")
        with self._inside():
            self._into(target, rest, root)
        self._line("END_IF;")

    def _one_by_one(self, e: tree.Logic) -> str:
        """Compute truths as far as they are needed, and return the variable that holds the answer."""
        target = self._aside(TRUTH)
        self._into(target, e.parts[0])
        for part in e.parts[1:]:
            self._line(f"IF {target if e.operator == 'and' else f'NOT {target}'} THEN")
            self._indent += INDENT
            self._into(target, part)
        for _ in e.parts[1:]:
            self._indent = self._indent[: -len(INDENT)]
            self._line("END_IF;")
        return target

    def _held(self, e: tree.Expression) -> str:
        """Return a variable that holds a value."""
        aside = self._aside(e.type)
        self._into(aside, e)
        return aside

    # --- expressions ----------------------------------------------------------------------------------------------

    def _of(self, e: tree.Expression, least: int = 0) -> str:
        text, binds = getattr(self, f"_{type(e).__name__.lower()}")(e)
        return text if binds >= least else f"({text})"

    def _place(self, at: tree.Expression) -> str:
        if isinstance(at, tree.Constant) or self.printer.integer == "DINT":
            return self._of(at)
        return f"LINT_TO_DINT({self._of(at)})"

    def _constant(self, e: tree.Constant) -> tuple[str, int]:
        if e.type == TRUTH:
            return ("TRUE" if e.value else "FALSE"), PRIMARY
        text = self.printer.real(float(e.value)) if e.type == REAL else whole_literal(int(e.value))
        return text, (0 if text.startswith("-") else PRIMARY)

    def _variable_name(self, variable: tree.Variable) -> str:
        return self._declare(self._names.of(variable.name, variable.name), variable.type)

    def _variable(self, e: tree.Variable) -> tuple[str, int]:
        return self._variable_name(e), PRIMARY

    def _field(self, e: tree.Field) -> tuple[str, int]:
        assert isinstance(e.of.type, Struct)
        return f"{self._in_place(e.of)}.{self.printer.field(e.of.type, e.name)}", PRIMARY

    def _in_place(self, e: tree.Expression) -> str:
        """Return where a tuple or an array lies; one that is computed is put into a variable."""
        return self._of(e) if isinstance(e, (tree.Variable, tree.Field)) else self._held(e)

    def _index(self, e: tree.Index) -> tuple[str, int]:
        return f"{self._in_place(e.array)}[{self._place(e.at)}]", PRIMARY

    def _negative(self, e: tree.Negative) -> tuple[str, int]:
        return f"-{self._of(e.of, PRIMARY)}", 0

    def _not(self, e: tree.Not) -> tuple[str, int]:
        return f"NOT {self._of(e.of, PRIMARY)}", UNARY

    def _binary(self, e: tree.Binary) -> tuple[str, int]:
        if e.operator in BINDS:
            binds = BINDS[e.operator]
            # Numbers that were rounded before are bracketed, though the standard would have it so: (x + C) - C.
            mixed = isinstance(e.left, tree.Binary) and e.left.operator != e.operator and e.type == REAL
            left = self._of(e.left, binds + 1 if mixed else binds)
            return f"{left} {e.operator} {self._of(e.right, binds + 1)}", binds
        if e.operator in IN_WORDS:
            left, right = (f"LINT_TO_LWORD({self._of(side)})" for side in (e.left, e.right))
            return f"LWORD_TO_LINT({left} {IN_WORDS[e.operator]} {right})", PRIMARY
        right = e.right
        if e.operator == ">>":
            if not isinstance(right, tree.Constant):
                raise NotExportableError(self.function.source, None, "a shift by what is not known here")
            right = tree.Constant(INTEGER, 2 ** int(right.value))
        helper = self.printer.helper("floor_rest" if e.operator == "%" else "floor_divided")
        return f"{helper}(first := {self._of(e.left)}, second := {self._of(right)})", PRIMARY

    def _compare(self, e: tree.Compare) -> tuple[str, int]:
        tighter = BINDS["-"]
        operator = COMPARISONS.get(e.operator, e.operator)
        return f"{self._of(e.left, tighter)} {operator} {self._of(e.right, tighter)}", COMPARED

    def _logic(self, e: tree.Logic) -> tuple[str, int]:
        if not all(is_safe(part) for part in e.parts[1:]):
            return self._one_by_one(e), PRIMARY
        return f" {e.operator.upper()} ".join(self._of(part, UNARY) for part in e.parts), BINDS[e.operator]

    def _select(self, e: tree.Select | tree.Make) -> tuple[str, int]:
        return self._held(e), PRIMARY

    _make = _select

    def _convert(self, e: tree.Convert) -> tuple[str, int]:
        if e.of.type == TRUTH:
            one, zero = (tree.Constant(e.type, float(value) if e.type == REAL else value) for value in (1, 0))
            return self._held(tree.Select(e.type, e.of, one, zero)), PRIMARY
        if e.type == REAL:
            return f"{self.printer.integer}_TO_{self.printer.scalar}({self._of(e.of)})", PRIMARY
        return f"{self.printer.helper('truncated')}(number := {self._of(e.of)})", PRIMARY

    def _call(self, e: tree.Call) -> tuple[str, int]:
        return (self._held(e) if isinstance(e.type, Struct) else self._called(e)), PRIMARY

    def _called(self, e: tree.Call, target: str = "") -> str:
        names, pairs = self.printer.body(e.function).arguments, []
        for name, parameter, argument in zip(names, e.function.parameters, e.arguments, strict=True):
            text = self._of(argument) if isinstance(parameter.type, Scalar) else self._in_place(argument)
            pairs.append(f"{name} := {text}")
        pairs += [f"{RESULT} := {target}"] if target else []
        return f"{self.printer.function(e.function)}({', '.join(pairs)})"

    def _intrinsic(self, e: tree.Intrinsic) -> tuple[str, int]:
        arguments = [self._of(argument) for argument in e.arguments]
        if e.name == "sqrt":
            return f"SQRT({arguments[0]})", PRIMARY
        name = e.name if e.type != INTEGER or e.name == "floor" else f"whole_{e.name}"
        inputs = [word.partition(":")[0] for word in TEXTS[name][1].split()]
        named = ", ".join(f"{name} := {text}" for name, text in zip(inputs, arguments, strict=True))
        return f"{self.printer.helper(name)}({named})", PRIMARY


def is_safe(e: tree.Expression) -> bool:
    """Return whether an expression may be computed where it is not needed, and without a statement before it."""
    for part in walk(e):
        divides = isinstance(part, tree.Binary) and part.operator not in ("+", "-", "*")
        calls = isinstance(part, tree.Intrinsic) and part.name not in ("abs", "min", "max", "copysign", "isinf", "isnan")
        if divides or calls or isinstance(part, (tree.Index, tree.Call, tree.Select, tree.Convert, tree.Make)):
            return False
    return True
