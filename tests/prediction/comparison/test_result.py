"""What a change says of itself: percents, units, and a verdict by its interval."""

import math

import pytest

from bristle.prediction.comparison.result import Change, Comparison


def change(before, after, interval, quantity="length", kind="translational"):
    return Change("following_error.rms", quantity, before, after, interval, kind)


def test_a_change_is_in_percent_of_the_size_before():
    lower = change(4.0, 3.0, (-1.5, -0.5))
    assert (lower.change, lower.change_percent, lower.interval_percent) == (
        -1.0,
        -25.0,
        (-37.5, -12.5),
    )
    falling = change(-4.0, -3.0, (0.5, 1.5))
    assert (falling.change_percent, falling.interval_percent) == (25.0, (12.5, 37.5))


def test_a_zero_before_gives_no_percent():
    fresh = change(0.0, 1.0, (0.5, 1.5))
    assert math.isnan(fresh.change_percent)
    assert fresh.interval_percent is None
    assert change(4.0, 3.0, None).interval_percent is None


def test_an_interval_in_reverse_order_is_sorted():
    assert change(2.0, 3.0, (1.5, 0.5)).interval_percent == (25.0, 75.0)


@pytest.mark.parametrize(
    ("after", "interval", "verdict"),
    [
        (3.0, (-1.5, -0.5), "lower"),
        (5.0, (0.5, 1.5), "higher"),
        (3.0, (-2.5, 0.5), "no_change"),
        (3.0, (-2.0, 0.0), "no_change"),
        (5.0, (0.0, 2.0), "no_change"),
        (3.0, None, "unknown"),
        (4.0 + 3.9e-6, (3.8e-6, 4.0e-6), "no_change"),  # a millionth is rounding
        (4.0 + 4.2e-6, (4.1e-6, 4.3e-6), "higher"),
    ],
)
def test_an_interval_without_zero_determines_the_verdict(after, interval, verdict):
    assert change(4.0, after, interval).verdict == verdict


def test_rounding_is_a_share_of_the_larger_value():
    assert change(1e-6, 1.0, (0.9, 1.1)).verdict == "higher"
    assert change(0.0, 0.0, (0.0, 0.0)).verdict == "no_change"
    assert change(1.0, 1.0 - 1.5e-6, (-1.6e-6, -1.4e-6)).verdict == "lower"


@pytest.mark.parametrize(
    ("quantity", "kind", "unit"),
    [
        ("length", "translational", "m"),
        ("length", "rotational", "rad"),
        ("force", "translational", "N"),
        ("force", "rotational", "N*m"),
    ],
)
def test_the_unit_is_that_of_the_axis(quantity, kind, unit):
    assert change(1.0, 2.0, None, quantity, kind).unit == unit


def test_plain_data_have_lists_and_the_verdict():
    assert change(4.0, 3.0, (-1.5, -0.5)).as_data() == {
        "before": 4.0,
        "after": 3.0,
        "change": -1.0,
        "interval": [-1.5, -0.5],
        "change_percent": -25.0,
        "interval_percent": [-37.5, -12.5],
        "unit": "m",
        "verdict": "lower",
    }
    assert change(4.0, 3.0, None).as_data()["interval"] is None


@pytest.mark.parametrize(
    ("changes", "helped"),
    [
        ({}, None),
        ({"effort.rms": change(4.0, 3.0, (-1.5, -0.5))}, None),
        ({"following_error.rms": change(4.0, 3.0, None)}, None),
        ({"following_error.rms": change(4.0, 3.0, (-1.5, -0.5))}, True),
        ({"following_error.rms": change(4.0, 3.0, (-1.5, 0.5))}, False),
        ({"following_error.rms": change(4.0, 5.0, (0.5, 1.5))}, False),
    ],
)
def test_a_smaller_following_error_is_help(changes, helped):
    nothing = None
    assert (
        Comparison("translational", changes, [], nothing, nothing, nothing, (), (), (), ()).helped
        is helped
    )
