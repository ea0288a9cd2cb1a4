"""Output error: a ringing structure with hysteresis, identified from a noisy position."""

from dataclasses import replace

import numpy as np
import pytest
from tests.simulation.test_between_samples import multisine

from bristle import friction, plants
from bristle.core.axis import Axis
from bristle.engine import run_open_loop
from bristle.identification import identify
from bristle.logs.log import Channel, Log
from bristle.prediction import predict
from bristle.report.messages import note_of, notes_of

RATE, SIZE, FINE = 750.0, 1500, 20
PLANT = plants.oscillator(M=2.0, c=40.0, k=5e4)
YIELDING = friction.bouc_wen_classic(alpha=4e4, beta=1e3, gamma=0.9, delta=0.3)
AXIS = Axis(plant="oscillator", offset=0.0, hold="band_limited", at_rest=True, method="output_error", cutoff=150.0, decimation=1)


def recorded(periods: int = 2, noise: float = 5e-6) -> Log:
    """A steady motion: the last of many periods, driven by a smooth force."""
    item = 4.0 * multisine(np.arange(SIZE * FINE) / (RATE * FINE))
    trace = run_open_loop(PLANT, YIELDING, np.tile(item, 3), 1.0 / (RATE * FINE), hold="linear")
    position = np.tile(trace.position[-item.size :: FINE], periods)
    position = position + np.random.default_rng(2).normal(0.0, noise, position.size)
    time = np.arange(position.size) / RATE
    return Log(
        time=Channel(time, "s", "t"),
        position=Channel(position, "m", "y"),
        effort=Channel(np.tile(item[::FINE], periods), "N", "u"),
        sample_time=1.0 / RATE,
        segments=(slice(0, time.size),),
    )


@pytest.fixture(scope="module")
def log() -> Log:
    return recorded()


@pytest.fixture(scope="module")
def fit(log):
    return identify(log, "bouc_wen_classic", axis=AXIS, draws=0).best


def test_intervals_contain_the_truth(fit):
    truth = {"M": 2.0, "c": 40.0, "k": 5e4, "alpha": 4e4}
    for name, true in truth.items():
        estimate = fit.parameters[name]
        assert estimate.status == "identified"
        assert abs(estimate.value - true) < 4.0 * estimate.larger_std, name
        assert estimate.relative_std_percent < 5.0
    for combination, true in zip(fit.combinations, (900.0, 300.0), strict=True):
        assert abs(combination.value - true) < 4.0 * combination.larger_std, combination.name
    assert fit.position_rmse == pytest.approx(5e-6, rel=0.05)


def test_a_factor_without_effect_is_named(fit):
    beta = fit.parameters["beta"]
    assert (beta.status, beta.std) == ("unidentifiable", None)
    assert "depends only on beta*gamma and beta*delta" in note_of(beta)
    assert [combination.name for combination in fit.combinations] == ["beta*gamma", "beta*delta"]


def test_a_held_out_part_is_not_a_repetition_of_a_fitted_part(fit):
    assert fit.held_out.of == "time blocks"
    assert fit.held_out.mean_percent == pytest.approx(fit.position_error_percent, rel=0.1)


def test_the_wrong_hold_costs_more_than_the_noise(fit, log):
    errors = {
        hold: predict(fit.plant, fit.friction, log, replace(AXIS, hold=hold), "open-loop").metrics["position_rmse"]
        for hold in ("band_limited", "linear", "zero")
    }
    assert errors["band_limited"] == pytest.approx(5e-6, rel=0.05)
    assert errors["zero"] > 5.0 * errors["band_limited"]
    assert errors["band_limited"] < errors["linear"] < errors["zero"]


def test_a_zero_order_hold_is_simulated(log):
    fixed = run_open_loop(PLANT, YIELDING, np.tile(log.effort.values, 3), log.sample_time, steps=FINE, hold="zero").position[
        -log.position.values.size :
    ]
    exact = replace(log, position=Channel(fixed, "m", "y"))
    prediction = predict(PLANT, YIELDING, exact, replace(AXIS, hold="zero"), "open-loop")
    assert prediction.metrics["position_error_percent"] < 0.5
    assert "2 equal periods" in notes_of(prediction)[-1]


def test_a_record_stated_as_not_periodic_starts_at_rest(log, fit):
    prediction = predict(fit.plant, fit.friction, log, replace(AXIS, periodic=False), "open-loop")
    assert notes_of(prediction)[-1] == "the motion begins at rest"
    error = np.abs(prediction.position - prediction.position_predicted)
    assert np.max(error[:100]) > 5.0 * np.max(error[-SIZE:])


def test_a_diverging_model_ends_with_a_status(log):
    wild = friction.bouc_wen_classic(alpha=4e4, beta=1e5, gamma=-1.0, delta=0.0)  # each cycle puts energy in
    prediction = predict(PLANT, wild, log, AXIS, "open-loop")
    assert prediction.metrics["position_rmse"] is None
    assert prediction.status.name == "NOT_FINITE"
