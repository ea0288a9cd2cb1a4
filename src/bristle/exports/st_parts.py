"""Parts of a PLC program, as text of the language and as XML alike: data types, and what has variables and a body."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

__all__ = ["INDENT", "Array", "Pou", "Record", "Variable", "commented", "declaration_text", "part_text", "used_of"]

INDENT = "    "
ENDS = {"FUNCTION": "END_FUNCTION", "FUNCTION_BLOCK": "END_FUNCTION_BLOCK", "PROGRAM": "END_PROGRAM"}
SECTIONS = ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT", "VAR")


@dataclass(frozen=True)
class Variable:
    """A variable or a field: its name, its type, what it is, in which section of a POU it is declared, its value."""

    name: str
    type: str
    meaning: str = ""
    section: str = "VAR"
    initial: str = ""


@dataclass(frozen=True)
class Array:
    """A data type: so many numbers, from place 0 on."""

    name: str
    size: int
    of: str


@dataclass(frozen=True)
class Record:
    """A data type: several values by name."""

    name: str
    fields: tuple[Variable, ...]


@dataclass(frozen=True)
class Pou:
    """A function, a function block or a program; `returns` is the type of a function."""

    kind: str
    name: str
    returns: str
    variables: tuple[Variable, ...]
    body: tuple[str, ...]
    meaning: str = ""

    def declared(self, section: str) -> list[Variable]:
        """Return the variables of one section."""
        return [variable for variable in self.variables if variable.section == section]


def commented(text: str) -> str:
    """Return text that neither begins a comment nor ends one."""
    return text.replace("(*", "( *").replace("*)", "* )")


def used_of(types: Sequence[Array | Record], pous: Iterable[Pou]) -> list[Array | Record]:
    """Return the data types that something is of, each after those that it holds."""
    names = {variable.type for pou in pous for variable in pou.variables}
    for part in reversed(types):
        if part.name in names and isinstance(part, Record):
            names |= {field.type for field in part.fields}
    return [part for part in types if part.name in names]


def part_text(part: Array | Record | Pou) -> str:
    """Return a part as Structured Text."""
    if isinstance(part, Pou):
        return "\n".join([declaration_text(part), *part.body, ENDS[part.kind], ""])
    if isinstance(part, Array):
        return f"TYPE\n{INDENT}{part.name} : ARRAY[0..{part.size - 1}] OF {part.of};\nEND_TYPE\n"
    fields = [f"{INDENT * 2}{line}" for line in _declarations(part.fields)]
    head, end = ["TYPE", f"{INDENT}{part.name} :", f"{INDENT}STRUCT"], [f"{INDENT}END_STRUCT;", "END_TYPE", ""]
    return "\n".join([*head, *fields, *end])


def declaration_text(pou: Pou) -> str:
    """Return what stands before the body of a POU: its kind, its name and its variables."""
    lines = [f"(* {commented(pou.meaning)} *)"] if pou.meaning else []
    lines.append(f"{pou.kind} {pou.name}{f' : {pou.returns}' if pou.returns else ''}")
    for section in SECTIONS:
        declared = pou.declared(section)
        if declared:
            lines += [section, *(f"{INDENT}{line}" for line in _declarations(declared)), "END_VAR"]
    return "\n".join([*lines, ""])


def _declarations(variables: Iterable[Variable]) -> list[str]:
    lines = []
    for variable in variables:
        initial = f" := {variable.initial}" if variable.initial else ""
        meaning = f" (* {commented(variable.meaning)} *)" if variable.meaning else ""
        lines.append(f"{variable.name} : {variable.type}{initial};{meaning}")
    return lines
