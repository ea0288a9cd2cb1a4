"""Recorded curves: their range, and the inputs before each of them."""

import pytest

from bristle.logs.curves import Curves

RISING, FALLING = ([-1.0, 0.0, 3.0], [0.0, -7.0, 2.0]), ([3.0, 1.0, -2.0], [2.0, 5.0, 1.0])


def test_range_and_full_scale_are_those_of_all_curves():
    curves = Curves((RISING, FALLING))
    assert (curves.low, curves.high, curves.full_scale) == (-2.0, 3.0, 7.0)
    swapped = Curves((FALLING, RISING))
    assert (swapped.low, swapped.high, swapped.full_scale) == (-2.0, 3.0, 7.0)


def test_a_saturated_operator_comes_from_far_beyond_the_end_that_the_curve_heads_for():
    curves = Curves((RISING, FALLING), start="saturated")
    assert curves.history(curves.curves[0]) == pytest.approx([30.0])
    assert curves.history(curves.curves[1]) == pytest.approx([-30.0])
    assert Curves((RISING,)).history(curves.curves[0]).size == 0
