"""Predictions of logs whose axis is known: each mode, known inputs, a motion under way, and what is refused."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.identification.known_logs import sliding_log

from bristle import controllers, friction, sensors
from bristle.core import Axis, InputError
from bristle.core.status import Status
from bristle.engine import run_closed_loop
from bristle.files import read_axis, read_log
from bristle.identification import identify
from bristle.logs.log import Channel, Log
from bristle.plants import inertia
from bristle.prediction import predict, unexplained_force
from bristle.prediction.predict import TREATED
from bristle.report.messages import notes_of

DT = 1e-3
PLANT = inertia(M=12.0)
TRUTH = friction.find("stribeck+asymmetry")(
    F_C_pos=8.0, F_C_neg=6.0, F_S_pos=10.0, F_S_neg=7.5, v_S=5e-3, F_v_pos=30.0, F_v_neg=35.0, offset=1.0
)
AXIS = Axis(controller=controllers.cascade(k_p=80.0, k_v=3000.0), resolution=1e-7)


def recorded(*, injected=None, start=0, kind="translational", gap=None, resolution=AXIS.resolution):
    t = DT * np.arange(6000)
    reference = 0.02 * (np.sin(3.1 * t) + 0.4 * np.sin(10.7 * t)) * np.minimum(t, 1.0)
    desired = np.zeros((4, t.size))
    desired[0] = reference
    trace = run_closed_loop(PLANT, TRUTH, AXIS.controller, sensors.encoder(resolution=resolution), desired, DT, steps=8, injected=injected)
    cut = slice(start, None)
    extra = () if injected is None else (Channel(injected[cut], "N", "pulses"),)
    count = t.size - start
    return Log(
        time=Channel(t[cut], "s", "t"),
        position=Channel(trace.measured[cut], "m", "q"),
        effort=Channel(trace.command[cut], "N", "u"),
        reference=Channel(reference[cut], "m", "r"),
        injected=extra,
        sample_time=DT,
        segments=(slice(0, count),) if gap is None else (slice(0, gap), slice(gap, count)),
        kind=kind,
    )


def test_the_closed_loop_of_the_true_model_reproduces_the_log():
    prediction = predict(PLANT, TRUTH, recorded(), AXIS, "closed-loop")
    assert prediction.status == Status.OK
    assert prediction.metrics["force_error_percent"] < 1.5
    assert prediction.metrics["position_error_percent"] < 1e-3
    assert prediction.metrics["position_unit"] == "m"


@pytest.mark.parametrize("start", [700, 1234, 2500])
def test_a_log_that_begins_in_motion_is_simulated_from_motion(start):
    prediction = predict(PLANT, TRUTH, recorded(start=start), AXIS, "closed-loop")
    assert prediction.metrics["force_error_percent"] < 1.5
    early = np.abs(prediction.position_predicted - prediction.position)[:200]
    assert np.max(early) < 5e-6


@pytest.mark.parametrize("start", [700, 2500])
def test_a_loop_begun_in_motion_has_the_effort_of_the_log_from_the_start(start):
    fine = replace(AXIS, resolution=1e-11)
    prediction = predict(PLANT, TRUTH, recorded(start=start, resolution=fine.resolution), fine, "closed-loop")
    assert np.max(np.abs(prediction.effort_predicted - prediction.effort)[:20]) < 0.02


def test_known_inputs_are_injected():
    pulses = np.where((np.arange(6000) // 250) % 5 == 2, 25.0, 0.0)
    log = recorded(injected=pulses)
    knowing = predict(PLANT, TRUTH, log, AXIS, "closed-loop").metrics["force_error_percent"]
    ignorant = predict(PLANT, TRUTH, replace(log, injected=()), AXIS, "closed-loop").metrics["force_error_percent"]
    assert knowing < 1.5
    assert ignorant > 10.0 * knowing


def test_each_stretch_begins_anew():
    whole = predict(PLANT, TRUTH, recorded(), AXIS, "closed-loop")
    parted = predict(PLANT, TRUTH, recorded(gap=3000), AXIS, "closed-loop")
    assert parted.effort.size == whole.effort.size
    assert parted.metrics["force_error_percent"] < 1.5


def test_open_loop_skips_twenty_samples_and_follows_the_motion():
    log = recorded()
    prediction = predict(PLANT, TRUTH, log, AXIS, "open-loop")
    assert prediction.time[0] == log.time.values[20]
    assert prediction.effort_predicted is None
    assert prediction.metrics["force_error_percent"] is None
    # Nothing holds an open loop on its path: it drifts by some 30 um in 6 s.
    assert prediction.metrics["position_error_percent"] < 0.5
    first = slice(0, 500)
    assert np.max(np.abs(prediction.position_predicted - prediction.position)[first]) < 4e-5


def channels_of(result):
    return {name: result.treatment[name] for name in TREATED[1:] if name in result.treatment}


def test_inverse_is_the_residual_of_the_identification():
    log = recorded()
    identification = identify(log, "coulomb_viscous+asymmetry", axis=AXIS, draws=0)
    fit = identification.best
    prediction = predict(fit.plant, fit.friction, log, AXIS, "inverse", **channels_of(identification))
    assert prediction.metrics["force_error_percent"] == pytest.approx(fit.force_error_percent, rel=1e-9)
    assert prediction.position_predicted is None


def test_the_treatment_of_the_identification_overrides_that_of_the_axis():
    log = recorded()
    identification = identify(log, "coulomb_viscous", axis=AXIS, cutoff=40.0, decimation=4, draws=0)
    fit = identification.best
    prediction = predict(fit.plant, fit.friction, log, AXIS, cutoff=40.0, decimation=4, **channels_of(identification))
    assert prediction.metrics["force_error_percent"] == pytest.approx(fit.force_error_percent, rel=1e-9)
    assert prediction.time.size == fit.traces.time.size
    assert "40 Hz" in notes_of(prediction)[0]
    assert predict(fit.plant, fit.friction, log, AXIS).time.size < prediction.time.size


@pytest.mark.parametrize("cutoff", [15.0, 30.0, 60.0])
def test_the_unexplained_force_is_the_residual_of_the_identification(cutoff):
    log = recorded()
    identification = identify(log, "coulomb_viscous", axis=AXIS, cutoff=cutoff, decimation=1, blocks=0, draws=0)
    fit = identification.best
    left = unexplained_force(fit.plant, fit.friction, log, AXIS, cutoff=cutoff, **channels_of(identification))
    at_rows = left[np.searchsorted(log.time.values, fit.traces.time)]
    assert np.allclose(at_rows, fit.traces.residual, atol=1e-9 * np.max(np.abs(log.effort.values)))


def test_a_diverging_loop_is_reported():
    wild = replace(AXIS, controller=controllers.cascade(k_p=2000.0, k_v=60000.0))
    prediction = predict(PLANT, TRUTH, recorded(), wild, "closed-loop")
    assert prediction.status == Status.NOT_FINITE
    assert prediction.metrics["force_error_percent"] is None


def test_the_true_model_leaves_little_unexplained_force():
    log = recorded()
    left = unexplained_force(PLANT, TRUTH, log, AXIS)
    assert left.size == len(log)
    coarse = unexplained_force(PLANT, friction.coulomb(F_C=8.0), log, AXIS)
    assert np.std(left) < 0.6 * np.std(coarse)
    assert np.std(left) < 0.1 * np.std(log.effort.values)


@pytest.mark.parametrize(
    ("change", "mode", "words"),
    [
        (lambda log, axis: (log, replace(axis, controller=None)), "closed-loop", r"\[controller\]"),
        (lambda log, axis: (replace(log, reference=None), axis), "closed-loop", "reference"),
        (lambda log, axis: (replace(log, effort=None), axis), "open-loop", "effort"),
        (lambda log, axis: (replace(log, kind="rotational"), axis), "inverse", "another kind of axis"),
        (lambda log, axis: (log, axis), "sideways", "mode: is not a valid choice"),
        (lambda log, axis: (replace(log, segments=(slice(0, 15),)), axis), "closed-loop", "long enough"),
    ],
)
def test_missing_signals_are_named(change, mode, words):
    log, axis = change(recorded(), AXIS)
    with pytest.raises(InputError, match=words):
        predict(PLANT, TRUTH, log, axis, mode)


@pytest.mark.measured
def test_the_measured_axis_is_predicted_as_well_as_published():
    folder = os.environ.get("BRISTLE_DATA")
    if not folder:
        pytest.skip("BRISTLE_DATA does not name the folder of the measured logs")
    axis = read_axis(Path(__file__).parents[2] / "examples" / "emps" / "axis.toml")
    log = read_log(Path(folder) / "emps" / "DATA_EMPS.mat", axis)
    for model, limit in (("coulomb_viscous", 4.5), ("coulomb_viscous+asymmetry", 3.6)):
        fit = identify(log, model, axis=axis, draws=0).best
        metrics = predict(fit.plant, fit.friction, log, axis, "closed-loop").metrics
        assert metrics["force_error_percent"] <= limit
        assert metrics["position_error_percent"] <= 0.0012
        # 246 mm there and back in 25 s: an open loop drifts, but stays on the machine.
        assert predict(fit.plant, fit.friction, log, axis, "open-loop").metrics["position_error_percent"] < 10.0


def test_a_prediction_worse_than_zero_is_reported():
    fit = identify(sliding_log(), "coulomb_viscous", blocks=0, draws=0).best
    stiff = friction.coulomb_viscous(F_C=80.0, F_v=30.0)
    doubted = predict(fit.plant, stiff, sliding_log())
    assert doubted.metrics["force_error_percent"] > 100.0
    assert notes_of(doubted)[0].startswith("warning: the prediction is worse than a constant effort of zero")
    message = doubted.diagnostics[0]
    assert (message.code, message.severity) == ("worse_than_none", "warning")
    assert message.numbers["percent"] == doubted.metrics["force_error_percent"]
    assert not any("warning" in item for item in notes_of(predict(fit.plant, fit.friction, sliding_log())))


def test_a_runaway_open_loop_is_reported():
    fit = identify(sliding_log(), "coulomb_viscous", blocks=0, draws=0).best
    loose = friction.coulomb_viscous(F_C=0.1, F_v=0.1)
    notes = notes_of(predict(fit.plant, loose, sliding_log(), mode="open-loop"))
    assert notes[0].startswith("warning: the prediction is worse than a constant position of zero")


def test_a_slowly_sampled_log_is_predicted_with_a_lower_cut_off():
    log = sliding_log()
    fit = identify(log, "coulomb_viscous", cutoff=80.0, blocks=0, draws=0).best
    every = 20  # 50 Hz
    channels = {name: replace(item, values=item.values[::every]) for name, item in log.channels()}
    slow = replace(log, **channels, sample_time=every * log.sample_time, segments=())
    prediction = predict(fit.plant, fit.friction, slow, cutoff=80.0, decimation=10)
    assert notes_of(prediction)[0].startswith("the log is sampled too slowly for the usual filter of 80 Hz. bristle filtered it at 20 Hz")
    # Central differences over 40 ms, and noise of the effort that nothing kept from folding down.
    assert prediction.metrics["force_error_percent"] < 5.0
    assert not any("too slowly" in item for item in notes_of(predict(fit.plant, fit.friction, log, cutoff=80.0)))


@pytest.mark.parametrize("mode", ["inverse", "open-loop"])
def test_speeds_beyond_the_fitted_range_are_reported(mode):
    identification = identify(sliding_log(), "coulomb_viscous", blocks=0, draws=0)
    plant, fitted = identification.best.plant, identification.best.friction
    top = identification.treatment["velocity_max"]
    assert not any("extrapolation" in note for note in notes_of(predict(plant, fitted, sliding_log(), mode=mode, velocity_max=top)))
    notes = notes_of(predict(plant, fitted, sliding_log(), mode=mode, velocity_max=0.5 * top))
    assert any(note.startswith("warning: above ") and "extrapolation" in note for note in notes)
