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
from bristle.friction import coulomb, lugre
from bristle.hysteresis import play
from bristle.plants import inertia

LENGTH = Variable("length", "a length", min=-1.0, max=2.0)
POSITIVE = Variable("time", "a time", min=0.0)


def refused(converter, value, words, kind=None):
    with pytest.raises(InputError, match=words):
        converter(value, "place", kind)


def test_an_amount_lies_within_its_range_ends_included():
    convert = amount(LENGTH)
    assert [convert(value, "x", None) for value in (-1.0, 2, "5 mm", np.array(0.5))] == [-1.0, 2.0, 0.005, 0.5]
    for value in (-1.001, 2.001, math.nan, math.inf):
        refused(convert, value, "place")
    assert amount(POSITIVE)(0.0, "t", None) == 0.0
    refused(amount(POSITIVE, exclusive=True), 0.0, r"must be positive.*> 0")
    refused(amount(POSITIVE, exclusive=True), -1.0, "must be positive")
    assert amount(POSITIVE, exclusive=True)(1e-9, "t", None) == 1e-9
    refused(amount(LENGTH, exclusive=True), -1.0, "out of range")
    assert amount(POSITIVE, endless=True)(math.inf, "t", None) == math.inf


def test_numbers_close_to_zero_are_refused():
    refused(amount(POSITIVE), 1e-301, "is too close to 0")
    refused(amount(LENGTH), -1e-301, "is too close to 0")
    assert amount(POSITIVE)(1e-299, "t", None) == 1e-299


def test_an_amount_of_an_unknown_kind_of_axis_has_the_unit_of_either():
    assert amount(LENGTH)("90 deg", "x", None) == pytest.approx(math.pi / 2.0)
    refused(amount(LENGTH), "90 deg", "place", kind="translational")
    refused(amount(LENGTH), "5 kg", "place")


def test_counts_are_whole_and_zero_may_be_allowed():
    assert [whole(1, 5)(value, "n", None) for value in (1, 5, 3.0, np.array(2), np.int64(4))] == [1, 5, 3, 2, 4]
    assert whole(2, none=True)(0, "n", None) == 0
    for value, words in ((0, "1 to 5"), (6, "out of range"), (2.5, "whole number"), (True, "whole number"), ("3", "whole number")):
        refused(whole(1, 5), value, words)
    refused(whole(2, none=True), 1, "0, or 2 and more")
    refused(whole(2, 5, none=True), 1, "0, or 2 to 5")
    refused(whole(2), 1, ">= 2")
    refused(whole(2), None, "found 'None'")
    refused(whole(2), math.nan, "whole number")


def test_invalid_choices_are_refused_with_the_allowed_words():
    assert among("load", "motor")("load", "side", None) == "load"
    refused(among("load", "motor"), "lod", "allowed load, motor.*load")
    refused(among("load"), 1, "is not a valid choice")


def test_an_instance_may_be_read_from_something_else():
    assert instance(int, "an integer")(3, "n", None) == 3
    assert instance(float, "a number", read=float)("2.5", "n", None) == 2.5
    assert instance(float, "a number", read=lambda value: pytest.fail("read again"))(1.5, "n", None) == 1.5
    refused(instance(int, "an integer", "Write one"), "x", "must be an integer.*Write one")


def test_components_and_models_of_other_families_are_refused():
    friction = coulomb(F_C=2.0)
    assert model("friction")(friction, "f", None) is friction
    assert model("plant", "friction")(friction, "f", None) is friction
    refused(model("friction"), coulomb, r"must be a friction model with parameters.*Call coulomb with its parameters: coulomb\(F_C=")
    refused(model("friction"), 3.0, "Give a model such as")
    refused(model("plant", "friction"), play(r=1.0), "must be a plant model or friction model, but is a hysteresis operator")
    assert component("plant")(inertia, "p", None) is inertia
    refused(component("plant"), coulomb, "must be a plant model without parameter values")
    refused(component("friction"), friction, "Give the attribute component of this model")


def test_lists_have_as_many_entries_as_are_asked_for():
    convert = many(whole(0), least=1, most=3)
    assert convert([1, 2], "n", None) == convert((1, 2), "n", None) == convert(np.array([1, 2]), "n", None) == (1, 2)
    refused(convert, [], "a list or a tuple of at least 1")
    refused(convert, [1, 2, 3, 4], "must be")
    refused(convert, 1, "must be a list or a tuple")
    refused(convert, [1, -1], r"place\[1\]")
    assert many(whole(0), single=True)(1, "n", None) == (1,)
    assert many(whole(0), single=True)([1, 2], "n", None) == (1, 2)
    refused(many(whole(0), least=2, most=2), [1], "must be a list or a tuple of two values")
    assert many(whole(0))([], "n", None) == ()


def test_errors_in_a_dictionary_name_the_key():
    assert mapping(whole(0))({"a": 1}, "n", None) == {"a": 1}
    refused(mapping(whole(0)), {"a": -1}, r"place\.a")
    refused(mapping(whole(0)), [1], "must be a dictionary")
    assert optional(whole(1))(None, "n", None) is None
    assert optional(whole(1))(2, "n", None) == 2


def test_names_are_separated_by_commas_and_truth_values_are_not_numbers():
    assert NAMES("a, b,,c ", "names", None) == NAMES(["a", "b", "c"], "names", None) == ("a", "b", "c")
    assert NAMES("", "names", None) == ()
    refused(NAMES, " , ", "is an empty list of names")
    assert FLAG(np.bool_(True), "flag", None) is True
    refused(FLAG, 1, "True or False")


def test_arrays_are_of_numbers_of_so_many_dimensions():
    assert array()([1, 2], "x", None).tolist() == [1.0, 2.0]
    assert array(ndim=2)([[1, 2]], "x", None).shape == (1, 2)
    assert array(single=True)(3.0, "x", None).shape == ()
    refused(array(), [[1.0]], "must be a 1-D array")
    refused(array(), 3.0, "must be a 1-D array")
    refused(array(least=3), [1.0, 2.0], "too short.*at least 3 numbers")
    assert array(least=2)([1.0, 2.0], "x", None).size == 2
    refused(array(), [0.0, math.nan, math.inf], "nan at index 1.*Remove NaN and infinity")
    assert np.isnan(array(finite=False)([math.nan], "x", None)).all()
    for value in (["a"], [[1.0], [1.0, 2.0]], [1j]):
        refused(array(), value, "must hold real numbers")
    with pytest.raises(InputError, match="masked"):
        vector(np.ma.array([1.0, 2.0], mask=[True, False]))


def test_numbers_are_finite_though_their_sum_is_not():
    assert is_finite(np.array([1e308, 1e308]))
    assert is_finite(np.zeros(0))
    assert not is_finite(np.array([1.0, np.nan]))
    assert not is_finite(np.array([np.inf, -np.inf]))


def test_a_curve_has_an_output_for_each_input():
    u, f = CURVE(([0.0, 1.0], [2.0, 3.0]), "curve", None)
    assert (u.tolist(), f.tolist()) == ([0.0, 1.0], [2.0, 3.0])
    refused(CURVE, ([0.0, 1.0], [2.0]), "needs an output for each input, but has 2 inputs and 1 outputs")
    refused(CURVE, ([0.0],), "must be a curve, a pair of inputs and outputs")
    refused(CURVE, ([], []), "too short")


def test_a_guarded_function_takes_the_kind_of_axis_of_its_first_model():
    @guarded(way=amount(LENGTH), count=whole(1))
    def reported(friction, way, count=2, kind="translational"):
        return way, count

    turning = coulomb(kind="rotational", F_C=2.0)
    assert reported(turning, "90 deg") == (pytest.approx(math.pi / 2.0), 2)
    assert reported(None, "5 mm", count=3.0) == (0.005, 3)
    assert reported(None, "90 deg", kind="rotational")[0] == pytest.approx(math.pi / 2.0)
    with pytest.raises(InputError, match="count"):
        reported(None, 0.1, 0)
    with pytest.raises(InputError):
        reported(turning, "5 mm")
    with pytest.raises(TypeError):
        reported(None, 0.1, way=0.1)
    with pytest.raises(TypeError):
        reported(None, 0.1, 1, "translational", 5)
    with pytest.raises(TypeError, match="no arguments other"):
        guarded(other=whole(1))(lambda friction: friction)


def test_fields_of_a_guarded_class_are_converted_and_have_variables():
    @guarded()
    @dataclass(frozen=True)
    class Moves:
        way: float = quantity_of(LENGTH)
        times: int = quantity_of(Variable("1", "times", min=1.0, max=9.0), 0, count=True)
        again: int = quantity_of(Variable("1", "again", min=1.0, max=9.0), 1, count=True)
        name: str = taken(among("a", "b"), "a")

    moves = Moves("5 mm")
    assert (moves.way, moves.times, moves.again, moves.name) == (0.005, 0, 1, "a")
    assert list(variables_in(Moves)) == ["way", "times", "again"]
    assert Moves(0.1, times=0).times == 0
    with pytest.raises(InputError, match="1 to 9"):
        Moves(0.1, again=0)
    with pytest.raises(InputError, match="name"):
        Moves(0.1, name="c")
    assert model("friction")(lugre(F_C=1.0, F_S=2.0, v_S=1e-3, sigma_0=1e5), "f", None).name == "lugre"


@pytest.mark.parametrize("family", _EXAMPLES)
def test_the_model_named_as_an_example_is_of_its_family(family):
    call = _EXAMPLES[family].rpartition(" such as ")[2]
    assert eval(call, vars(bristle)).component.family == family  # the call as a person would copy it
    with pytest.raises(InputError, match=re.escape(call)):
        model(family)(None, "value", None)


def test_a_value_beyond_an_exclusive_limit_names_its_range():
    length = amount(Variable("length", "a length", min=0.0, max=1.0), exclusive=True)
    assert length(0.5, "x", None) == 0.5
    with pytest.raises(InputError, match="must be positive"):
        length(0.0, "x", None)
    with pytest.raises(InputError, match="out of range; found 2"):
        length(2.0, "x", None)
