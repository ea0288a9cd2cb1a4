"""Quantities by their exponents: the units that they have had, units of any product, and what is refused."""

from __future__ import annotations

import pytest
from hypothesis import given, settings, strategies as st
from tests.core.quantities import MAGNETIC, UNITS

from bristle.core import units
from bristle.core.dimensions import KINDS, NAMES, canonical, exponents_of, unit_elsewhere, unit_of
from bristle.core.errors import InputError
from bristle.core.variable import Variable

POWERS = st.sampled_from([-2.0, -1.5, -1.0, -0.5, 0.5, 1.0, 1.5, 2.0])
PRODUCTS = st.dictionaries(st.sampled_from(sorted(NAMES)), POWERS, max_size=4)


def written(powers):
    """A product as a person may write it, in any order and without brackets."""
    return "*".join(["1", *(f"{name}^{power:g}" for name, power in powers.items())])


@pytest.mark.parametrize(("quantity", "pair"), UNITS.items())
def test_units_of_quantities_are_unchanged(quantity, pair):
    assert tuple(unit_of(quantity, kind) for kind in KINDS) == pair
    assert Variable(quantity, "any").quantity == quantity


@pytest.mark.parametrize(("quantity", "unit"), MAGNETIC.items())
def test_units_of_magnets_are_unchanged(quantity, unit):
    assert unit_of(quantity, "magnetic") == unit


@pytest.mark.parametrize(
    ("quantity", "translational", "rotational"),
    [
        ("force*time^2/length^2", "N*s^2/m^2", "N*m*s^2/rad^2"),
        ("force/length/time", "N/(m*s)", "N*m/(rad*s)"),
        ("force/(length*time)", "N/(m*s)", "N*m/(rad*s)"),
        ("force*length", "N*m", "N*m*rad"),
        ("force/travel", "N/m", "N"),
        ("1/mass", "1/kg", "1/(kg*m^2)"),
        ("length^-2*time^0.5", "s^0.5/m^2", "s^0.5/rad^2"),
    ],
)
def test_the_unit_of_a_product_follows_from_it(quantity, translational, rotational):
    assert [unit_of(quantity, kind) for kind in KINDS] == [translational, rotational]


@pytest.mark.parametrize(
    ("quantity", "spelling"),
    [
        ("time*force/length", "force*time/length"),
        (" force * time ** 2 / length**2 ", "force*time^2/length^2"),
        ("force/length/time", "force/(length*time)"),
        ("(force*time)/(length*length)", "force*time/length^2"),
        ("travel*force of travel", "force of travel*travel"),
        ("length/length", "1"),
    ],
)
def test_quantities_have_a_canonical_spelling(quantity, spelling):
    assert Variable(quantity, "any").quantity == spelling
    assert Variable(quantity, "any") == Variable(spelling, "any")


@given(powers=PRODUCTS)
def test_the_canonical_spelling_keeps_the_dimension(powers):
    quantity = written(powers)
    assert canonical(canonical(quantity)) == canonical(quantity)
    assert exponents_of(canonical(quantity)) == pytest.approx(exponents_of(quantity))


@settings(deadline=None)
@given(powers=PRODUCTS, kind=st.sampled_from(KINDS))
def test_the_unit_of_a_product_is_the_product_of_the_units(powers, kind):
    unit = unit_of(written(powers), kind)
    product = "*".join(
        ["1", *(f"({unit_of(name, kind)})**({power})" for name, power in powers.items())]
    )
    registry = units._registry()
    assert units.is_unit(unit)
    assert registry.Quantity(1.0, registry.parse_units(product)).to(unit).magnitude == 1.0


@pytest.mark.parametrize("name", [name for name in NAMES if NAMES[name].product])
def test_a_name_has_the_dimension_of_its_product(name):
    assert exponents_of(name) == exponents_of(NAMES[name].product)
    assert units.compatible(unit_of(name), unit_of(NAMES[name].product))


@given(
    powers=st.dictionaries(
        st.sampled_from(["mass", "force", "length", "time", "temperature"]), POWERS, max_size=4
    )
)
def test_units_convert_between_kinds_of_axis(powers):
    quantity = written(powers)
    straight, turning = (unit_of(quantity, kind) for kind in KINDS)
    assert unit_elsewhere(turning, "rotational", "translational") == straight
    assert unit_elsewhere(straight, "translational", "rotational") == turning


@pytest.mark.parametrize("unit", ["V", "N/V", "count", "7 N", "N*", "deg"])
def test_foreign_units_do_not_convert_between_kinds_of_axis(unit):
    assert unit_elsewhere(unit, "translational", "rotational") is None


@pytest.mark.parametrize(
    ("quantity", "said"),
    [
        ("forse*time^2/length^2", "'forse' is unknown.*Did you mean 'force'"),
        ("mas of travel", "'mas of travel' is unknown.*Did you mean 'mass of travel'"),
        ("N*s/m", "'N' is unknown.*not its unit"),
        ("velocity", 'Write "length/time" for velocity'),
        ("Torque/angle", 'Write "force" for Torque'),
        ("force//time", "is not a quantity; found 'force//time'.*such as"),
        ("force*(time", "is not a quantity"),
        ("2*force", "is not a quantity"),
        ("force^12", "is not a quantity"),
        ("", "is not a quantity; found ''"),
        ("force" + "*force" * 999, "is not a quantity"),
        ("force^5*mass^4", "too high a power; found 'force.*up to 9"),
        (3, "must be text that names a quantity; found 3"),
        (["force"], "must be text that names a quantity"),
    ],
)
def test_invalid_quantities_are_refused_with_place_and_allowed_values(quantity, said):
    with pytest.raises(InputError, match=said) as caught:
        Variable(quantity, "drag of a seal")
    assert caught.value.path == "quantity of 'drag of a seal'"
    assert caught.value.allowed
    assert caught.value.mend
