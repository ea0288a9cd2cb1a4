"""What is handed in from outside becomes a number, a name or an array, or is refused with its place."""

import math
import re
from dataclasses import dataclass

import numpy as np
import pytest

import bristle
from bristle.core.edge import (
    _EXAMPLES,
    CURVE,
    FLAG,
    NAMES,
    among,
    amount,
    array,
    component,
    guarded,
    instance,
    is_finite,
    many,
    mapping,
    model,
    optional,
    quantity_of,
    taken,
    variables_in,
    vector,
    whole,
)
from bristle.core.errors import InputError
from bristle.core.variable import Variable
from bristle.models.friction import coulomb
from bristle.models.hysteresis import play
from bristle.models.plants import inertia

LENGTH = Variable("length", "a length", min=-1.0, max=2.0)
POSITIVE = Variable("time", "a time", min=0.0)
SHARE = Variable("length", "a length", min=0.0, max=1.0)
COULOMB = coulomb(F_C=2.0)


@pytest.mark.parametrize(
    ("convert", "value", "expected"),
    [
        # Ends of a range are included.
        *(
            (amount(LENGTH), value, number)
            for value, number in ((-1.0, -1.0), (2, 2.0), ("5 mm", 0.005), (np.array(0.5), 0.5))
        ),
        (amount(POSITIVE), 0.0, 0.0),
        (amount(POSITIVE), 1e-299, 1e-299),
        (amount(POSITIVE, exclusive=True), 1e-9, 1e-9),
        (amount(SHARE, exclusive=True), 0.5, 0.5),
        (amount(POSITIVE, endless=True), math.inf, math.inf),
        # Of an unknown kind of axis: the unit of either.
        (amount(LENGTH), "90 deg", pytest.approx(math.pi / 2.0)),
        *(
            (whole(1, 5), value, count)
            for value, count in ((1, 1), (5, 5), (3.0, 3), (np.array(2), 2), (np.int64(4), 4))
        ),
        (whole(2, none=True), 0, 0),
        (among("load", "motor"), "load", "load"),
        (instance(int, "an integer"), 3, 3),
        (instance(float, "a number", read=float), "2.5", 2.5),
        (instance(float, "a number", read=lambda value: pytest.fail("read again")), 1.5, 1.5),
        (model("friction"), COULOMB, COULOMB),
        (model("plant", "friction"), COULOMB, COULOMB),
        (component("plant"), inertia, inertia),
        *(
            (many(whole(0), least=1, most=3), value, (1, 2))
            for value in ([1, 2], (1, 2), np.array([1, 2]))
        ),
        (many(whole(0), single=True), 1, (1,)),
        (many(whole(0), single=True), [1, 2], (1, 2)),
        (many(whole(0)), [], ()),
        (mapping(whole(0)), {"a": 1}, {"a": 1}),
        (optional(whole(1)), None, None),
        (optional(whole(1)), 2, 2),
        (NAMES, "a, b,,c ", ("a", "b", "c")),
        (NAMES, ["a", "b", "c"], ("a", "b", "c")),
        (NAMES, "", ()),
        (FLAG, np.bool_(True), True),
    ],
)
def test_a_value_that_is_allowed_is_taken(convert, value, expected):
    result = convert(value, "place", None)
    assert result == expected
    assert not isinstance(result, np.generic)


@pytest.mark.parametrize(
    ("convert", "value", "words"),
    [
        *(
            (amount(LENGTH), value, "place")
            for value in (-1.001, 2.001, math.nan, math.inf, "5 kg")
        ),
        (lambda value, path, kind: amount(LENGTH)(value, path, "translational"), "90 deg", "place"),
        (amount(POSITIVE, exclusive=True), 0.0, r"must be positive.*> 0"),
        (amount(POSITIVE, exclusive=True), -1.0, "must be positive"),
        (amount(LENGTH, exclusive=True), -1.0, "out of range"),
        (amount(SHARE, exclusive=True), 0.0, "must be positive"),
        (amount(SHARE, exclusive=True), 2.0, "out of range; found 2"),
        (amount(POSITIVE), 1e-301, "is too close to 0"),
        (amount(LENGTH), -1e-301, "is too close to 0"),
        (whole(1, 5), 0, "1 to 5"),
        (whole(1, 5), 6, "out of range"),
        *((whole(1, 5), value, "whole number") for value in (2.5, True, "3", math.nan)),
        (whole(2, none=True), 1, "0, or 2 and more"),
        (whole(2, 5, none=True), 1, "0, or 2 to 5"),
        (whole(2), 1, ">= 2"),
        (whole(2), None, "found 'None'"),
        (among("load", "motor"), "lod", "allowed load, motor.*load"),
        (among("load"), 1, "is not a valid choice"),
        (instance(int, "an integer", "Write one"), "x", "must be an integer.*Write one"),
        (
            model("friction"),
            coulomb,
            r"must be a friction model with parameters.*Call coulomb with its parameters: coulomb\(F_C=",
        ),
        (model("friction"), 3.0, "Give a model such as"),
        (
            model("plant", "friction"),
            play(r=1.0),
            "must be a plant model or friction model, but is a hysteresis operator",
        ),
        (component("plant"), coulomb, "must be a plant model without parameter values"),
        (component("friction"), COULOMB, "Give the attribute component of this model"),
        (many(whole(0), least=1), [], "a list or a tuple of at least 1"),
        (many(whole(0), most=3), [1, 2, 3, 4], "must be"),
        (many(whole(0)), 1, "must be a list or a tuple"),
        (many(whole(0)), [1, -1], r"place\[1\]"),
        (many(whole(0), least=2, most=2), [1], "must be a list or a tuple of two values"),
        (mapping(whole(0)), {"a": -1}, r"place\.a"),
        (mapping(whole(0)), [1], "must be a dictionary"),
        (NAMES, " , ", "is an empty list of names"),
        (FLAG, 1, "True or False"),
        (array(), [[1.0]], "must be a 1-D array"),
        (array(), 3.0, "must be a 1-D array"),
        (array(least=3), [1.0, 2.0], "too short.*at least 3 numbers"),
        (array(), [0.0, math.nan, math.inf], "nan at index 1.*Remove NaN and infinity"),
        *(
            (array(), value, "must hold real numbers")
            for value in (["a"], [[1.0], [1.0, 2.0]], [1j])
        ),
        (
            lambda value, path, kind: vector(value),
            np.ma.array([1.0, 2.0], mask=[True, False]),
            "masked",
        ),
        (
            CURVE,
            ([0.0, 1.0], [2.0]),
            "needs an output for each input, but has 2 inputs and 1 outputs",
        ),
        (CURVE, ([0.0],), "must be a curve, a pair of inputs and outputs"),
        (CURVE, ([], []), "too short"),
    ],
)
def test_any_other_value_is_refused_in_words(convert, value, words):
    with pytest.raises(InputError, match=words):
        convert(value, "place", None)


@pytest.mark.parametrize(
    ("convert", "value", "expected"),
    [
        (array(), [1, 2], [1.0, 2.0]),
        (array(ndim=2), [[1, 2]], [[1.0, 2.0]]),
        (array(single=True), 3.0, 3.0),
        (array(least=2), [1.0, 2.0], [1.0, 2.0]),
        (array(finite=False), [math.nan], [math.nan]),
        (CURVE, ([0.0, 1.0], [2.0, 3.0]), [[0.0, 1.0], [2.0, 3.0]]),
    ],
)
def test_arrays_are_of_numbers_of_so_many_dimensions(convert, value, expected):
    np.testing.assert_array_equal(convert(value, "x", None), expected)


@pytest.mark.parametrize(
    ("numbers", "finite"),
    [([1e308, 1e308], True), ([], True), ([1.0, math.nan], False), ([math.inf, -math.inf], False)],
)
def test_numbers_are_finite_though_their_sum_is_not(numbers, finite):
    assert is_finite(np.array(numbers)) is finite


@guarded(way=amount(LENGTH), count=whole(1))
def moved(friction, way, count=2, kind="translational"):
    return way, count


def test_a_guarded_function_takes_the_kind_of_axis_of_its_first_model():
    assert moved(coulomb(kind="rotational", F_C=2.0), "90 deg") == (pytest.approx(math.pi / 2.0), 2)
    assert moved(None, "5 mm", count=3.0) == (0.005, 3)
    assert moved(None, "90 deg", kind="rotational")[0] == pytest.approx(math.pi / 2.0)


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: moved(None, 0.1, 0), InputError, "count"),
        (lambda: moved(coulomb(kind="rotational", F_C=2.0), "5 mm"), InputError, "way"),
        (lambda: moved(None, 0.1, way=0.1), TypeError, "way"),
        (lambda: moved(None, 0.1, 1, "translational", 5), TypeError, None),
        (
            lambda: guarded(other=whole(1))(lambda friction: friction),
            TypeError,
            "no arguments other",
        ),
    ],
)
def test_a_guarded_function_refuses_invalid_arguments(call, error, words):
    with pytest.raises(error, match=words):
        call()


@guarded()
@dataclass(frozen=True)
class Moves:
    way: float = quantity_of(LENGTH)
    times: int = quantity_of(Variable("1", "times", min=1.0, max=9.0), 0, count=True)
    again: int = quantity_of(Variable("1", "again", min=1.0, max=9.0), 1, count=True)
    name: str = taken(among("a", "b"), "a")


def test_fields_of_a_guarded_class_are_converted_and_have_variables():
    moves = Moves("5 mm")
    assert (moves.way, moves.times, moves.again, moves.name) == (0.005, 0, 1, "a")
    assert list(variables_in(Moves)) == ["way", "times", "again"]
    assert Moves(0.1, times=0).times == 0
    for wrong, words in (({"again": 0}, "1 to 9"), ({"name": "c"}, "name")):
        with pytest.raises(InputError, match=words):
            Moves(0.1, **wrong)


@pytest.mark.parametrize("family", _EXAMPLES)
def test_the_model_named_as_an_example_is_of_its_family(family):
    call = _EXAMPLES[family].rpartition(" such as ")[2]
    names = {name: getattr(bristle, name) for name in bristle.__all__}
    assert eval(call, names).component.family == family  # the call as a person would copy it
    with pytest.raises(InputError, match=re.escape(call)):
        model(family)(None, "value", None)
