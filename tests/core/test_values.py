"""Thresholds that a person sets: within their range, by name."""

import math
from dataclasses import dataclass
from functools import partial

import numpy as np
import pytest

from bristle import friction
from bristle.core.errors import InputError
from bristle.core.values import Thresholds, check_relations, coerced, looked_at, shown, threshold
from bristle.core.variable import Variable


@dataclass(frozen=True)
class Some(Thresholds):
    share: float = threshold(0.3, "of all", least=0.1, most=0.9)
    ratio: float = threshold(2.0, "of two", unit="s", least=1.0, source="a book")
    FIXED = 5.0


@pytest.mark.parametrize(
    ("some", "data", "changed"),
    [
        (Some(), {"share": 0.3, "ratio": 2.0}, {}),
        (Some.of({"ratio": 3}), {"share": 0.3, "ratio": 3.0}, {"ratio": 3.0}),
        (
            Some.of({"share": 0.1, "ratio": 1.0}),
            {"share": 0.1, "ratio": 1.0},
            {"share": 0.1, "ratio": 1.0},
        ),
        (Some.of({"share": 0.9}), {"share": 0.9, "ratio": 2.0}, {"share": 0.9}),
        (Some.among({"share": 0.4, "other": 1.0}), {"share": 0.4, "ratio": 2.0}, {"share": 0.4}),
    ],
)
def test_thresholds_are_those_that_are_given_and_else_at_their_defaults(some, data, changed):
    assert (some.as_data(), some.changed) == (data, changed)
    assert isinstance(some.ratio, float)


def test_thresholds_are_described():
    assert list(Some.described()) == [
        ("share", 0.3, "1", "of all", 0.1, 0.9, ""),
        ("ratio", 2.0, "s", "of two", 1.0, math.inf, "a book"),
    ]


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
        ({"other": 4.0}, "is not a threshold.*share, ratio.*missing_evidence replaces"),
        ({"ratoi": 4.0}, r"settings\.ratoi: is not a threshold.*Did you mean 'ratio'\?"),
        ({"FIXED": 4.0}, r"settings\.FIXED: is not a threshold"),
    ],
)
def test_a_threshold_out_of_its_range_is_refused(values, words):
    with pytest.raises(InputError, match=words):
        Some.of(values)


def test_errors_of_foreign_values_are_reported_with_their_place():
    def broken(value, path, kind):
        raise RuntimeError("gone")

    with pytest.raises(InputError, match=r"place: cannot be read \(RuntimeError: gone\)"):
        looked_at(broken, 3.0, "place", None)
    assert shown(None) == "None"
    assert shown(0) == 0


@dataclass(frozen=True)
class Plain(Thresholds):
    share: float = threshold(0.3, "of all")


FALLING = friction.stribeck(F_C=8.0, F_S=7.0, v_S=4e-3, F_v=30.0, validate=False)
CAPACITY = partial(
    coerced, friction.leuven, "capacity", Variable("1", "count"), path="n", kind="translational"
)
LUGRE = partial(friction.lugre, F_C=1.0, F_S=1.0, v_S=1.0)
STOPS = partial(friction.maxwell_slip, F_C=1.0, nu_i=[0.5, 0.5])


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: check_relations(friction.stribeck, FALLING.parameters, "here"),
            r"here: needs .*F_S.*but F_C = 8, F_S = 7",
        ),
        (lambda: friction.maxwell_slip(F_C=1.0, k_i=[1.0, 2.0], nu_i=[1.0], validate=False), "k_i"),
        (lambda: LUGRE(sigma_0=1.0, sigma_2=math.inf), "sigma_2: is not a finite number"),
        (lambda: LUGRE(sigma_0=math.inf), "sigma_0: is not a finite number"),
        (lambda: LUGRE(sigma_0=1.0, v_d=-math.inf), "v_d"),
        *(
            (lambda wrong=wrong: STOPS(k_i=wrong), "k_i: must be a list of numbers")
            for wrong in ("12", b"12", 3.0)
        ),
        *(
            (lambda wrong=wrong: STOPS(k_i=np.array([1.0, wrong])), "k_i")
            for wrong in (1e101, math.nan)
        ),
        (lambda: CAPACITY(value=2.0**53 + 2.0), "must be a whole number"),
        (lambda: Plain.of({"share": -1e-9}, "here"), r"here\.share"),
        (lambda: Plain.among({"share": -1.0}), r"settings\.share"),
    ],
)
def test_values_that_break_a_rule_are_refused_by_name(call, words):
    with pytest.raises(InputError, match=words):
        call()


def test_values_within_the_rules_are_taken():
    check_relations(friction.stribeck, FALLING.parameters, "here", structural_only=True)
    assert (LUGRE(sigma_0=1.0, v_d=math.inf).v_d, CAPACITY(value=2.0**53)) == (math.inf, 2**53)
    assert STOPS(k_i=["1 N/m", 2]).k_i.tolist() == [1.0, 2.0]
    assert Plain.described()[0] == ("share", 0.3, "1", "of all", 0.0, math.inf, "")
    assert Plain.of({"share": 0.0}).share == 0.0
