"""A sampled loop holds its effort until the next sample: the effort leads by half a sample."""

import pytest
from tests.identification.known_logs import held_log, sliding_log
from tests.identification.rigid import identify

from bristle import friction
from bristle.core import Axis
from bristle.prediction import predict
from bristle.report.messages import note_of, warnings_of

TRUTH = {"F_C": 35.0, "F_S": 44.0, "v_S": 5e-3, "sigma_0": 1e6, "sigma_1": 2e3, "sigma_2": 200.0}


@pytest.fixture(scope="module")
def log():
    return held_log(friction.lugre(**TRUTH))


def fit_with(log, held):
    return identify(log, "lugre", axis=Axis(held=held, resolution=1e-7), blocks=0, draws=0).best


@pytest.mark.slow
def test_every_parameter_is_in_its_interval_if_the_hold_is_stated(log):
    fit = fit_with(log, True)
    for name, truth in TRUTH.items():
        result = fit.parameters[name]
        assert result.status == "identified", note_of(result)
        if name != "sigma_1":
            assert abs(result.value - truth) < 0.015 * result.interval_percent * result.value, name
    damping = fit.parameters["sigma_1"]
    # Of the half sample, a few hundredths of a sample are left: friction bends between the samples.
    left = 0.03 * log.sample_time * TRUTH["sigma_0"]
    assert abs(damping.value - TRUTH["sigma_1"]) < 0.01 * damping.interval_percent * damping.value + left
    assert damping.interval_percent < 5.0
    assert not any("held" in item for item in warnings_of(fit))


def test_predictions_use_the_effort_with_the_same_hold(log):
    model = friction.lugre(**TRUTH)
    plant = identify(sliding_log(), "coulomb_viscous", mass=28.0, blocks=0, draws=0).best.plant
    stated, unstated = (predict(plant, model, log, Axis(held=fixed)).metrics["force_error_percent"] for fixed in (True, None))
    assert stated < 0.6 * unstated
