"""What `check` hands out, and what it refuses."""

from dataclasses import fields

import pytest
from tests.contract.models import with_fast
from tests.simulation.certificates.ballscrew import UM, composite, lugre

import bristle
from bristle import friction, hysteresis
from bristle.core import InputError
from bristle.simulation.certificates import Certificate, check

QUESTIONS = ["well_posed", "passive", "drift", "closure", "dissipation"]


def test_the_public_function_is_check():
    assert bristle.check is check


def test_every_question_is_answered_with_every_field():
    result = check(composite(sigma_2=0.04))
    assert list(result) == QUESTIONS
    assert [field.name for field in fields(Certificate)] == [
        "applies",
        "value",
        "unit",
        "threshold",
        "passed",
        "advice",
    ]
    assert all(field.applies and field.passed is True for field in result.values())
    assert all(field.advice and "\n" not in field.advice for field in result.values())


def test_a_model_that_fails_gets_advice():
    result = check(lugre())
    assert [name for name, item in result.items() if item.passed is False] == [
        "passive",
        "drift",
        "closure",
    ]
    assert "sigma_2 to at least 30 mN·m·s/rad" in result["passive"].advice
    assert all("preisach_lugre" in result[name].advice for name in ("drift", "closure"))


@pytest.mark.parametrize("name", with_fast("stribeck", "lugre"))
def test_every_model_has_its_certificates(name):
    model = friction.MODELS[name]
    result = check(model(**model.example))
    assert list(result) == QUESTIONS
    assert result["dissipation"].passed
    for item in result.values():
        assert (
            (item.passed is None)
            == (not item.applies)
            == (item.value is None)
            == (item.threshold is None)
        )


def test_coulomb_friction_rests_and_has_no_loop_to_close():
    result = check(friction.coulomb(F_C=2.0), force_ripple=(0.5, 1.0))
    assert result["drift"].passed
    assert result["drift"].value == 0.0
    assert not result["closure"].applies


def test_a_viscous_film_has_no_break_away_force():
    result = check(friction.viscous(F_v=5.0))
    assert [name for name, item in result.items() if item.applies] == ["passive", "dissipation"]


def test_units_are_those_of_the_kind_of_axis():
    result = check(friction.lugre(F_C=20.0, F_S=28.0, v_S=2e-3, sigma_0=1e7))
    assert (result["drift"].unit, result["passive"].unit, result["well_posed"].unit) == (
        "m",
        "N*s/m",
        "m",
    )


@pytest.mark.slow
def test_forces_and_positions_may_be_text_with_units():
    bare = check(lugre(), force_ripple=(0.04, 0.08), loop=(3.77e-3, 1.885e-3))
    message = check(lugre(), force_ripple=("40 mN*m", "80 mN*m"), loop=("3.77 mrad", "1.885 mrad"))
    assert message == bare


def test_an_offset_shifts_the_static_forces():
    plain = check(friction.find("lugre+asymmetry")(**slots(offset=0.0)), force_ripple=(0.04, 0.08))
    moved = check(friction.find("lugre+asymmetry")(**slots(offset=0.02)), force_ripple=(0.06, 0.10))
    assert moved["drift"].value == pytest.approx(plain["drift"].value, rel=1e-6)
    assert moved["closure"].value == pytest.approx(plain["closure"].value, rel=1e-6)


def test_friction_that_varies_along_the_axis_is_tested_in_the_middle():
    # At 0, where contacts are led from, friction is 13 % less than in the middle.
    values = {"kind": "rotational", "F_C": 0.1, "F_S": 0.13, "v_S": 0.3, "sigma_0": 100.0}
    place = {"x_0": 0.1, "x_L": 0.1, "p_1": 0.05, "p_2": -0.08}
    plain, varied = friction.lugre(**values), friction.find("lugre+position")(**values, **place)
    ripple = (0.04, 0.08)
    assert (
        check(varied, force_ripple=ripple)["drift"].value
        == check(plain, force_ripple=ripple)["drift"].value
    )


def slots(offset):
    both = {
        f"{name}_{side}": value
        for name, value in (("F_C", 0.1), ("F_S", 0.13))
        for side in ("pos", "neg")
    }
    return both | {"kind": "rotational", "v_S": 0.3, "sigma_0": 100.0, "offset": offset}


def test_a_friction_operator_is_friction():
    result = check(hysteresis.preisach(kernel="dahl_masing", s=1.25e7, f_p=150.0))
    assert [name for name, item in result.items() if item.applies] == [
        "passive",
        "drift",
        "closure",
        "dissipation",
    ]
    assert all(item.passed for item in result.values() if item.applies)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"model": friction.lugre}, "with parameters"),
        ({"model": 3.0}, "with parameters"),
        ({"force_ripple": 0.05}, "two values"),
        ({"force_ripple": (0.05, 0.2)}, "rests"),
        ({"force_ripple": (0.08, 0.04)}, "rests"),
        ({"force_ripple": ("40 J", "80 J")}, "torque"),
        ({"loop": "3 um, 1 um"}, "two values"),
        ({"loop": (3 * UM, 3 * UM)}, "back toward 0 or beyond"),
        ({"loop": (0.0, 1.0)}, "away from 0"),
        ({"loop": (float("nan"), 1.0)}, "loop"),
    ],
)
def test_bad_arguments_are_refused_with_their_place(arguments, words):
    with pytest.raises(InputError, match=words):
        check(arguments.pop("model", lugre()), **arguments)
