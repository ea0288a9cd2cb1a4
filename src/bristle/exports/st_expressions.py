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
UNSAFE = (tree.Index, tree.Call, tree.Select, tree.Convert, tree.Make)


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

    def _variable_name(self, variable: tree.Variable) -> str:
        return self._declare(self._names.of(variable.name, variable.name), variable.type)

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
        elif isinstance(e.type, Struct) and isinstance(e, (tree.Make, tree.Call)) and _mentions(e, root):
            aside = self._aside(e.type)
            self._into(aside, e)
            self._line(f"{target} := {aside};")
        elif isinstance(e, tree.Make):
            assert isinstance(e.type, Struct)
            for (name, _), part in zip(e.type.fields, e.parts, strict=True):
                self._into(f"{target}.{self.printer.field(e.type, name)}", part)
        elif isinstance(e, tree.Call) and isinstance(e.type, Struct):
            self._line(f"{self._aside(TRUTH)} := {self._called(e, target)};")
        else:
            self._line(f"{target} := {self._of(e)};")

    def _choose(self, target: str, e: tree.Select, root: str) -> None:
        self._line(f"IF {self._of(e.test)} THEN")
        with self._inside():
            self._into(target, e.first, root)
        second = e.second
        while isinstance(second, tree.Select) and is_safe(second.test):
            self._line(f"ELSIF {self._of(second.test)} THEN")
            with self._inside():
                self._into(target, second.first, root)
            second = second.second
        self._line("ELSE")
        with self._inside():
            self._into(target, second, root)
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

    def _select(self, e: tree.Select) -> tuple[str, int]:
        return self._held(e), PRIMARY

    def _make(self, e: tree.Make) -> tuple[str, int]:
        return self._held(e), PRIMARY

    def _convert(self, e: tree.Convert) -> tuple[str, int]:
        if e.of.type == TRUTH:
            return self._held(tree.Select(e.type, e.of, _constant_of(e.type, 1), _constant_of(e.type, 0))), PRIMARY
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
        named = ", ".join(f"{name} := {text}" for name, text in zip(ARGUMENTS[e.name], arguments, strict=True))
        return f"{self.printer.helper(name)}({named})", PRIMARY


ARGUMENTS = {
    "copysign": ("number", "sign_of"),
    "abs": ("number",),
    "floor": ("number",),
    "isinf": ("number",),
    "isnan": ("number",),
    "min": ("first", "second"),
    "max": ("first", "second"),
    "mantissa": ("number",),
    "exponent": ("number",),
    "power_of_two": ("power",),
}


def _constant_of(kind: Type, value: int) -> tree.Constant:
    return tree.Constant(kind, float(value) if kind == REAL else value)


def is_safe(e: tree.Expression) -> bool:
    """Return whether an expression may be computed where it is not needed, and without a statement before it."""
    divides = any(isinstance(part, tree.Binary) and part.operator not in ("+", "-", "*") for part in walk(e))
    return not divides and not any(isinstance(part, UNSAFE) or _calls(part) for part in walk(e))


def _calls(e: object) -> bool:
    return isinstance(e, tree.Intrinsic) and e.name not in ("abs", "min", "max", "copysign", "isinf", "isnan")


def _mentions(e: tree.Expression, name: str) -> bool:
    return bool(name) and any(isinstance(part, tree.Variable) and part.name == name for part in walk(e))
