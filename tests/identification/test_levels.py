"""Friction with a level that rises with the transmitted effort or ripples with a screw, and constant friction."""

import numpy as np
import pytest
from tests.simulation import transmitted_truth as truth

import bristle.identification.request as request
from bristle import friction, identify
from bristle.core import InputError
from bristle.files.axis import read_axis
from bristle.friction.next_model import model_with
from bristle.logs.log import Log
from bristle.report.messages import message

pytestmark = pytest.mark.usefixtures("of_one_mass")

COLUMNS = {"time": {"column": "t", "unit": "s"}}
ARM = {
    "schema": 1,
    "kind": "rotational",
    "plant": {"gravity": "link"},
    "identification": {"decimation": 10, "cutoff": "100 Hz"},
    "timing": {"delay": 0},
    "columns": COLUMNS | {"position": {"column": "q", "unit": "rad"}, "effort": {"column": "u", "unit": "N*m"}},
}
SCREW = {
    "schema": 1,
    "kind": "translational",
    "transmission": {"lead": "5 mm"},
    "identification": {"decimation": 4},
    "columns": COLUMNS | {"position": {"column": "q", "unit": "m"}, "effort": {"column": "u", "unit": "N"}},
    "cogging": [{"turn": "motor", "harmonics": [1, 6]}],
}


SLOTTED = ("coulomb_viscous", "coulomb_viscous+transmitted")


def identified(columns, described, model, **options):
    axis = read_axis(described)
    return identify(Log.from_columns(columns, axis=axis), model, axis=axis, draws=0, **options)


def held_out(fit):
    assert fit.held_out is not None
    return fit.held_out.mean_percent


@pytest.fixture(scope="module")
def geared():
    """Fits with the slot and without it, to friction that rises with the transmitted effort."""
    fits = identified(truth.log(seconds=12.0), ARM, list(SLOTTED), blocks=2).fits
    return {fit.name: fit for fit in fits}


def test_friction_of_a_gear_rises_with_the_transmitted_effort(geared):
    with_slot, without = geared["coulomb_viscous+transmitted"], geared["coulomb_viscous"]
    assert with_slot.rank == 1
    assert held_out(without) > 2.0 * held_out(with_slot)
    values = with_slot.friction.values
    assert values["c_T"] == pytest.approx(truth.SHARE, rel=0.03)
    assert values["F_C"] == pytest.approx(truth.F_C, rel=0.03)
    assert with_slot.plant.values["g_sin"] == pytest.approx(truth.GRAVITY, rel=0.01)
    assert "structure" not in {diagnostic.code for diagnostic in with_slot.diagnostics}  # no force is missing


def test_the_slot_does_no_harm_for_constant_friction():
    fits = {fit.name: fit for fit in identified(truth.log(share=0.0, seconds=12.0), ARM, list(SLOTTED), blocks=2).fits}
    plain, slotted = (fits[name] for name in SLOTTED)
    assert held_out(slotted) < 1.02 * held_out(plain)
    assert abs(slotted.friction.values["c_T"]) < 0.005


def test_a_gear_is_named_by_the_input_of_its_friction():
    best = identified(truth.log(), ARM, "coulomb_viscous", blocks=0).best
    said = {diagnostic.code: diagnostic for diagnostic in best.diagnostics}
    assert said["structure"].numbers["causes"][0] == "transmitted"
    assert said["missing_transmitted"].numbers["model"] == "coulomb_viscous+transmitted"
    assert "`coulomb_viscous+transmitted`" in message(said["missing_transmitted"])


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("seed", range(3))
def test_a_gear_is_not_named_for_constant_friction(seed):
    best = identified(truth.log(share=0.0, seed=seed), ARM, "coulomb_viscous", blocks=0).best
    assert "structure" not in {diagnostic.code for diagnostic in best.diagnostics}


@pytest.mark.slow
@pytest.mark.parametrize("share", [truth.SHARE, 0.0])
def test_all_models_include_the_gear_if_the_log_shows_it(share, monkeypatch):
    monkeypatch.setattr(request, "MODELS", {"coulomb": request.MODELS["coulomb"]})
    axis = read_axis(ARM)
    log = Log.from_columns(truth.log(share=share, seconds=10.0), axis=axis)
    identification = identify(log, "all", axis=axis, draws=0, blocks=2)
    names = [fit.name for fit in identification.fits]
    if share:
        assert names[0] == "coulomb_viscous+transmitted"
        plain = next(fit for fit in identification.fits if fit.name == "coulomb")
        assert held_out(plain) > 2.0 * held_out(identification.best)
    else:
        assert not any("transmitted" in name for name in names)


def test_elements_are_not_referred_to_an_impossible_slot():
    assert model_with("transmitted", friction.maxwell_slip(**friction.maxwell_slip.example)) == ""
    assert model_with("transmitted", friction.lugre(**friction.lugre.example)) == "lugre+transmitted"


@pytest.mark.slow
def test_cogging_is_distinguished_from_rippling_friction():
    t, q, v, a = truth.swing(25.0, 3)
    q, v, a = (0.02 * signal for signal in (q, v, a))
    angle = 2.0 * np.pi * q / 5e-3
    # Six in a hundred of the friction each: even once and six times a turn, odd once a turn.
    even = 0.9 * np.cos(angle + 1.0) + 0.9 * np.sin(6.0 * angle)
    u = 12.0 * a + even + (15.0 + 0.9 * np.sin(angle - 0.3)) * np.sign(v) + 60.0 * v
    noisy = u + 0.05 * np.random.default_rng(5).standard_normal(t.size)
    best = identified({"t": t, "q": q, "u": noisy}, SCREW, "coulomb_viscous+ripple").best
    plant, contact = best.plant.values, best.friction.values
    assert np.hypot(plant["motor_1_cos"], plant["motor_1_sin"]) == pytest.approx(0.9, rel=0.1)
    assert np.hypot(plant["motor_6_cos"], plant["motor_6_sin"]) == pytest.approx(0.9, rel=0.1)
    assert np.hypot(contact["h_c1"], contact["h_s1"]) == pytest.approx(0.9, rel=0.1)
    assert contact["h_s1"] == pytest.approx(0.9 * np.cos(0.3), rel=0.1)


@pytest.mark.parametrize(("model", "told"), [("viscous+transmitted", "no friction level"), ("maxwell_slip+transmitted", r"\+transmitted")])
def test_a_model_without_a_level_or_with_elements_has_no_such_slot(model, told):
    with pytest.raises(InputError, match=told):
        identified(truth.log(seconds=3.0), ARM, model)
