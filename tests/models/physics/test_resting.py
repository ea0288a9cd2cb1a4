"""A static map at rest: which force it has there, and which models have a rule for it."""

import math

import pytest

from bristle import friction, hysteresis
from bristle.core.motion import Motion
from bristle.models.friction.resting import HELD, State, rest_rule, with_rest

SIDED = friction.find("coulomb_viscous+asymmetry")(
    F_C_pos=20.0, F_C_neg=14.0, F_v_pos=0.0, F_v_neg=0.0
)


def force(rule, side, v, map_=SIDED):
    model = with_rest(map_, rule)
    result, move = model.component.trial(State(side), (), Motion(v, 0.0), 1e-3, model.parameters)
    return result, model.component.commit(State(side), (), move, model.parameters).side


@pytest.mark.parametrize(
    ("rule", "side", "expected"),
    [
        ("held", 0.0, 3.0),
        ("held", 1.0, 20.0),
        ("held", -1.0, -14.0),
        ("middle", 0.0, 3.0),
        ("middle", 1.0, 3.0),
        ("middle", -1.0, 3.0),
    ],
)
@pytest.mark.parametrize("v", [0.0, -0.0, 1e-10, -1e-10])
def test_the_force_at_rest_is_that_of_the_last_side_or_the_middle(rule, side, expected, v):
    assert force(rule, side, v) == (pytest.approx(expected), side)


@pytest.mark.parametrize("rule", ["held", "middle"])
@pytest.mark.parametrize(("v", "expected"), [(1.1e-10, 20.0), (-1.1e-10, -14.0), (0.5, 20.0)])
def test_a_moving_map_is_unchanged_and_its_side_is_stored(rule, v, expected):
    for side in (0.0, 1.0, -1.0):
        assert force(rule, side, v) == (pytest.approx(expected), math.copysign(1.0, v))


def test_the_load_acts_on_a_contact_at_rest():
    model = with_rest(friction.find("coulomb+load")(F_C=20.0, k_L=1.0), "held")
    assert model.component.trial(State(1.0), (), Motion(0.0, 0.0, 2.0), 1e-3, model.parameters)[
        0
    ] == pytest.approx(40.0)


@pytest.mark.parametrize(
    "model",
    [
        friction.viscous(F_v=3.0),
        friction.dahl(**friction.dahl.example),
        friction.maxwell_slip(F_C=1.0, k_i=[1.0], nu_i=[1.0]),
        hysteresis.stop(r=1.0),
    ],
)
def test_a_model_that_has_one_force_at_rest_has_no_rule(model):
    assert with_rest(model, "held") is model
    assert rest_rule(model) == ""


def test_a_model_keeps_its_rule_its_kind_and_its_parameters():
    holding, middle = with_rest(SIDED, "held"), with_rest(SIDED, "middle")
    assert [rest_rule(model) for model in (holding, middle, SIDED)] == ["held", "middle", ""]
    assert (holding.values[HELD], middle.values[HELD], holding.F_C_neg) == (1.0, 0.0, 14.0)
    assert middle.component is holding.component
    assert with_rest(holding, "middle") is holding
    assert with_rest(friction.coulomb(F_C=1.0, kind="rotational"), "held").kind == "rotational"
