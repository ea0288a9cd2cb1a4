"""Which models a person asks for."""

import pytest
from tests.identification.known_logs import TRUTH, log_of, sines, sliding_effort

from bristle.core import InputError
from bristle.friction import MODELS
from bristle.identification import identify, least_squares
from bristle.identification.request import models_of

REFUSED = {"maxwell_stribeck"}  # its elements are given, not found


def names(model):
    return [item.name for item in models_of(model)]


def test_all_is_every_model_that_can_be_identified():
    assert set(names("all")) == set(MODELS) - REFUSED
    assert names("all+asymmetry") == [f"{name}+asymmetry" for name in MODELS if name not in REFUSED]


def test_what_is_named_beside_all_comes_first_and_once():
    assert names("lugre, all")[0] == "lugre"
    assert sorted(names("lugre,all")) == sorted(names("all"))
    assert names(["all", "coulomb+asymmetry"])[0] == "coulomb+asymmetry"


@pytest.mark.parametrize("model", ["all+speed", "all+asymmetry+asymmetry", "every", "coulomb,coulomb"])
def test_a_wrong_word_is_refused(model):
    with pytest.raises(InputError):
        models_of(model)


@pytest.mark.slow
def test_all_models_are_ranked_and_the_one_that_made_the_log_is_not_beaten(monkeypatch):
    monkeypatch.setattr(least_squares, "STARTS", 1)  # the best of few candidates is one enough for a log so plain
    monkeypatch.setattr(least_squares, "CANDIDATES", 8)
    motion = sines(6.0, 4e-3)
    identification = identify(log_of(motion, sliding_effort(motion)), "all", blocks=3, draws=0)
    plain = [fit for fit in identification.fits if "+" not in fit.name]
    assert len(plain) + len(identification.left_out) == len(MODELS) - len(REFUSED)
    # The best of them with both directions apart, which this log does not ask for.
    assert [fit.name for fit in identification.fits if fit not in plain] == ["coulomb_viscous+asymmetry"]
    assert identification.best.name == "coulomb_viscous"
    assert identification.best.parameters["M"].value == pytest.approx(TRUTH["M"], rel=0.01)
