"""What derives from the one description of a quantity."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from bristle.core.contracts import Component, Relation
from bristle.core.errors import InputError, InputWarning
from bristle.core.variable import KINDS, Variable, is_array, unit_of, variables_of


class Parameters(NamedTuple):
    F_C: Annotated[float, Variable("force", "Coulomb force", min=0.0)]
    k: Annotated[np.ndarray, Variable("force/length", "stiffnesses", min=0.0)]


def test_the_kind_of_axis_decides_the_unit():
    assert [unit_of("mass", kind) for kind in KINDS] == ["kg", "kg*m^2"]
    assert Variable("force*time/length", "viscous").unit("rotational") == "N*m*s/rad"


@pytest.mark.parametrize(
    ("quantity", "low", "high", "said"),
    [
        ("force", -math.inf, math.inf, "any number in N"),
        ("force", 0.0, math.inf, ">= 0 N"),
        ("force", -math.inf, 2.0, "<= 2 N"),
        ("force", 0.0, 2.0, "0 to 2 N"),
        ("1", 0.0, 1.0, "0 to 1"),
        ("1", -math.inf, math.inf, "any number"),
    ],
)
def test_the_allowed_range_in_words(quantity, low, high, said):
    assert Variable(quantity, "a quantity", min=low, max=high).allowed() == said


@pytest.mark.parametrize(
    ("value", "place"), [(-1.0, "p.k"), (math.nan, "p.k"), ([1.0, -1.0], "p.k[1]")]
)
def test_a_value_out_of_range_is_named_with_its_place(value, place):
    with pytest.raises(InputError) as caught:
        Variable("force/length", "stiffness", min=0.0).validate(value, "p.k")
    assert caught.value.path == place
    assert caught.value.allowed == ">= 0 N/m"


def test_fields_carry_their_variables_in_order():
    assert list(variables_of(Parameters)) == ["F_C", "k"]
    assert is_array(Parameters, "k")
    assert not is_array(Parameters, "F_C")


class Chosen(NamedTuple):
    shape: Annotated[int, Variable("1", "shape of the curve", choices=("round", "square"))] = 1
    count: Annotated[int, Variable("1", "number of parts", min=1, max=9)] = 3
    level: Annotated[float, Variable("force", "level", min=0.0)] = 1.0


CHOSEN = Component(
    name="chosen",
    description="a component with a choice",
    Parameters=Chosen,
    State=Chosen,
    relations=(Relation("level >= 0.5", lambda p: p.level >= 0.5, "Raise level", advisory=True),),
)


def test_a_choice_is_a_name_for_people_and_a_place_for_kernels():
    model = CHOSEN(shape="round", level="2 N")
    assert model.parameters == (0, 3, 2.0)
    assert model.values == {"shape": "round", "count": 3, "level": 2.0}
    assert CHOSEN.defaults["shape"] == "square"
    assert model.with_values(count="4").parameters == (0, 4, 2.0)
    assert repr(model) == "chosen(shape=round, count=3, level=2 N)"


def test_an_advisory_relation_only_warns():
    with pytest.warns(
        InputWarning, match=r"should have level >= 0.5, but level = 0.2. Raise level"
    ):
        CHOSEN(level=0.2)
    assert CHOSEN(level=0.2, validate=False).values["level"] == 0.2


class Bare(NamedTuple):
    F_C: float


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (
            lambda: CHOSEN(shape="squar"),
            InputError,
            "is not a valid choice.*round, square.*Did you mean 'square'",
        ),
        (lambda: CHOSEN(shape=0), InputError, "is not a valid choice"),
        (lambda: CHOSEN(shape=["round"]), InputError, "is not a valid choice"),
        (lambda: CHOSEN(count=2.5), InputError, "whole number"),
        (lambda: CHOSEN(count=math.inf), InputError, "finite number"),
        (lambda: CHOSEN(count=1e60), InputError, "whole number"),
        (lambda: CHOSEN(count=12), InputError, "1 to 9"),
        (
            lambda: Variable("force", "a force", excitation="slide"),
            InputError,
            r"excitation of 'a force': is not an excitation; found 'slide', allowed sliding, .* Did you mean 'sliding'",
        ),
        (
            lambda: Variable("Coulomb friction"),
            InputError,
            r"Variable\('Coulomb friction'\): lacks the quantity or the description",
        ),
        (lambda: variables_of(Bare), TypeError, r"Bare\.F_C has no Variable"),
    ],
)
def test_invalid_choices_and_descriptions_are_refused(call, error, words):
    with pytest.raises(error, match=words):
        call()
