"""Common parts of exports to Structured Text: files from parts, initial values of structures, the walk of a self-test."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any
from xml.etree import ElementTree

import numpy as np

from bristle.apps.targets import st_parts
from bristle.apps.targets.st_code import RESULT, Printer
from bristle.apps.targets.st_parts import (
    INDENT,
    LREAL,
    REAL,
    Array,
    Names,
    Pou,
    Variable,
    helpers_of,
    real_literal,
)
from bristle.engine.translation.tree import (
    REAL as NUMBER,
    TRUTH,
    Array as ArrayType,
    Function,
    Struct,
    Type,
)
from bristle.exports.described import Source, meaning_within, plain, rendered, version, with_rights
from bristle.exports.printing import element, wrapped
from bristle.exports.subject import FACTOR, PART, RESTS, SEED, TERM, Walk
from bristle.exports.tunable import CHECKPOINT, TOLERANCE, Tunable, bounds_of, checkpoints
from bristle.prediction.drive_units import CommandUnits

Key = tuple[str, int | None]


@dataclass(frozen=True)
class Tuned:
    """The inputs of a block for its parameters; each number of an array is a separate input."""

    tunable: Tunable
    names: dict[Key, str]

    @classmethod
    def of(cls, tunable: Tunable, names: Names) -> Tuned:
        """Return the inputs, with names that are unique in the block."""
        inputs = {}
        for name, place, _ in tunable.numbers():
            title = name
            if place is not None:
                title = f"{name}_{place + 1}"
            inputs[name, place] = names.of(("parameter", name, place), title)
        return cls(tunable, inputs)

    def inputs(self, printer: Printer) -> list[Variable]:
        """Return the declarations."""
        meanings = {
            name: meaning_within(variable, self.tunable.kind)
            for name, variable in self.tunable.variables.items()
        }
        return [
            Variable(
                self.names[name, place],
                printer.scalar,
                meanings[name],
                "VAR_INPUT",
                printer.real(value),
            )
            for name, place, value in self.tunable.numbers()
        ]

    def ranges(self, printer: Printer) -> Iterator[str]:
        """Yield a condition for each number: its range."""
        farthest = {LREAL: 1e30, REAL: 1e15}[printer.scalar]
        for name, place, compared in bounds_of(self.tunable):
            tests = [
                f"({self.names[name, place]} {operator} {printer.real(min(max(bound, -farthest), farthest))})"
                for operator, bound in compared
            ]
            yield " AND ".join(tests)

    def lines(
        self, place: str, kind: Struct, printer: Printer, path: tuple[str, ...] = ()
    ) -> Iterator[str]:
        """Yield the lines that copy the inputs to the parameters of the kernels."""
        for name, part in kind.fields:
            at = f"{place}.{printer.field(kind, name)}"
            inner = (*path, name)
            if isinstance(part, Struct):
                yield from self.lines(at, part, printer, inner)
            elif inner in self.tunable.places:
                parameter = self.tunable.places[inner]
                numbers = {None: at}
                if isinstance(part, ArrayType):
                    numbers = {i: f"{at}[{i}]" for i in range(part.size)}
                yield from (f"{to} := {self.names[parameter, i]};" for i, to in numbers.items())


FARTHEST = 1e30  # Inputs and outputs beyond it do not count as numbers
# Allowed time steps, in double and single precision [s]
PERIODS = {False: (1e-12, 1e12), True: (1e-6, 1e6)}
# Limits that keep the square of velocity over Stribeck velocity within single precision.
FASTEST = 1e9
FARTHEST_OF_OPERATOR = 1e9
FARTHEST_OF_LAW = 1e5
Path = tuple[str, ...]
TURN = real_literal(2.0**32)
PER_CYCLE = 20  # Steps of a self-test in one cycle of a task


def project_files(
    name: str,
    printer: Printer,
    facts: dict[str, Any],
    block: Pou,
    test: Pou,
    arrays: Sequence[Array],
    head: str,
    source: Source,
) -> dict[str, str]:
    """Return the files of a function block with its parts, and of its self-test; `head` is the template of their first comment."""
    types, functions = printer.parts()
    helpers = []
    for scalar in (LREAL, REAL):
        names = [helper for helper, of in sorted(printer.helpers) if of == scalar]
        helpers += helpers_of(
            names, partial(printer.helper, scalar=scalar), printer.integer, scalar
        )
    functions = [*helpers, *functions]
    types = st_parts.used_of(types, [*functions, block])
    comment = rendered(head, facts)
    test_head = rendered("st/selftest_head.st", facts | {"per_cycle": PER_CYCLE})
    files = {
        f"{name}.st": "\n".join([comment, *map(st_parts.part_text, [*types, *functions, block])]),
        f"{name}_selftest.st": "\n".join([test_head, *map(st_parts.part_text, [*arrays, test])]),
        f"{name}_plcopen.xml": project_text(
            name, comment, [*types, *arrays], [*functions, block, test]
        ),
    }
    return with_rights(files, source)


def interface(anew: str, output: str, meaning: str, units: CommandUnits | None) -> list[Variable]:
    """Return the further inputs and the outputs of a block: command in units of a drive, and flags of repeated output."""
    command = []
    if units is not None:
        command = [
            Variable(
                "command",
                "LREAL",
                f"the same in the units of the drive [{plain(units.effort.name)}]",
                "VAR_OUTPUT",
            )
        ]
    return [
        Variable("restart", "BOOL", f"begin anew: {anew}", "VAR_INPUT"),
        Variable("clear", "BOOL", "reset the flags", "VAR_INPUT"),
        Variable(output, "LREAL", meaning, "VAR_OUTPUT"),
        *command,
        Variable(
            "refused",
            "BOOL",
            "an input was not a finite number: the output was repeated",
            "VAR_OUTPUT",
        ),
        Variable(
            "overflow",
            "BOOL",
            "the result was not a finite number: the last output was repeated",
            "VAR_OUTPUT",
        ),
    ]


@dataclass(frozen=True)
class Judged:
    """Criteria of a self-test: the exact sum of the outputs, or some outputs within a tolerance."""

    name: str
    outputs: np.ndarray
    single: bool

    def facts(self) -> dict[str, Any]:
        """Return the facts for the templates of a self-test."""
        total, lost = total_of(self.outputs.tolist())
        near = checkpoints(self.outputs, single=self.single)
        return (
            {
                "total": real_literal(total),
                "lost": real_literal(lost),
                "last": real_literal(float(self.outputs[-1])),
            }
            | {
                "every": near["every"],
                "expected": [real_literal(float(text)) for text in near["checkpoints"]],
            }
            | {
                "tolerance": real_literal(TOLERANCE * float(near["largest"])),
                "count": self.outputs.size,
            }
        )

    def variables(self) -> list[Variable]:
        """Return the variables that all self-tests have."""
        gave = "bit by bit"
        worst = []
        numbers = ["bits", "walked", "following", "total", "lost", "added"]
        expected = []
        if self.single:
            gave = "within the error of single precision"
            worst = [Variable("worst", "LREAL", "largest deviation of the output", "VAR_OUTPUT")]
            numbers = ["bits", "walked", "following"]
            expected = [Variable("expected", f"{self.name}_Expected")]
        return [
            Variable("done", "BOOL", "whether the walk is complete", "VAR_OUTPUT"),
            Variable(
                "passed",
                "BOOL",
                f"whether the outputs match those of bristle, {gave}",
                "VAR_OUTPUT",
            ),
            *worst,
            Variable("axis", self.name),
            Variable("prepared", "BOOL"),
            *(Variable(number, "DINT") for number in ("count", "each")),
            *(Variable(number, "LREAL") for number in numbers),
            Variable("scales", f"{self.name}_Scales"),
            *expected,
        ]

    def arrays(self, walk: Walk, *further: Array) -> tuple[Array, ...]:
        """Return the data types of these variables."""
        scales = Array(f"{self.name}_Scales", len(walk.scales), LREAL)
        if self.single:
            count = len(self.outputs[::CHECKPOINT])
            further = (*further, Array(f"{self.name}_Expected", count, LREAL))
        return (scales, *further)


def commented_facts(facts: dict[str, Any]) -> dict[str, Any]:
    """Return facts without text that begins or ends a comment."""
    texts = {
        key: st_parts.commented(facts[key])
        for key in ("description", "variant", "table")
        if key in facts
    }
    texts |= {
        "frictions": {
            title: st_parts.commented(rows) for title, rows in facts.get("frictions", {}).items()
        }
    }
    return (
        facts
        | texts
        | {
            key: [st_parts.commented(line) for line in facts[key]]
            for key in ("facts", "fed")
            if key in facts
        }
    )


def call_text(printer: Printer, function: Function, handed: Iterable[str], result: str) -> str:
    """Return a call of a function that writes a structure to `result`."""
    pairs = [
        f"{name} := {value}"
        for name, value in zip(printer.body(function).arguments, handed, strict=True)
    ]
    return f"{printer.function(function)}({', '.join([*pairs, f'{RESULT} := {result}'])})"


def bounds(*, single: bool, farthest: float = FARTHEST) -> dict[str, str]:
    """Return the limits of inputs and outputs; in single precision, `farthest` limits inputs."""
    shortest, longest = PERIODS[single]
    fastest = real_literal(FASTEST)
    if not single:
        farthest = FARTHEST
        fastest = ""
    held = {"farthest": farthest, "beyond": FARTHEST, "shortest": shortest, "longest": longest}
    return {name: real_literal(value) for name, value in held.items()} | {"fastest": fastest}


def set_lines(
    place: str,
    value: Any,
    kind: Struct,
    printer: Printer,
    skipped: Container[Path] = (),
    path: Path = (),
) -> Iterator[str]:
    """Yield the lines that set a structure, without the skipped paths."""
    for (name, part), field in zip(kind.fields, value, strict=True):
        at = f"{place}.{printer.field(kind, name)}"
        inner = (*path, name)
        if inner in skipped:
            continue
        if isinstance(part, Struct):
            yield from set_lines(at, field, part, printer, skipped, inner)
        elif isinstance(part, ArrayType):
            yield from (
                f"{at}[{i}] := {printer.real(float(number))};" for i, number in enumerate(field)
            )
        else:
            yield f"{at} := {_literal(field, part, printer)};"


def _literal(value: float, kind: Type, printer: Printer) -> str:
    """Return a truth or a number of this type as text."""
    if kind == TRUTH:
        return st_parts.TRUTHS[bool(value)]
    if kind == NUMBER:
        return printer.real(float(value))
    return st_parts.whole_literal(int(value))


def body_lines(template: str, facts: dict[str, Any]) -> tuple[str, ...]:
    """Return the lines of a body."""
    lines = [f"{INDENT}{line}" for line in rendered(template, facts).rstrip("\n").split("\n")]
    return tuple(
        part for line in lines for part in wrapped(line, line[: len(line) - len(line.lstrip())])
    )


def walk_facts(walk: Walk, printer: Printer, count: str) -> dict[str, Any]:
    """Return the facts for the walk of a program; `count` is the variable that counts its steps."""
    integer = printer.integer
    floor = printer.helper("floor", LREAL)
    scale = f"scales[({count} / {PART}) MOD {len(walk.scales)}]"
    step = [
        f"bits := bits * {real_literal(FACTOR)} + {real_literal(TERM)};",
        f"bits := bits - {integer}_TO_LREAL({floor}(number := bits / {TURN})) * {TURN};",
        f"IF ({floor}(number := bits / 256.0) MOD {RESTS}) <> 0 THEN",
        f"{INDENT}walked := walked + ({integer}_TO_LREAL({floor}(number := bits / 65536.0)) - 32768.0) * {scale};",
        "END_IF;",
    ]
    scales = [real_literal(scale) for scale in walk.scales]
    return {
        "seed": real_literal(SEED),
        "scales": scales,
        "dt": real_literal(walk.dt),
        "per_cycle": PER_CYCLE,
        "step": step,
    }


def total_of(numbers: Iterable[float]) -> tuple[float, float]:
    """Return the sum of some numbers and its rounding error: a change in the last place of any number changes one of them."""
    # D. E. Knuth, "The art of computer programming", vol. 2, 3rd ed., Addison-Wesley, 1997, sec. 4.2.2, theorem B.
    total = 0.0
    lost = 0.0
    for number in numbers:
        following = total + number
        added = following - total
        lost = lost + ((total - (following - added)) + (number - added))
        total = following
    return total, lost


NAMESPACE = "http://www.plcopen.org/xml/tc6_0201"
XHTML = "http://www.w3.org/1999/xhtml"
POU_TYPES = {"FUNCTION": "function", "FUNCTION_BLOCK": "functionBlock", "PROGRAM": "program"}
SECTIONS = {
    "VAR_INPUT": "inputVars",
    "VAR_OUTPUT": "outputVars",
    "VAR_IN_OUT": "inOutVars",
    "VAR": "localVars",
}
NEVER = "1970-01-01T00:00:00"  # the same model gives the same file


def project_text(
    name: str, head: str, types: Sequence[Array | st_parts.Record], pous: Sequence[Pou]
) -> str:
    """Return a project with data types, functions, blocks and programs."""
    scaled = [
        element(language, element("scaling", x="1", y="1")) for language in ("fbd", "ld", "sfc")
    ]
    comment = head.strip().removeprefix("(*").removesuffix("*)").strip()
    project = element(
        "project",
        element(
            "fileHeader",
            companyName="bristle",
            productName="bristle",
            productVersion=version(),
            creationDateTime=NEVER,
        ),
        element(
            "contentHeader",
            element("Comment", comment),
            element("coordinateInfo", *scaled),
            name=name,
        ),
        element(
            "types",
            element("dataTypes", *map(_data_type, types)),
            element("pous", *map(_pou, pous)),
        ),
        element("instances", element("configurations")),
        **{"xmlns": NAMESPACE, "xmlns:xhtml": XHTML},
    )
    ElementTree.indent(project)
    return (
        '<?xml version="1.0" encoding="utf-8"?>\n'
        + ElementTree.tostring(project, encoding="unicode")
        + "\n"
    )


def _data_type(part: Array | st_parts.Record) -> ElementTree.Element:
    if isinstance(part, Array):
        base = element(
            "array",
            element("dimension", lower="0", upper=str(part.size - 1)),
            element("baseType", _type(part.of)),
        )
    else:
        base = element("struct", *map(_variable, part.fields))
    return element("dataType", element("baseType", base), name=part.name)


def _pou(pou: Pou) -> ElementTree.Element:
    declared = []
    if pou.returns:
        declared = [element("returnType", _type(pou.returns))]
    sections = {tag: pou.declared(section) for section, tag in SECTIONS.items()}
    declared += [
        element(tag, *map(_variable, variables)) for tag, variables in sections.items() if variables
    ]
    body = element(
        "body", element("ST", _paragraph("\n".join(line.removeprefix(INDENT) for line in pou.body)))
    )
    meaning = []
    if pou.meaning:
        meaning = [element("documentation", _paragraph(pou.meaning))]
    return element(
        "pou",
        element("interface", *declared),
        body,
        *meaning,
        name=pou.name,
        pouType=POU_TYPES[pou.kind],
    )


def _variable(variable: Variable) -> ElementTree.Element:
    initial = []
    if variable.initial:
        initial = [element("initialValue", element("simpleValue", value=variable.initial))]
    meaning = []
    if variable.meaning:
        meaning = [element("documentation", _paragraph(variable.meaning))]
    return element(
        "variable", element("type", _type(variable.type)), *initial, *meaning, name=variable.name
    )


def _type(name: str) -> ElementTree.Element:
    if name in ("LREAL", "REAL", "DINT", "LINT", "BOOL"):
        return element(name)
    return element("derived", name=name)


def _paragraph(text: str) -> ElementTree.Element:
    return element("xhtml:p", text)
