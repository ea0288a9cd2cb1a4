"""What can be changed in a line: one small fault at a time, as text, so that everything else stays as it is."""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

__all__ = ["Mutant", "applied", "chosen", "mutants_of"]

FLIPPED = {
    "<": ">",
    ">": "<",
    "<=": ">=",
    ">=": "<=",
    "==": "!=",
    "!=": "==",
    "is not": "is",
    "is": "is not",
    "not in": "in",
    "in": "not in",
}
SYMBOLS = {
    ast.Lt: "<",
    ast.Gt: ">",
    ast.LtE: "<=",
    ast.GtE: ">=",
    ast.Eq: "==",
    ast.NotEq: "!=",
    ast.Is: "is",
    ast.IsNot: "is not",
    ast.In: "in",
    ast.NotIn: "not in",
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.And: "and",
    ast.Or: "or",
}
SWAPPED = {"+": "-", "-": "+", "*": "/", "/": "*", "and": "or", "or": "and"}
OTHER_END = {"min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum"}
SETTLED_BY_A_FLIP = (ast.Eq, ast.NotEq, ast.Is, ast.IsNot, ast.In, ast.NotIn)


@dataclass(frozen=True, order=True)
class Mutant:
    """One fault: bytes `begin` to `end` of a file give way to others."""

    path: str
    line: int
    begin: int
    end: int
    kind: str
    old: str
    new: str

    @property
    def room(self) -> str:
        """The room or the app that it is in."""
        parts = Path(self.path).parts[2:]
        return "/".join(parts[:2]) if parts[0] == "apps" else parts[0]

    def key(self, source: bytes) -> str:
        """Return what tells it from all others, wherever lines above it move it."""
        text = "\n".join(
            (
                self.path,
                whole_line(source, self.begin),
                str(self.begin - start_of(source, self.begin)),
            )
        )
        nth = source[: self.begin].count(whole_line(source, self.begin).encode())
        return hashlib.sha256(
            f"{text}\n{nth}\n{self.kind}\n{self.old}\n{self.new}".encode()
        ).hexdigest()[:16]


def start_of(source: bytes, at: int) -> int:
    """Return where the line begins that holds this byte."""
    return source.rfind(b"\n", 0, at) + 1


def whole_line(source: bytes, at: int) -> str:
    """Return the line that holds this byte."""
    return source[start_of(source, at) :].partition(b"\n")[0].decode()


def applied(mutant: Mutant, source: bytes) -> bytes:
    """Return a source with the fault in it."""
    return source[: mutant.begin] + mutant.new.encode() + source[mutant.end :]


def mutants_of(path: str, source: bytes) -> list[Mutant]:
    """Return every fault that can be put into a file of the package.

    Left alone are texts, `raise`, annotations, imports, decorators, `__all__` and what only a type checker reads.
    """
    return sorted(
        Mutant(
            path,
            source.count(b"\n", 0, begin) + 1,
            begin,
            end,
            kind,
            source[begin:end].decode(),
            new,
        )
        for kind, begin, end, new in _Places(source).visit_all(ast.parse(source))
    )


def chosen(sources: dict[str, bytes], count: int, seed: int, left_out: set[str]) -> list[Mutant]:
    """Return a sample of lines with one fault in each.

    Which lines and faults these are depends on the seed and on what stands in them, so that a larger sample holds a
    smaller one, and a change elsewhere changes neither. `left_out` are keys of mutants that are no faults.
    """

    def lot(text: str) -> str:
        return hashlib.sha256(f"{seed}\n{text}".encode()).hexdigest()

    lines: dict[tuple[str, int], list[tuple[str, Mutant]]] = {}
    for path, source in sources.items():
        for mutant in mutants_of(path, source):
            if (key := mutant.key(source)) not in left_out:
                lines.setdefault((path, mutant.line), []).append((key, mutant))
    drawn = []
    for among in lines.values():
        kind = min(
            {item.kind for _, item in among}, key=lambda kind, among=among: lot(kind + among[0][0])
        )
        drawn.append(min((lot(key), item) for key, item in among if item.kind == kind))
    return [item for _, item in sorted(drawn)[:count]]


# What is done, first byte, byte after the last one, what comes there.
Place = tuple[str, int, int, str]


class _Places:
    """Walks a syntax tree and says where which fault fits."""

    def __init__(self, source: bytes) -> None:
        self.source = source
        self.starts = [0]
        for line in source.splitlines(keepends=True):
            self.starts.append(self.starts[-1] + len(line))

    def begin(self, node: ast.AST) -> int:
        return self.starts[node.lineno - 1] + node.col_offset

    def end(self, node: ast.AST) -> int:
        return self.starts[node.end_lineno - 1] + node.end_col_offset

    def text(self, node: ast.AST) -> str:
        return self.source[self.begin(node) : self.end(node)].decode()

    def visit_all(self, node: ast.AST, known: frozenset[str] = frozenset()) -> Iterator[Place]:
        """Yield the places in a node; `known` are the names bound before it in its function."""
        if _only_typed(node):
            return
        yield from self.in_node(node, known)
        if isinstance(node, ast.FunctionDef | ast.Lambda):
            arguments = node.args
            known = frozenset(
                item.arg
                for item in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)
            )
        for child in _children(node):
            yield from self.visit_all(child, known)
            if isinstance(child, ast.stmt):
                bound = (
                    item
                    for item in ast.walk(child)
                    if isinstance(item, ast.Name) and isinstance(item.ctx, ast.Store)
                )
                known |= {item.id for item in bound}

    def in_node(self, node: ast.AST, known: frozenset[str]) -> Iterator[Place]:
        match node:
            case ast.Compare():
                for (left, right), operator in zip(
                    pairwise((node.left, *node.comparators)), node.ops, strict=True
                ):
                    yield from self.between(
                        "comparison", left, right, SYMBOLS[type(operator)], FLIPPED
                    )
            case ast.BinOp(op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div()):
                yield from self.between(
                    "arithmetic", node.left, node.right, SYMBOLS[type(node.op)], SWAPPED
                )
            case ast.AugAssign(op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div()):
                yield from self.between(
                    "arithmetic", node.target, node.value, SYMBOLS[type(node.op)], SWAPPED
                )
            case ast.BoolOp():
                for left, right in pairwise(node.values):
                    yield from self.between("and/or", left, right, SYMBOLS[type(node.op)], SWAPPED)
            case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name)) if name in OTHER_END:
                yield (
                    "min/max",
                    self.end(node.func) - len(name),
                    self.end(node.func),
                    OTHER_END[name],
                )
            case ast.Constant(value=bool() | int() | float()):
                for new in _other_numbers(node.value):
                    yield "constant", self.begin(node), self.end(node), new
            case ast.Return(value=ast.expr()) if not isinstance(
                node.value, ast.Constant | ast.JoinedStr
            ):
                yield "return", self.begin(node.value), self.end(node.value), "None"
        yield from self.negated(node)
        if _can_go(node, known):
            yield "statement", self.begin(node), self.end(node), "pass"

    def between(
        self, kind: str, left: ast.expr, right: ast.expr, symbol: str, other: dict[str, str]
    ) -> Iterator[Place]:
        at = self.source.find(symbol.encode(), self.end(left), self.begin(right))
        if at >= 0:
            yield kind, at, at + len(symbol), other[symbol]

    def negated(self, node: ast.AST) -> Iterator[Place]:
        tests = (
            node.ifs if isinstance(node, ast.comprehension) else [node.test] if _asks(node) else []
        )
        for test in tests:
            if not (isinstance(test, ast.Compare) and isinstance(test.ops[0], SETTLED_BY_A_FLIP)):
                yield "condition", self.begin(test), self.end(test), f"(not ({self.text(test)}))"


def _asks(node: ast.AST) -> bool:
    return isinstance(node, ast.If | ast.IfExp)


def _only_typed(node: ast.AST) -> bool:
    return (
        isinstance(node, ast.If)
        and isinstance(node.test, ast.Name)
        and node.test.id == "TYPE_CHECKING"
    )


def _other_numbers(value: float) -> list[str]:
    if isinstance(value, bool):
        return [str(not value)]
    zero = 0 if isinstance(value, int) else 0.0
    return sorted({repr(item) for item in (2 * value, zero, value + 1, value - 1)} - {repr(value)})


def _can_go(node: ast.AST, known: frozenset[str]) -> bool:
    """Return whether a statement can be left out without a name that is missing later."""
    match node:
        case ast.AugAssign() | ast.Expr(value=ast.Call()):
            return True
        case ast.Assign(targets=[ast.Attribute() | ast.Subscript()]):
            return True
        case ast.Assign(targets=[ast.Name(id=name)]):
            return name in known
    return False


def _children(node: ast.AST) -> list[ast.AST]:
    """Return what is walked on to: code that runs, without texts, annotations and declarations."""
    match node:
        case ast.Raise() | ast.Import() | ast.ImportFrom() | ast.JoinedStr() | ast.Assert():
            return []
        case ast.Assign(targets=[ast.Name(id="__all__")]):
            return []
        case ast.AnnAssign():
            return [node.value] if node.value else []
        # strict=True asserts what the lines above have made equal
        case ast.Call(func=ast.Name(id="zip")):
            return list(node.args)
        case ast.FunctionDef():
            return [
                *node.args.defaults,
                *(kw_default for kw_default in node.args.kw_defaults if kw_default),
                *node.body,
            ]
        case ast.ClassDef():
            return list(node.body)
        case ast.Lambda():
            return [*node.args.defaults, node.body]
    return list(ast.iter_child_nodes(node))
