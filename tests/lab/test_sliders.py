"""A slider reaches what its variable may be, what it is, and what it was identified to be."""

import math

import pytest

from bristle.core.variable import Variable
from bristle.exports.page.sliders import slider_for

FORCE = Variable("force", "some force", min=0.0)


def test_it_goes_by_factors_where_the_range_spans_decades():
    assert slider_for(FORCE, 20.0).logarithmic
    assert slider_for(FORCE, 20.0).to_zero
    assert slider_for(Variable("1", "exponent", min=0.1, max=10.0), 2.0).logarithmic
    assert not slider_for(Variable("1", "share", min=0.0, max=1.0), 0.3).logarithmic


@pytest.mark.parametrize("interval", [(1e-4, 21.0), (19.0, 1e6)])
def test_an_interval_lies_on_it_however_wide_it_is(interval):
    slider = slider_for(FORCE, 20.0, interval=interval)
    assert slider.low <= interval[0] < interval[1] <= slider.high


def test_it_stays_within_what_is_allowed():
    slider = slider_for(Variable("1", "factor", min=0.5, max=math.inf), 2.0)
    assert (slider.low, slider.high) == (0.5, 200.0)
    assert not slider.to_zero


def test_infinity_is_at_its_end():
    slider = slider_for(Variable("length/time", "some velocity", min=1e-12, nominal=0.05), math.inf)
    assert slider.endless
    assert slider.low < 0.05 < slider.high < math.inf


def test_a_number_of_either_sign_lies_in_the_middle():
    assert slider_for(Variable("force", "offset"), 3.0)[:2] == (-12.0, 12.0)
    assert slider_for(Variable("force", "offset"), 0.0, span=28.0)[:2] == (-28.0, 28.0)
