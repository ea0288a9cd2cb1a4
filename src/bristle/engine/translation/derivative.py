r"""Forward derivatives of kernels, by rules on the typed tree: for each function, a function with value and tangent.

For :math:`y = g(x_1, \dots)` along the executed branches, each number has the tangent :math:`\dot y = \sum_i (\partial
g/\partial x_i)\,\dot x_i` (`bristle.core.tangent`). The numbers are computed as before, in the same order, with identical
results. A search for a root ends with a step of Newton's method, whose derivative is that of the implicit function. A
turning point moves with the quantities that created it, because the memory has tangents, too. Whole numbers, truths and
values that depend only on constants have no tangent and cost no time.

The derived function of ``f(a, b)`` is ``f(a, b, da, db) -> (value, tangent)``, with the tangents of those arguments that
have one, in their order. The tangent of a tuple is a tuple of the tangents of its fields; that of an array is an array.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from bristle.core.exponent import mantissa
from bristle.core.kernel import is_absorbed, kernel
from bristle.core.tangent import TANGENTS
from bristle.engine.translation import tree
from bristle.engine.translation.python_text import PythonText, part_of
from bristle.engine.translation.scope import defined, free_name
from bristle.engine.translation.slopes import SLOPES
from bristle.engine.translation.tree import REAL, VOID, Array, Struct, Type, tuple_of

Activity = bool | tuple["Activity", ...]
"""Whether a value has a tangent; for a tuple, field by field."""

TEMPORARY = "number__"  # prefix of names that no kernel has
ROUNDS = 30  # limit of iterations to find the tangents of all variables


def activity_of(kind: Type) -> Activity:
    """Return the activity of a type: all real numbers may have tangents."""
    if isinstance(kind, Struct):
        return tuple(activity_of(part) for _, part in kind.fields)
    return kind == REAL or isinstance(kind, Array)


def is_active(activity: Activity) -> bool:
    """Return whether any part has a tangent."""
    return any(map(is_active, activity)) if isinstance(activity, tuple) else activity


def type_of_tangent(kind: Type, activity: Activity) -> Type:
    """Return the type of a tangent in one direction."""
    if not isinstance(kind, Struct) or not isinstance(activity, tuple):
        return kind
    pairs = zip(kind.fields, activity, strict=True)
    return tuple_of(
        [type_of_tangent(part, inner) for (_, part), inner in pairs if is_active(inner)]
    )


def joined(first: Activity, second: Activity) -> Activity:
    """Return the activity of a value that is one of two."""
    if isinstance(first, tuple) and isinstance(second, tuple):
        return tuple(map(joined, first, second))
    return first or second


@dataclass(frozen=True)
class Derived:
    """A derived function: its name, the activities of its arguments and its result, and whether it writes tangents."""

    name: str
    entering: Sequence[Activity]
    result: Activity
    does: bool

    @property
    def is_needed(self) -> bool:
        """Whether it does more than the original function."""
        return self.does or is_active(self.result)


@dataclass
class Derivatives:
    """Derives functions on demand: those in `apart` once for all arguments, those in `rules` by their own rule, such as root searches."""

    apart: frozenset[Callable[..., Any]] = frozenset()
    rules: Mapping[Callable[..., Any], Callable[[Rules], None]] = field(default_factory=dict)
    scope: dict[str, Any] = field(
        default_factory=lambda: (
            {"__name__": __name__, "math": math} | {rule.__name__: rule for rule in TANGENTS}
        )
    )
    portable: bool = False
    """Whether the scope has tangents in one direction, so that other targets support the derived functions."""
    _derived: dict[tuple[tree.Function, tuple[Activity, ...]], Derived] = field(
        default_factory=dict
    )

    def of(self, function: tree.Function, activities: Sequence[Activity]) -> Derived:
        """Return the derived function for arguments of these activities."""
        if function.source in self.apart and any(map(is_active, activities)):
            pairs = zip(function.parameters, activities, strict=True)
            activities = [
                given if isinstance(part.type, Array) else activity_of(part.type)
                for part, given in pairs
            ]
        key = function, tuple(activities)
        if key not in self._derived:
            if not any(map(is_active, activities)):
                self._derived[key] = Derived("", activities, nowhere(function.result), does=False)
            else:
                self._derived[key] = Rules(self, function, activities).derived()
        return self._derived[key]


def nowhere(kind: Type) -> Activity:
    """Return the activity of a value without tangents."""
    return tuple(nowhere(part) for _, part in kind.fields) if isinstance(kind, Struct) else False


@dataclass
class Dual:
    """A value in the text of a function, its activity, and its tangent."""

    value: str
    activity: Activity = False
    tangent: str = ""


class Rules(PythonText):
    """Derives one function for arguments with given activities; `lines` is its text."""

    def __init__(
        self, derivatives: Derivatives, function: tree.Function, activities: Sequence[Activity]
    ) -> None:
        super().__init__(derivatives.scope)
        self.all, self.function = derivatives, function
        self.entering = dict(
            zip((parameter.name for parameter in function.parameters), activities, strict=True)
        )
        self.activities = dict(self.entering)
        self.result, self.lines, self.indent, self.count, self.does = (
            nowhere(function.result),
            list[str](),
            1,
            0,
            False,
        )
        self.choices = dict[int, str]()

    def argument(self, name: str) -> Dual:
        """Return an argument of the function."""
        return Dual(
            name, self.entering[name], tangent_of(name) if is_active(self.entering[name]) else ""
        )

    def derived(self) -> Derived:
        """Return the derived function, known to the scope and to the compiler."""
        rule = self.all.rules.get(self.function.source)
        if rule is not None:
            rule(self)
        for _ in range(ROUNDS if rule is None else 0):
            before = dict(self.activities), self.result
            self.lines, self.count, self.does = [], 0, False
            self._enter()
            self._block(self.function.body)
            if (self.activities, self.result) == before:
                break
        activities, source = tuple(self.entering.values()), self.function.source
        if not self.does and not is_active(self.result):
            return Derived("", activities, self.result, self.does)
        names = [parameter.name for parameter in self.function.parameters]
        arguments = [
            *names,
            *(tangent_of(name) for name in names if is_active(self.entering[name])),
        ]
        name = free_name(f"with_tangent_{self.function.name}", self.scope)
        text = f"def {name}({', '.join(arguments)}):\n" + "\n".join(self.lines) + "\n"
        function: Any = defined(name, text, self.scope)
        if self.all.portable:
            function.is_portable = True
        else:
            kernel(inline=is_absorbed(source) and source not in self.all.apart, portable=False)(
                function
            )
        return Derived(name, activities, self.result, self.does)

    def _enter(self) -> None:
        """Give a tangent to each argument that has none, but is assigned a value with a tangent later."""
        for name, activity in self.entering.items():
            if self.activities[name] != activity:
                before = Dual(name, activity, tangent_of(name) if is_active(activity) else "")
                self.line(f"{tangent_of(name)} = {self.fitted(before, self.activities[name])}")

    # --- statements -------------------------------------------------------------------------------------------------

    def line(self, text: str) -> None:
        """Write a line."""
        self.lines.append("    " * self.indent + text)

    def _block(self, statements: Iterable[tree.Statement]) -> None:
        for statement in statements:
            match statement:
                case tree.Assign():
                    self._assign(statement)
                case tree.Store():
                    self._store(statement)
                case tree.Return():
                    self._return(statement)
                case tree.Evaluate():
                    self.line(self.dual(statement.call).value)
                case tree.If():
                    self._inside(f"if {self.plain(statement.test)}:", statement.body)
                    if statement.otherwise:
                        self._inside("else:", statement.otherwise)
                case tree.For():
                    ends = f"{self.plain(statement.start)}, {self.plain(statement.stop)}"
                    self._inside(f"for {statement.variable.name} in range({ends}):", statement.body)
                case tree.While():
                    self._inside(f"while {self.plain(statement.test)}:", statement.body)
                case _:
                    self.line("break" if isinstance(statement, tree.Break) else "continue")

    def _inside(self, head: str, statements: Sequence[tree.Statement]) -> None:
        self.line(head)
        self.indent += 1
        self._block(statements)
        if not statements:
            self.line("pass")
        self.indent -= 1

    def _assign(self, statement: tree.Assign) -> None:
        name, value = statement.variable.name, self.dual(statement.value)
        before = self.activities.get(name, nowhere(statement.variable.type))
        self.activities[name] = joined(before, value.activity)
        if is_active(self.activities[name]):
            self.line(f"{tangent_of(name)} = {self.fitted(value, self.activities[name])}")
        self.line(f"{name} = {value.value}")

    def _store(self, statement: tree.Store) -> None:
        array, at, value = (
            self.dual(statement.array),
            self._held(self.plain(statement.at)),
            self.dual(statement.value),
        )
        if array.activity:
            self.does = True
            self.line(f"keep_tangent({array.tangent}, {at}, {self.fitted(value, True)})")
        self.line(f"{array.value}[{at}] = {value.value}")

    def _return(self, statement: tree.Return) -> None:
        if statement.value is None:
            self.line("return")
            return
        value = self.dual(statement.value)
        self.result = joined(self.result, value.activity)
        self.line(
            f"return {value.value}, {self.fitted(value, self.result)}"
            if is_active(self.result)
            else f"return {value.value}"
        )

    # --- expressions with tangents ----------------------------------------------------------------------------------

    def dual(self, node: tree.Expression) -> Dual:
        """Return a value with its tangent."""
        rule: Callable[[Any], Dual] | None = getattr(
            self, f"_dual_{type(node).__name__.lower()}", None
        )
        if rule is None or not (isinstance(node, tree.Call) or self._has_tangent(node)):
            return Dual(self.plain(node), nowhere(node.type))
        return rule(node)

    def _has_tangent(self, node: tree.Expression) -> bool:
        """Return whether an expression may have a tangent: it reads a number or an array with a tangent."""
        if activity_of(node.type) is False:
            return False
        return any(
            (isinstance(part, tree.Variable) and is_active(self.activities.get(part.name, False)))
            or isinstance(part, tree.Call)
            for part in tree.walk(node)
        )

    def _held(self, text: str) -> str:
        """Return a name for a value, or the value if it is a name or a number."""
        if text.replace(".", "").replace("_", "").isalnum():
            return text
        self.count += 1
        self.line(f"{TEMPORARY}{self.count} = {text}")
        return f"{TEMPORARY}{self.count}"

    def _number(self, node: tree.Expression) -> Dual:
        dual = self.dual(node)
        return Dual(
            self._held(dual.value), dual.activity, self._held(dual.tangent) if dual.tangent else ""
        )

    def fitted(self, dual: Dual, target: Activity) -> str:
        """Return a tangent of the target's activity; missing parts are zero."""
        if dual.activity == target:
            return dual.tangent
        if not isinstance(target, tuple):
            return "still()"
        tangent = self._held(dual.tangent) if dual.tangent else ""
        parts, place = list[str](), 0
        for part, asked_for in zip(
            dual.activity if isinstance(dual.activity, tuple) else [False] * len(target),
            target,
            strict=True,
        ):
            if is_active(asked_for):
                parts.append(
                    self.fitted(
                        Dual("", part, f"{tangent}[{place}]" if is_active(part) else ""), asked_for
                    )
                )
            place += is_active(part)
        return f"({', '.join(parts)},)"

    def _dual_variable(self, node: tree.Variable) -> Dual:
        activity = self.activities.get(node.name, nowhere(node.type))
        return Dual(node.name, activity, tangent_of(node.name) if is_active(activity) else "")

    def _dual_field(self, node: tree.Field) -> Dual:
        of, kind = self.dual(node.of), node.of.type
        assert isinstance(kind, Struct)
        value, place = (
            self._held(of.value) if isinstance(node.of, tree.Call) else of.value,
            kind.place(node.name),
        )
        activity = of.activity[place] if isinstance(of.activity, tuple) else False
        if not is_active(activity):
            return Dual(part_of(value, node), activity)
        assert isinstance(of.activity, tuple)
        return Dual(
            part_of(value, node),
            activity,
            f"{of.tangent}[{sum(map(is_active, of.activity[:place]))}]",
        )

    def _dual_index(self, node: tree.Index) -> Dual:
        array, at = self.dual(node.array), self._held(self.plain(node.at))
        return Dual(
            f"{array.value}[{at}]",
            array.activity,
            f"tangent_at({array.tangent}, {at})" if array.activity else "",
        )

    def _dual_negative(self, node: tree.Negative) -> Dual:
        of = self._number(node.of)
        return Dual(
            f"(-{of.value})",
            of.activity,
            f"tangent_scaled(-1.0, {of.tangent})" if of.activity else "",
        )

    def _dual_binary(self, node: tree.Binary) -> Dual:
        a, b = self._number(node.left), self._number(node.right)
        value = f"({a.value} {node.operator} {b.value})"
        if node.operator in "+-":
            if a.activity and b.activity:
                rule = "tangent_sum" if node.operator == "+" else "tangent_difference"
                return Dual(value, True, f"{rule}({a.tangent}, {b.tangent})")
            alone = (
                f"tangent_scaled(-1.0, {b.tangent})"
                if node.operator == "-" and b.activity
                else a.tangent or b.tangent
            )
            return Dual(value, a.activity or b.activity, alone)
        if node.operator == "*":
            # An infinite number stays infinite.
            if _is_infinite(node.left) or _is_infinite(node.right):
                return Dual(value)
            return self._combined(value, [(b.value, a), (a.value, b)])
        if not (a.activity or b.activity):
            return Dual(value)
        value = self._held(value)
        inverse = self._held(f"1.0 / {b.value}")
        return self._combined(value, [(inverse, a), (f"-{value} * {inverse}", b)])

    def _combined(self, value: str, terms: Sequence[tuple[str, Dual]]) -> Dual:
        """Return a value whose tangent is the sum of several tangents, each times its slope."""
        active = [(slope, dual.tangent) for slope, dual in terms if dual.activity]
        rule = "tangent_scaled" if len(active) == 1 else "tangent_combined"
        if active:
            return Dual(
                value, True, f"{rule}({', '.join(part for pair in active for part in pair)})"
            )
        return Dual(value)

    def _dual_select(self, node: tree.Select) -> Dual:
        choice = tree.Variable(
            node.type, self.choices.setdefault(id(node), f"choice__{len(self.choices)}")
        )
        self._block(
            [
                tree.If(
                    node.test, [tree.Assign(choice, node.first)], [tree.Assign(choice, node.second)]
                )
            ]
        )
        return self._dual_variable(choice)

    def _dual_intrinsic(self, node: tree.Intrinsic) -> Dual:
        if node.type != REAL or node.name in ("power_of_two", "exponent"):
            return Dual(self.plain(node))
        numbers = list(map(self._number, node.arguments))
        value = self._held(self.intrinsic(node, [number.value for number in numbers]))
        if node.name in ("min", "max"):
            a, b = numbers
            if not (a.activity or b.activity):
                return Dual(value)
            sign = "<" if node.name == "min" else ">"
            return Dual(
                value,
                True,
                f"({b.tangent or 'still()'} if {b.value} {sign} {a.value} else {a.tangent or 'still()'})",
            )
        first = numbers[0]
        if node.name in ("abs", "copysign"):
            signs = [f"math.copysign(1.0, {number.value})" for number in numbers]
            return self._combined(value, [(" * ".join(signs), first)])
        slope = SLOPES[math.sqrt if node.name == "sqrt" else mantissa]
        return self._combined(value, [(f"{self.kernel(slope)}({first.value}, {value})", first)])

    def _dual_call(self, node: tree.Call) -> Dual:
        numbers = list(map(self._number, node.arguments))
        values, source = ", ".join(number.value for number in numbers), node.function.source
        if source in SLOPES:
            if not any(is_active(number.activity) for number in numbers):
                return Dual(f"{self.kernel(source)}({values})")
            value = self._held(f"{self.kernel(source)}({values})")
            slopes = self._held(f"{self.kernel(SLOPES[source])}({values}, {value})")
            alone = len(numbers) == 1
            return self._combined(
                value,
                [
                    (slopes if alone else f"{slopes}[{k}]", number)
                    for k, number in enumerate(numbers)
                ],
            )
        derived = self.all.of(node.function, [number.activity for number in numbers])
        if not derived.is_needed:
            return Dual(f"{self.kernel(source)}({values})", derived.result)
        self.does |= derived.does
        pairs = zip(numbers, derived.entering, strict=True)
        tangents = [
            self.fitted(number, entering) for number, entering in pairs if is_active(entering)
        ]
        call = f"{derived.name}({', '.join([values, *tangents])})"
        if not is_active(derived.result):
            return Dual(call if node.type == VOID else self._held(call), derived.result)
        self.count += 1
        name = f"{TEMPORARY}{self.count}"
        self.line(f"{name}, {tangent_of(name)} = {call}")
        return Dual(name, derived.result, tangent_of(name))

    def _dual_make(self, node: tree.Make) -> Dual:
        parts = list(map(self.dual, node.parts))
        tangents = [part.tangent for part in parts if is_active(part.activity)]
        value = self.tuple_text(node, [part.value for part in parts])
        return Dual(
            value,
            tuple(part.activity for part in parts),
            f"({', '.join(tangents)},)" if tangents else "",
        )


def tangent_of(name: str) -> str:
    """Return the name of the tangent of a variable, distinct from names in kernels such as ``d_v``."""
    return f"tangent__{name}"


def _is_infinite(node: tree.Expression) -> bool:
    return isinstance(node, tree.Constant) and math.isinf(node.value)
