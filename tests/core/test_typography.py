"""Numbers and units as people read them."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.core.quantities import PRODUCTS, UNITS

from bristle.core.dimensions import KINDS, unit_of
from bristle.core.typography import number, scale_of, typeset, with_unit
from bristle.core.units import factor
from bristle.report.page import typeset_sentence

SI = sorted({unit_of(quantity, kind) for quantity in (*UNITS, *PRODUCTS) for kind in KINDS})


@pytest.mark.fast_cases(7)
@pytest.mark.parametrize("unit", SI)
@settings(deadline=None)  # the first example loads the library of units
@given(magnitude=st.floats(1e-10, 1e7))
def test_a_multiple_is_what_the_unit_edge_reads(unit, magnitude):
    scale = scale_of(unit, magnitude)
    assert factor(unit, scale.unit or "1") == pytest.approx(scale.factor, rel=1e-12)


@given(magnitude=st.floats(1e-9, 9e3))
def test_the_multiple_of_a_length_stands_between_one_and_a_thousand(magnitude):
    shown = magnitude * scale_of("m", magnitude).factor
    assert 0.999 <= shown < 1000.1 or magnitude >= 1.0


@given(value=st.floats(-1e6, 1e6), std=st.floats(1e-6, 1e5))
def test_rounding_stays_within_a_tenth_of_the_standard_error(value, std):
    shown = number(value, std)
    assert abs(float(shown.replace("−", "-")) - value) <= 0.1 * std


@pytest.mark.parametrize(("value", "shown"), [(math.nan, "–"), (math.inf, "∞"), (-math.inf, "−∞"), (0.0, "0"), (-1.5, "−1.500")])
def test_odd_numbers_have_a_sign_of_their_own(value, shown):
    assert number(value) == shown


def test_zero_has_no_sign():
    assert number(-1e-7, 0.01) == "0.000"


def test_units_are_set_for_reading():
    assert typeset("N*m*s/rad") == "N·m·s/rad"
    assert typeset("um/s^2") == "µm/s²"
    assert typeset("m^2.5/(N*s^2)") == "m^2.5/(N·s²)"
    assert with_unit(2.5e-9, "m") == "2.5 nm"
    assert with_unit(0.034, "N*m") == "34 mN·m"
    assert with_unit(5e-6, "kg*m^2") == "50 g·cm²"


def test_a_unit_in_a_sentence_is_set_whole():
    assert typeset_sentence("k_I = 7 N*m/(rad*s) (at 2 N*s^2/m^2.)") == "k_I = 7 N·m/(rad·s) (at 2 N·s²/m².)"
