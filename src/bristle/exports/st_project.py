"""What exports to Structured Text share: their files from parts, how a structure is set, how a walk is made."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from bristle.exports.c_code import wrapped
from bristle.exports.plcopen import project_text
from bristle.exports.rendering import rendered
from bristle.exports.st_code import RESULT, Printer
from bristle.exports.st_helpers import helpers_of
from bristle.exports.st_names import real_literal, whole_literal
from bristle.exports.st_parts import INDENT, Array, Pou, Variable, part_text, used_of
from bristle.exports.tree import Function
from bristle.exports.types import REAL, TRUTH, Struct, Type
from bristle.exports.types import Array as ArrayType
from bristle.exports.walk import FACTOR, PART, RESTS, SEED, TERM, Walk

__all__ = [
    "FARTHEST",
    "Project",
    "answers",
    "body_lines",
    "call_text",
    "requests",
    "set_lines",
    "sums",
    "test_variables",
    "total_of",
    "walk_facts",
]  # fmt: skip

FARTHEST = 1e30
"""What comes in or goes out beyond it is taken for no number."""
TURN = real_literal(2.0**32)
PER_CYCLE = 20
"""Steps of a self-test in one cycle of a task."""


@dataclass(frozen=True)
class Project:
    """A function block with what it needs, and its self-test.

    Parameters
    ----------
    name : str
        What the block is called.
    printer : Printer
        What printed their calls.
    facts : dict
        What the comments at the head of the files say.
    block, test : Pou
        The function block, and the program that tests it.
    arrays : tuple of Array
        Data types of the test.
    """

    name: str
    printer: Printer
    facts: dict[str, Any]
    block: Pou
    test: Pou
    arrays: tuple[Array, ...]

    def files(self, head: str) -> dict[str, str]:
        """Return the text of each file by its name; `head` is the template of the comment that they begin with."""
        types, functions = self.printer.parts()
        functions = [*helpers_of(self.printer.helpers, self.printer.helper, self.printer.integer), *functions]
        types = used_of(types, [*functions, self.block])
        comment = rendered(head, self.facts)
        test_head = rendered("st/selftest_head.st", self.facts | {"per_cycle": PER_CYCLE})
        return {
            f"{self.name}.st": "\n".join([comment, *(part_text(part) for part in (*types, *functions, self.block))]),
            f"{self.name}_selftest.st": "\n".join(
                [test_head, *(part_text(part) for part in (*self.arrays, self.test))]
            ),
            f"{self.name}_plcopen.xml": project_text(
                self.name, comment, [*types, *self.arrays], [*functions, self.block, self.test]
            ),
        }


def requests(anew: str) -> list[Variable]:
    """Return what a block may be requests for besides."""
    return [
        Variable("restart", "BOOL", f"begin anew: {anew}", "VAR_INPUT"),
        Variable("clear", "BOOL", "forget what was refused", "VAR_INPUT"),
    ]


def answers(output: str, meaning: str) -> list[Variable]:
    """Return what a block gives, and whether it was held."""
    return [
        Variable(output, "LREAL", meaning, "VAR_OUTPUT"),
        Variable("refused", "BOOL", "what came in was no finite number: the output was held", "VAR_OUTPUT"),
        Variable("overflow", "BOOL", "what was to go out was no finite number: it was held", "VAR_OUTPUT"),
    ]


def test_variables(name: str) -> list[Variable]:
    """Return what a self-test of a block has, whatever the block."""
    return [
        Variable("done", "BOOL", "whether the walk has come to its end", "VAR_OUTPUT"),
        Variable("passed", "BOOL", "whether it gave the numbers of bristle, to the bit", "VAR_OUTPUT"),
        Variable("axis", name), Variable("prepared", "BOOL"), Variable("count", "DINT"), Variable("each", "DINT"),
        *(Variable(number, "LREAL") for number in ("bits", "walked", "total", "lost", "following", "added")),
        Variable("scales", f"{name}_Scales"),
    ]  # fmt: skip


def sums(numbers: Sequence[float]) -> dict[str, str]:
    """Return what a self-test compares the numbers that it gets with."""
    total, lost = total_of(numbers)
    return {"total": real_literal(total), "lost": real_literal(lost), "last": real_literal(numbers[-1])}


def call_text(printer: Printer, function: Function, handed: Iterable[str], result: str) -> str:
    """Return a call of a function that gives a structure into `result`."""
    pairs = [f"{name} := {value}" for name, value in zip(printer.body(function).arguments, handed, strict=True)]
    return f"{printer.function(function)}({', '.join([*pairs, f'{RESULT} := {result}'])})"


def set_lines(place: str, value: Any, kind: Struct, printer: Printer) -> Iterator[str]:
    """Give the lines that set a structure."""
    for (name, part), field in zip(kind.fields, value, strict=True):
        at = f"{place}.{printer.field(kind, name)}"
        if isinstance(part, Struct):
            yield from set_lines(at, field, part, printer)
        elif isinstance(part, ArrayType):
            yield from (f"{at}[{i}] := {real_literal(float(number))};" for i, number in enumerate(field))
        else:
            yield f"{at} := {_literal(field, part)};"


def body_lines(template: str, facts: dict[str, Any]) -> tuple[str, ...]:
    """Return the lines of a body."""
    lines = [f"{INDENT}{line}" for line in rendered(template, facts).rstrip("\n").split("\n")]
    return tuple(part for line in lines for part in wrapped(line, line[: len(line) - len(line.lstrip())]))


def walk_facts(walk: Walk, printer: Printer, count: str) -> dict[str, Any]:
    """Return what a program needs to know to walk by itself; `count` is the variable that counts its steps."""
    integer, floor = printer.integer, printer.helper("floor")
    scale = f"scales[({count} / {PART}) MOD {len(walk.scales)}]"
    return {
        "seed": real_literal(SEED), "scales": [real_literal(scale) for scale in walk.scales],
        "dt": real_literal(walk.dt), "per_cycle": PER_CYCLE,
        "step": [
            f"bits := bits * {real_literal(FACTOR)} + {real_literal(TERM)};",
            f"bits := bits - {integer}_TO_LREAL({floor}(number := bits / {TURN})) * {TURN};",
            f"IF ({floor}(number := bits / 256.0) MOD {RESTS}) <> 0 THEN",
            f"{INDENT}walked := walked + ({integer}_TO_LREAL({floor}(number := bits / 65536.0)) - 32768.0) * {scale};",
            "END_IF;",
        ],
    }  # fmt: skip


def total_of(numbers: Iterable[float]) -> tuple[float, float]:
    """Return the sum of some numbers and what rounding took from it: another last place anywhere changes one of them.

    References
    ----------
    .. [1] D. E. Knuth, "The art of computer programming", vol. 2, 3rd ed., Addison-Wesley, 1997, sec. 4.2.2, theorem B.
    """
    total, lost = 0.0, 0.0
    for number in numbers:
        following = total + number
        added = following - total
        lost = lost + ((total - (following - added)) + (number - added))
        total = following
    return total, lost


def _literal(value: Any, kind: Type) -> str:
    if kind == TRUTH:
        return "TRUE" if value else "FALSE"
    return real_literal(float(value)) if kind == REAL else whole_literal(int(value))
