"""What printers share: which numbers need 64 bits, in which order tuples stand, where lines break, how long loops take."""

from typing import NamedTuple

import pytest

from bristle.exports.printing import element, loops_of, needs_wide_integers, structures_of, types_in, wrapped
from bristle.translation import tree as t
from bristle.translation.scope import free_name
from bristle.translation.tree import INTEGER, REAL, TRUTH, VOID

X, N = t.Variable(REAL, "x"), t.Variable(INTEGER, "n")


def whole(value):
    return t.Constant(INTEGER, value)


def function_of(*body, parameters=(X, N), result=VOID, name="f", description=""):
    return t.Function(name, print, list(parameters), result, list(body), description)


def test_integers_beyond_31_bits_and_bitwise_operations_are_64_bit():
    narrow = [whole(2**31 - 1), whole(1 - 2**31), t.Constant(REAL, 1e12), *(t.Binary(INTEGER, operator, N, N) for operator in "+%")]
    wide = [whole(2**31), whole(-(2**31)), *(t.Binary(INTEGER, operator, N, N) for operator in ("&", "^", ">>"))]
    outcome = [[needs_wide_integers(t.Unit([function_of(), function_of(t.Return(e))])) for e in group] for group in (narrow, wide)]
    assert outcome == [[False] * 5, [True] * 5]


class Inner(NamedTuple):
    a: float


class Outer(NamedTuple):
    inner: Inner
    b: float


def test_a_tuple_is_listed_once_after_its_inner_tuples():
    inner = t.Struct(Inner, (("a", REAL),))
    outer = t.Struct(Outer, (("inner", inner), ("b", REAL)))
    assert structures_of([REAL, outer, inner, t.Array(3), outer]) == [inner, outer]
    assert structures_of([inner, outer]) == [inner, outer]
    assert structures_of([REAL, t.Array(2)]) == []


def test_types_of_a_function_include_result_arguments_and_body():
    kinds = types_in(function_of(t.Return(t.Compare(TRUTH, "<", X, t.Constant(REAL, 0.0))), parameters=[N], result=TRUTH))
    assert kinds == [TRUTH, INTEGER, TRUTH, REAL, REAL]


@pytest.mark.parametrize(
    ("line", "lines"),
    [
        ("x" * 110, ["x" * 110]),
        ("a" * 50 + ", " + "b" * 58, ["a" * 50 + ", " + "b" * 58]),
        ("a" * 50 + ", " + "b" * 59, ["a" * 50 + ",", "        " + "b" * 59]),
        ("a" * 50 + " + " + "b" * 60, ["a" * 50, "        + " + "b" * 60]),
        ("a" * 50 + ", " + "b" * 20 + " ? " + "c" * 60, ["a" * 50 + ", " + "b" * 20, "        ? " + "c" * 60]),
        ("a" * 30 + ", " + "b" * 90, ["a" * 30 + ", " + "b" * 90]),  # in the first forty letters no line ends
    ],
)
def test_a_line_of_more_than_110_letters_breaks_after_a_comma_or_before_an_operator(line, lines):
    assert wrapped(line, "") == lines


def test_a_used_name_gets_the_first_free_number_from_two():
    assert free_name("f", {"g"}) == "f"
    assert free_name("f", {"f"}) == "f_2"
    assert free_name("f", {"f", "f_2", "f_4"}) == "f_3"


def test_an_element_contains_text_and_then_further_elements():
    made = element("a", "text", element("b"), " more", element("c", name="d"), size="3")
    assert (made.tag, made.text, made.attrib) == ("a", "text more", {"size": "3"})
    assert [(inner.tag, inner.attrib) for inner in made] == [("b", {}), ("c", {"name": "d"})]


def test_rounds_of_bounded_loops_are_counted():
    counted = t.For(N, whole(2), whole(7), [t.Assign(X, X)])
    open_end, open_start = t.For(N, whole(0), N, []), t.For(N, N, whole(7), [])
    until = t.While(t.Compare(TRUTH, "<", X, X), [counted])
    unit = t.Unit([function_of(name="none"), function_of(until, open_end, open_start, name="many", description="of `x`")])
    assert loops_of(unit, 21) == [
        {"function": "many", "description": "of x", "most": "5, half of the stored turning points"},
        {"function": "many", "description": "of x", "most": "5"},
        {"function": "many", "description": "of x", "most": "the number in its argument"},
        {"function": "many", "description": "of x", "most": "the number in its argument"},
    ]
