"""Expressions and statements of the tree as Structured Text: brackets, and what must stand before a value."""

import math
from typing import NamedTuple

import pytest

from bristle.exports import tree as t
from bristle.exports.scope import NotExportableError
from bristle.exports.st_code import Body, Printer, is_safe
from bristle.exports.tree import INTEGER, REAL, TRUTH, VOID


class Pair(NamedTuple):
    first: float
    second: float


PAIR = t.Struct(Pair, (("first", REAL), ("second", REAL)))
A, B, C = (t.Variable(REAL, name) for name in ("alpha", "beta", "gamma"))
N, K = (t.Variable(INTEGER, name) for name in ("place", "count"))
P, Q = (t.Variable(TRUTH, name) for name in ("open", "closed"))
PARTS, MEMORY = t.Variable(PAIR, "parts"), t.Variable(t.Array(4, writable=True), "memory")
ONE, TWO = t.Constant(REAL, 1.0), t.Constant(INTEGER, 2)


def binary(operator, left, right):
    return t.Binary(left.type, operator, left, right)


def less(left, right, operator="<"):
    return t.Compare(TRUTH, operator, left, right)


def function_of(*body, parameters=(), result=REAL, name="value", description=""):
    return t.Function(name, print, list(parameters), result, list(body), description)


G = function_of(parameters=[A, MEMORY], name="inner")
MADE = function_of(parameters=[A], result=PAIR, name="made")


def text_of(*statements, parameters=(), result=REAL, scalar="LREAL"):
    """Return the body of a function of these statements in one line."""
    function = function_of(*statements, parameters=parameters, result=result)
    return " ".join(line.strip() for line in Body(Printer(t.Unit([function]), "axis", (PAIR,), scalar), function).pou().body)


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        (binary("-", binary("-", A, B), C), "alpha - beta - gamma"),
        (binary("-", A, binary("-", B, C)), "alpha - (beta - gamma)"),
        # What was rounded before stands in brackets.
        (binary("-", binary("+", A, B), C), "(alpha + beta) - gamma"),
        (binary("+", binary("*", A, B), C), "alpha * beta + gamma"),
        (binary("/", binary("*", A, B), C), "(alpha * beta) / gamma"),
        (binary("-", binary("+", N, K), K), "place + count - count"),
        (binary("*", binary("+", A, B), C), "(alpha + beta) * gamma"),
        (binary("/", A, binary("*", B, C)), "alpha / (beta * gamma)"),
        (t.Negative(REAL, A), "-alpha"),
        (binary("*", t.Negative(REAL, A), B), "(-alpha) * beta"),
        (t.Negative(REAL, binary("*", A, B)), "-(alpha * beta)"),
        (t.Negative(REAL, t.Negative(REAL, A)), "-(-alpha)"),
        (binary("+", A, t.Constant(REAL, -2.0)), "alpha + (-2.0)"),
        (t.Not(TRUTH, P), "NOT open"),
        (t.Not(TRUTH, less(A, B)), "NOT (alpha < beta)"),
        (t.Not(TRUTH, t.Not(TRUTH, P)), "NOT (NOT open)"),
        (less(A, B, "=="), "alpha = beta"),
        (less(A, B, "!="), "alpha <> beta"),
        (less(A, B, ">="), "alpha >= beta"),
        (less(binary("-", A, B), binary("*", A, B)), "alpha - beta < alpha * beta"),
        (t.Logic(TRUTH, "and", [P, less(A, B)]), "open AND (alpha < beta)"),
        (t.Logic(TRUTH, "or", [t.Not(TRUTH, P), t.Logic(TRUTH, "and", [P, Q])]), "NOT open OR (open AND closed)"),
        (t.Convert(REAL, N), "DINT_TO_LREAL(place)"),
        (t.Index(REAL, MEMORY, binary("+", N, K)), "memory[place + count]"),
        (t.Field(REAL, PARTS, "second"), "parts.second"),
        (t.Intrinsic(REAL, "sqrt", [binary("+", A, B)]), "SQRT(alpha + beta)"),
        (t.Constant(TRUTH, True), "TRUE"),
        (t.Constant(TRUTH, False), "FALSE"),
        (t.Constant(REAL, 0.5), "0.5"),
        (t.Constant(INTEGER, -3), "-3"),
    ],
)
def test_brackets_stand_where_the_order_is_another_one(expression, text):
    assert text_of(t.Return(expression), result=expression.type) == f"axis_value := {text};"


def test_bits_of_whole_numbers_are_words_of_the_language_and_places_are_narrow():
    assert text_of(t.Return(binary("&", N, K))) == "axis_value := LWORD_TO_LINT(LINT_TO_LWORD(place) AND LINT_TO_LWORD(count));"
    assert text_of(t.Return(binary("^", N, K))) == "axis_value := LWORD_TO_LINT(LINT_TO_LWORD(place) XOR LINT_TO_LWORD(count));"
    shifted = binary(">>", N, t.Constant(INTEGER, 3))
    assert text_of(t.Return(shifted)) == "axis_value := axis_floor_divided(first := place, second := 8);"
    assert text_of(t.Return(t.Index(REAL, MEMORY, binary("//", shifted, K)))) == (
        "axis_value := memory[LINT_TO_DINT(axis_floor_divided(first := axis_floor_divided(first := place, second := 8), second := count))];"
    )
    assert text_of(t.Return(t.Index(REAL, MEMORY, TWO)), t.Return(binary("%", shifted, K))).startswith("axis_value := memory[2];")
    with pytest.raises(NotExportableError, match="a shift by what is not known here"):
        text_of(t.Return(binary(">>", N, K)))


def test_helpers_are_called_by_the_names_of_their_inputs():
    assert text_of(t.Return(t.Intrinsic(REAL, "min", [A, B]))) == "axis_value := axis_min(first := alpha, second := beta);"
    assert text_of(t.Return(t.Intrinsic(INTEGER, "min", [N, K]))) == "axis_value := axis_whole_min(first := place, second := count);"
    assert text_of(t.Return(t.Convert(INTEGER, A))) == "axis_value := axis_truncated(number := alpha);"
    assert text_of(t.Return(t.Intrinsic(REAL, "min", [A, B])), scalar="REAL") == (
        "axis_value := axis_single_min(first := alpha, second := beta);"
    )


def test_a_choice_inside_an_expression_is_made_before_it():
    chosen = t.Select(REAL, P, A, t.Select(REAL, Q, B, C))
    assert text_of(t.Return(binary("*", chosen, C))) == (
        "IF open THEN aside_1 := alpha; ELSIF closed THEN aside_1 := beta; ELSE aside_1 := gamma; END_IF; axis_value := aside_1 * gamma;"
    )
    late = t.Select(REAL, P, A, t.Select(REAL, less(binary("/", A, B), C), B, C))
    assert text_of(t.Assign(A, late)) == (
        "IF open THEN alpha := alpha; ELSE IF alpha / beta < gamma THEN alpha := beta; ELSE alpha := gamma; END_IF; END_IF;"
    )


@pytest.mark.parametrize(("operator", "asked"), [("and", "aside_1"), ("or", "NOT aside_1")])
def test_truths_that_may_trap_are_computed_as_far_as_they_are_needed(operator, asked):
    unsafe = [less(binary("/", A, binary("+", B, part)), C) for part in (A, B)]
    assert text_of(t.Return(t.Logic(TRUTH, operator, [P, *unsafe])), result=TRUTH) == (
        f"aside_1 := open; IF {asked} THEN aside_1 := alpha / (beta + alpha) < gamma; IF {asked} THEN aside_1 := alpha / (beta + "
        "beta) < gamma; END_IF; END_IF; axis_value := aside_1;"
    )
    assert text_of(t.Return(t.Logic(TRUTH, operator, [unsafe[0], P])), result=TRUTH) == (
        f"axis_value := (alpha / (beta + alpha) < gamma) {operator.upper()} open;"
    )


def test_a_truth_becomes_a_number_by_a_choice():
    assert text_of(t.Return(t.Convert(REAL, P))) == "IF open THEN aside_1 := 1.0; ELSE aside_1 := 0.0; END_IF; axis_value := aside_1;"
    assert text_of(t.Return(t.Convert(INTEGER, P)), result=INTEGER).startswith("IF open THEN aside_1 := 1; ELSE aside_1 := 0; END_IF;")


def test_a_tuple_is_written_in_place_but_where_it_is_made_of_itself():
    swapped = t.Make(PAIR, [t.Field(REAL, PARTS, "second"), t.Field(REAL, PARTS, "first")])
    assert text_of(t.Assign(PARTS, t.Make(PAIR, [A, B]))) == "parts.first := alpha; parts.second := beta;"
    assert text_of(t.Assign(PARTS, swapped)) == "aside_1.first := parts.second; aside_1.second := parts.first; parts := aside_1;"
    assert text_of(t.Assign(PARTS, t.Call(PAIR, MADE, [A]))) == "aside_1 := axis_made(alpha := alpha, given_back := parts);"
    assert text_of(t.Return(t.Field(REAL, t.Call(PAIR, MADE, [A]), "first"))) == (
        "aside_2 := axis_made(alpha := alpha, given_back := aside_1); axis_value := aside_1.first;"
    )
    assert text_of(t.Return(t.Make(PAIR, [A, B])), result=PAIR) == (
        "axis_value := TRUE; given_back.first := alpha; given_back.second := beta;"
    )


def test_an_argument_that_takes_another_value_is_copied_first():
    assert text_of(t.Assign(A, B), t.Return(A), parameters=[A, B]) == "alpha := alpha_given; alpha := beta; axis_value := alpha;"
    called = function_of(t.Assign(A, B), parameters=[A, B], name="inner")
    assert text_of(t.Return(t.Call(REAL, called, [C, ONE]))) == "axis_value := axis_inner(alpha_given := gamma, beta := 1.0);"


def test_a_loop_counts_from_one_below_its_start_to_one_below_its_end():
    assert text_of(t.For(N, t.Constant(INTEGER, 0), t.Constant(INTEGER, 3), [t.Store(MEMORY, N, A), t.Continue()])) == (
        "place := -1; WHILE place < 2 DO place := place + 1; memory[place] := alpha; CONTINUE; END_WHILE;"
    )
    assert text_of(t.For(t.Variable(INTEGER, "_"), N, binary("+", N, K), [t.Break()])) == (
        "aside_2 := place + count - 1; aside_1 := place - 1; WHILE aside_1 < aside_2 DO aside_1 := aside_1 + 1; EXIT; END_WHILE;"
    )


def test_a_loop_asks_inside_where_its_question_needs_a_statement():
    assert text_of(t.While(less(A, B), [t.Assign(A, B)])) == "WHILE alpha < beta DO alpha := beta; END_WHILE;"
    assert text_of(t.While(less(binary("/", A, B), C), [t.Break()])) == (
        "WHILE TRUE DO IF NOT (alpha / beta < gamma) THEN EXIT; END_IF; EXIT; END_WHILE;"
    )


def test_blocks_are_chosen_one_behind_the_other_and_one_that_is_empty_is_turned():
    step = [t.Assign(A, B)]
    assert text_of(t.If(P, [], step)) == "IF NOT open THEN alpha := beta; END_IF;"
    assert text_of(t.If(P, step, [t.If(Q, step, step)])) == (
        "IF open THEN alpha := beta; ELSIF closed THEN alpha := beta; ELSE alpha := beta; END_IF;"
    )
    assert "; ELSE IF alpha / beta < gamma THEN" in text_of(t.If(P, step, [t.If(less(binary("/", A, B), C), step, [])]))
    assert "; ELSE IF NOT closed THEN" in text_of(t.If(P, step, [t.If(Q, [], step)]))
    assert "; ELSE IF closed THEN" in text_of(t.If(P, step, [t.If(Q, step, []), *step]))


def test_a_function_ends_where_it_returns_and_one_without_a_result_gives_a_truth():
    assert text_of(t.If(P, [t.Return(A)], []), t.Return(B)) == "IF open THEN axis_value := alpha; RETURN; END_IF; axis_value := beta;"
    assert text_of(t.Evaluate(t.Call(REAL, G, [A, MEMORY])), t.Return(None), result=VOID) == (
        "axis_value := TRUE; aside_1 := axis_inner(alpha := alpha, memory := memory);"
    )


@pytest.mark.parametrize(
    ("expression", "safe"),
    [
        (less(binary("*", A, B), binary("-", A, B)), True),
        (less(t.Intrinsic(REAL, "abs", [A]), t.Negative(REAL, B)), True),
        (less(t.Field(REAL, PARTS, "first"), A), True),
        (less(binary("/", A, B), C), False),
        (less(binary("//", N, K), K), False),
        (less(t.Intrinsic(REAL, "sqrt", [A]), B), False),
        (less(t.Index(REAL, MEMORY, N), A), False),
        (less(t.Call(REAL, G, [A, MEMORY]), A), False),
        (less(t.Select(REAL, P, A, B), A), False),
        (less(t.Convert(REAL, N), A), False),
    ],
)
def test_what_may_trap_or_needs_a_statement_is_computed_only_where_it_is_needed(expression, safe):
    assert is_safe(expression) is safe


def test_data_types_have_a_name_and_a_place_for_everything():
    nothing = t.Struct(Pair, ())
    function = function_of(t.Return(A), parameters=[A, MEMORY, PARTS, t.Variable(nothing, "empty"), t.Variable(t.Array(0), "none_of")])
    types, (pou,) = Printer(t.Unit([function]), "axis").parts()
    assert [(kind.name, getattr(kind, "size", None)) for kind in types[:2]] == [("axis_Numbers_0", 1), ("axis_Numbers_4", 4)]
    assert [(field.name, field.type) for field in types[2].fields] == [("first", "LREAL"), ("second", "LREAL")]
    assert [(field.name, field.type) for field in types[3].fields] == [("nothing", "BOOL")]
    assert [part.section for part in pou.variables] == ["VAR_INPUT", *["VAR_IN_OUT"] * 4]
    assert (pou.kind, pou.name, pou.returns) == ("FUNCTION", "axis_value", "LREAL")


def test_a_limit_from_below_is_a_number_just_below_zero():
    printer = Printer(t.Unit([]), "axis")
    assert printer.real(0.0) == "0.0"
    below = printer.real(-0.0)
    assert below.startswith(("(-", "-"))
    assert -1e-30 < math.prod(float(part) for part in below.strip("()").split(" * ")) < 0.0


def test_numbers_cross_to_single_precision_and_back():
    double, single = Printer(t.Unit([]), "axis"), Printer(t.Unit([]), "axis", scalar="REAL")
    assert (double.narrowed("x"), double.widened("x")) == ("x", "x")
    assert (single.narrowed("x"), single.widened("x")) == ("LREAL_TO_REAL(x)", "REAL_TO_LREAL(x)")
    assert (double.array(3), single.array(3), single.array(3, "LREAL")) == ("axis_Numbers_3", "axis_Singles_3", "axis_Numbers_3")
