"""Common parts of the printers of the tree: lines, elements of XML, types in use, and bounds of loops."""

from collections.abc import Iterable
from xml.etree import ElementTree

from bristle.engine.translation.tree import (
    INTEGER,
    Binary,
    Constant,
    Expression,
    For,
    Function,
    Struct,
    Type,
    Unit,
    While,
    walk,
)

INDENT = "    "
LONGEST = 110
PRIMARY = 16  # precedence of a name
UNARY = 14  # precedence of a sign
BREAKS = (", ", " + ", " - ", " * ", " && ", " || ", " ? ", " : ")


def needs_wide_integers(unit: Unit) -> bool:
    """Return whether whole numbers of a unit exceed 32 bits, as those of the random numbers do."""
    return any(
        (isinstance(part, Constant) and part.type == INTEGER and abs(part.value) >= 2**31)
        or (isinstance(part, Binary) and part.operator in ("&", "^", ">>"))
        for part in walk(*[function.body for function in unit.functions])
    )


def structures_of(types: Iterable[Type]) -> list[Struct]:
    """Return the tuples among some types and inside them, each after its inner tuples."""
    structures: dict[Struct, None] = {}

    def add(kind: Type) -> None:
        if isinstance(kind, Struct) and kind not in structures:
            for _, part in kind.fields:
                add(part)
            structures[kind] = None

    for kind in types:
        add(kind)
    return list(structures)


def types_in(function: Function) -> list[Type]:
    """Return the types of a function, its arguments and its expressions."""
    inside = [part.type for part in walk(function.body) if isinstance(part, Expression)]
    return [function.result, *(parameter.type for parameter in function.parameters), *inside]


def described(text: str) -> str:
    """Return the first line of a docstring as a comment of C: in ASCII, without markup."""
    plain = text.replace(":math:", "").replace("`", "").replace("*/", "")
    return plain.encode("ascii", "replace").decode()


def wrapped(line: str, indent: str) -> list[str]:
    """Return a long line as several lines, broken after commas and before operators."""
    lines: list[str] = []
    while len(line) > LONGEST:
        at = max(line.rfind(mark, len(indent) + 40, LONGEST) for mark in BREAKS)
        if at < 0:
            break
        cut = at
        if line[at] == ",":
            cut = at + 1
        lines.append(line[:cut])
        line = f"{indent}{INDENT}{INDENT}{line[cut:].lstrip()}"
    return [*lines, line]


def element(
    tag: str, /, *inside: ElementTree.Element | str, **attributes: str
) -> ElementTree.Element:
    """Return an element of XML with text or inner elements."""
    made = ElementTree.Element(tag, attributes)
    made.text = "".join(part for part in inside if isinstance(part, str))
    made.extend(part for part in inside if not isinstance(part, str))
    return made


def loops_of(unit: Unit, memory_size: int) -> list[dict[str, str]]:
    """Return the loops of the functions of a model or a law: function, purpose, and largest number of rounds in words."""
    loops = []
    for function in unit.functions:
        for loop in walk(function.body):
            if isinstance(loop, While):
                most = f"{(memory_size // 4).bit_length()}, which halve the stored turning points"
            elif not isinstance(loop, For):
                continue
            elif isinstance(loop.start, Constant) and isinstance(loop.stop, Constant):
                most = str(int(loop.stop.value) - int(loop.start.value))
            else:
                most = "the number in its argument"
            loops.append(
                {
                    "function": function.name,
                    "description": described(function.description),
                    "most": most,
                }
            )
    return loops
