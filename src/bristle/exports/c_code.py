"""Functions of a tree as C99: static functions, tuples as structures by value, ``sqrt`` as the only library function."""

import math
import re
from collections import Counter
from collections.abc import Iterable, Sequence

from bristle.core.kernel import is_absorbed
from bristle.engine.translation import scope, tree
from bristle.engine.translation.tree import (
    INTEGER,
    REAL,
    TRUTH,
    VOID,
    Array,
    Scalar,
    Struct,
    Type,
    blocks_of,
    walk,
)
from bristle.exports import printing

WORDS_OF_C = """
alignas alignof asm auto bool break case char const constexpr continue default do double else enum extern false float
for goto if inline int long nullptr register restrict return short signed sizeof static static_assert struct switch
thread_local true typedef typeof typeof_unqual union unsigned void volatile while
"""
WORDS_OF_CPP = """
and and_eq bitand bitor catch char16_t char32_t char8_t class co_await co_return co_yield compl concept const_cast
consteval constinit decltype delete dynamic_cast explicit export friend mutable namespace new noexcept not not_eq
operator or or_eq private protected public reinterpret_cast requires static_cast template this throw try typeid typename
using virtual wchar_t xor xor_eq
"""
# Macros of compilers and of the headers that an export includes, in addition to the patterns of MACROS.
MACROS_BY_NAME = """
BIG_ENDIAN BYTE_ORDER DECIMAL_DIG FD_SETSIZE HUGE_VAL HUGE_VALF HUGE_VALL INFINITY LITTLE_ENDIAN MAXFLOAT MB_CUR_MAX
NAN NFDBITS NULL PDP_ENDIAN RAND_MAX WCONTINUED WEXITED WNOHANG WNOWAIT WSTOPPED WUNTRACED errno far fd_set linux
main math_errhandling near physadr quad signgam strtodf unix
"""
MACROS = re.compile(
    r"(DBL|DEC\d*|EXIT|FLT|FP|INT|INT_\w+|INT\d+|INTMAX|INTPTR|LDBL|MATH|PTRDIFF|PTHREAD|SCHED|SIG_ATOMIC|SIZE|UINT_\w+"
    r"|UINT\d+|UINTMAX|UINTPTR|WCHAR|WINT)_[A-Z0-9_]+|M_(E|LOG\w+|LN\w+|IVLN\w+|INVLN\w+|SQRT\w+|TWOPI|\w*PI(_[24])?)"
)
DEFINED = """
ABSORBED Bits root with_sign magnitude next_below is_infinite is_nan is_finite least greatest mantissa_of exponent_of
power_of_two whole_magnitude whole_least whole_greatest floor_divided floor_rest
"""
RESERVED = frozenset((WORDS_OF_C + WORDS_OF_CPP + MACROS_BY_NAME + DEFINED).split())
"""Reserved names: keywords of C and C++, macros of a system, and definitions of the unit."""


class Names:
    """Unique names of the structures of a unit: the class name, with the module name before it if two classes share it."""

    def __init__(self, structures: Sequence[Struct], functions: Iterable[str] = ()) -> None:
        counted = Counter(kind.cls.__name__ for kind in structures)
        self.structures: dict[Struct, str] = {}
        self._functions = frozenset(functions)
        used = {*RESERVED, *self._functions}
        for kind in structures:
            first = "Several"
            if not kind.is_plain:
                first = kind.cls.__name__
            if counted[first] > 1 and not kind.is_plain:
                module = kind.cls.__module__.rpartition(".")[2]
                if module.startswith("bristle_user_"):
                    first = f"Own{first}"
                else:
                    first = "".join(part.capitalize() for part in module.split("_")) + first
            self.structures[kind] = scope.free_name(scope.ascii_name(first), used)
            used.add(self.structures[kind])

    def variable(self, name: str) -> str:
        """Return a name for a variable, an argument or a field; different names stay different, and case matters."""
        plain = name.rstrip("_")
        if plain in RESERVED or name in self._functions or MACROS.fullmatch(plain):
            return f"{name}_"
        if name.startswith("_"):
            return f"part{name}"
        return scope.ascii_name(name)


# Precedence of an expression; a part with too low a precedence gets brackets.
SELECT = 2
BOUND = {
    13: "* /",
    12: "+ -",
    11: ">>",
    10: "< <= > >=",
    9: "== !=",
    8: "&",
    7: "^",
    4: "and",
    3: "or",
}
BINDS = {operator: binds for binds, operators in BOUND.items() for operator in operators.split()}
ABSORBED = """/* Kernels that their callers absorb, as in compiled Python, but where code is to be small. */
#if defined(__GNUC__) && defined(__OPTIMIZE__) && !defined(__OPTIMIZE_SIZE__)
#define ABSORBED static inline __attribute__((always_inline))
#else
#define ABSORBED static inline
#endif
"""


TRUTHS = {True: "true", False: "false"}


def number(value: float, scalar: str = "double") -> str:
    """Return a real number as exact text of C."""
    if math.isnan(value):
        return f"({scalar})NAN"
    if value == math.inf:
        return f"({scalar})INFINITY"
    if value == -math.inf:
        return f"-({scalar})INFINITY"
    if scalar == "float":
        return f"{float(value)!r}f"
    return repr(float(value))


def initializer(parts: Iterable[str]) -> str:
    """Return the parts of a structure or an array as text of C, which cannot be empty."""
    return ", ".join(parts) or "0"


class Printer:
    """Prints the functions of one unit."""

    inline = "static inline"
    """Specifiers of a function."""
    absorbed = "ABSORBED"
    """Specifiers of a kernel that the compiler inlines into its callers."""
    constant = "static const"
    """Specifiers of a constant of the file."""
    cleared = "{0}"
    """Initializer of a structure of zeros."""

    def __init__(self, unit: tree.Unit, scalar: str = "double", also: Sequence[Type] = ()) -> None:
        self.unit = unit
        self.scalar = scalar
        self.integer = "int32_t"
        if printing.needs_wide_integers(unit):
            self.integer = "int64_t"
        used = [kind for function in unit.functions for kind in printing.types_in(function)]
        self.structures = printing.structures_of([*used, *also])
        self.names = Names(self.structures, [function.name for function in unit.functions])
        self.helpers: set[str] = set()

    def definitions(self) -> str:
        """Return structures and functions; `helpers` then holds the helpers that they call."""
        functions = [self._function(function) for function in self.unit.functions]
        texts = []
        if self.absorbed == "ABSORBED":
            texts = [ABSORBED]
        for kind in self.structures:
            declared = [
                f"{self.named(part, self.names.variable(name))};" for name, part in kind.fields
            ] or ["char nothing;"]
            fields = [f"{printing.INDENT}{field}" for field in declared]
            texts.append(
                "\n".join(["typedef struct {", *fields, f"}} {self.type_name(kind)};", ""])
            )
        return "\n".join([*texts, *functions])

    def named(self, kind: Type, name: str) -> str:
        """Return the declaration of a name of this type."""
        text = self.type_name(kind)
        if text.endswith("*"):
            return f"{text}{name}"
        return f"{text} {name}"

    def type_name(self, kind: Type) -> str:
        """Return the name of a type."""
        if isinstance(kind, Scalar):
            return {REAL: self.scalar, INTEGER: self.integer, TRUTH: "bool", VOID: "void"}[kind]
        if isinstance(kind, Array):
            if kind.writable:
                return f"{self.scalar} *"
            return f"const {self.scalar} *"
        return self.names.structures[kind]

    def structure_text(self, kind: Type, parts: str) -> str:
        """Return the expression that constructs a structure from its parts."""
        return f"({self.type_name(kind)}){{{parts}}}"

    def _function(self, function: tree.Function) -> str:
        arguments = [
            self.named(argument.type, self.names.variable(argument.name))
            for argument in function.parameters
        ]
        inline = self.inline
        if is_absorbed(function.source):
            inline = self.absorbed
        head = f"{inline} {self.named(function.result, function.name)}({', '.join(arguments) or 'void'})"
        comment = []
        if function.description:
            comment = [f"/* {printing.described(function.description)} */"]
        body = Body(self, function).lines()
        return "\n".join([*comment, *printing.wrapped(head, ""), "{", *body, "}", ""])


class Body:
    """Prints the body of one function."""

    def __init__(self, printer: Printer, function: tree.Function) -> None:
        self.printer = printer
        self.function = function
        self.helpers = printer.helpers
        self._arguments = {parameter.name for parameter in function.parameters}
        self._first: set[int] = set()  # assignments that declare their variables
        self._rounds = 0

    def lines(self) -> list[str]:
        """Return the lines of the body; a variable is declared with its first value if this precedes every use."""
        top: list[str] = []
        assigned = [
            part.variable for part in walk(self.function.body) if isinstance(part, tree.Assign)
        ]
        for variable in {
            part.name: part for part in assigned if part.name not in self._arguments
        }.values():
            at = _first_value(self.function.body, variable.name)
            if at is not None:
                self._first.add(id(at))
                continue
            zero = {REAL: number(0.0, self.printer.scalar), TRUTH: "false"}.get(variable.type, "0")  # type: ignore[call-overload]
            if isinstance(variable.type, Struct):
                zero = self.printer.cleared
            top.append(
                f"{printing.INDENT}{self.printer.named(variable.type, self._name(variable.name))} = {zero};"
            )
        return top + self._block(self.function.body, printing.INDENT)

    def _block(self, block: list[tree.Statement], indent: str) -> list[str]:
        return [line for statement in block for line in self._statement(statement, indent)]

    def _statement(self, statement: tree.Statement, indent: str) -> list[str]:
        inner = indent + printing.INDENT
        after = f"{indent}}}"
        if isinstance(statement, tree.If):
            test = statement.test
            first = statement.body
            second = statement.otherwise
            if not first:
                test = tree.Not(TRUTH, test)
                first = second
                second = []
            lines = [
                *printing.wrapped(f"{indent}if ({self._of(test)}) {{", indent),
                *self._block(first, inner),
            ]
            if second:
                lines += [f"{indent}}} else {{", *self._block(second, inner)]
            return [*lines, after]
        if isinstance(statement, tree.For):
            self._rounds += 1
            name = f"round_{self._rounds}"
            if statement.variable.name != "_":
                name = self._name(statement.variable.name)
            start = self._of(statement.start)
            stop = self._of(statement.stop, BINDS["<"] + 1)
            head = f"for ({self.printer.integer} {name} = {start}; {name} < {stop}; ++{name}) {{"
            return [
                *printing.wrapped(indent + head, indent),
                *self._block(statement.body, inner),
                after,
            ]
        if isinstance(statement, tree.While):
            return [
                *printing.wrapped(f"{indent}while ({self._of(statement.test)}) {{", indent),
                *self._block(statement.body, inner),
                after,
            ]
        return printing.wrapped(f"{indent}{self._simple(statement)};", indent)

    def _simple(self, statement: tree.Statement) -> str:
        """Return a statement without inner statements."""
        if isinstance(statement, tree.Assign):
            name = self._name(statement.variable.name)
            target = name
            if id(statement) in self._first:
                target = self.printer.named(statement.variable.type, name)
            return f"{target} = {self._of(statement.value)}"
        if isinstance(statement, tree.Store):
            return f"{self._of(statement.array, printing.PRIMARY)}[{self._of(statement.at)}] = {self._of(statement.value)}"
        if isinstance(statement, tree.Evaluate):
            return f"(void){self._of(statement.call)}"
        if isinstance(statement, tree.Return):
            if statement.value is None:
                return "return"
            return f"return {self._of(statement.value)}"
        if isinstance(statement, tree.Break):
            return "break"
        return "continue"

    def _of(self, expression: tree.Expression, least: int = 0) -> str:
        text, binds = getattr(self, f"_{type(expression).__name__.lower()}")(expression)
        if binds >= least and binds > 0:
            return text
        return f"({text})"

    def _name(self, name: str) -> str:
        return self.printer.names.variable(name)

    def _constant(self, e: tree.Constant) -> tuple[str, int]:
        if e.type == TRUTH:
            return TRUTHS[bool(e.value)], printing.PRIMARY
        if e.type == REAL:
            text = number(float(e.value), self.printer.scalar)
        else:
            text = str(int(e.value))
        if e.type == INTEGER and abs(e.value) >= 2**31:
            text = f"INT64_C({text})"
        if text.startswith("-"):
            return text, printing.UNARY - 1
        return text, printing.PRIMARY

    def _variable(self, e: tree.Variable) -> tuple[str, int]:
        return self._name(e.name), printing.PRIMARY

    def _field(self, e: tree.Field) -> tuple[str, int]:
        return f"{self._of(e.of, printing.PRIMARY)}.{self._name(e.name)}", printing.PRIMARY

    def _index(self, e: tree.Index) -> tuple[str, int]:
        return f"{self._of(e.array, printing.PRIMARY)}[{self._of(e.at)}]", printing.PRIMARY

    def _negative(self, e: tree.Negative) -> tuple[str, int]:
        return f"-{self._of(e.of, printing.UNARY + 1)}", printing.UNARY

    def _not(self, e: tree.Not) -> tuple[str, int]:
        return f"!{self._of(e.of, printing.UNARY)}", printing.UNARY

    def _binary(self, e: tree.Binary) -> tuple[str, int]:
        if e.operator in ("//", "%"):
            helper = "floor_rest"
            if e.operator == "//":
                helper = "floor_divided"
            self.helpers |= {"floor_divided", helper}
            return f"{helper}({self._of(e.left)}, {self._of(e.right)})", printing.PRIMARY
        binds = BINDS[e.operator]
        if e.operator in ("&", "^", ">>"):
            return (
                f"{self._of(e.left, printing.PRIMARY)} {e.operator} {self._of(e.right, printing.PRIMARY)}",
                binds,
            )
        return f"{self._of(e.left, binds)} {e.operator} {self._of(e.right, binds + 1)}", binds

    def _compare(self, e: tree.Compare) -> tuple[str, int]:
        tighter = BINDS["<"] + 1
        return f"{self._of(e.left, tighter)} {e.operator} {self._of(e.right, tighter)}", BINDS[
            e.operator
        ]

    def _logic(self, e: tree.Logic) -> tuple[str, int]:
        joined = {"and": " && ", "or": " || "}[e.operator]
        return joined.join(self._of(part, BINDS["=="]) for part in e.parts), BINDS[e.operator]

    def _select(self, e: tree.Select) -> tuple[str, int]:
        return (
            f"{self._of(e.test, BINDS['or'])} ? {self._of(e.first, 3)} : {self._of(e.second, 3)}",
            SELECT,
        )

    def _convert(self, e: tree.Convert) -> tuple[str, int]:
        return f"({self.printer.type_name(e.type)}){self._of(e.of, printing.UNARY)}", printing.UNARY

    def _call(self, e: tree.Call) -> tuple[str, int]:
        return (
            f"{e.function.name}({', '.join(self._of(argument) for argument in e.arguments)})",
            printing.PRIMARY,
        )

    def _intrinsic(self, e: tree.Intrinsic) -> tuple[str, int]:
        if e.type != INTEGER or e.name == "floor":
            name = e.name
        else:
            name = f"whole_{e.name}"
        self.helpers.add(name)
        return (
            f"{HELPED.get(name, name)}({', '.join(self._of(argument) for argument in e.arguments)})",
            printing.PRIMARY,
        )

    def _make(self, e: tree.Make) -> tuple[str, int]:
        parts = initializer(self._of(part) for part in e.parts)
        return self.printer.structure_text(e.type, parts), printing.PRIMARY


# Names of the helpers in C; library functions of the same name would differ.
HELPED = {
    "sqrt": "root",
    "copysign": "with_sign",
    "abs": "magnitude",
    "floor": "next_below",
    "isinf": "is_infinite",
    "isnan": "is_nan",
    "min": "least",
    "max": "greatest",
    "whole_min": "whole_least",
    "whole_max": "whole_greatest",
    "whole_abs": "whole_magnitude",
    "mantissa": "mantissa_of",
    "exponent": "exponent_of",
}


def _first_value(block: list[tree.Statement], name: str) -> tree.Assign | None:
    """Return the assignment that precedes every other use of a name, in a block around all of them."""
    using = [statement for statement in block if _uses(statement, name)]
    first = using[0]
    if isinstance(first, tree.Assign):
        if _uses(first.value, name):
            return None
        return first
    inside = [
        part for part in blocks_of(first) if any(_uses(statement, name) for statement in part)
    ]
    if isinstance(first, tree.For):
        heads = [first.start, first.stop, first.variable]
    else:
        heads = [getattr(first, "test", first)]
    if len(using) > 1 or len(inside) != 1 or any(_uses(head, name) for head in heads):
        return None
    return _first_value(inside[0], name)


def _uses(node: tree.Statement | tree.Expression, name: str) -> bool:
    return any(isinstance(part, tree.Variable) and part.name == name for part in walk(node))
