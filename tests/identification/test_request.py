"""Requested models."""

from types import SimpleNamespace

import pytest
from tests.identification.known_logs import TRUTH, log_of, sines, sliding_effort

from bristle.core import Axis, InputError
from bristle.core.axis import Cogging
from bristle.friction import MODELS
from bristle.identification import identify, least_squares
from bristle.identification.parameters import PriorKnowledge
from bristle.identification.request import freed, models_of, prior_knowledge_of, settings_of, treatment_of, with_method
from bristle.identification.settings import Settings
from bristle.plants import PLANTS

pytestmark = pytest.mark.usefixtures("of_one_mass")

REFUSED = {"maxwell_stribeck"}  # its elements are given, not found
WITHOUT_LOAD = REFUSED | {"efficiency"}  # losses in proportion to a load


def names(model):
    return [item.name for item in models_of(model)]


def test_all_means_every_identifiable_model():
    assert set(names("all")) == set(MODELS) - WITHOUT_LOAD
    assert {model.name for model in models_of("all", transmits=True)} == set(MODELS) - REFUSED
    assert names("all+asymmetry") == [f"{name}+asymmetry" for name in MODELS if name not in WITHOUT_LOAD]


def test_models_named_with_all_come_first_and_once():
    assert names("lugre, all")[0] == "lugre"
    assert sorted(names("lugre,all")) == sorted(names("all"))
    assert names(["all", "coulomb+asymmetry"])[0] == "coulomb+asymmetry"


@pytest.mark.parametrize("model", ["all+speed", "all+asymmetry+asymmetry", "every", "coulomb,coulomb"])
def test_an_unknown_name_is_rejected(model):
    with pytest.raises(InputError):
        models_of(model)


@pytest.mark.slow
def test_among_all_models_the_true_one_is_not_beaten(monkeypatch):
    monkeypatch.setattr(least_squares, "STARTS", 1)  # the best of few candidates is one enough for a log so plain
    monkeypatch.setattr(least_squares, "CANDIDATES", 8)
    motion = sines(6.0, 4e-3)
    identification = identify(log_of(motion, sliding_effort(motion)), "all", blocks=3, draws=0)
    plain = [fit for fit in identification.fits if "+" not in fit.name]
    assert len(plain) + len(identification.left_out) == len(MODELS) - len(WITHOUT_LOAD)
    # The best of them with both directions apart, which this log does not ask for.
    assert [fit.name for fit in identification.fits if fit not in plain] == ["coulomb_viscous+asymmetry"]
    assert identification.best.name == "coulomb_viscous"
    assert identification.best.parameters["M"].value == pytest.approx(TRUTH["M"], rel=0.01)


def test_arguments_override_the_axis_and_the_axis_overrides_the_search():
    known = Axis(mass=12.0, offset=2.0, plant="oscillator", damping=3.0, stiffness=40.0, pitch=0.01)
    prior = prior_knowledge_of(known, None, None, "translational")
    assert (prior.offset, prior.pitch, prior.plant) == (2.0, 0.01, PLANTS["oscillator"])
    assert sorted(prior.values.values()) == [3.0, 12.0, 40.0]
    asked = prior_knowledge_of(known, "500 g", "3 N", "translational")
    assert (asked.offset, sorted(asked.values.values())) == (3.0, [0.5, 3.0, 40.0])
    assert prior_knowledge_of(known, None, "identify", "translational").offset is None
    assert prior_knowledge_of(None, None, None, "rotational").offset is None
    assert prior_knowledge_of(None, 4.0, 0.0, "rotational") == PriorKnowledge(0.0, {"M": 4.0})
    for mass in (0.0, -1.0, 1e-16, float("inf")):
        with pytest.raises(InputError, match="mass"):
            prior_knowledge_of(known, mass, None, "translational")
    assert prior_knowledge_of(known, 1e-15, None, "translational").values["M"] == 1e-15
    with pytest.raises(InputError, match="offset"):
        prior_knowledge_of(known, None, float("nan"), "translational")


def test_turns_of_cogging_are_known_with_its_harmonics():
    axis = Axis(cogging=(Cogging("motor", 0.01, (6,)), Cogging("screw", 0.02, None)))
    prior = prior_knowledge_of(axis, None, None, "translational")
    assert (prior.values, prior.plant.orders) == ({"motor_turn": 0.01}, (("motor", 6),))


def test_shapes_are_freed_and_other_names_are_rejected():
    components = models_of("dahl, stribeck+position")
    assert freed(["exponent", "delta_S"], components) == ("exponent", "delta_S")
    for name in ("F_C", "exponents"):
        with pytest.raises(InputError, match=r"is not a shape parameter with a default value.*delta_S, exponent"):
            freed([name], components)


def test_thresholds_and_method_are_as_requested():
    axis = Axis(settings={"unsure_std": 0.3, "sure": 4.0})
    assert settings_of(axis, {"sure": 6.0}) == Settings(unsure_std=0.3, sure=6.0)
    assert settings_of(axis, Settings()) == settings_of(None, None) == Settings()
    pairs = [("log", axis)]
    assert with_method(pairs, None) == pairs
    assert with_method(pairs, "output_error")[0][1].method == "output_error"
    assert with_method([(SimpleNamespace(kind="rotational"), None)], "output_error")[0][1].kind == "rotational"


@pytest.mark.parametrize("asked", [("0.2 kHz", 5), (None, None), (None, 1), (None, 10_000)])
def test_a_treatment_is_as_requested(asked):
    cutoff, decimation = asked
    assert treatment_of(cutoff, decimation, "translational") == (cutoff and 200.0, decimation)


@pytest.mark.parametrize("rows", [0, 10_001])
def test_a_decimation_out_of_range_is_rejected(rows):
    with pytest.raises(InputError, match="decimation"):
        treatment_of(None, rows, "translational")
