"""Thresholds that a person sets: within their range, by name."""

import math
from dataclasses import dataclass

import pytest

from bristle.core.errors import InputError
from bristle.core.values import Thresholds, looked_at, shown, threshold


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
        ({"FIXED": 4.0}, "is fixed, and no longer set"),
        ({"other": 4.0}, "is no threshold.*share, ratio"),
    ],
)
def test_a_threshold_out_of_its_range_is_refused(values, words):
    with pytest.raises(InputError, match=words):
        Some.of(values)


def test_a_value_that_breaks_while_looked_at_is_told_with_its_place():
    def broken(value, path, kind):
        raise RuntimeError("gone")

    with pytest.raises(InputError, match=r"place: cannot be read \(RuntimeError: gone\)"):
        looked_at(broken, 3.0, "place", None)
    assert shown(None) == "None"
    assert shown(0) == 0
