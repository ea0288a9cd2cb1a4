"""Thresholds that a person sets: within their range, by name."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from bristle import friction
from bristle.core.errors import InputError, InputWarning
from bristle.core.values import Thresholds, check_relations, coerced, looked_at, shown, threshold
from bristle.core.variable import Variable


@dataclass(frozen=True)
class Some(Thresholds):
    share: float = threshold(0.3, "of all", least=0.1, most=0.9)
    ratio: float = threshold(2.0, "of two", unit="s", least=1.0, source="a book")
    FIXED = 5.0


def test_thresholds_are_those_that_are_given_and_else_at_their_defaults():
    some = Some.of({"ratio": 3})
    assert some.as_data() == {"share": 0.3, "ratio": 3.0}
    assert isinstance(some.ratio, float)
    assert some.changed == {"ratio": 3.0}
    assert Some().changed == {}
    assert Some.of({"share": 0.1, "ratio": 1.0}).share == 0.1
    assert Some.of({"share": 0.9}).share == 0.9
    assert Some.among({"share": 0.4, "other": 1.0}).changed == {"share": 0.4}
    first, second = Some.described()
    assert first == ("share", 0.3, "1", "of all", 0.1, 0.9, "")
    assert second == ("ratio", 2.0, "s", "of two", 1.0, math.inf, "a book")


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"share": 0.09}, r"settings\.share: is out of range.*0\.1 to 0\.9"),
        ({"share": 0.91}, "out of range"),
        ({"ratio": 0.5}, ">= 1"),
        ({"ratio": math.inf}, "out of range"),
        ({"ratio": math.nan}, "out of range"),
        ({"ratio": True}, "out of range"),
        ({"ratio": "2"}, "out of range"),
        ({"other": 4.0}, "is not a threshold.*share, ratio"),
    ],
)
def test_a_threshold_out_of_its_range_is_refused(values, words):
    with pytest.raises(InputError, match=words):
        Some.of(values)


def test_a_former_threshold_is_left_out_with_a_warning():
    with pytest.warns(InputWarning, match=r"settings\.FIXED: has no effect any more"):
        assert Some.of({"FIXED": 4.0, "share": 0.4}).changed == {"share": 0.4}


def test_errors_of_foreign_values_are_reported_with_their_place():
    def broken(value, path, kind):
        raise RuntimeError("gone")

    with pytest.raises(InputError, match=r"place: cannot be read \(RuntimeError: gone\)"):
        looked_at(broken, 3.0, "place", None)
    assert shown(None) == "None"
    assert shown(0) == 0


FALLING = friction.stribeck(F_C=8.0, F_S=7.0, v_S=4e-3, F_v=30.0, validate=False)


def test_all_relations_are_checked_unless_only_structural_ones_are_requested():
    with pytest.raises(InputError, match=r"here: needs .*F_S.*but F_C = 8, F_S = 7"):
        check_relations(friction.stribeck, FALLING.parameters, "here")
    check_relations(friction.stribeck, FALLING.parameters, "here", structural_only=True)
    with pytest.raises(InputError, match="k_i"):
        friction.maxwell_slip(F_C=1.0, k_i=[1.0, 2.0], nu_i=[1.0], validate=False)


def test_a_number_may_be_without_end_only_where_it_is_so_by_default():
    assert friction.lugre(F_C=1.0, F_S=1.0, v_S=1.0, sigma_0=1.0, v_d=math.inf).v_d == math.inf
    for name in ("sigma_2", "sigma_0"):
        with pytest.raises(InputError, match=f"{name}: is not a finite number"):
            friction.lugre(**{"F_C": 1.0, "F_S": 1.0, "v_S": 1.0, "sigma_0": 1.0} | {name: math.inf})
    with pytest.raises(InputError, match="v_d"):
        friction.lugre(F_C=1.0, F_S=1.0, v_S=1.0, sigma_0=1.0, v_d=-math.inf)


def test_a_list_of_numbers_is_not_a_text_or_a_number():
    stops = {"F_C": 1.0, "nu_i": [0.5, 0.5]}
    assert friction.maxwell_slip(**stops, k_i=["1 N/m", 2]).k_i.tolist() == [1.0, 2.0]
    for wrong in ("12", b"12", 3.0):
        with pytest.raises(InputError, match="k_i: must be a list of numbers"):
            friction.maxwell_slip(**stops, k_i=wrong)
    for wrong in (np.array([1.0, 1e101]), np.array([1.0, math.nan])):
        with pytest.raises(InputError, match="k_i"):
            friction.maxwell_slip(**stops, k_i=wrong)


def test_whole_numbers_are_limited_by_the_resolution_of_floats():
    capacity = Variable("1", "count")
    component = friction.leuven
    assert coerced(component, "capacity", capacity, 2.0**53, "n", "translational") == 2**53
    with pytest.raises(InputError, match="must be a whole number"):
        coerced(component, "capacity", capacity, 2.0**53 + 2.0, "n", "translational")


def test_a_threshold_has_a_range_from_zero_to_infinity_by_default():
    @dataclass(frozen=True)
    class Plain(Thresholds):
        share: float = threshold(0.3, "of all")

    assert Plain.described()[0] == ("share", 0.3, "1", "of all", 0.0, math.inf, "")
    assert Plain.of({"share": 0.0}).share == 0.0
    with pytest.raises(InputError, match=r"here\.share"):
        Plain.of({"share": -1e-9}, "here")
    with pytest.raises(InputError, match=r"settings\.share"):
        Plain.among({"share": -1.0})
