"""Known truth: an identified axis is simulated along its log, identified again and compared."""

from dataclasses import replace
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest
from tests.identification.rigid import identify

import bristle as br
from bristle.core import InputError
from bristle.core.diagnostic import Diagnostic
from bristle.identification import known_truth
from bristle.identification.known_truth import Determined, SimulatedLog
from bristle.logs.filters import low_passed

DT, COUNT, STEP = 1e-3, 3000, 2e-6
TIME = DT * np.arange(COUNT)
POSITION = 4e-3 * np.sin(6.9 * TIME) * (1.0 + 0.6 * np.sin(1.95 * TIME)) + 1e-3 * np.sin(
    18.2 * TIME
)
AXIS = br.Axis(resolution=STEP)


@pytest.fixture(scope="module")
def identified():
    """A mass with Dahl friction, identified from a log of a fine encoder."""
    friction = br.friction.dahl(F_C=8.0, sigma_0=2e4, sigma_2=20.0)
    inertia = 3.0 * np.gradient(np.gradient(POSITION, DT), DT)
    effort = (
        inertia
        + br.response(friction, POSITION, dt=DT)
        + 0.03 * np.random.default_rng(1).standard_normal(COUNT)
    )
    log = br.Log.from_columns(
        {"time": TIME, "position": STEP * np.round(POSITION / STEP), "effort": effort}, axis=AXIS
    )
    return identify(
        log, "dahl", axis=AXIS, method="inverse_dynamics", draws=20, blocks=0, by=br.identify
    )


def determined(identified, *, axis=AXIS, fit=None, count=2):
    found = Determined.by_simulated_logs(
        [identified.log], [axis], fit or identified.best, identified.treatment, {}, count=count
    )
    return {one.name: one for one in found}


@pytest.mark.slow
def test_visible_parameters_are_determined_within_percents(identified):
    found = determined(identified)
    for name in ("M", "sigma_0", "F_C"):
        assert found[name].verdict == "determined", name
        assert found[name].truth == identified.parameters[name].value
        assert abs(found[name].median_error_percent) < 5.0
    assert found["sigma_0"].hold == found["sigma_0"].intervals == 2


@pytest.mark.slow
def test_an_encoder_forty_decibels_coarser_hides_the_stiffness(identified):
    found = determined(identified, axis=replace(AXIS, resolution=100.0 * STEP))
    assert found["sigma_0"].verdict == "not determined"
    assert found["sigma_0"].identified < found["F_C"].identified == 2


@pytest.mark.slow
def test_the_truth_is_that_of_the_models_not_of_the_log(identified, monkeypatch):
    monkeypatch.setattr(
        known_truth, "identify", lambda logs, **asked: identify(logs, **asked | {"draws": 0})
    )
    best = identified.best
    found = determined(
        identified,
        fit=replace(best, friction=best.friction.component(**best.friction.values | {"F_C": 12.0})),
        count=1,
    )
    assert list(found) == ["M", "sigma_0", "F_C", "sigma_2", "offset"]  # and no shape that is held
    assert found["F_C"].truth == 12.0
    assert max(abs(found[name].median_error_percent) for name in ("M", "sigma_0", "F_C")) < 5.0
    assert found["offset"].relative_to == "F_C"


def drawn(identified, resolution=STEP, **treatment):
    axis, treatment = replace(AXIS, resolution=resolution), dict(identified.treatment) | treatment
    return SimulatedLog(identified.log, axis, identified.best, treatment).drawn(
        np.random.default_rng(3)
    )


def test_a_simulated_log_has_the_delay_and_the_encoder_of_the_recorded_log(identified):
    simulated, coarse = (
        drawn(identified, delay=4e-3),
        drawn(identified, resolution=5.0 * STEP, delay=4e-3),
    )
    position, effort = (
        low_passed(signal.values, 40.0, DT) for signal in (simulated.position, simulated.effort)
    )
    friction = br.response(identified.model, position, dt=DT)
    friction[:-1] = 0.5 * (friction[:-1] + friction[1:])  # that of a step is the one in its middle
    acted = identified.plant.values["M"] * np.gradient(np.gradient(position, DT), DT) + friction
    off = [np.std((effort[lag:] - acted[: COUNT - lag])[200:-200]) for lag in range(10)]
    assert np.argmin(off) == 4
    steps = np.diff(simulated.position.values) / STEP
    assert steps == pytest.approx(np.round(steps), abs=1e-6)
    # Not the phase of the recorded log, which is 0
    assert 0.05 < simulated.position.values[0] / STEP % 1.0 < 0.95
    assert np.min(np.abs(np.diff(np.unique(coarse.position.values)))) > 4.9 * STEP
    # Friction moves the axis by itself.
    assert np.std(simulated.position.values - identified.log.position.values) > STEP


def test_a_simulated_log_has_the_filter_of_the_effort(identified):
    smooth, rough = (
        drawn(identified, smoothing=smoothing).effort.values for smoothing in (3e-3, 0.0)
    )
    assert np.std(np.diff(smooth, 2)) < 0.5 * np.std(np.diff(rough, 2))


def test_friction_over_a_recorded_channel_acts_along_the_recorded_motion(identified):
    log, best = identified.log, identified.best
    warm = np.where(TIME < 1.5, 283.15, 303.15)
    log = br.Log.from_columns(
        {
            "time": TIME,
            "position": log.position.values,
            "effort": log.effort.values,
            "temperature": warm,
        },
        axis=AXIS,
    )
    model = br.friction.find("coulomb_viscous+temperature")(F_C=8.0, F_v=20.0, k_T=-0.02)
    simulated = drawn(
        replace(identified, log=log, fits=(replace(best, friction=model),)), delay=5e-3
    )
    assert np.max(np.abs(simulated.position.values - log.position.values)) < 20.0 * STEP
    velocity = np.gradient(POSITION, DT)
    ahead = simulated.effort.values - 3.0 * np.gradient(np.gradient(np.roll(POSITION, 5), DT), DT)
    sliding = np.abs(velocity) > 0.02
    cold, hot = (
        np.mean(np.abs(ahead[sliding & part]))
        for part in ((TIME > 0.2) & (TIME < 1.4), (TIME > 1.6) & (TIME < 2.8))
    )
    assert hot / cold == pytest.approx(0.8 / 1.2, rel=0.08)


def test_a_fit_to_a_simulated_log_knows_only_the_given_data(identified, monkeypatch):
    again = Mock(return_value=SimpleNamespace(best=SimpleNamespace(parameters={})))
    monkeypatch.setattr(known_truth, "identify", again)
    determined(identified)
    asked = again.call_args.kwargs
    assert (asked["cutoff"], asked["free"], asked["mass"], asked["offset"]) == (
        None,
        [],
        None,
        None,
    )
    assert (asked["method"], asked["draws"], asked["axis"]) == ("inverse_dynamics", 20, [AXIS])
    best = identified.best
    told = Diagnostic("held_known", "M")
    estimates = [
        replace(one, status="held", reason=told)
        if one.name == "M"
        else replace(one, status="identified")
        for one in best.estimates
    ]
    changed = replace(
        best, estimates=tuple(estimates), diagnostics=(Diagnostic("prediction_error"),)
    )
    treatment = dict(identified.treatment) | {"cutoff": 60.0}
    Determined.by_simulated_logs(
        [identified.log], [AXIS], changed, treatment, {"hidden_shape": 0.1}, count=1
    )
    asked = again.call_args.kwargs
    assert (asked["cutoff"], asked["free"], asked["mass"]) == (
        60.0,
        ["exponent"],
        identified.parameters["M"].value,
    )
    assert (asked["method"], asked["settings"]) == ("prediction_error", {"hidden_shape": 0.1})


def test_progress_covers_all_logs(identified, monkeypatch):
    def noted(logs, *, progress, **options):
        progress(0.5, "fitting")
        return SimpleNamespace(best=SimpleNamespace(parameters={}))

    shares = []
    monkeypatch.setattr(known_truth, "identify", noted)
    record = [identified.log], [AXIS], identified.best, identified.treatment, {}
    Determined.by_simulated_logs(*record, count=2, progress=lambda *told: shares.append(told))
    assert [share for share, _ in shares] == [0.0, 0.25, 0.5, 0.75]
    assert shares[-1][1] == "identifying simulated log 2 of 2"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"resampling": None}, "without simulated logs"),
        ({"loop_rmse": 1.0}, "output_error"),
        ({"position_rmse": 1e-6}, "output_error"),
    ],
)
def test_a_fit_that_cannot_be_simulated_is_rejected(identified, changes, words):
    with pytest.raises(InputError, match=words):
        determined(identified, fit=replace(identified.best, **changes))


def test_a_rejected_simulated_log_counts_and_an_error_is_raised_if_all_are(identified, monkeypatch):
    error = InputError("is too short", path="log")
    monkeypatch.setattr(known_truth, "identify", Mock(side_effect=[error, identified]))
    found = determined(identified)
    assert (found["F_C"].identified, found["F_C"].logs, found["F_C"].verdict) == (
        1,
        2,
        "not determined",
    )
    assert (found["F_C"].hold, found["F_C"].intervals) == (1, 1)
    monkeypatch.setattr(known_truth, "identify", Mock(side_effect=error))
    with pytest.raises(InputError, match="is too short"):
        determined(identified)


@pytest.mark.parametrize(
    ("errors", "hold", "verdict", "narrow"),
    [
        ([1.0, -1.0, 2.0, 0.0, -2.0, 1.0], 6, "determined", False),
        ([1.0, -1.0, 2.0, 0.0, -2.0, 1.0], 4, "determined", True),
        ([31.0, 29.0, 32.0, 30.0, 28.0, 31.0], 6, "rough", False),
        ([60.0, -55.0, 40.0, 30.0, -28.0, 31.0], 6, "not determined", False),
        # Identified in no more than half of the logs.
        ([1.0, -1.0, 2.0], 2, "not determined", False),
        ([np.nan] * 6, 6, "not determined", False),  # the true value is 0
    ],
)
def test_a_verdict_depends_on_errors_and_intervals(errors, hold, verdict, narrow):
    one = Determined("F_C", "N", "level", 8.0, "F_C", np.array(errors), len(errors), hold, 6)
    assert (one.verdict, one.too_narrow) == (verdict, narrow)
