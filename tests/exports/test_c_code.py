"""Expressions and statements of the tree as C: brackets where the language would read another order, and no others."""

import math
from typing import NamedTuple

import pytest

from bristle.exports.c_code import Body, Names, Printer, number
from bristle.exports.tree import (
    INTEGER,
    REAL,
    TRUTH,
    VOID,
    Array,
    Assign,
    Binary,
    Break,
    Call,
    Compare,
    Constant,
    Continue,
    Convert,
    Evaluate,
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
    Store,
    Struct,
    Unit,
    Variable,
    While,
)


class Pair(NamedTuple):
    first: float
    int: float


PAIR = Struct(Pair, (("first", REAL), ("int", REAL)))
A, B, C = (Variable(REAL, name) for name in "abc")
I, J = (Variable(INTEGER, name) for name in "ij")
P, Q = (Variable(TRUTH, name) for name in "pq")
PARTS, MEMORY = Variable(PAIR, "parts"), Variable(Array(4, writable=True), "memory")
ONE = Constant(REAL, 1.0)


def binary(operator, left, right):
    return Binary(left.type, operator, left, right)


def less(left, right, operator="<"):
    return Compare(TRUTH, operator, left, right)


def function_of(*body, parameters=(), result=REAL, name="f", description=""):
    return Function(name, print, list(parameters), result, list(body), description)


def body_of(*statements, parameters=(), scalar="double"):
    function = function_of(*statements, parameters=parameters)
    return Body(Printer(Unit([function]), scalar, [PAIR]), function)


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        (binary("-", binary("-", A, B), C), "a - b - c"),
        (binary("-", A, binary("-", B, C)), "a - (b - c)"),
        (binary("*", binary("+", A, B), C), "(a + b) * c"),
        (binary("+", binary("*", A, B), C), "a * b + c"),
        (binary("/", A, binary("*", B, C)), "a / (b * c)"),
        (Negative(REAL, A), "-a"),
        (Negative(REAL, Negative(REAL, A)), "-(-a)"),
        (Negative(REAL, binary("*", A, B)), "-(a * b)"),
        (binary("*", Negative(REAL, A), B), "-a * b"),
        (binary("-", A, Negative(REAL, B)), "a - -b"),
        (Negative(REAL, Constant(REAL, -2.0)), "-(-2.0)"),
        (Negative(REAL, Constant(REAL, 2.0)), "-2.0"),
        (binary("&", binary("+", I, J), J), "(i + j) & j"),
        (binary("+", binary(">>", I, Constant(INTEGER, 3)), J), "(i >> 3) + j"),
        (binary("//", binary("+", I, J), J), "floor_divided(i + j, j)"),
        (binary("%", I, J), "floor_rest(i, j)"),
        (less(binary("+", A, B), C), "a + b < c"),
        (less(I, binary("&", I, J), "=="), "i == (i & j)"),
        (Not(TRUTH, P), "!p"),
        (Not(TRUTH, less(A, B)), "!(a < b)"),
        (Not(TRUTH, Not(TRUTH, P)), "!!p"),
        (Logic(TRUTH, "and", [P, Logic(TRUTH, "or", [Q, less(A, B)])]), "p && (q || a < b)"),
        (Logic(TRUTH, "or", [P, Logic(TRUTH, "and", [Q, P])]), "p || (q && p)"),
        (Logic(TRUTH, "and", [less(A, B, "!="), Not(TRUTH, P)]), "a != b && !p"),
        (Select(REAL, less(A, B), A, B), "a < b ? a : b"),
        (Select(REAL, P, Select(REAL, Q, A, B), C), "p ? (q ? a : b) : c"),
        (Select(REAL, P, A, Select(REAL, Q, B, C)), "p ? a : (q ? b : c)"),
        (binary("*", Select(REAL, P, A, B), C), "(p ? a : b) * c"),
        (Convert(REAL, I), "(double)i"),
        (Convert(REAL, binary("+", I, J)), "(double)(i + j)"),
        (binary("*", Convert(REAL, I), A), "(double)i * a"),
        (Convert(INTEGER, Negative(REAL, A)), "(int32_t)-a"),
        (Field(REAL, PARTS, "int"), "parts.int_"),
        (Field(REAL, Make(PAIR, [A, B]), "first"), "(Pair){a, b}.first"),
        (Index(REAL, MEMORY, binary("+", I, J)), "memory[i + j]"),
        (Intrinsic(REAL, "sqrt", [binary("+", A, B)]), "root(a + b)"),
        (Intrinsic(INTEGER, "floor", [A]), "next_below(a)"),
        (Intrinsic(INTEGER, "min", [I, J]), "whole_least(i, j)"),
        (Intrinsic(REAL, "min", [A, B]), "least(a, b)"),
        (Call(REAL, function_of(name="g"), [A, binary("-", A, B)]), "g(a, a - b)"),
        (Constant(TRUTH, True), "true"),
        (Constant(TRUTH, False), "false"),
        (Constant(INTEGER, 2**31 - 1), "2147483647"),
        (Constant(INTEGER, 2**31), "INT64_C(2147483648)"),
        (Constant(INTEGER, -(2**31)), "INT64_C(-2147483648)"),
        (Constant(REAL, -math.inf), "-(double)INFINITY"),
    ],
)
def test_brackets_stand_where_the_order_is_another_one(expression, text):
    assert body_of(Return(expression)).lines()[-1] == f"    return {text};"


def test_helpers_are_those_that_are_called():
    body = body_of()
    for expression in (binary("%", I, J), Intrinsic(REAL, "sqrt", [A]), Intrinsic(INTEGER, "abs", [I])):
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
    lines = body_of(Assign(A, ONE), Assign(A, binary("+", A, ONE)), Return(A)).lines()
    assert lines == ["    double a = 1.0;", "    a = a + 1.0;", "    return a;"]


def test_a_variable_is_declared_inside_the_block_that_alone_uses_it():
    inner = [Assign(A, ONE), Assign(B, A)]
    lines = body_of(Assign(B, ONE), If(P, inner, []), Return(B), parameters=[P]).lines()
    assert lines == ["    double b = 1.0;", "    if (p) {", "        double a = 1.0;", "        b = a;", "    }", "    return b;"]


@pytest.mark.parametrize(
    ("statements", "first"),
    [
        ([If(P, [Assign(A, ONE)], []), Return(A)], "    double a = 0.0;"),
        ([If(P, [Assign(A, ONE)], [Assign(A, B)]), Return(B)], "    double a = 0.0;"),
        ([While(less(A, B), [Assign(A, B)])], "    double a = 0.0;"),
        ([If(P, [Assign(I, I)], [])], "    int32_t i = 0;"),
        ([If(P, [Assign(Q, P)], []), Return(Q)], "    bool q = false;"),
        ([If(P, [Assign(PARTS, PARTS)], [])], "    Pair parts = {0};"),
        ([For(J, Constant(INTEGER, 0), I, [Assign(I, J)])], "    int32_t i = 0;"),
    ],
)
def test_a_variable_that_is_looked_at_elsewhere_is_zero_first(statements, first):
    assert body_of(*statements, parameters=[P, B]).lines()[0] == first


def test_statements_stand_in_their_blocks():
    three = Constant(INTEGER, 3)
    anonymous = Variable(INTEGER, "_")
    loop = For(anonymous, Constant(INTEGER, 0), three, [Store(MEMORY, I, A), Continue()])
    other = For(J, I, binary("+", I, three), [Break()])
    choice = If(less(A, B), [], [Evaluate(Call(VOID, function_of(name="g"), []))])
    both = If(P, [Return(None)], [While(P, [Assign(A, B)])])
    lines = body_of(loop, loop, other, choice, both, parameters=[A, B, I, P, MEMORY]).lines()
    assert lines == [
        "    for (int32_t round_1 = 0; round_1 < 3; ++round_1) {",
        "        memory[i] = a;",
        "        continue;",
        "    }",
        "    for (int32_t round_2 = 0; round_2 < 3; ++round_2) {",
        "        memory[i] = a;",
        "        continue;",
        "    }",
        "    for (int32_t j = i; j < i + 3; ++j) {",
        "        break;",
        "    }",
        "    if (!(a < b)) {",
        "        (void)g();",
        "    }",
        "    if (p) {",
        "        return;",
        "    } else {",
        "        while (p) {",
        "            a = b;",
        "        }",
        "    }",
    ]


def test_a_unit_is_its_structures_and_its_functions_with_what_each_is_for():
    plain = function_of(Return(ONE), name="g")
    told = function_of(Return(PARTS), parameters=[PARTS, Variable(Array(2), "table"), MEMORY], result=PAIR, description="Return `parts`.")
    nothing = Struct(Inner, ())
    text = Printer(Unit([plain, told, function_of(Return(Make(nothing, [])), name="h", result=nothing)]), "float").definitions()
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
    kinds = [PAIR, *(Struct(cls, ()) for cls in (twin, own, user, tuple)), Struct(tuple, (("_0", REAL),))]
    assert list(Names(kinds).structures.values()) == ["TestCCodePair", "SlipLawPair", "MinePair", "OwnPair", "Several", "Several_2"]
    assert list(Names([PAIR]).structures.values()) == ["Pair"]
    assert list(Names([PAIR], ["Pair"]).structures.values()) == ["Pair_2"]


@pytest.mark.parametrize(
    ("name", "written"),
    [("int", "int_"), ("int_", "int__"), ("x", "x"), ("_0", "part_0"), ("root", "root_"), ("g", "g_"), ("DBL_MAX", "DBL_MAX_")],
)
def test_a_name_that_c_has_already_gets_a_line_behind_it(name, written):
    assert Names([], ["g"]).variable(name) == written
