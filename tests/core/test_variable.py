"""What derives from the one description of a quantity."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.core.variable import KINDS, UNITS, Variable, is_array, unit_of, variables_of


class Parameters(NamedTuple):
    F_C: Annotated[float, Variable("force", "Coulomb force", min=0.0)]
    k: Annotated[np.ndarray, Variable("force/length", "stiffnesses", min=0.0)]


def test_the_kind_of_axis_decides_the_unit():
    assert [unit_of("mass", kind) for kind in KINDS] == ["kg", "kg*m^2"]
    assert Variable("force*time/length", "viscous").unit("rotational") == "N*m*s/rad"


def test_an_unknown_quantity_is_our_own_mistake():
    with pytest.raises(ValueError, match=r"unknown quantity 'newton'; known: 1, time"):
        Variable("newton", "not a quantity")


@pytest.mark.parametrize(
    ("low", "high", "said"),
    [
        (-math.inf, math.inf, "any number in N"),
        (0.0, math.inf, ">= 0 N"),
        (-math.inf, 2.0, "<= 2 N"),
        (0.0, 2.0, "0 to 2 N"),
    ],
)
def test_the_allowed_range_in_words(low, high, said):
    assert Variable("force", "force", min=low, max=high).allowed() == said


def test_the_range_of_a_plain_number_has_no_unit():
    assert Variable("1", "share", min=0.0, max=1.0).allowed() == "0 to 1"
    assert Variable("1", "share").allowed() == "any number"


@pytest.mark.parametrize(("value", "place"), [(-1.0, "p.k"), (math.nan, "p.k"), ([1.0, -1.0], "p.k[1]")])
def test_a_value_out_of_range_is_named_with_its_place(value, place):
    with pytest.raises(InputError) as caught:
        Variable("force/length", "stiffness", min=0.0).validate(value, "p.k")
    assert caught.value.path == place
    assert caught.value.allowed == ">= 0 N/m"


def test_fields_carry_their_variables_in_order():
    assert list(variables_of(Parameters)) == ["F_C", "k"]
    assert is_array(Parameters, "k")
    assert not is_array(Parameters, "F_C")


def test_a_field_without_a_variable_is_named():
    class Bare(NamedTuple):
        F_C: float

    with pytest.raises(TypeError, match=r"Bare\.F_C has no Variable"):
        variables_of(Bare)


def test_each_quantity_has_a_unit_for_each_kind():
    assert all(len(pair) == len(KINDS) for pair in UNITS.values())
