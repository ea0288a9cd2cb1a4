"""Parameters of friction models: what is allowed, what holds where nothing is said, and examples of one contact."""

import math

import pytest

from bristle.core import InputError
from bristle.core.motion import Motion
from bristle.friction import (
    MODELS,
    bouc_wen,
    bouc_wen_classic,
    coulomb,
    coulomb_viscous,
    dahl,
    efficiency,
    elastoplastic,
    find,
    gap_slider,
    gms,
    leuven,
    lugre,
    maxwell_slip,
    maxwell_stribeck,
    preisach_contact,
    preisach_lugre,
    reformed_dahl,
    stribeck,
    stribeck_free,
    viscous,
)
from bristle.friction.uneven import Contact, uneven

# Models with a state divide by their forces and stiffnesses; a static map may have none.
STATIC = (coulomb, viscous, coulomb_viscous, stribeck, stribeck_free, gap_slider)
FORCES, STIFFNESSES = ("F_C", "F_S", "F_0", "f_p"), ("sigma_0", "s", "k_i")
BOUNDS = {
    "v_S": (1e-9, math.inf),
    "v_d": (1e-12, math.inf),
    "F_v": (0.0, math.inf),
    "sigma_1": (0.0, math.inf),
    "sigma_2": (0.0, math.inf),
    "delta_S": (0.1, 10.0),
    "z_ba": (0.0, math.inf),
    "C": (1e-9, math.inf),
    "nu_i": (0.0, 1.0),
    "scatter": (0.0, 0.3),
    "v_r": (0.0, math.inf),
    "rho": (0.0, 0.999),
    "give": (1e-12, math.inf),
    "gap": (0.0, math.inf),
    "share": (0.0, 1.0),
    "beta": (0.5, 1.0),
    "alpha": (0.0, 1.0),
    "nu": (1.0, 20.0),
}
OF_ONE = {
    (dahl, "exponent"): (0.1, 5.0),
    (bouc_wen, "exponent"): (1.0, 20.0),
    (preisach_contact, "exponent"): (0.1, 5.0),
    (preisach_lugre, "exponent"): (0.1, 5.0),
    (leuven, "exponent"): (0.1, 5.0),
    (preisach_lugre, "n"): (1.0, 50.0),
    (leuven, "n"): (1.0, 50.0),
    (gap_slider, "n"): (1.0, 12.0),
    (preisach_contact, "capacity"): (4.0, 100_000.0),
    (preisach_lugre, "capacity"): (4.0, 100_000.0),
    (leuven, "capacity"): (4.0, 100_000.0),
    (bouc_wen_classic, "alpha"): (1e-9, math.inf),
    (bouc_wen_classic, "beta"): (1e-12, math.inf),
    (bouc_wen_classic, "gamma"): (-math.inf, math.inf),
    (bouc_wen_classic, "delta"): (-math.inf, math.inf),
    (efficiency, "mu_avg"): (-math.inf, math.inf),
    (efficiency, "mu_dif"): (-math.inf, math.inf),
    (efficiency, "h"): (1e-12, math.inf),
    (efficiency, "mu_fall"): (0.0, math.inf),
    (efficiency, "F_idle"): (0.0, math.inf),
}
CHOSEN = ("kernel", "transition", "seed")


def bounds_of(model, name):
    if name in FORCES:
        return (0.0 if model in STATIC else 1e-12), math.inf
    if name in STIFFNESSES:
        return 1e-9, math.inf
    return OF_ONE.get((model, name)) or BOUNDS[name]


@pytest.mark.parametrize("model", MODELS.values(), ids=list(MODELS))
def test_parameters_are_allowed_up_to_their_bounds(model):
    for name, variable in model.variables.items():
        if name in CHOSEN:
            continue
        low, high = bounds_of(model, name)
        allowed = [-math.inf if variable.min is None else variable.min, math.inf if variable.max is None else variable.max]
        assert allowed == [low, high], name


@pytest.mark.parametrize("model", [lugre, bouc_wen, maxwell_stribeck])
def test_a_value_beyond_its_bound_is_refused_by_name(model):
    for name, value in {"sigma_2": -1.0, "F_C": 0.0, "scatter": 0.31, "beta": 0.49}.items():
        if name in model.variables:
            with pytest.raises(InputError, match=name):
                model(**model.example | {name: value})


DEFAULTS = {
    "sigma_1": 0.0,
    "sigma_2": 0.0,
    "v_d": math.inf,
    "delta_S": 2.0,
    "scatter": 0.0,
    "v_r": 0.0,
    "seed": 0,
    "alpha": 0.0,
    "beta": 0.5,
    "gap": 0.0,
    "n": 1.0,
    "share": 0.0,
    "nu": 1.0,
    "kernel": "dahl_masing",
    "transition": "elastoplastic",
    "rho": 0.9,
    "capacity": 256,
}
DEFAULTS_OF_ONE = {
    (dahl, "exponent"): 1.0,
    (bouc_wen_classic, "beta"): 1.0,
    (preisach_lugre, "n"): 2.0,
    (leuven, "n"): 2.0,
    (bouc_wen, "exponent"): 2.0,
    (preisach_contact, "exponent"): 2.0,
    (preisach_lugre, "exponent"): 2.0,
    (leuven, "exponent"): 2.0,
    (efficiency, "mu_fall"): 0.0,
    (efficiency, "v_S"): 1e-2,
    (efficiency, "F_idle"): 0.0,
}


@pytest.mark.parametrize("model", MODELS.values(), ids=list(MODELS))
def test_omitted_parameters_are_absent_or_have_the_usual_default(model):
    made = model(**{name: value for name, value in model.example.items() if name not in model.defaults})
    for name in model.defaults:
        expected = DEFAULTS_OF_ONE.get((model, name), DEFAULTS.get(name))
        assert made.values[name] == expected, name


# 20 N of Coulomb and 28 N of static friction, 1e7 N/m before sliding.
CONTACT = {"F_C": 20.0, "F_S": 28.0, "v_S": 2e-3, "sigma_0": 1e7, "s": 1e7, "sigma_1": 1e3, "F_v": 200.0}
VISCOUS = {elastoplastic: 800.0, gms: 800.0, preisach_lugre: 800.0, leuven: 800.0}  # where the Stribeck effect may not be passive with less


@pytest.mark.parametrize("model", MODELS.values(), ids=list(MODELS))
def test_examples_are_of_one_contact(model):
    example = dict(model.example)
    for name, value in CONTACT.items():
        if name in example and (model, name) != (stribeck_free, "F_C"):
            assert example[name] == value, name
    if "sigma_2" in example:
        assert example["sigma_2"] == VISCOUS.get(model, 200.0)
    if "k_i" in example:
        assert sum(example["k_i"]) == 1e7
        assert list(example["k_i"]) == sorted(example["k_i"], reverse=True)
        assert sum(example["nu_i"]) == pytest.approx(1.0)
        # The stiffest element slips first, and each after 1, 2.7 and 6 um.
        assert [20.0 * nu / k for nu, k in zip(example["nu_i"], example["k_i"], strict=True)] == pytest.approx([1e-6, 8e-6 / 3.0, 6e-6])


def test_examples_differ_if_the_model_is_about_the_difference():
    assert (dict(stribeck_free.example)["F_0"], dict(stribeck_free.example)["F_C"]) == (18.0, 24.0)  # friction that rises
    assert dict(reformed_dahl.example)["f_p"] == 20.0
    assert dict(preisach_contact.example)["f_p"] == 28.0
    assert dict(preisach_lugre.example)["f_p"] == dict(leuven.example)["f_p"] == pytest.approx(1.2 * 28.0)
    assert dict(leuven.example)["n"] == 4.0
    assert dict(elastoplastic.example)["z_ba"] == pytest.approx(0.7 * 20.0 / 1e7)
    assert dict(lugre.example)["v_d"] == 0.05
    assert dict(gms.example)["C"] == 2e3
    assert dict(dahl.example)["exponent"] == 1.5
    assert (dict(bouc_wen.example)["exponent"], dict(bouc_wen.example)["beta"]) == (2.0, 0.6)
    assert [dict(maxwell_stribeck.example)[name] for name in ("scatter", "v_r", "seed")] == [0.05, 1e-7, 1]
    assert dict(gap_slider.example) == {"F_C": 20.0, "give": 4e-6, "gap": 4e-6, "n": 2.0, "share": 0.1, "sigma_2": 200.0}
    # The force that yielding bounds is 20 N.
    classic = dict(bouc_wen_classic.example)
    assert classic["alpha"] / (classic["beta"] * (classic["gamma"] + classic["delta"])) == pytest.approx(20.0)
    assert (classic["gamma"], classic["alpha"]) == (0.3, 1e7)
    assert dict(maxwell_slip.example)["nu_i"] == (0.3, 0.4, 0.3)
    assert (dict(efficiency.example)["F_idle"], dict(efficiency.example)["h"]) == (20.0, 20.0 / 1e7)


def test_an_example_by_direction_has_a_tenth_more_forward_and_a_tenth_less_backward():
    model = find("coulomb_viscous+asymmetry")
    assert dict(model.example) == pytest.approx({"F_C_pos": 22.0, "F_C_neg": 18.0, "F_v_pos": 220.0, "F_v_neg": 180.0})


def test_examples_of_slots_are_friction_that_hardly_varies():
    model = find("coulomb+position+periodic+load+temperature")
    example = {name: value for name, value in model.example.items() if name != "F_C"}
    assert (example["x_0"], example["x_L"]) == (0.1, 0.1)  # a stroke from 0 to 0.2 m
    assert (example["p_1"], example["p_2"], example["k_L"], example["k_T"]) == (0.05, -0.08, 0.8, -0.01)
    assert (example["a_1"], example["a_2"]) == (0.6, 0.4)
    assert (example["pitch"], example["c_1"], example["s_1"], example["c_2"], example["s_2"]) == (5e-3, 0.7, -0.3, 0.3, 0.2)
    raised = dict(find("coulomb+transmitted+ripple").example)
    assert raised["c_T"] == 0.1
    assert [raised[name] for name in ("pitch", "h_c1", "h_s1", "h_c2", "h_s2")] == [5e-3, 0.7, -0.3, 0.3, 0.2]


@pytest.mark.parametrize("model", MODELS.values(), ids=list(MODELS))
def test_a_virgin_contact_has_not_moved(model):
    made = model(**model.example)
    state = made.component.initial_state(made.parameters)
    assert [value for name, value in state._asdict().items() if name != "scale"] == [0.0] * (len(state) - ("scale" in state._fields))
    assert getattr(state, "scale", 1.0) == 1.0


@pytest.mark.parametrize("model", [item for item in STATIC if item is not gap_slider], ids=lambda item: item.name)
def test_the_move_of_a_static_map_is_empty(model):
    made = model(**model.example)
    _, move = model.trial((), (), Motion(0.3, 0.0), 1e-3, made.parameters)
    assert (tuple(move), model.commit((), (), move, made.parameters)) == ((), ())


def test_a_virgin_uneven_contact_has_no_side_and_its_level():
    made = uneven(coulomb_viscous_with_offset(), level=1.2)
    state = made.component.initial_state(made.parameters)
    assert (state.side, state.reversals, state.scale, state.aim, state.factor, state.creeping) == (0.0, 0, 1.0, 1.0, 1.2, 0.0)
    assert dict(Contact._field_defaults) == {
        "level": 1.0,
        "unevenness": 0.0,
        "travel": 1e-6,
        "wave": 0.0,
        "wavelength": 1.0,
        "k_creep": 0.0,
        "tau": 1.0,
        "seed": 0,
    }


def coulomb_viscous_with_offset():
    return find("coulomb_viscous")(F_C=20.0, F_v=100.0, offset=1.5)


NOMINAL = {
    "v_S": 1e-2,
    "sigma_0": 1e6,
    "s": 1e6,
    "k_i": 1e6,
    "sigma_1": 1e2,
    "z_ba": 1e-6,
    "C": 1e3,
    "give": 1e-3,
    "n": 2.0,
    "share": 0.1,
    "h": 1e-3,
}


@pytest.mark.parametrize("model", MODELS.values(), ids=list(MODELS))
def test_nominal_values_are_of_the_order_of_a_machine(model):
    for name, variable in model.variables.items():
        expected = NOMINAL.get(name)
        if (model, name) in {(bouc_wen_classic, "alpha"): 1e6, (bouc_wen_classic, "beta"): 1e3}:
            expected = {"alpha": 1e6, "beta": 1e3}[name]
        if (model, name) in {(preisach_lugre, "n"), (leuven, "n"), (maxwell_stribeck, "sigma_1")}:
            expected = None
        if expected is not None:
            assert variable.nominal == expected, name


DIRECTIONAL = ("F_C", "F_S", "F_0", "F_v", "sigma_2", "give")


@pytest.mark.parametrize("model", MODELS.values(), ids=list(MODELS))
def test_only_the_forces_of_sliding_may_differ_by_direction(model):
    for name, variable in model.variables.items():
        expected = (name in DIRECTIONAL or (model, name) == (reformed_dahl, "f_p")) and model is not bouc_wen_classic
        assert variable.directional is expected, name


def test_an_uneven_contact_keeps_the_kinds_of_its_parameters():
    made = uneven(find("preisach_lugre")(**preisach_lugre.example), level=1.2)
    assert made.component.is_integer("seed")
    assert made.component.is_integer("capacity")
    assert not made.component.is_integer("level")
    elements = uneven(find("maxwell_slip")(**maxwell_slip.example))
    assert elements.component.is_array("k_i")
    assert not elements.component.is_array("level")
