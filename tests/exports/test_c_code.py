"""Expressions and statements of the tree as C: brackets where the language would read another order, and no others."""

import math
from typing import NamedTuple

import pytest

from bristle.exports import tree as t
from bristle.exports.c_code import Body, Names, Printer, number
from bristle.exports.tree import INTEGER, REAL, TRUTH, VOID


class Pair(NamedTuple):
    first: float
    int: float


PAIR = t.Struct(Pair, (("first", REAL), ("int", REAL)))
A, B, C = (t.Variable(REAL, name) for name in "abc")
N, K = (t.Variable(INTEGER, name) for name in "ij")
P, Q = (t.Variable(TRUTH, name) for name in "pq")
PARTS, MEMORY = t.Variable(PAIR, "parts"), t.Variable(t.Array(4, writable=True), "memory")
ONE = t.Constant(REAL, 1.0)


def binary(operator, left, right):
    return t.Binary(left.type, operator, left, right)


def less(left, right, operator="<"):
    return t.Compare(TRUTH, operator, left, right)


def function_of(*body, parameters=(), result=REAL, name="f", description=""):
    return t.Function(name, print, list(parameters), result, list(body), description)


def body_of(*statements, parameters=(), scalar="double"):
    function = function_of(*statements, parameters=parameters)
    return Body(Printer(t.Unit([function]), scalar, [PAIR]), function)


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        (binary("-", binary("-", A, B), C), "a - b - c"),
        (binary("-", A, binary("-", B, C)), "a - (b - c)"),
        (binary("*", binary("+", A, B), C), "(a + b) * c"),
        (binary("+", binary("*", A, B), C), "a * b + c"),
        (binary("/", A, binary("*", B, C)), "a / (b * c)"),
        (t.Negative(REAL, A), "-a"),
        (t.Negative(REAL, t.Negative(REAL, A)), "-(-a)"),
        (t.Negative(REAL, binary("*", A, B)), "-(a * b)"),
        (binary("*", t.Negative(REAL, A), B), "-a * b"),
        (binary("-", A, t.Negative(REAL, B)), "a - -b"),
        (t.Negative(REAL, t.Constant(REAL, -2.0)), "-(-2.0)"),
        (t.Negative(REAL, t.Constant(REAL, 2.0)), "-2.0"),
        (binary("&", binary("+", N, K), K), "(i + j) & j"),
        (binary("+", binary(">>", N, t.Constant(INTEGER, 3)), K), "(i >> 3) + j"),
        (binary("//", binary("+", N, K), K), "floor_divided(i + j, j)"),
        (binary("%", N, K), "floor_rest(i, j)"),
        (less(binary("+", A, B), C), "a + b < c"),
        (less(N, binary("&", N, K), "=="), "i == (i & j)"),
        (t.Not(TRUTH, P), "!p"),
        (t.Not(TRUTH, less(A, B)), "!(a < b)"),
        (t.Not(TRUTH, t.Not(TRUTH, P)), "!!p"),
        (t.Logic(TRUTH, "and", [P, t.Logic(TRUTH, "or", [Q, less(A, B)])]), "p && (q || a < b)"),
        (t.Logic(TRUTH, "or", [P, t.Logic(TRUTH, "and", [Q, P])]), "p || (q && p)"),
        (t.Logic(TRUTH, "and", [less(A, B, "!="), t.Not(TRUTH, P)]), "a != b && !p"),
        (t.Select(REAL, less(A, B), A, B), "a < b ? a : b"),
        (t.Select(REAL, P, t.Select(REAL, Q, A, B), C), "p ? (q ? a : b) : c"),
        (t.Select(REAL, P, A, t.Select(REAL, Q, B, C)), "p ? a : (q ? b : c)"),
        (binary("*", t.Select(REAL, P, A, B), C), "(p ? a : b) * c"),
        (t.Convert(REAL, N), "(double)i"),
        (t.Convert(REAL, binary("+", N, K)), "(double)(i + j)"),
        (binary("*", t.Convert(REAL, N), A), "(double)i * a"),
        (t.Convert(INTEGER, t.Negative(REAL, A)), "(int32_t)-a"),
        (t.Field(REAL, PARTS, "int"), "parts.int_"),
        (t.Field(REAL, t.Make(PAIR, [A, B]), "first"), "(Pair){a, b}.first"),
        (t.Index(REAL, MEMORY, binary("+", N, K)), "memory[i + j]"),
        (t.Intrinsic(REAL, "sqrt", [binary("+", A, B)]), "root(a + b)"),
        (t.Intrinsic(INTEGER, "floor", [A]), "next_below(a)"),
        (t.Intrinsic(INTEGER, "min", [N, K]), "whole_least(i, j)"),
        (t.Intrinsic(REAL, "min", [A, B]), "least(a, b)"),
        (t.Call(REAL, function_of(name="g"), [A, binary("-", A, B)]), "g(a, a - b)"),
        (t.Constant(TRUTH, True), "true"),
        (t.Constant(TRUTH, False), "false"),
        (t.Constant(INTEGER, 2**31 - 1), "2147483647"),
        (t.Constant(INTEGER, 2**31), "INT64_C(2147483648)"),
        (t.Constant(INTEGER, -(2**31)), "INT64_C(-2147483648)"),
        (t.Constant(REAL, -math.inf), "-(double)INFINITY"),
    ],
)
def test_brackets_stand_where_the_order_is_another_one(expression, text):
    assert body_of(t.Return(expression)).lines()[-1] == f"    return {text};"


def test_helpers_are_those_that_are_called():
    body = body_of()
    for expression in (binary("%", N, K), t.Intrinsic(REAL, "sqrt", [A]), t.Intrinsic(INTEGER, "abs", [N])):
        body._of(expression)
    assert body.helpers == {"floor_divided", "floor_rest", "sqrt", "whole_abs"}


@pytest.mark.parametrize(
    ("value", "double", "single"),
    [
        (0.1, "0.1", "0.1f"),
        (-2.0, "-2.0", "-2.0f"),
        (math.inf, "(double)INFINITY", "(float)INFINITY"),
        (-math.inf, "-(double)INFINITY", "-(float)INFINITY"),
        (math.nan, "(double)NAN", "(float)NAN"),
    ],
)
def test_a_number_is_written_to_the_bit(value, double, single):
    assert (number(value), number(value, "float")) == (double, single)


def test_a_variable_is_declared_with_its_first_value_where_all_else_comes_behind():
    lines = body_of(t.Assign(A, ONE), t.Assign(A, binary("+", A, ONE)), t.Return(A)).lines()
    assert lines == ["    double a = 1.0;", "    a = a + 1.0;", "    return a;"]


def test_a_variable_is_declared_inside_the_block_that_alone_uses_it():
    inner = [t.Assign(A, ONE), t.Assign(B, A)]
    lines = body_of(t.Assign(B, ONE), t.If(P, inner, []), t.Return(B), parameters=[P]).lines()
    assert lines == ["    double b = 1.0;", "    if (p) {", "        double a = 1.0;", "        b = a;", "    }", "    return b;"]


@pytest.mark.parametrize(
    ("statements", "first"),
    [
        ([t.If(P, [t.Assign(A, ONE)], []), t.Return(A)], "    double a = 0.0;"),
        ([t.If(P, [t.Assign(A, ONE)], [t.Assign(A, B)]), t.Return(B)], "    double a = 0.0;"),
        ([t.While(less(A, B), [t.Assign(A, B)])], "    double a = 0.0;"),
        ([t.If(P, [t.Assign(N, N)], [])], "    int32_t i = 0;"),
        ([t.If(P, [t.Assign(Q, P)], []), t.Return(Q)], "    bool q = false;"),
        ([t.If(P, [t.Assign(PARTS, PARTS)], [])], "    Pair parts = {0};"),
        ([t.For(K, t.Constant(INTEGER, 0), N, [t.Assign(N, K)])], "    int32_t i = 0;"),
    ],
)
def test_a_variable_that_is_looked_at_elsewhere_is_zero_first(statements, first):
    assert body_of(*statements, parameters=[P, B]).lines()[0] == first


def test_statements_stand_in_their_blocks():
    three = t.Constant(INTEGER, 3)
    anonymous = t.Variable(INTEGER, "_")
    loop = t.For(anonymous, t.Constant(INTEGER, 0), three, [t.Store(MEMORY, N, A), t.Continue()])
    other = t.For(K, N, binary("+", N, three), [t.Break()])
    choice = t.If(less(A, B), [], [t.Evaluate(t.Call(VOID, function_of(name="g"), []))])
    both = t.If(P, [t.Return(None)], [t.While(P, [t.Assign(A, B)])])
    lines = body_of(loop, loop, other, choice, both, parameters=[A, B, N, P, MEMORY]).lines()
    assert [len(line) - len(line.lstrip()) for line in lines[-7:]] == [4, 8, 4, 8, 12, 8, 4]
    assert " ".join(line.strip() for line in lines) == (
        "for (int32_t round_1 = 0; round_1 < 3; ++round_1) { memory[i] = a; continue; } "
        "for (int32_t round_2 = 0; round_2 < 3; ++round_2) { memory[i] = a; continue; } "
        "for (int32_t j = i; j < i + 3; ++j) { break; } "
        "if (!(a < b)) { (void)g(); } if (p) { return; } else { while (p) { a = b; } }"
    )


def test_a_unit_is_its_structures_and_its_functions_with_what_each_is_for():
    plain = function_of(t.Return(ONE), name="g")
    told = function_of(
        t.Return(PARTS), parameters=[PARTS, t.Variable(t.Array(2), "table"), MEMORY], result=PAIR, description="Return `parts`."
    )
    nothing = t.Struct(Inner, ())
    text = Printer(t.Unit([plain, told, function_of(t.Return(t.Make(nothing, [])), name="h", result=nothing)]), "float").definitions()
    _, _, text = text.partition("#endif\n")
    assert text == (
        "\ntypedef struct {\n    float first;\n    float int_;\n} Pair;\n"
        "\ntypedef struct {\n    char nothing;\n} Inner;\n"
        "\nstatic inline float g(void)\n{\n    return 1.0f;\n}\n"
        "\n/* Return parts. */\nstatic inline Pair f(Pair parts, const float *table, float *memory)\n{\n    return parts;\n}\n"
        "\nstatic inline Inner h(void)\n{\n    return (Inner){0};\n}\n"
    )


class Inner(NamedTuple):
    a: float


def test_structures_of_one_name_are_told_apart_by_their_module():
    twin = type("Pair", (tuple,), {"_fields": (), "__module__": "bristle.friction.slip_law"})
    own = type("Pair", (tuple,), {"_fields": (), "__module__": "bristle_user_1.mine"})
    user = type("Pair", (tuple,), {"_fields": (), "__module__": "bristle_user_2"})
    kinds = [PAIR, *(t.Struct(cls, ()) for cls in (twin, own, user, tuple)), t.Struct(tuple, (("_0", REAL),))]
    assert list(Names(kinds).structures.values()) == ["TestCCodePair", "SlipLawPair", "MinePair", "OwnPair", "Several", "Several_2"]
    assert list(Names([PAIR]).structures.values()) == ["Pair"]
    assert list(Names([PAIR], ["Pair"]).structures.values()) == ["Pair_2"]


@pytest.mark.parametrize(
    ("name", "written"),
    [("int", "int_"), ("int_", "int__"), ("x", "x"), ("_0", "part_0"), ("root", "root_"), ("g", "g_"), ("DBL_MAX", "DBL_MAX_")],
)
def test_a_name_that_c_has_already_gets_a_line_behind_it(name, written):
    assert Names([], ["g"]).variable(name) == written
