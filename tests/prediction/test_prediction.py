"""Predictions of logs whose axis is known: each mode, known inputs, a motion under way, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from tests.prediction.known_axis import AXIS, PLANT, TRUTH, recorded

from bristle import controllers
from bristle.core import InputError
from bristle.core.status import Status
from bristle.identification import identify
from bristle.prediction import predict, unexplained_force
from bristle.prediction.predict import TREATED
from bristle.report.messages import notes_of


def test_the_closed_loop_of_the_true_model_reproduces_the_log():
    prediction = predict(PLANT, TRUTH, recorded(), AXIS, "closed-loop")
    assert prediction.status == Status.OK
    assert prediction.metrics["force_error_percent"] < 1.5
    assert prediction.metrics["position_error_percent"] < 1e-3


@pytest.mark.parametrize("start", [700, 2500])
def test_a_log_that_begins_in_motion_is_simulated_from_motion(start):
    fine = replace(AXIS, resolution=1e-11)
    prediction = predict(
        PLANT, TRUTH, recorded(start=start, resolution=fine.resolution), fine, "closed-loop"
    )
    assert np.max(np.abs(prediction.position_predicted - prediction.position)[:200]) < 5e-6
    assert np.max(np.abs(prediction.effort_predicted - prediction.effort)[:20]) < 0.02


def test_known_inputs_are_injected():
    pulses = np.where((np.arange(6000) // 250) % 5 == 2, 25.0, 0.0)
    log = recorded(injected=pulses)
    knowing = predict(PLANT, TRUTH, log, AXIS, "closed-loop").metrics["force_error_percent"]
    ignorant = predict(PLANT, TRUTH, replace(log, injected=()), AXIS, "closed-loop").metrics[
        "force_error_percent"
    ]
    assert knowing < 1.5
    assert ignorant > 10.0 * knowing


def test_open_loop_skips_twenty_samples_and_follows_the_motion():
    log = recorded()
    prediction = predict(PLANT, TRUTH, log, AXIS, "open-loop")
    assert prediction.time[0] == log.time.values[20]
    assert (prediction.effort_predicted, prediction.metrics["force_error_percent"]) == (None, None)
    # Nothing holds an open loop on its path: it drifts by some 30 um in 6 s.
    assert prediction.metrics["position_error_percent"] < 0.5


def channels_of(result):
    return {name: result.treatment[name] for name in TREATED[1:] if name in result.treatment}


def test_the_treatment_of_the_identification_overrides_that_of_the_axis():
    log = recorded()
    identification = identify(
        log, "coulomb_viscous", axis=AXIS, cutoff=40.0, decimation=4, blocks=0, draws=0
    )
    fit = identification.best
    prediction = predict(
        fit.plant, fit.friction, log, AXIS, cutoff=40.0, decimation=4, **channels_of(identification)
    )
    assert prediction.metrics["force_error_percent"] == pytest.approx(
        fit.force_error_percent, rel=1e-9
    )
    assert prediction.time.size == fit.traces.time.size
    assert "40 Hz" in notes_of(prediction)[0]
    assert predict(fit.plant, fit.friction, log, AXIS).time.size < prediction.time.size


def test_the_unexplained_force_is_the_residual_of_the_identification():
    log = recorded()
    identification = identify(
        log, "coulomb_viscous", axis=AXIS, cutoff=30.0, decimation=1, blocks=0, draws=0
    )
    fit = identification.best
    left = unexplained_force(
        fit.plant, fit.friction, log, AXIS, cutoff=30.0, **channels_of(identification)
    )
    at_rows = left[np.searchsorted(log.time.values, fit.traces.time)]
    assert np.allclose(at_rows, fit.traces.residual, atol=1e-9 * np.max(np.abs(log.effort.values)))


def test_a_diverging_loop_is_reported():
    wild = replace(AXIS, controller=controllers.cascade(k_p=2000.0, k_v=60000.0))
    prediction = predict(PLANT, TRUTH, recorded(), wild, "closed-loop")
    assert prediction.status == Status.NOT_FINITE
    assert prediction.metrics["force_error_percent"] is None


@pytest.mark.parametrize(
    ("change", "mode", "words"),
    [
        (lambda log, axis: (log, replace(axis, controller=None)), "closed-loop", r"\[controller\]"),
        (lambda log, axis: (replace(log, reference=None), axis), "closed-loop", "reference"),
        (lambda log, axis: (replace(log, effort=None), axis), "open-loop", "effort"),
        (
            lambda log, axis: (replace(log, kind="rotational"), axis),
            "inverse",
            "another kind of axis",
        ),
        (lambda log, axis: (log, axis), "sideways", "mode: is not a valid choice"),
        (
            lambda log, axis: (replace(log, segments=(slice(0, 15),)), axis),
            "closed-loop",
            "long enough",
        ),
    ],
)
def test_missing_signals_are_named(change, mode, words):
    log, axis = change(recorded(), AXIS)
    with pytest.raises(InputError, match=words):
        predict(PLANT, TRUTH, log, axis, mode)
