"""Names and literals of Structured Text."""

import math

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.exports.st_parts import Names, checked, real_literal, whole_literal


@pytest.mark.parametrize("value", [1e300, -1.7976e308, 2.2250738585072014e-308, 5e-324, 1.5, -0.1, 0.0, 1e37, 1e-37, 3e40])
def test_a_literal_of_any_magnitude_is_exact_with_small_factors(value):
    text = real_literal(value)
    factors = [float(part) for part in text.strip("()").split(" * ")]
    assert math.prod(factors) == value
    assert all(factor == 0.0 or 1e-37 <= abs(factor) <= 1e37 for factor in factors)
    assert ("*" in text) == (value != 0.0 and not 1e-37 <= abs(value) <= 1e37)


def test_the_largest_number_has_finite_factors_in_single_precision():
    factors = [float(np.float32(part)) for part in real_literal(1.7976931348623157e308).strip("()").split(" * ")]
    assert math.prod(factors) == pytest.approx(1.7976931348623157e308, rel=1e-7)


def test_infinity_and_nan_have_substitute_numbers():
    assert float(real_literal(math.inf)) == 1e37
    assert float(real_literal(-math.inf)) == -1e37
    assert 1e37 < float(real_literal(math.nan)) < 1e38


@pytest.mark.parametrize(
    ("literal", "arguments", "text"),
    [
        (real_literal, (2.0,), "2.0"),
        (real_literal, (1e20,), "1.0E20"),
        (real_literal, (1.5e-7,), "1.5E-7"),
        (real_literal, (0.1, "REAL"), "REAL#0.1"),
        (real_literal, (-0.5, "REAL"), "-REAL#0.5"),
        (real_literal, (1.0 / 3.0, "REAL"), "REAL#0.33333334"),
        (whole_literal, (2**31 - 1,), "2147483647"),
        (whole_literal, (2**31,), "LINT#2147483648"),
        (whole_literal, (-(2**31),), "LINT#-2147483648"),
    ],
)
def test_a_literal_has_a_decimal_point_and_in_single_precision_its_type(literal, arguments, text):
    assert literal(*arguments) == text


def test_names_are_unique_regardless_of_case():
    names = Names(["Used"], prefix="axis_")
    assert names.of("key", "force") == names.of("key", "other") == "axis_force"
    assert names.new("FORCE").lower() != "axis_force"
    assert Names(["used"]).new("Used").lower() != "used"


@pytest.mark.parametrize(("name", "new"), [("x", "v_x"), ("limit", "v_limit"), ("a__b_", "a_b"), ("1st", "part_1st")])
def test_a_name_becomes_one_that_every_compiler_accepts(name, new):
    assert Names([]).new(name) == new


@pytest.mark.parametrize("name", ["if", "ab", "axis_", "a__b", "limit", "integral", "ramp", "hysteresis", "pid", "rtc", "sema", "lag1"])
def test_a_block_has_a_name_that_every_compiler_accepts(name):
    with pytest.raises(InputError, match="cannot name a function block"):
        checked(name)
    checked("axis_x")
    checked("abc")
