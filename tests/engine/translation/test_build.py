"""Kernels as a tree: computed from the tree they give what they give as Python, also where parameters are settled."""

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from bristle.core.kernel import kernel
from bristle.engine.translation import tree
from bristle.engine.translation.build import FACE, Builder
from bristle.engine.translation.expressions import COMPUTED
from bristle.engine.translation.scope import NotExportableError, defined
from bristle.engine.translation.tree import INTEGER, REAL, TRUTH, VOID, Array, type_of
from bristle.exports import targets
from bristle.exports.settled import fact_of, settled

EXACT = {
    "sqrt": math.sqrt,
    "copysign": math.copysign,
    "abs": abs,
    "floor": math.floor,
    "isinf": math.isinf,
    "isnan": math.isnan,
}
EXACT |= {"min": min, "max": max}


class Ended(Exception):  # noqa: N818
    """A block ends before its last line: by a return, a break or a continue."""


def computed(function, arguments) -> Any:
    """Return what a function of the tree gives for some arguments, whose arrays it writes."""
    names = {
        parameter.name: value
        for parameter, value in zip(function.parameters, arguments, strict=True)
    }
    try:
        run(function.body, names)
    except Ended as end:
        return end.args[1]
    return None


def run(block, names):
    for s in block:
        match s:
            case tree.Assign():
                names[s.variable.name] = value(s.value, names)
            case tree.Store():
                value(s.array, names)[value(s.at, names)] = value(s.value, names)
            case tree.Evaluate():
                value(s.call, names)
            case tree.Return():
                raise Ended("return", None if s.value is None else value(s.value, names))
            case tree.If():
                run(s.body if value(s.test, names) else s.otherwise, names)
            case tree.For():
                for k in range(value(s.start, names), value(s.stop, names)):
                    names[s.variable.name] = k
                    if not goes_on(s.body, names):
                        break
            case tree.While():
                while value(s.test, names) and goes_on(s.body, names):
                    pass
            case _:
                raise Ended("break" if isinstance(s, tree.Break) else "continue")


def goes_on(body, names):
    try:
        run(body, names)
    except Ended as end:
        if end.args[0] == "return":
            raise
        return end.args[0] == "continue"
    return True


def value(e, names) -> Any:
    """Return the value of an expression, of the type that the tree says it has."""
    match e:
        case tree.Constant():
            result = e.value
        case tree.Variable():
            result = names[e.name]
        case tree.Field():
            assert isinstance(e.of.type, tree.Struct)
            result = value(e.of, names)[e.of.type.place(e.name)]
        case tree.Index():
            result = value(e.array, names)[value(e.at, names)]
        case tree.Negative():
            result = -value(e.of, names)
        case tree.Not():
            result = not value(e.of, names)
        case tree.Binary() | tree.Compare():
            assert e.left.type == e.right.type
            result = COMPUTED[e.operator](value(e.left, names), value(e.right, names))
        case tree.Logic():
            result = (all if e.operator == "and" else any)(value(part, names) for part in e.parts)
        case tree.Select():
            result = value(e.first if value(e.test, names) else e.second, names)
        case tree.Convert():
            result = (float if e.type == REAL else int)(value(e.of, names))
        case tree.Call():
            result = computed(e.function, [value(argument, names) for argument in e.arguments])
        case tree.Intrinsic():
            result = EXACT[e.name](*(value(argument, names) for argument in e.arguments))
        case tree.Make():
            result = tuple(value(part, names) for part in e.parts)
        case _:
            raise AssertionError(e)
    assert (
        not isinstance(e.type, tree.Scalar) or e.type == VOID or type(result) in NUMBERS[e.type]
    ), (e, result)
    return result


NUMBERS = {REAL: (float, np.float64), INTEGER: (int,), TRUTH: (bool, np.bool_)}


class Values(NamedTuple):
    kind: int
    is_even: bool
    gain: float
    table: np.ndarray


class Part(NamedTuple):
    low: float
    turns: int = 3
    high: float = 0.5


SHARE, ROUNDS = 0.25, 3


@kernel
def arithmetic(x, n, memory, p):
    total = n + 2 * 3 - (n // 4) % 5
    total -= n >> 1
    total += (n & 6) ^ 3
    result = x / 4 - -x * p.gain + total
    result *= 0.5
    return result + True + n / 2 + (7 & 3) * +x


@kernel
def questions(x, n, memory, p):
    count = 0
    if 0.0 < x <= 2.0 and not (n == 3 or n > 5):
        count += 1
    if x < -1 or x >= 3.0 or n != 2:
        count += 2
    elif n:
        count += 4
    else:
        count += 8
    if p.is_even:
        count += 16
    if x:
        count += 32
    rest = 1.5 if n > 1 else 2
    return count + rest + (x > 0.0) * 64 + (p.gain if p.kind == 2 else x) + (n if x > 1.0 else -n)


@kernel
def numbers_of_mathematics(x, n, memory, p):
    low, high = min(x, 1, n), max(x, n, -2.0)
    whole = (
        abs(n - 2)
        + min(n, 2)
        + max(n, 1, 2)
        + int(x * 10.0)
        + math.floor(x)
        + len(memory)
        + p.table.size
    )
    if math.isnan(x) or math.isinf(math.inf * (x + 9.0)):
        whole += 5
    return (
        low
        + 10.0 * high
        + abs(x)
        + math.sqrt(abs(x))
        + math.copysign(2.0, x)
        + math.fabs(x - 1.0)
        + whole
        + float(n)
        + math.pi
    )


@kernel
def loops(x, n, memory, p):
    total = 0.0
    for i in range(n):
        if i == 2:
            continue
        total += i * x
        if total > 3.0:
            break
    for _ in range(1, ROUNDS):
        total += 1
    k: int = 0
    while k < n:
        k += 1
        if k == 4:
            return total - k
        if k > p.kind:
            break
    return total + k


@kernel
def swapped(x, n, memory, p):
    first, second = x, 2.0 * x
    first, second = second, first + 1.0
    memory[0], memory[1] = memory[1], memory[0] + first
    memory[n % 3] -= second
    memory[-1] = memory[2] + p.table[-1] + p.table[0]
    shared, _ = pair(x, n)
    return shared + first * second + memory[0]


@kernel
def pair(x, n):
    """Return two numbers of two types."""
    return x + SHARE, n


@kernel
def written(memory, x):
    memory[1] = x
    memory[2] += x


@kernel
def tuples(x, n, memory, p):
    low = Part(x)
    part = Part(1, n, x) if x > 0.0 else low
    left, right = pair(part.high, part.turns)
    written(memory, left)
    _ = pair(x, n)
    whole = pair(left, n)[1]
    return left + right + part[0] + pair(x, right)[-2] + whole + low.turns + low.high


KERNELS = (arithmetic, questions, numbers_of_mathematics, loops, swapped, tuples)
P = Values(2, True, 3.5, np.array([1.0, -2.0]))
TYPES = [REAL, INTEGER, Array(3, writable=True), type_of(P)]


HEAD = "def refused(x, n, memory, p):\n    "


def python_and_tree(function, entry, x, n, p, of_entry):
    """Return what Python and the tree give for the same arguments, and what both leave in the memory."""
    memories = [np.array([0.5, -1.5, 2.5]) for _ in range(2)]
    return (function(x, n, memories[0], p), memories[0].tolist()), (
        computed(entry, of_entry(x, n, memories[1], p)),
        memories[1].tolist(),
    )


@pytest.mark.parametrize("function", KERNELS, ids=lambda function: function.__name__)
def test_a_tree_gives_the_results_of_the_kernel(function):
    entry = Builder().function(function, TYPES)
    for x in (-3.25, -1.0, -0.5, 0.0, 0.3, 1.0, 2.0, 2.75, 9.5):
        for n in range(7):
            for p in (P, P._replace(kind=9, is_even=False)):
                expected, outcome = python_and_tree(
                    function, entry, x, n, p, lambda *passed: passed
                )
                assert outcome == expected


@pytest.mark.parametrize("function", KERNELS, ids=lambda function: function.__name__)
@pytest.mark.parametrize("p", [P, P._replace(kind=9, is_even=False)])
def test_a_tree_with_folded_parameters_gives_the_results_of_the_kernel(function, p):
    builder = Builder()
    entry = builder.function(function, TYPES)
    _, (left,) = settled(builder.unit, [entry], {"p": fact_of(p, TYPES[3])})
    kept = [["x", "n", "memory", "p"].index(parameter.name) for parameter in left.parameters]
    for x in (-3.25, -1.0, 0.0, 0.3, 2.0, 9.5):
        for n in (0, 2, 3, 5):
            expected, outcome = python_and_tree(
                function, left, x, n, p, lambda *passed: [passed[place] for place in kept]
            )
            assert outcome == expected


def test_called_functions_precede_their_callers_with_descriptions():
    builder = Builder()
    entry = builder.function(tuples, TYPES)
    names = [function.name for function in builder.unit.functions]
    assert names == ["test_build_pair", "test_build_written", "test_build_tuples"]
    assert [function.writes for function in builder.unit.functions] == [False, True, True]
    assert builder.unit.functions[0].description == "Return two numbers of two types."
    assert builder.unit.functions[1].result == VOID
    assert builder.function(tuples, TYPES) is entry
    other = builder.function(pair, [REAL, REAL])
    assert (other.name, len(builder.unit.functions)) == ("test_build_pair_2", 4)


@pytest.mark.parametrize(
    ("line", "held"),
    [
        ("memory[0], memory[1] = x, 2.0 * x", 0),
        ("memory[0], memory[1] = memory[1], x", 2),
        ("a, b = memory[0], memory[1]", 0),
        ("a, b = x, a", 2),
        ("x, b = 2.0, x", 2),
        ("b, x = x, 2.0", 0),
    ],
)
def test_values_are_copied_if_another_value_reads_a_written_element(line, held):
    scope = {"__name__": __name__}
    entry = Builder().function(
        defined("refused", f"{HEAD}a = 1.0\n    {line}\n    return x\n", scope), TYPES
    )
    assert (
        sum(isinstance(s, tree.Assign) and s.variable.name.startswith("held") for s in entry.body)
        == held
    )


def test_a_constant_of_single_precision_is_replaced_by_name_and_value():
    entry = Builder(constants={("SHARE", 0.25): 0.75, ("SHARE", 0.5): 9.0}).function(
        pair, [REAL, INTEGER]
    )
    assert computed(entry, [1.0, 2]) == (1.75, 2)


@pytest.mark.parametrize(
    ("lines", "reason"),
    [
        ("return x ** 2", "differs between targets"),
        ("return n | 3", "BitOr of whole numbers is outside the subset"),
        ("return x // 2.0", "FloorDiv of real numbers is outside the subset"),
        ("return ~n", "Invert of a whole number"),
        ("return x + p", "arithmetic with a Values"),
        ("return memory < x", "Lt of an array of 3 numbers and a number"),
        ("return x and n > 2", "the operands of and, or must be true or false"),
        (
            "return 0.0 < x * 2.0 < 1.0",
            "assign the middle of a chained comparison to a variable first",
        ),
        ("return x is n", "Is of a number and a whole number"),
        ("return memory[0:2]", "slices of an array are outside the subset"),
        ("return memory[x]", "an index needs an array and a whole number"),
        ("return pair(x, n)[n]", "the index of a tuple must be a literal number"),
        ("return pair(x, n)[2]", "the index of a tuple must be a literal number"),
        ("return pair(x, n)[-3]", "the index of a tuple must be a literal number"),
        ("return memory.shape", "an array of 3 numbers has no field 'shape'"),
        ("return math.exp(x)", "math.exp may raise"),
        ("return x.hex()", "calls of the method .hex are outside the subset"),
        ("return abs(p)", "the arguments of abs must be numbers"),
        ("return min(x)", "has too few arguments"),
        ("return sum(x, x)", "sum is not a kernel"),
        ("return print(x)", "print is not a kernel"),
        ("return unknown + x", "unknown is not defined"),
        ("return Part(x, x, x).low", "a value is a number, but must be a whole number"),
        ("return Part(x, n, x, x).low", "Part needs values for 3 fields: low, turns, high"),
        ("return Part().low", "Part needs values for 3 fields"),
        (
            "return p if x > 0.0 else x",
            "two values must have the same type, but are a Values and a number",
        ),
        ("return 1.0 if p else x", "a Values is neither true nor false"),
        ("x", "this expression has no effect"),
        ("for i in memory:\n        pass\n    return x", r"must run over range\(...\)"),
        ("for i in range(0, n, 2):\n        pass\n    return x", "a start and a stop, and no else"),
        (
            "for i in range(x):\n        pass\n    return x",
            "the arguments of range must be whole numbers",
        ),
        (
            "for i in range(n):\n        x += i\n    return i",
            "the loop variable i is read outside its loop",
        ),
        (
            "while n > 2:\n        n -= 1\n    else:\n        n = 0\n    return n",
            "a loop must not have else",
        ),
        ("a = b = x\n    return a", "an assignment must have one target"),
        (
            "a, b, c = pair(x, n)\n    return a",
            "an assignment to 3 names needs a tuple of the same length",
        ),
        ("p.gain = x\n    return x", "cannot assign to Attribute"),
        (
            "memory[x] = 1.0\n    return x",
            "an indexed assignment needs an array and a whole number",
        ),
        ("p.table[0] = x\n    return x", "writes to a read-only array"),
        ("a = written(memory, x)\n    return x", "the call assigned to a has no result"),
        ("if x > 0.0:\n        return x", "does not return a value on every path"),
        ("while n > 2:\n        return x", "does not return a value on every path"),
        (
            "while True:\n        break\n    return_ = pair(x, n)[0]\n    if x > 0.0:\n        return x",
            "on every path",
        ),
        ("return pair(x)", "takes 2 arguments, not 1"),
        ("assert x > 0.0\n    return x", "Assert is outside the exportable subset"),
        ("return [x]", "List is outside the exportable subset"),
        ("return refused(x, n, memory, p)", "calls itself"),
    ],
)
def test_python_beyond_the_subset_is_refused_with_the_reason(lines, reason):
    scope = {"math": math, "pair": pair, "written": written, "Part": Part, "__name__": __name__}
    function = kernel(defined("refused", HEAD + lines + "\n", scope))
    with pytest.raises(NotExportableError, match=reason):
        Builder().function(function, TYPES)


@pytest.mark.parametrize(
    "lines",
    [
        "while True:\n        n += 1\n        if n > 3:\n            return x",
        "if x > 0.0:\n        return x\n    else:\n        return -x",
    ],
)
def test_a_function_may_end_in_an_infinite_loop_or_in_both_branches(lines):
    entry = Builder().function(
        defined("refused", HEAD + lines + "\n", {"__name__": __name__}), TYPES
    )
    assert computed(replace(entry), [2.0, 1, np.zeros(3), P]) == 2.0


@kernel
def length_of(state):
    return state.size


@pytest.mark.parametrize(("size", "is_known"), [(0, True), (3, True), (-1, False)])
def test_the_length_of_an_array_is_a_constant_if_known(size, is_known):
    (returned,) = Builder().function(length_of, [Array(size)]).body
    assert isinstance(returned.value, tree.Constant if is_known else tree.Intrinsic)
    assert not is_known or returned.value.value == size


def test_no_kernel_has_the_name_of_a_function_of_an_export():
    templates = Path(targets.__file__).parent / "templates"
    texts = [
        path.read_text()
        for folder in ("c", "shared", "hal", "ros2", "fmu")
        for path in (templates / folder).rglob("*")
        if path.is_file()
    ]
    suffixes = {
        suffix for text in texts for suffix in re.findall(r"\{\{ ?name ?\}\}_([a-z_]+)\(", text)
    }
    assert {"force", "command", "feed"} <= suffixes <= FACE
