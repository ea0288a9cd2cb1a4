"""Parameters of friction models: what is allowed, what holds where nothing is said, and examples of one contact."""

import pytest

from bristle.core import InputError
from bristle.core.motion import Motion
from bristle.friction import MODELS, bouc_wen, find, lugre, maxwell_slip, maxwell_stribeck, preisach_lugre
from bristle.friction.uneven import Contact, uneven

# Of each parameter: the allowed range or the choices, the nominal value, whether it may differ by direction, default and example.
# Models with a state divide by their forces and stiffnesses; a static map may have none. The examples are of one contact: 20 N of
# Coulomb and 28 N of static friction, 1e7 N/m before sliding.
PARAMETERS = """
coulomb.F_C: 0..inf, 1, by direction, -, 20
viscous.F_v: 0..inf, 1, by direction, -, 200
coulomb_viscous.F_v: 0..inf, 1, by direction, -, 200
coulomb_viscous.F_C: 0..inf, 1, by direction, -, 20
stribeck.F_C: 0..inf, 1, by direction, -, 20
stribeck.F_S: 0..inf, 1, by direction, -, 28
stribeck.v_S: 1e-09..inf, 0.01, -, 0.002
stribeck.F_v: 0..inf, 1, by direction, -, 200
stribeck.delta_S: 0.1..10, 1, 2, -
stribeck_free.F_C: 0..inf, 1, by direction, -, 24
stribeck_free.F_0: 0..inf, 1, by direction, -, 18
stribeck_free.v_S: 1e-09..inf, 0.01, -, 0.002
stribeck_free.F_v: 0..inf, 1, by direction, -, 200
stribeck_free.delta_S: 0.1..10, 1, 2, -
dahl.sigma_0: 1e-09..inf, 1e+06, -, 1e+07
dahl.F_C: 1e-12..inf, 1, by direction, -, 20
dahl.sigma_2: 0..inf, 1, by direction, 0, 200
dahl.exponent: 0.1..5, 1, 1, 1.5
reformed_dahl.s: 1e-09..inf, 1e+06, -, 1e+07
reformed_dahl.f_p: 1e-12..inf, 1, by direction, -, 20
reformed_dahl.sigma_2: 0..inf, 1, by direction, 0, 200
bouc_wen.s: 1e-09..inf, 1e+06, -, 1e+07
bouc_wen.F_C: 1e-12..inf, 1, by direction, -, 20
bouc_wen.exponent: 1..20, 1, 2, 2
bouc_wen.beta: 0.5..1, 1, 0.5, 0.6
bouc_wen.alpha: 0..1, 1, 0, -
bouc_wen.sigma_2: 0..inf, 1, by direction, 0, 200
bouc_wen_classic.alpha: 1e-09..inf, 1e+06, -, 1e+07
bouc_wen_classic.gamma: -inf..inf, 1, -, 0.3
bouc_wen_classic.delta: -inf..inf, 1, -, 0.2
bouc_wen_classic.beta: 1e-12..inf, 1000, 1, 1e+06
bouc_wen_classic.nu: 1..20, 1, 1, -
bouc_wen_classic.sigma_2: 0..inf, 1, 0, 200
lugre.F_C: 1e-12..inf, 1, by direction, -, 20
lugre.F_S: 1e-12..inf, 1, by direction, -, 28
lugre.v_S: 1e-09..inf, 0.01, -, 0.002
lugre.sigma_0: 1e-09..inf, 1e+06, -, 1e+07
lugre.sigma_1: 0..inf, 100, 0, 1000
lugre.sigma_2: 0..inf, 1, by direction, 0, 200
lugre.v_d: 1e-12..inf, 1, inf, 0.05
elastoplastic.F_C: 1e-12..inf, 1, by direction, -, 20
elastoplastic.F_S: 1e-12..inf, 1, by direction, -, 28
elastoplastic.v_S: 1e-09..inf, 0.01, -, 0.002
elastoplastic.sigma_0: 1e-09..inf, 1e+06, -, 1e+07
elastoplastic.z_ba: 0..inf, 1e-06, -, 1.4e-06
elastoplastic.sigma_1: 0..inf, 100, 0, 1000
elastoplastic.sigma_2: 0..inf, 1, by direction, 0, 800
maxwell_slip.F_C: 1e-12..inf, 1, by direction, -, 20
maxwell_slip.k_i: 1e-09..inf, 1e+06, -, [6e+06 3e+06 1e+06]
maxwell_slip.nu_i: 0..1, 1, -, [0.3 0.4 0.3]
maxwell_slip.sigma_2: 0..inf, 1, by direction, 0, 200
maxwell_stribeck.F_C: 1e-12..inf, 1, by direction, -, 20
maxwell_stribeck.F_S: 1e-12..inf, 1, by direction, -, 28
maxwell_stribeck.v_S: 1e-09..inf, 0.01, -, 0.002
maxwell_stribeck.k_i: 1e-09..inf, 1e+06, -, [6e+06 3e+06 1e+06]
maxwell_stribeck.nu_i: 0..1, 1, -, [0.3 0.4 0.3]
maxwell_stribeck.sigma_1: 0..inf, 1, 0, 1000
maxwell_stribeck.sigma_2: 0..inf, 1, by direction, 0, 200
maxwell_stribeck.scatter: 0..0.3, 1, 0, 0.05
maxwell_stribeck.v_r: 0..inf, 1, 0, 1e-07
maxwell_stribeck.seed: 0..2.14748e+09, 1, 0, 1
gms.F_C: 1e-12..inf, 1, by direction, -, 20
gms.F_S: 1e-12..inf, 1, by direction, -, 28
gms.v_S: 1e-09..inf, 0.01, -, 0.002
gms.C: 1e-09..inf, 1000, -, 2000
gms.k_i: 1e-09..inf, 1e+06, -, [6e+06 3e+06 1e+06]
gms.nu_i: 0..1, 1, -, [0.3 0.4 0.3]
gms.sigma_2: 0..inf, 1, by direction, 0, 800
gap_slider.F_C: 0..inf, 1, by direction, -, 20
gap_slider.give: 1e-12..inf, 0.001, by direction, -, 4e-06
gap_slider.gap: 0..inf, 1, 0, 4e-06
gap_slider.n: 1..12, 2, 1, 2
gap_slider.share: 0..1, 0.1, 0, 0.1
gap_slider.sigma_2: 0..inf, 1, by direction, 0, 200
preisach_contact.s: 1e-09..inf, 1e+06, -, 1e+07
preisach_contact.f_p: 1e-12..inf, 1, -, 28
preisach_contact.sigma_2: 0..inf, 1, by direction, 0, 200
preisach_contact.kernel: dahl_masing|tip_masing|reformed_dahl_exact|exp_masing, 1, dahl_masing, -
preisach_contact.exponent: 0.1..5, 1, 2, -
preisach_contact.capacity: 4..100000, 1, 256, -
preisach_lugre.s: 1e-09..inf, 1e+06, -, 1e+07
preisach_lugre.f_p: 1e-12..inf, 1, -, 33.6
preisach_lugre.F_C: 1e-12..inf, 1, by direction, -, 20
preisach_lugre.F_S: 1e-12..inf, 1, by direction, -, 28
preisach_lugre.v_S: 1e-09..inf, 0.01, -, 0.002
preisach_lugre.sigma_1: 0..inf, 100, 0, 1000
preisach_lugre.sigma_2: 0..inf, 1, by direction, 0, 800
preisach_lugre.v_d: 1e-12..inf, 1, inf, -
preisach_lugre.kernel: dahl_masing|tip_masing|reformed_dahl_exact|exp_masing, 1, dahl_masing, -
preisach_lugre.exponent: 0.1..5, 1, 2, -
preisach_lugre.transition: paper|leuven|elastoplastic, 1, elastoplastic, -
preisach_lugre.n: 1..50, 1, 2, -
preisach_lugre.rho: 0..0.999, 1, 0.9, -
preisach_lugre.capacity: 4..100000, 1, 256, -
leuven.s: 1e-09..inf, 1e+06, -, 1e+07
leuven.f_p: 1e-12..inf, 1, -, 33.6
leuven.F_C: 1e-12..inf, 1, by direction, -, 20
leuven.F_S: 1e-12..inf, 1, by direction, -, 28
leuven.v_S: 1e-09..inf, 0.01, -, 0.002
leuven.sigma_1: 0..inf, 100, 0, 1000
leuven.sigma_2: 0..inf, 1, by direction, 0, 800
leuven.v_d: 1e-12..inf, 1, inf, -
leuven.kernel: dahl_masing|tip_masing|reformed_dahl_exact|exp_masing, 1, dahl_masing, -
leuven.exponent: 0.1..5, 1, 2, -
leuven.n: 1..50, 1, 2, 4
leuven.capacity: 4..100000, 1, 256, -
efficiency.mu_avg: -inf..inf, 0.1, -, 0.2
efficiency.mu_dif: -inf..inf, 0.01, -, 0.05
efficiency.h: 1e-12..inf, 0.001, -, 2e-06
efficiency.sigma_2: 0..inf, 1, by direction, 0, 200
efficiency.mu_fall: 0..inf, 0.1, 0, 0.1
efficiency.v_S: 1e-09..inf, 0.01, 0.01, 0.002
efficiency.F_idle: 0..inf, 1, 0, 20
"""


def number(value):
    return f"{value:.6g}" if isinstance(value, (int, float)) else str(value)


def told(value):
    return f"[{' '.join(map(number, value))}]" if isinstance(value, (tuple, list)) else number(value)


def line_of(model, name):
    variable = model.variables[name]
    allowed = "|".join(variable.choices) if variable.choices else f"{number(variable.min)}..{number(variable.max)}"
    sided = ", by direction" if variable.directional else ""
    known = [told(values.get(name, "-")) for values in (model.defaults, model.example)]
    return f"{model.name}.{name}: {allowed}, {number(variable.nominal)}{sided}, {', '.join(known)}"


@pytest.mark.parametrize("model", MODELS.values(), ids=list(MODELS))
def test_parameters_have_their_range_nominal_value_default_and_example(model):
    expected = [line for line in PARAMETERS.splitlines() if line.startswith(f"{model.name}.")]
    assert [line_of(model, name) for name in model.variables] == expected


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


@pytest.mark.parametrize("name", ["coulomb", "viscous", "coulomb_viscous", "stribeck", "stribeck_free"])
def test_the_move_of_a_static_map_is_empty(name):
    made = MODELS[name](**MODELS[name].example)
    _, move = made.component.trial((), (), Motion(0.3, 0.0), 1e-3, made.parameters)
    assert (tuple(move), made.component.commit((), (), move, made.parameters)) == ((), ())


def test_a_virgin_uneven_contact_has_no_side_and_its_level():
    made = uneven(find("coulomb_viscous")(F_C=20.0, F_v=100.0, offset=1.5), level=1.2)
    state = made.component.initial_state(made.parameters)
    assert (state.side, state.reversals, state.scale, state.aim, state.factor, state.creeping) == (0.0, 0, 1.0, 1.0, 1.2, 0.0)
    rest = {"level": 1.0, "unevenness": 0.0, "travel": 1e-6, "wave": 0.0, "wavelength": 1.0, "k_creep": 0.0, "tau": 1.0, "seed": 0}
    assert dict(Contact._field_defaults) == rest


def test_an_uneven_contact_keeps_the_kinds_of_its_parameters():
    made = uneven(find("preisach_lugre")(**preisach_lugre.example), level=1.2)
    assert made.component.is_integer("seed")
    assert made.component.is_integer("capacity")
    assert not made.component.is_integer("level")
    elements = uneven(find("maxwell_slip")(**maxwell_slip.example))
    assert elements.component.is_array("k_i")
    assert not elements.component.is_array("level")
