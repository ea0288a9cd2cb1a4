"""Parameters of friction models: examples by direction and of slots, and how a virgin contact begins."""

import pytest

from bristle.core import InputError
from bristle.core.motion import Motion
from bristle.models.friction import (
    MODELS,
    bouc_wen,
    find,
    lugre,
    maxwell_slip,
    maxwell_stribeck,
    preisach_lugre,
)
from bristle.models.friction.uneven import Contact, uneven


@pytest.mark.parametrize(
    ("model", "name", "value"),
    [
        *((item, "sigma_2", -1.0) for item in (lugre, bouc_wen)),
        (lugre, "F_C", 0.0),
        (maxwell_stribeck, "scatter", 0.31),
        (bouc_wen, "beta", 0.49),
    ],
)
def test_a_value_beyond_its_bound_is_refused_by_name(model, name, value):
    with pytest.raises(InputError, match=name):
        model(**model.example | {name: value})


def test_an_example_by_direction_has_a_tenth_more_forward_and_a_tenth_less_backward():
    model = find("coulomb_viscous+asymmetry")
    assert dict(model.example) == pytest.approx(
        {"F_C_pos": 22.0, "F_C_neg": 18.0, "F_v_pos": 220.0, "F_v_neg": 180.0}
    )


def test_examples_of_slots_are_friction_that_hardly_varies():
    model = find("coulomb+position+periodic+load+temperature")
    example = {name: value for name, value in model.example.items() if name != "F_C"}
    assert (example["x_0"], example["x_L"]) == (0.1, 0.1)  # a stroke from 0 to 0.2 m
    assert (example["p_1"], example["p_2"], example["k_L"], example["k_T"]) == (
        0.05,
        -0.08,
        0.8,
        -0.01,
    )
    assert (example["a_1"], example["a_2"]) == (0.6, 0.4)
    assert (example["pitch"], example["c_1"], example["s_1"], example["c_2"], example["s_2"]) == (
        5e-3,
        0.7,
        -0.3,
        0.3,
        0.2,
    )
    raised = dict(find("coulomb+transmitted+ripple").example)
    assert raised["c_T"] == 0.1
    assert [raised[name] for name in ("pitch", "h_c1", "h_s1", "h_c2", "h_s2")] == [
        5e-3,
        0.7,
        -0.3,
        0.3,
        0.2,
    ]


@pytest.mark.parametrize("model", MODELS.values(), ids=list(MODELS))
def test_a_virgin_contact_has_not_moved(model):
    made = model(**model.example)
    state = made.component.initial_state(made.parameters)
    assert [value for name, value in state._asdict().items() if name != "scale"] == [0.0] * (
        len(state) - ("scale" in state._fields)
    )
    assert getattr(state, "scale", 1.0) == 1.0


@pytest.mark.parametrize(
    "name", ["coulomb", "viscous", "coulomb_viscous", "stribeck", "stribeck_free"]
)
def test_the_move_of_a_static_map_is_empty(name):
    made = MODELS[name](**MODELS[name].example)
    _, move = made.component.trial((), (), Motion(0.3, 0.0), 1e-3, made.parameters)
    assert (tuple(move), made.component.commit((), (), move, made.parameters)) == ((), ())


def test_a_virgin_uneven_contact_has_no_side_and_its_level():
    made = uneven(find("coulomb_viscous")(F_C=20.0, F_v=100.0, offset=1.5), level=1.2)
    state = made.component.initial_state(made.parameters)
    assert (state.side, state.reversals, state.scale, state.aim, state.factor, state.creeping) == (
        0.0,
        0,
        1.0,
        1.0,
        1.2,
        0.0,
    )
    rest = {
        "level": 1.0,
        "unevenness": 0.0,
        "travel": 1e-6,
        "wave": 0.0,
        "wavelength": 1.0,
        "k_creep": 0.0,
        "tau": 1.0,
        "seed": 0,
    }
    assert dict(Contact._field_defaults) == rest


def test_an_uneven_contact_keeps_the_kinds_of_its_parameters():
    made = uneven(find("preisach_lugre")(**preisach_lugre.example), level=1.2)
    assert made.component.is_integer("seed")
    assert made.component.is_integer("capacity")
    assert not made.component.is_integer("level")
    elements = uneven(find("maxwell_slip")(**maxwell_slip.example))
    assert elements.component.is_array("k_i")
    assert not elements.component.is_array("level")
