"""Expressions and statements of the tree as Structured Text: brackets, and what must stand before a value."""

import math
from typing import NamedTuple

import pytest

from bristle.exports.scope import NotExportableError
from bristle.exports.st_code import Body, Printer, is_safe
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
    second: float


PAIR = Struct(Pair, (("first", REAL), ("second", REAL)))
A, B, C = (Variable(REAL, name) for name in ("alpha", "beta", "gamma"))
I, J = (Variable(INTEGER, name) for name in ("place", "count"))
P, Q = (Variable(TRUTH, name) for name in ("open", "closed"))
PARTS, MEMORY = Variable(PAIR, "parts"), Variable(Array(4, writable=True), "memory")
ONE, TWO = Constant(REAL, 1.0), Constant(INTEGER, 2)


def binary(operator, left, right):
    return Binary(left.type, operator, left, right)


def less(left, right, operator="<"):
    return Compare(TRUTH, operator, left, right)


def function_of(*body, parameters=(), result=REAL, name="value", description=""):
    return Function(name, print, list(parameters), result, list(body), description)


G = function_of(parameters=[A, MEMORY], name="inner")
MADE = function_of(parameters=[A], result=PAIR, name="made")


def lines_of(*statements, parameters=(), result=REAL, scalar="LREAL"):
    function = function_of(*statements, parameters=parameters, result=result)
    return [line.removeprefix("    ") for line in Body(Printer(Unit([function]), "axis", (PAIR,), scalar), function).pou().body]


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        (binary("-", binary("-", A, B), C), "alpha - beta - gamma"),
        (binary("-", A, binary("-", B, C)), "alpha - (beta - gamma)"),
        # What was rounded before stands in brackets.
        (binary("-", binary("+", A, B), C), "(alpha + beta) - gamma"),
        (binary("+", binary("*", A, B), C), "alpha * beta + gamma"),
        (binary("/", binary("*", A, B), C), "(alpha * beta) / gamma"),
        (binary("-", binary("+", I, J), J), "place + count - count"),
        (binary("*", binary("+", A, B), C), "(alpha + beta) * gamma"),
        (binary("/", A, binary("*", B, C)), "alpha / (beta * gamma)"),
        (Negative(REAL, A), "-alpha"),
        (binary("*", Negative(REAL, A), B), "(-alpha) * beta"),
        (Negative(REAL, binary("*", A, B)), "-(alpha * beta)"),
        (Negative(REAL, Negative(REAL, A)), "-(-alpha)"),
        (binary("+", A, Constant(REAL, -2.0)), "alpha + (-2.0)"),
        (Not(TRUTH, P), "NOT open"),
        (Not(TRUTH, less(A, B)), "NOT (alpha < beta)"),
        (Not(TRUTH, Not(TRUTH, P)), "NOT (NOT open)"),
        (less(A, B, "=="), "alpha = beta"),
        (less(A, B, "!="), "alpha <> beta"),
        (less(A, B, ">="), "alpha >= beta"),
        (less(binary("-", A, B), binary("*", A, B)), "alpha - beta < alpha * beta"),
        (Logic(TRUTH, "and", [P, less(A, B)]), "open AND (alpha < beta)"),
        (Logic(TRUTH, "or", [Not(TRUTH, P), Logic(TRUTH, "and", [P, Q])]), "NOT open OR (open AND closed)"),
        (Convert(REAL, I), "DINT_TO_LREAL(place)"),
        (Index(REAL, MEMORY, binary("+", I, J)), "memory[place + count]"),
        (Field(REAL, PARTS, "second"), "parts.second"),
        (Intrinsic(REAL, "sqrt", [binary("+", A, B)]), "SQRT(alpha + beta)"),
        (Constant(TRUTH, True), "TRUE"),
        (Constant(TRUTH, False), "FALSE"),
        (Constant(REAL, 0.5), "0.5"),
        (Constant(INTEGER, -3), "-3"),
    ],
)
def test_brackets_stand_where_the_order_is_another_one(expression, text):
    assert lines_of(Return(expression), result=expression.type) == [f"axis_value := {text};"]


def test_bits_of_whole_numbers_are_words_of_the_language_and_places_are_narrow():
    assert lines_of(Return(binary("&", I, J))) == ["axis_value := LWORD_TO_LINT(LINT_TO_LWORD(place) AND LINT_TO_LWORD(count));"]
    assert lines_of(Return(binary("^", I, J))) == ["axis_value := LWORD_TO_LINT(LINT_TO_LWORD(place) XOR LINT_TO_LWORD(count));"]
    shifted = binary(">>", I, Constant(INTEGER, 3))
    assert lines_of(Return(shifted)) == ["axis_value := axis_floor_divided(first := place, second := 8);"]
    assert " ".join(map(str.strip, lines_of(Return(Index(REAL, MEMORY, binary("//", shifted, J)))))) == (
        "axis_value := memory[LINT_TO_DINT(axis_floor_divided(first := axis_floor_divided(first := place, second := 8), second := count))];"
    )
    assert lines_of(Return(Index(REAL, MEMORY, TWO)), Return(binary("%", shifted, J)))[0] == "axis_value := memory[2];"
    with pytest.raises(NotExportableError, match="a shift by what is not known here"):
        lines_of(Return(binary(">>", I, J)))


def test_helpers_are_called_by_the_names_of_their_inputs():
    assert lines_of(Return(Intrinsic(REAL, "min", [A, B]))) == ["axis_value := axis_min(first := alpha, second := beta);"]
    assert lines_of(Return(Intrinsic(INTEGER, "min", [I, J]))) == ["axis_value := axis_whole_min(first := place, second := count);"]
    assert lines_of(Return(Convert(INTEGER, A))) == ["axis_value := axis_truncated(number := alpha);"]
    assert lines_of(Return(Intrinsic(REAL, "min", [A, B])), scalar="REAL") == [
        "axis_value := axis_single_min(first := alpha, second := beta);"
    ]


def test_a_choice_inside_an_expression_is_made_before_it():
    chosen = Select(REAL, P, A, Select(REAL, Q, B, C))
    assert lines_of(Return(binary("*", chosen, C))) == [
        "IF open THEN",
        "    aside_1 := alpha;",
        "ELSIF closed THEN",
        "    aside_1 := beta;",
        "ELSE",
        "    aside_1 := gamma;",
        "END_IF;",
        "axis_value := aside_1 * gamma;",
    ]
    late = Select(REAL, P, A, Select(REAL, less(binary("/", A, B), C), B, C))
    assert lines_of(Assign(A, late)) == [
        "IF open THEN",
        "    alpha := alpha;",
        "ELSE",
        "    IF alpha / beta < gamma THEN",
        "        alpha := beta;",
        "    ELSE",
        "        alpha := gamma;",
        "    END_IF;",
        "END_IF;",
    ]


@pytest.mark.parametrize(("operator", "asked"), [("and", "aside_1"), ("or", "NOT aside_1")])
def test_truths_that_may_trap_are_computed_as_far_as_they_are_needed(operator, asked):
    unsafe = [less(binary("/", A, binary("+", B, part)), C) for part in (A, B)]
    assert lines_of(Return(Logic(TRUTH, operator, [P, *unsafe])), result=TRUTH) == [
        "aside_1 := open;",
        f"IF {asked} THEN",
        "    aside_1 := alpha / (beta + alpha) < gamma;",
        f"    IF {asked} THEN",
        "        aside_1 := alpha / (beta + beta) < gamma;",
        "    END_IF;",
        "END_IF;",
        "axis_value := aside_1;",
    ]
    assert lines_of(Return(Logic(TRUTH, operator, [unsafe[0], P])), result=TRUTH) == [
        f"axis_value := (alpha / (beta + alpha) < gamma) {operator.upper()} open;"
    ]


def test_a_truth_becomes_a_number_by_a_choice():
    assert lines_of(Return(Convert(REAL, P)))[1::2] == ["    aside_1 := 1.0;", "    aside_1 := 0.0;", "axis_value := aside_1;"]
    assert lines_of(Return(Convert(INTEGER, P)), result=INTEGER)[1::2] == [
        "    aside_1 := 1;",
        "    aside_1 := 0;",
        "axis_value := aside_1;",
    ]


def test_a_tuple_is_written_in_place_but_where_it_is_made_of_itself():
    swapped = Make(PAIR, [Field(REAL, PARTS, "second"), Field(REAL, PARTS, "first")])
    assert lines_of(Assign(PARTS, Make(PAIR, [A, B])))[:2] == ["parts.first := alpha;", "parts.second := beta;"]
    assert lines_of(Assign(PARTS, swapped)) == ["aside_1.first := parts.second;", "aside_1.second := parts.first;", "parts := aside_1;"]
    assert lines_of(Assign(PARTS, Call(PAIR, MADE, [A]))) == ["aside_1 := axis_made(alpha := alpha, given_back := parts);"]
    assert lines_of(Return(Field(REAL, Call(PAIR, MADE, [A]), "first"))) == [
        "aside_2 := axis_made(alpha := alpha, given_back := aside_1);",
        "axis_value := aside_1.first;",
    ]
    assert lines_of(Return(Make(PAIR, [A, B])), result=PAIR) == [
        "axis_value := TRUE;",
        "given_back.first := alpha;",
        "given_back.second := beta;",
    ]


def test_an_argument_that_takes_another_value_is_copied_first():
    assert lines_of(Assign(A, B), Return(A), parameters=[A, B]) == ["alpha := alpha_given;", "alpha := beta;", "axis_value := alpha;"]
    called = function_of(Assign(A, B), parameters=[A, B], name="inner")
    assert lines_of(Return(Call(REAL, called, [C, ONE]))) == ["axis_value := axis_inner(alpha_given := gamma, beta := 1.0);"]


def test_a_loop_counts_from_one_below_its_start_to_one_below_its_end():
    assert lines_of(For(I, Constant(INTEGER, 0), Constant(INTEGER, 3), [Store(MEMORY, I, A), Continue()])) == [
        "place := -1;",
        "WHILE place < 2 DO",
        "    place := place + 1;",
        "    memory[place] := alpha;",
        "    CONTINUE;",
        "END_WHILE;",
    ]
    assert lines_of(For(Variable(INTEGER, "_"), I, binary("+", I, J), [Break()])) == [
        "aside_2 := place + count - 1;",
        "aside_1 := place - 1;",
        "WHILE aside_1 < aside_2 DO",
        "    aside_1 := aside_1 + 1;",
        "    EXIT;",
        "END_WHILE;",
    ]


def test_a_loop_asks_inside_where_its_question_needs_a_statement():
    assert lines_of(While(less(A, B), [Assign(A, B)])) == ["WHILE alpha < beta DO", "    alpha := beta;", "END_WHILE;"]
    assert lines_of(While(less(binary("/", A, B), C), [Break()])) == [
        "WHILE TRUE DO",
        "    IF NOT (alpha / beta < gamma) THEN",
        "        EXIT;",
        "    END_IF;",
        "    EXIT;",
        "END_WHILE;",
    ]


def test_blocks_are_chosen_one_behind_the_other_and_one_that_is_empty_is_turned():
    step = [Assign(A, B)]
    assert lines_of(If(P, [], step)) == ["IF NOT open THEN", "    alpha := beta;", "END_IF;"]
    assert lines_of(If(P, step, [If(Q, step, step)])) == [
        "IF open THEN",
        "    alpha := beta;",
        "ELSIF closed THEN",
        "    alpha := beta;",
        "ELSE",
        "    alpha := beta;",
        "END_IF;",
    ]
    unsafe = lines_of(If(P, step, [If(less(binary("/", A, B), C), step, [])]))
    assert unsafe[2:4] == ["ELSE", "    IF alpha / beta < gamma THEN"]
    assert lines_of(If(P, step, [If(Q, [], step)]))[2:4] == ["ELSE", "    IF NOT closed THEN"]
    assert lines_of(If(P, step, [If(Q, step, []), *step]))[2:4] == ["ELSE", "    IF closed THEN"]


def test_a_function_ends_where_it_returns_and_one_without_a_result_gives_a_truth():
    assert lines_of(If(P, [Return(A)], []), Return(B)) == [
        "IF open THEN",
        "    axis_value := alpha;",
        "    RETURN;",
        "END_IF;",
        "axis_value := beta;",
    ]
    assert lines_of(Evaluate(Call(REAL, G, [A, MEMORY])), Return(None), result=VOID) == [
        "axis_value := TRUE;",
        "aside_1 := axis_inner(alpha := alpha, memory := memory);",
    ]


@pytest.mark.parametrize(
    ("expression", "safe"),
    [
        (less(binary("*", A, B), binary("-", A, B)), True),
        (less(Intrinsic(REAL, "abs", [A]), Negative(REAL, B)), True),
        (less(Field(REAL, PARTS, "first"), A), True),
        (less(binary("/", A, B), C), False),
        (less(binary("//", I, J), J), False),
        (less(Intrinsic(REAL, "sqrt", [A]), B), False),
        (less(Index(REAL, MEMORY, I), A), False),
        (less(Call(REAL, G, [A, MEMORY]), A), False),
        (less(Select(REAL, P, A, B), A), False),
        (less(Convert(REAL, I), A), False),
    ],
)
def test_what_may_trap_or_needs_a_statement_is_computed_only_where_it_is_needed(expression, safe):
    assert is_safe(expression) is safe


def test_data_types_have_a_name_and_a_place_for_everything():
    nothing = Struct(Pair, ())
    function = function_of(Return(A), parameters=[A, MEMORY, PARTS, Variable(nothing, "empty"), Variable(Array(0), "none_of")])
    types, (pou,) = Printer(Unit([function]), "axis").parts()
    assert [(kind.name, getattr(kind, "size", None)) for kind in types[:2]] == [("axis_Numbers_0", 1), ("axis_Numbers_4", 4)]
    assert [(field.name, field.type) for field in types[2].fields] == [("first", "LREAL"), ("second", "LREAL")]
    assert [(field.name, field.type) for field in types[3].fields] == [("nothing", "BOOL")]
    assert [(part.name, part.section) for part in pou.variables] == [
        ("alpha", "VAR_INPUT"),
        ("memory", "VAR_IN_OUT"),
        ("parts", "VAR_IN_OUT"),
        ("empty", "VAR_IN_OUT"),
        ("none_of", "VAR_IN_OUT"),
    ]
    assert (pou.kind, pou.name, pou.returns) == ("FUNCTION", "axis_value", "LREAL")


def test_a_limit_from_below_is_a_number_just_below_zero():
    printer = Printer(Unit([]), "axis")
    assert printer.real(0.0) == "0.0"
    below = printer.real(-0.0)
    assert below.startswith("(-") or below.startswith("-")
    assert -1e-30 < math.prod(float(part) for part in below.strip("()").split(" * ")) < 0.0


def test_numbers_cross_to_single_precision_and_back():
    double, single = Printer(Unit([]), "axis"), Printer(Unit([]), "axis", scalar="REAL")
    assert (double.narrowed("x"), double.widened("x")) == ("x", "x")
    assert (single.narrowed("x"), single.widened("x")) == ("LREAL_TO_REAL(x)", "REAL_TO_LREAL(x)")
    assert (double.array(3), single.array(3), single.array(3, "LREAL")) == ("axis_Numbers_3", "axis_Singles_3", "axis_Numbers_3")
