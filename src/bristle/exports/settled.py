"""What is settled when a source is written: a choice, and whatever parameters that stay decide, is made here.

A kernel serves every kind of a model, and asks its parameters which one this is, again and again in every step. Where
the answer is known the question is left out, with all that stands behind the other answers: a function is written for
what it is called with. Only whole numbers and truths are put in; numbers stay with the parameters, and so do the bits.
"""

from __future__ import annotations

import math
import struct
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from bristle.exports.expressions import COMPUTED
from bristle.exports.prune import pruned
from bristle.exports.tree import (
    Assign,
    Binary,
    Call,
    Compare,
    Constant,
    Convert,
    Evaluate,
    Expression,
    Field,
    For,
    Function,
    If,
    Index,
    Intrinsic,
    Logic,
    Make,
    Negative,
    Not,
    Return,
    Select,
    Statement,
    Store,
    Unit,
    Variable,
    While,
    walk,
)
from bristle.exports.types import INTEGER, REAL, TRUTH, Struct, Type

__all__ = ["Fact", "fact_of", "settled"]

Fact = Any
"""What is known of a value: None for nothing, a tuple for that of each field, a whole number, a real one as text."""
COMPARED: dict[str, Callable[[Any, Any], bool]] = {
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b,
    "!=": lambda a, b: a != b,
}
OF_REALS: dict[str, Callable[[float, float], float]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
}
EXACT: dict[str, Callable[..., Any]] = {
    "sqrt": math.sqrt,
    "copysign": math.copysign,
    "abs": abs,
    "floor": math.floor,
    "isinf": math.isinf,
    "isnan": math.isnan,
    "min": lambda a, b: b if b < a else a,
    "max": lambda a, b: b if b > a else a,
}


def fact_of(value: Any, kind: Type, unknown: Iterable[tuple[str, ...]] = (), path: tuple[str, ...] = ()) -> Fact:
    """Return what is known of a value that a component has, but for what stands at some paths; arrays are not known."""
    if path in unknown:
        return None
    if isinstance(kind, Struct):
        fields = zip(kind.fields, value, strict=True)
        return _of_fields(fact_of(part, inner, unknown, (*path, name)) for (name, inner), part in fields)
    if kind == REAL:
        return float(value).hex()
    return int(value) if kind in (INTEGER, TRUTH) else None


def settled(unit: Unit, roots: Sequence[Function], facts: Mapping[str, Fact], *, single: bool = False) -> tuple[Unit, list[Function]]:
    """Return a unit, and its roots, for arguments of which something is known.

    Parameters
    ----------
    unit : Unit
        The functions; they stay as they are.
    roots : sequence of Function
        Those that are called from outside.
    facts : mapping
        For the name of an argument of a root what is known of it.
    single : bool
        Whether numbers are of single precision, where a comparison may come out otherwise.
    """
    settling = _Settling(single=single)
    if single:
        facts = {name: _narrowed(fact) for name, fact in facts.items()}
    written = [settling.function(root, [facts.get(p.name) for p in root.parameters])[0] for root in roots]
    names: set[str] = set()
    left = pruned(Unit(settling.functions), written)
    for function in left.functions:
        name, count = function.name, 1
        while name in names:
            count += 1
            name = f"{function.name}_{count}"
        function.name = name
        names.add(name)
    return left, written


class _Settling:
    def __init__(self, *, single: bool) -> None:
        self.single = single
        self.functions: list[Function] = []
        self._written: dict[tuple[int, tuple[Fact, ...]], tuple[Function, Fact]] = {}
        self._variants: dict[int, list[Function]] = {}  # of one kernel, by any of its functions

    def function(self, function: Function, fact: Sequence[Fact]) -> tuple[Function, Fact]:
        """Return a function for what is known of its arguments, and what is known of its result."""
        key = (id(function), tuple(fact))
        if key not in self._written:
            body = _Body(self, function, fact)
            statements = body.settled()
            variants = self._variants.setdefault(id(function), [])
            written = next((variant for variant in variants if variant.body == statements), None)
            if written is None:
                written = replace(function, body=statements, parameters=list(function.parameters))
                self._variants[id(written)] = variants
                variants.append(written)
                self.functions.append(written)
            self._written[key] = written, body.result
        return self._written[key]


class _Body:
    """Settles the body of one function."""

    def __init__(self, settling: _Settling, function: Function, fact: Sequence[Fact]) -> None:
        self.settling, self.function = settling, function
        self._arguments = dict(zip([p.name for p in function.parameters], fact, strict=True))
        self._facts: dict[str, Fact] = {}
        self._values: Counter[str] = Counter()
        self._results: list[Fact] = []

    @property
    def result(self) -> Fact:
        """What is known of the result."""
        common, *further = self._results or [None]
        for result in further:
            common = _common(common, result)
        return common

    def settled(self) -> list[Statement]:
        """Return the statements that are left."""
        body, size, before = self.function.body, 0, -1
        while size != before:
            before = size
            self._values = Counter(part.variable.name for part in walk(body) if isinstance(part, (Assign, For)))
            self._facts = {name: fact for name, fact in self._arguments.items() if name not in self._values}
            self._results = []
            body = self._block(body)
            size = sum(1 for _ in walk(body))
        return body

    # --- statements -----------------------------------------------------------------------------------------------

    def _block(self, block: list[Statement]) -> list[Statement]:
        left: list[Statement] = []
        for statement in block:
            left += self._statement(statement)
            if left and isinstance(left[-1], Return):
                break
        return left

    def _statement(self, s: Statement) -> list[Statement]:
        if isinstance(s, Assign):
            value, fact = self._of(s.value)
            if self._values[s.variable.name] == 1:
                self._facts[s.variable.name] = fact
            return [Assign(s.variable, value)]
        if isinstance(s, Store):
            return [Store(self._of(s.array)[0], self._of(s.at)[0], self._of(s.value)[0])]
        if isinstance(s, Evaluate):
            return [Evaluate(self._of(s.call)[0])]
        if isinstance(s, Return):
            if s.value is None:
                return [s]
            value, fact = self._of(s.value)
            self._results.append(fact)
            return [Return(value)]
        if isinstance(s, For):
            return [For(s.variable, self._of(s.start)[0], self._of(s.stop)[0], self._block(s.body))]
        if isinstance(s, (If, While)):
            return self._asking(s)
        return [s]

    def _asking(self, s: If | While) -> list[Statement]:
        test, fact = self._of(s.test)
        if isinstance(s, While):
            return [] if fact is not None and not fact else [While(test, self._block(s.body))]
        if fact is None:
            return [If(test, self._block(s.body), self._block(s.otherwise))]
        return self._block(s.body if fact else s.otherwise)

    # --- expressions ----------------------------------------------------------------------------------------------

    def _of(self, e: Expression) -> tuple[Expression, Fact]:
        """Return an expression that is left, and what is known of it."""
        left, fact = getattr(self, f"_{type(e).__name__.lower()}")(e)
        if fact is None or e.type not in (INTEGER, TRUTH) or isinstance(left, Constant):
            return left, fact
        if _writes(left):
            return left, fact
        return Constant(e.type, bool(fact) if e.type == TRUTH else int(fact)), fact

    def _constant(self, e: Constant) -> tuple[Expression, Fact]:
        return e, self._written(e.type, e.value)

    def _variable(self, e: Variable) -> tuple[Expression, Fact]:
        return e, self._facts.get(e.name)

    def _field(self, e: Field) -> tuple[Expression, Fact]:
        of, fact = self._of(e.of)
        assert isinstance(e.of.type, Struct)
        return Field(e.type, of, e.name), None if fact is None else fact[e.of.type.place(e.name)]

    def _index(self, e: Index) -> tuple[Expression, Fact]:
        return Index(e.type, self._of(e.array)[0], self._of(e.at)[0]), None

    def _negative(self, e: Negative) -> tuple[Expression, Fact]:
        of, fact = self._of(e.of)
        return Negative(e.type, of), self._computed(e.type, lambda value: -value, [e.of.type], [fact])

    def _not(self, e: Not) -> tuple[Expression, Fact]:
        of, fact = self._of(e.of)
        return Not(e.type, of), None if fact is None else int(not fact)

    def _binary(self, e: Binary) -> tuple[Expression, Fact]:
        sides = [self._of(e.left), self._of(e.right)]
        by = (OF_REALS if e.type == REAL else COMPUTED)[e.operator]
        fact = self._computed(e.type, by, [e.left.type, e.right.type], [side[1] for side in sides])
        return Binary(e.type, e.operator, sides[0][0], sides[1][0]), fact

    def _compare(self, e: Compare) -> tuple[Expression, Fact]:
        sides, by = [self._of(e.left), self._of(e.right)], COMPARED[e.operator]
        fact = self._computed(e.type, by, [e.left.type, e.right.type], [side[1] for side in sides])
        return Compare(e.type, e.operator, sides[0][0], sides[1][0]), fact

    def _logic(self, e: Logic) -> tuple[Expression, Fact]:
        ending = e.operator == "or"
        parts: list[Expression] = []
        for part in e.parts:
            left, fact = self._of(part)
            if fact is None:
                parts.append(left)
            elif bool(fact) == ending:
                # What comes later is not looked at; what came before decides nothing, and writes nothing.
                return Constant(TRUTH, ending), int(ending)
        if not parts:
            return Constant(TRUTH, not ending), int(not ending)
        return (parts[0] if len(parts) == 1 else Logic(e.type, e.operator, parts)), None

    def _select(self, e: Select) -> tuple[Expression, Fact]:
        test, fact = self._of(e.test)
        if fact is not None:
            return self._of(e.first if fact else e.second)
        first, second = self._of(e.first), self._of(e.second)
        return Select(e.type, test, first[0], second[0]), _common(first[1], second[1])

    def _convert(self, e: Convert) -> tuple[Expression, Fact]:
        of, fact = self._of(e.of)
        to = {REAL: float, INTEGER: int, TRUTH: bool}[e.type]  # type: ignore[index]
        return Convert(e.type, of), self._computed(e.type, to, [e.of.type], [fact])

    def _call(self, e: Call) -> tuple[Expression, Fact]:
        arguments = [self._of(argument) for argument in e.arguments]
        function, fact = self.settling.function(e.function, [argument[1] for argument in arguments])
        number = _only_constant(function)
        if number is not None and not any(_writes(argument[0]) for argument in arguments):
            return number, fact
        return Call(e.type, function, [argument[0] for argument in arguments]), fact

    def _intrinsic(self, e: Intrinsic) -> tuple[Expression, Fact]:
        arguments = [self._of(argument) for argument in e.arguments]
        fact = None
        if e.name in EXACT:
            kinds = [argument.type for argument in e.arguments]
            fact = self._computed(e.type, EXACT[e.name], kinds, [argument[1] for argument in arguments])
        return Intrinsic(e.type, e.name, [argument[0] for argument in arguments]), fact

    def _make(self, e: Make) -> tuple[Expression, Fact]:
        parts = [self._of(part) for part in e.parts]
        return Make(e.type, [part[0] for part in parts]), _of_fields(part[1] for part in parts)

    # --- numbers --------------------------------------------------------------------------------------------------

    def _written(self, kind: Type, value: Any) -> Fact:
        if kind != REAL:
            return int(value)
        return _narrowed(float(value).hex()) if self.settling.single else float(value).hex()

    def _computed(self, kind: Type, by: Callable[..., Any], kinds: Sequence[Type], fact: Sequence[Fact]) -> Fact:
        """Return what an operation gives that every target rounds alike; nothing where Python raises."""
        if any(value is None for value in fact):
            return None
        values = [float.fromhex(value) if of == REAL else value for of, value in zip(kinds, fact, strict=True)]
        try:
            return self._written(kind, by(*values))
        except (ArithmeticError, ValueError):
            return None


def _only_constant(function: Function) -> Constant | None:
    """Return the number that a function gives whatever it is called with; None where it does anything else."""
    match function.body:
        case [Return(Constant() as number)]:
            return number
    return None


def _writes(e: Expression) -> bool:
    return any(isinstance(part, Call) and part.function.writes for part in walk(e))


def _narrowed(fact: Fact) -> Fact:
    """Return what is known of a value in single precision."""
    if isinstance(fact, tuple):
        return tuple(_narrowed(field) for field in fact)
    if not isinstance(fact, str):
        return fact
    value = float.fromhex(fact)
    try:
        return float(struct.unpack("f", struct.pack("f", value))[0]).hex()
    except OverflowError:
        return math.copysign(math.inf, value).hex()


def _of_fields(fields: Iterable[Fact]) -> Fact:
    """Return what is known of the fields of a tuple."""
    fact = tuple(fields)
    return fact if any(field is not None for field in fact) else None


def _common(first: Fact, second: Fact) -> Fact:
    """Return what is known of a value that is one of two."""
    if isinstance(first, tuple) and isinstance(second, tuple):
        return _of_fields(_common(left, right) for left, right in zip(first, second, strict=True))
    return first if first == second and type(first) is type(second) else None
