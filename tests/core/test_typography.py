"""Numbers and units as people read them."""

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from tests.core.quantities import PRODUCTS, UNITS

from bristle.core.dimensions import KINDS, unit_of
from bristle.core.typography import Scale, number, printable, scale_of, typed, typeset, with_unit
from bristle.core.units import factor
from bristle.report.page import typeset_sentence

SI = sorted({unit_of(quantity, kind) for quantity in (*UNITS, *PRODUCTS) for kind in KINDS})


@pytest.mark.fast_cases(7)
@pytest.mark.parametrize("unit", SI)
@settings(deadline=None)  # the first example loads the library of units
@given(magnitude=st.floats(1e-10, 1e7))
def test_displayed_multiples_can_be_read_as_input(unit, magnitude):
    scale = scale_of(unit, magnitude)
    assert factor(unit, scale.unit or "1") == pytest.approx(scale.factor, rel=1e-12)


@given(magnitude=st.floats(1e-9, 9e3))
def test_displayed_lengths_are_between_1_and_1000(magnitude):
    shown = magnitude * scale_of("m", magnitude).factor
    assert 0.999 <= shown < 1000.1 or magnitude >= 1.0


@given(value=st.floats(-1e6, 1e6), std=st.floats(1e-6, 1e5))
def test_rounding_stays_within_a_tenth_of_the_standard_error(value, std):
    shown = number(value, std)
    assert abs(float(shown.replace("−", "-")) - value) <= 0.1 * std


@pytest.mark.parametrize(
    ("value", "resolution", "digits", "text"),
    [
        (1234.567, None, 4, "1235"),
        (0.00123456, None, 4, "0.001235"),
        (12.3456, 0.2, 4, "12.35"),
        (1234.0, 300.0, 4, "1230"),
        (1254.0, 3000.0, 4, "1300"),
        (5.0, 0.0, 4, "5.000"),
        (-0.00001, 0.1, 4, "0.00"),
        (-2.5, None, 2, "−2.5"),
        (1.5e-12, None, 4, "1.500e−12"),
        (0.0, None, 4, "0"),
        (math.nan, None, 4, "–"),
        (math.inf, None, 4, "∞"),
        (-math.inf, None, 4, "−∞"),
        (-1.5, None, 4, "−1.500"),
        (-1e-7, 0.01, 4, "0.000"),
        # Very large and very small numbers have a power of ten.
        (0.9e12, None, 4, "900000000000"),
        (1e12, None, 4, "1.000e+12"),
        (-1e12, None, 4, "−1.000e+12"),
        (1.5e-6, None, 4, "0.000001500"),
        (1.5e-7, None, 4, "1.500e−07"),
    ],
)
def test_numbers_are_rounded_by_resolution_or_significant_digits(value, resolution, digits, text):
    assert number(value, resolution, digits) == text


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        *(
            (7e-6, "m", "7 µm"),
            (0.04, "N*m", "40 mN·m"),
            (0.25, "s", "250 ms"),
            (0.0, "N", "0 N"),
            (3.0, "1", "3"),
            (1e-3, "s", "1 ms"),
        ),
        *(
            (0.9999999999999999e-3, "m", "1 mm"),
            (999.0, "N", "999 N"),
            (12345.0, "N/m", "12.3 kN/m"),
        ),
    ],
)
def test_a_number_in_a_sentence_has_a_fitting_unit_and_no_zeros_at_its_end(value, unit, text):
    assert with_unit(value, unit) == text


@pytest.mark.parametrize(
    ("unit", "magnitude", "factor_to", "label"),
    [
        *(
            ("N", 1e4, 1e-3, "kN"),
            ("N", 9999.0, 1.0, "N"),
            ("N", 0.999, 1e3, "mN"),
            ("N", 1e-9, 1e6, "µN"),
            ("V", 2e4, 1e-3, "kV"),
        ),
        *(
            ("Hz", 1e4, 1e-3, "kHz"),
            ("Hz", 9999.0, 1.0, "Hz"),
            ("Hz", 1e-3, 1.0, "Hz"),
            ("m", 1e5, 1.0, "m"),
            ("m", 1e-12, 1e9, "nm"),
        ),
        *(
            ("kg", 0.1, 1.0, "kg"),
            ("kg", 0.0999, 1e3, "g"),
            ("kg", 1e-9, 1e3, "g"),
            ("kg*m^2", 0.1, 1.0, "kg·m²"),
        ),
        *(
            ("kg*m^2", 1e-5, 1e4, "kg·cm²"),
            ("kg*m^2", 0.9e-5, 1e7, "g·cm²"),
            ("1", 1e-6, 1.0, ""),
            ("K", 1e-6, 1.0, "K"),
        ),
        *(
            ("m", 0.0, 1.0, "m"),
            ("m", math.inf, 1.0, "m"),
            ("m", -2e-3, 1e3, "mm"),
            ("m^2", 1e-6, 1.0, "m²"),
            ("rad/s", 2e-3, 1e3, "mrad/s"),
        ),
    ],
)
def test_a_unit_is_read_in_the_multiple_that_the_size_of_a_number_asks_for(
    unit, magnitude, factor_to, label
):
    assert scale_of(unit, magnitude) == (pytest.approx(factor_to, rel=1e-15), label)


@pytest.mark.parametrize(
    ("result", "text"),
    [
        (typeset("N*m*s/rad"), "N·m·s/rad"),
        (typeset("um/s^2"), "µm/s²"),
        (typeset("um*s^2"), "µm·s²"),
        (typeset("m^2.5/(N*s^2)"), "m^2.5/(N·s²)"),
        (typeset("m^2.5"), "m^2.5"),
        (typeset("1"), ""),
        (with_unit(2.5e-9, "m"), "2.5 nm"),
        (with_unit(0.034, "N*m"), "34 mN·m"),
        (with_unit(5e-6, "kg*m^2"), "50 g·cm²"),
        (
            typeset_sentence("k_I = 7 N*m/(rad*s) (at 2 N*s^2/m^2.)"),
            "k_I = 7 N·m/(rad·s) (at 2 N·s²/m².)",
        ),
        (typed(2.0), "2"),
        (typed(1.23456789), "1.23457"),
        (typed(np.array([1.0, 2.5])), "[1, 2.5]"),
        (typed("held"), "held"),
        (printable("a\x07b\udcff"), "a b\\xff"),
        (Scale(1e3, "mm").label("Position"), "Position [mm]"),
        (Scale(1.0, "").label("Share"), "Share"),
    ],
)
def test_units_and_values_are_set_for_reading(result, text):
    assert result == text
