"""Constant folding of an export: resolves branches that fixed parameters decide.

A kernel serves all variants of a model and tests its parameters in every step. If the result of a test is known, the
export omits the test and the other branches: each function is specialized for its arguments. Only whole numbers and
truths are folded; real numbers stay with the parameters, so that the results do not change in any bit.
"""

import math
import operator
import struct
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import reduce
from typing import Any

from bristle.engine.translation import tree
from bristle.engine.translation.expressions import COMPUTED
from bristle.engine.translation.scope import free_name

Fact = Any  # Known value: None if unknown, a tuple for the fields of a tuple, a whole number, or text for a real number
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


def fact_of(
    value: Any, kind: tree.Type, unknown: Iterable[tuple[str, ...]] = (), path: tuple[str, ...] = ()
) -> Fact:
    """Return the fact of a value of a component; arrays and the values at some paths are unknown."""
    if path in unknown:
        return None
    if isinstance(kind, tree.Struct):
        fields = zip(kind.fields, value, strict=True)
        return _of_fields(
            fact_of(part, inner, unknown, (*path, name)) for (name, inner), part in fields
        )
    if kind == tree.REAL:
        return float(value).hex()
    if kind in (tree.INTEGER, tree.TRUTH):
        return int(value)
    return None


def settled(
    unit: tree.Unit,
    roots: Sequence[tree.Function],
    facts: Mapping[str, Fact],
    *,
    single: bool = False,
) -> tuple[tree.Unit, list[tree.Function]]:
    """Return a unit and its roots, specialized for partly known arguments.

    Parameters
    ----------
    unit : Unit
        The functions; they are not changed.
    roots : sequence of Function
        The functions with callers outside the unit.
    facts : mapping
        Facts of arguments of the roots, by name.
    single : bool
        Whether numbers are of single precision, which can change the result of a comparison.
    """
    settling = _Settling(single=single)
    if single:
        facts = {name: _narrowed(fact) for name, fact in facts.items()}
    written = [
        settling.function(root, [facts.get(p.name) for p in root.parameters])[0] for root in roots
    ]
    names: set[str] = set()
    left = pruned(tree.Unit(settling.functions), written)
    for function in left.functions:
        function.name = free_name(function.name, names)
        names.add(function.name)
    return left, written


class _Settling:
    def __init__(self, *, single: bool) -> None:
        self.single = single
        self.functions: list[tree.Function] = []
        self._written: dict[tuple[int, tuple[Fact, ...]], tuple[tree.Function, Fact]] = {}
        self._variants: dict[
            int, list[tree.Function]
        ] = {}  # of one kernel, by any of its functions

    def function(self, function: tree.Function, fact: Sequence[Fact]) -> tuple[tree.Function, Fact]:
        """Return a function, specialized for the facts of its arguments, and the fact of its result."""
        key = (id(function), tuple(fact))
        if key not in self._written:
            statements, result = _Body(self, function, fact).settled()
            variants = self._variants.setdefault(id(function), [])
            written = next((variant for variant in variants if variant.body == statements), None)
            if written is None:
                written = replace(function, body=statements, parameters=list(function.parameters))
                self._variants[id(written)] = variants
                variants.append(written)
                self.functions.append(written)
            self._written[key] = written, result
        return self._written[key]


class _Body:
    """Specializes the body of one function."""

    def __init__(self, settling: _Settling, function: tree.Function, fact: Sequence[Fact]) -> None:
        self.settling = settling
        self.function = function
        self._arguments = dict(zip([p.name for p in function.parameters], fact, strict=True))
        self._facts: dict[str, Fact] = {}
        self._values: Counter[str] = Counter()
        self._results: list[Fact] = []

    def settled(self) -> tuple[list[tree.Statement], Fact]:
        """Return the remaining statements, and the fact of the result."""
        body = self.function.body
        size = 0
        before = -1
        while size != before:
            before = size
            self._values = Counter(
                part.variable.name
                for part in tree.walk(body)
                if isinstance(part, (tree.Assign, tree.For))
            )
            self._facts = {
                name: fact for name, fact in self._arguments.items() if name not in self._values
            }
            self._results = []
            body = self._block(body)
            size = sum(1 for _ in tree.walk(body))
        if self._results:
            return body, reduce(_common, self._results)
        return body, None

    def _block(self, block: list[tree.Statement]) -> list[tree.Statement]:
        left: list[tree.Statement] = []
        for statement in block:
            left += self._statement(statement)
            if left and isinstance(left[-1], tree.Return):
                break
        return left

    def _statement(self, s: tree.Statement) -> list[tree.Statement]:
        if isinstance(s, tree.Assign):
            value, fact = self._of(s.value)
            if self._values[s.variable.name] == 1:
                self._facts[s.variable.name] = fact
            return [tree.Assign(s.variable, value)]
        if isinstance(s, tree.Return) and s.value is not None:
            value, fact = self._of(s.value)
            self._results.append(fact)
            return [tree.Return(value)]
        if isinstance(s, tree.For):
            return [
                tree.For(s.variable, self._of(s.start)[0], self._of(s.stop)[0], self._block(s.body))
            ]
        if isinstance(s, (tree.If, tree.While)):
            return self._asking(s)
        parts = {
            name: self._of(part)[0]
            for name, part in vars(s).items()
            if isinstance(part, tree.Expression)
        }
        if parts:
            s = replace(s, **parts)
        return [s]

    def _asking(self, s: tree.If | tree.While) -> list[tree.Statement]:
        test, fact = self._of(s.test)
        if isinstance(s, tree.While):
            if fact is not None and not fact:
                return []
            return [tree.While(test, self._block(s.body))]
        if fact is None:
            return [tree.If(test, self._block(s.body), self._block(s.otherwise))]
        if fact:
            return self._block(s.body)
        return self._block(s.otherwise)

    def _of(self, e: tree.Expression) -> tuple[tree.Expression, Fact]:
        """Return the remaining expression and its fact."""
        own = getattr(self, f"_{type(e).__name__.lower()}", self._computed)
        left, fact = own(e)
        if (
            fact is None
            or e.type not in (tree.INTEGER, tree.TRUTH)
            or isinstance(left, tree.Constant)
            or _writes(left)
        ):
            return left, fact
        if e.type == tree.TRUTH:
            return tree.Constant(e.type, bool(fact)), fact
        return tree.Constant(e.type, int(fact)), fact

    def _constant(self, e: tree.Constant) -> tuple[tree.Expression, Fact]:
        return e, self._written(e.type, e.value)

    def _variable(self, e: tree.Variable) -> tuple[tree.Expression, Fact]:
        return e, self._facts.get(e.name)

    def _logic(self, e: tree.Logic) -> tuple[tree.Expression, Fact]:
        ending = e.operator == "or"
        parts: list[tree.Expression] = []
        for part in e.parts:
            left, fact = self._of(part)
            if fact is None:
                parts.append(left)
            elif bool(fact) == ending:
                # Later parts are not evaluated; earlier parts have no influence and no side effect.
                return tree.Constant(tree.TRUTH, ending), int(ending)
        if not parts:
            return tree.Constant(tree.TRUTH, not ending), int(not ending)
        if len(parts) == 1:
            return parts[0], None
        return tree.Logic(e.type, e.operator, parts), None

    def _select(self, e: tree.Select) -> tuple[tree.Expression, Fact]:
        test, fact = self._of(e.test)
        if fact:
            return self._of(e.first)
        if fact is not None:
            return self._of(e.second)
        first = self._of(e.first)
        second = self._of(e.second)
        return tree.Select(e.type, test, first[0], second[0]), _common(first[1], second[1])

    def _call(self, e: tree.Call) -> tuple[tree.Expression, Fact]:
        arguments = [self._of(argument) for argument in e.arguments]
        function, fact = self.settling.function(e.function, [argument[1] for argument in arguments])
        match function.body:
            case [tree.Return(tree.Constant() as number)] if not any(
                _writes(argument[0]) for argument in arguments
            ):
                return number, fact
        return tree.Call(e.type, function, [argument[0] for argument in arguments]), fact

    def _written(self, kind: tree.Type, value: Any) -> Fact:
        if kind != tree.REAL:
            return int(value)
        if self.settling.single:
            return _narrowed(float(value).hex())
        return float(value).hex()

    def _computed(self, e: tree.Expression) -> tuple[tree.Expression, Fact]:
        """Return an expression of its remaining parts, and its fact if all targets compute the same; unknown if Python raises."""
        left: dict[str, Any] = {}
        kinds = []
        facts = []
        for name, part in vars(e).items():
            if isinstance(part, tree.Expression):
                left[name], fact = self._of(part)
                kinds.append(part.type)
                facts.append(fact)
            elif isinstance(part, list):
                pairs = [self._of(child) for child in part]
                left[name] = [pair[0] for pair in pairs]
                kinds += [child.type for child in part]
                facts += [pair[1] for pair in pairs]
        return replace(e, **left), self._fact(e, kinds, facts)

    def _fact(self, e: tree.Expression, kinds: Sequence[tree.Type], facts: Sequence[Fact]) -> Fact:
        if isinstance(e, tree.Make):
            return _of_fields(facts)
        if isinstance(e, tree.Index) or any(fact is None for fact in facts):
            return None
        if isinstance(e, tree.Field):
            assert isinstance(e.of.type, tree.Struct)
            return facts[0][e.of.type.place(e.name)]
        if isinstance(e, (tree.Binary, tree.Compare)):
            by: Callable[..., Any] | None = COMPUTED[e.operator]
        elif isinstance(e, tree.Intrinsic):
            by = EXACT.get(e.name)
        elif isinstance(e, tree.Convert):
            by = {tree.REAL: float, tree.INTEGER: int, tree.TRUTH: bool}[e.type]  # type: ignore[index]
        else:
            by = operator.not_
            if isinstance(e, tree.Negative):
                by = operator.neg
        values = [
            float.fromhex(value) if kind == tree.REAL else value
            for kind, value in zip(kinds, facts, strict=True)
        ]
        try:
            return by and self._written(e.type, by(*values))
        except (ArithmeticError, ValueError):
            return None


def _writes(e: tree.Expression) -> bool:
    return any(isinstance(part, tree.Call) and part.function.writes for part in tree.walk(e))


def _narrowed(fact: Fact) -> Fact:
    """Return the fact of a value in single precision."""
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
    """Return the fact of a tuple from those of its fields."""
    fact = tuple(fields)
    if any(field is not None for field in fact):
        return fact
    return None


def _common(first: Fact, second: Fact) -> Fact:
    """Return the common fact of two possible values."""
    if isinstance(first, tuple) and isinstance(second, tuple):
        return _of_fields(_common(left, right) for left, right in zip(first, second, strict=True))
    if first == second and type(first) is type(second):
        return first
    return None


def pruned(unit: tree.Unit, roots: Iterable[tree.Function]) -> tree.Unit:
    """Return a unit with the functions and arguments that the roots need, changed in place: callers pass the remaining arguments."""
    entries = list(roots)
    while True:
        parts: dict[int, list[tree.Node]] = {}  # of the body of each function that is needed
        waiting = list(entries)
        while waiting:
            function = waiting.pop()
            if id(function) not in parts:
                parts[id(function)] = list(tree.walk(function.body))
                waiting += [
                    part.function for part in parts[id(function)] if isinstance(part, tree.Call)
                ]
        functions = [function for function in unit.functions if id(function) in parts]
        dead = False
        for function in functions:
            dropped: list[tree.Statement] = []
            function.body = _live(
                function.body, {part.name for part in _read(parts[id(function)])}, dropped
            )
            if dropped:
                dead = True
                parts[id(function)] = list(tree.walk(function.body))
        if (
            not _without_arguments(functions, [parts[id(function)] for function in functions])
            and not dead
        ):
            return tree.Unit(functions)


def _read(parts: list[tree.Node]) -> list[tree.Variable]:
    """Return the variables that parts of a tree read; assignments do not count."""
    assigned = {id(part.variable) for part in parts if isinstance(part, (tree.Assign, tree.For))}
    return [part for part in parts if isinstance(part, tree.Variable) and id(part) not in assigned]


def _live(
    block: list[tree.Statement], read: set[str], dropped: list[tree.Statement]
) -> list[tree.Statement]:
    entries: list[tree.Statement] = []
    for statement in block:
        if isinstance(statement, tree.Assign) and statement.variable.name not in read:
            dropped.append(statement)
            if isinstance(statement.value, tree.Call) and statement.value.function.writes:
                entries.append(tree.Evaluate(statement.value))
            continue
        if isinstance(statement, tree.If):
            statement.body = _live(statement.body, read, dropped)
            statement.otherwise = _live(statement.otherwise, read, dropped)
            if not statement.body and not statement.otherwise:
                dropped.append(statement)
                continue
        elif isinstance(statement, (tree.For, tree.While)):
            statement.body = _live(statement.body, read, dropped)
        entries.append(statement)
    return entries


def _without_arguments(functions: list[tree.Function], parts: list[list[tree.Node]]) -> bool:
    """Remove arguments that no body reads; return whether there were any."""
    used: dict[int, set[str]] = {id(function): set() for function in functions}
    calls = [[part for part in body if isinstance(part, tree.Call)] for body in parts]
    read = [_read(body) for body in parts]
    news = True
    while news:  # arguments that are read, given the read arguments of the called functions
        news = False
        for function, called, variables in zip(functions, calls, read, strict=True):
            idle = {
                id(argument)
                for call in called
                for parameter, argument in zip(
                    call.function.parameters, call.arguments, strict=True
                )
                if isinstance(argument, tree.Variable)
                and parameter.name not in used[id(call.function)]
            }
            looked_at = {part.name for part in variables if id(part) not in idle}
            fresh = {parameter.name for parameter in function.parameters} & looked_at - used[
                id(function)
            ]
            used[id(function)] |= fresh
            news |= bool(fresh)
    for call in (call for called in calls for call in called):
        pairs = zip(call.function.parameters, call.arguments, strict=True)
        call.arguments = [
            argument for parameter, argument in pairs if parameter.name in used[id(call.function)]
        ]
    dropped = False
    for function in functions:
        left = [
            parameter for parameter in function.parameters if parameter.name in used[id(function)]
        ]
        dropped |= len(left) < len(function.parameters)
        function.parameters = left
    return dropped
