"""Units as people write them, against the unit library and against the traps it sets."""

from __future__ import annotations

import math
from functools import cache

import pint
import pytest
from hypothesis import given, settings, strategies as st
from tests.core.quantities import PRODUCTS, UNITS

from bristle.core import units
from bristle.core.dimensions import KINDS, unit_of
from bristle.core.errors import InputError
from bristle.core.variable import Variable

SI = {unit_of(quantity, kind) for quantity in (*UNITS, *PRODUCTS) for kind in KINDS}


@cache
def library() -> pint.UnitRegistry:
    """A registry of the library's own definitions, but for what it has no dimension for."""
    registry = pint.UnitRegistry()
    registry.define("count = [count]")
    registry.define("rated = [rated]")
    return registry


DECIMAL = [
    "s",
    "ms",
    "us",
    "1/s",
    "1/ms",
    "Hz",
    "kHz",
    "kg",
    "g",
    "kg*m^2",
    "kg*cm^2",
    "g*cm^2",
    "K",
    "V",
    "mV",
    "A",
    "mA",
    "count",
    "count/s",
    "rated",
    "m",
    "cm",
    "mm",
    "um",
    "nm",
    "rad",
    "mrad",
    "urad",
    "m/s",
    "mm/s",
    "um/s^2",
    "mm/s^3",
    "V/mm",
    "V*s/mm",
    "A/rad",
    "A*s/urad",
    "N",
    "mN",
    "uN",
    "kN",
    "N*m",
    "mN*m",
    "N*mm",
    "kN*cm",
    "N/um",
    "kN*s/mm",
    "N*m/rad",
    "mN*m*s/rad",
    "mN*m/V",
    "N/A",
    "kN/count",
    "N*cm/rated",
    "mm^2",
    "N*m^2/mrad^2",
    "N/(mm/s)",
    "kg*m/s^2",
    "V*A*s",
]


@pytest.mark.parametrize("unit", DECIMAL)
def test_every_decimal_unit_agrees_with_the_unit_library(unit):
    si = units.si_of(unit)
    assert units.is_decimal(unit)
    assert units.factor(unit, si) == pytest.approx(
        library().Quantity(1.0, unit).to(si).magnitude, rel=1e-12
    )
    assert math.log10(units.factor(unit, si)) == pytest.approx(
        round(math.log10(units.factor(unit, si))), abs=1e-12
    )


@pytest.mark.parametrize("unit", ["", "1", "deg", "rpm", "inch", "m/mm", "mm^0.5", "vir", "m*9**9"])
def test_only_units_beyond_powers_of_ten_need_the_unit_library(unit):
    assert not units.is_decimal(unit)


@given(
    number=st.decimals(
        min_value="-1e6", max_value="1e6", allow_nan=False, allow_infinity=False, places=6
    ),
    unit=st.sampled_from(
        [
            ("um", "m", -6),
            ("mN*m", "N*m", -3),
            ("kHz", "Hz", 3),
            ("kg*cm^2", "kg*m^2", -4),
            ("N/um", "N/m", 6),
        ]
    ),
)
def test_decimal_units_are_converted_to_the_nearest_number(number, unit):
    unit, si, power = unit
    assert units.convert(f"{number} {unit}", si) == float(f"{number}e{power}")


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("3000 rpm", "rad/s", 100 * math.pi),
        ("1 rev/s", "rad/s", 2 * math.pi),
        ("90°", "rad", math.pi / 2),
        ("2 turn", "rad", 4 * math.pi),
        ("10 ozf*in", "N*m", 10 * 0.028349523125 * 9.80665 * 0.0254),
        ("1 inch", "m", 0.0254),
        ("20 degC", "K", 293.15),
        ("30 %", "rated", 0.3),
        ("30 %", "1", 0.3),
        ("30 ‰", "1", 0.03),
        ("30 permille", "rated", 0.03),
        ("4 count", "count", 4.0),
        ("5 1/min", "1/s", 5 / 60),
    ],
)
def test_units_that_are_not_decimal(text, unit, value):
    assert units.convert(text, unit) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "5 N*m",
        "5 Nm",
        "5Nm",
        "5 N m",
        "5 N·m",
        "5000 mNm",
        "500 Ncm",
        "5 newton * meter",
        "5e0 N * m",
    ],
)
def test_a_torque_is_read_in_every_spelling(text):
    assert units.convert(text, "N*m") == pytest.approx(5.0, rel=1e-14)


@pytest.mark.parametrize("micro", ["u", "µ", "μ"])
def test_micro_is_read_in_every_spelling(micro):
    assert units.convert(f"7 {micro}m", "m") == 7e-6
    assert units.convert(f"7 {micro}m/s²", "m/s^2") == 7e-6


@pytest.mark.parametrize(
    ("text", "unit", "said"),
    [
        ("60 Hz", "rad/s", "A frequency is not an angular velocity"),
        ("10 rad/s", "Hz", "divide rad/s by 2 pi"),
        ("160 Hz", "1/s", "A gain is not a frequency"),
        ("40000 count", "rad", "Counts need a resolution"),
        ("40000 counts", "m", "Counts need a resolution"),
        ("0.04 J", "N*m", "An energy is not a torque"),
        ("40 mJ/rad", "N*m/rad", "An energy is not a torque"),
        ("3 N*m", "N", "for a rotational axis"),
        ("3 N", "N*m", "for a translational axis"),
        ("3 kg", "kg*m^2", "for a translational axis"),
        ("3 N*s^2/mm^2", "N*m*s^2/rad^2", "for a translational axis"),
        ("3e-3 N*m*s", "N*m*s/rad", "Include the angle on a rotational axis: write N*m*s/rad"),
        ("30 %", "N", "needs the rated effort"),
        ("7 m", "1", "Write a number without a unit"),
        ("7", "m", "has no unit"),
        ("mm", "m", "is not a number with a unit"),
        ("", "m", "is not a number with a unit"),
        ("seven um", "m", "is not a number with a unit"),
        ("1,5 mm", "m", "Write '1.5 mm'"),
        ("7 furlungs", "m", "is not a unit"),
        ("7 m/", "m", "is not a unit"),
        ("2 * 3 m", "m", "is not a unit"),
        ("5 s", "m", "Use m or a multiple of m"),
    ],
)
def test_refusals_name_the_place_and_the_remedy(text, unit, said):
    with pytest.raises(InputError) as caught:
        units.convert(text, unit, path="axis.toml: effort.limit")
    assert said in str(caught.value)
    assert str(caught.value).startswith("axis.toml: effort.limit: ")


@pytest.mark.parametrize("value", [True, None, [1.0], {"value": 1}])
def test_only_numbers_and_text_are_quantities(value):
    with pytest.raises(InputError, match="must be a number, or text with a unit"):
        units.quantity(value, Variable("length", "lead"))


def test_bare_numbers_are_si():
    assert units.quantity(0.25, Variable("force", "limit"), "rotational") == 0.25
    assert units.quantity("0.25", Variable("force", "limit"), "rotational") == 0.25


def test_the_kind_of_axis_follows_from_the_units():
    variables = {"F_C": Variable("force", "Coulomb force"), "share": Variable("1", "share")}
    assert units.kind_of({"share": "3 %", "F_C": "34 mN*m"}, variables) == "rotational"
    assert units.kind_of({"F_C": "34 N"}, variables) == "translational"
    assert units.kind_of({"F_C": 34.0}, variables) == "translational"


@pytest.mark.parametrize("si", sorted(SI))
def test_every_unit_of_a_variable_converts_to_itself(si):
    assert units.convert(f"2.5 {si}", si) == 2.5
    assert units.compatible(si, si)


@pytest.mark.parametrize("unit", ["N", "Hz", "1/s", "count", "m/s", "N*m/A"])
def test_decimal_units_are_compatible_like_in_the_unit_library(unit):
    here = library().Unit(unit)
    for other in DECIMAL:
        if "rad" not in other:
            assert units.compatible(other, unit) == (
                library().Unit(other).dimensionality == here.dimensionality
            ), other


@pytest.mark.parametrize(
    "call",
    [
        lambda: units.convert("34 mNm", "N*m"),
        lambda: units.factor("um", "m"),
        lambda: units.compatible("V", "V"),
        lambda: units.si_of("mm/s"),
    ],
)
def test_plain_units_do_not_ask_the_unit_library(call, monkeypatch):
    monkeypatch.setattr(units, "_registry", lambda: pytest.fail("the unit library was asked"))
    call()
    with pytest.raises(pytest.fail.Exception):
        units.convert("3000 rpm", "rad/s")


ABSURD = [
    "m*9**9**9**9",
    "m^9^9",
    "9^9^9",
    "m**99",
    "m^10",
    "2*m",
    "10 mm",
    "1e3*m",
    "m^-0.7",
    "m^(2)",
    "(m",
    "m)",
    "m*",
    "*m",
    "m//s",
    "m^",
    "m s^",
    "((m))",
    "m+s",
    "m-s",
    "m=s",
    "lambda:m",
    "__import__",
    "m.real",
    "m[0]",
    "'m'",
    "m;s",
    "m\0",
    "µ" * 65,
    "m*" * 40 + "m",
    " " * 70 + "(",
    "m" + " " * 5000 + "s",
    "[" + " " * 4000,
    "9" * 5000,
    "m^" + "9" * 100,
    "1/0",
    "m/0",
    "m%2",
]


@pytest.mark.parametrize("unit", ABSURD, ids=range(len(ABSURD)))
def test_invalid_units_are_refused_without_evaluation(unit, monkeypatch):
    monkeypatch.setattr(units, "_registry", lambda: pytest.fail("the unit library was asked"))
    assert not units.is_unit(unit)
    with pytest.raises(InputError):
        units.convert(f"3 {unit}", "m")


@pytest.mark.parametrize("unit", sorted(SI - {"1"}))
def test_every_unit_of_a_quantity_matches_the_grammar(unit):
    assert units.is_unit(unit)
    assert units.factor(unit, unit) == 1.0


@settings(max_examples=80)
@given(st.text(max_size=80) | st.text(alphabet="m*/^()29 s.-µ²%", max_size=64))
def test_random_text_and_text_close_to_a_unit_are_refused_quickly(text):
    if units.is_unit(text):
        units.compatible(text, "m")


@pytest.mark.parametrize(
    "value",
    [
        math.nan,
        math.inf,
        -math.inf,
        "nan",
        "inf m",
        "1e999 m",
        1e101,
        "1e98 km",
        10**400,
        "9" * 400,
    ],
)
def test_absurd_quantities_are_refused(value):
    with pytest.raises(InputError):
        units.quantity(value, Variable("length", "distance"), path="distance")


def test_infinity_must_be_explicitly_allowed():
    assert units.quantity(math.inf, Variable("length/time", "speed"), infinite=True) == math.inf
    with pytest.raises(InputError, match="finite"):
        units.quantity(math.nan, Variable("length/time", "speed"), infinite=True)


@pytest.mark.parametrize(
    ("unit", "si"),
    [("‰", "1"), ("%", "1"), ("mm", "m"), ("kN*m", "N*m"), ("g", "kg"), ("1", "1"), ("ms", "s")],
)
def test_a_unit_without_a_known_quantity_has_an_si_unit(unit, si):
    assert units.si_of(unit) == si
