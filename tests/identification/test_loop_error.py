"""Output error of a closed loop: all parameters together, the lag of the drive among them."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.loops import AXIS, MASS, recorded_in_loop

from bristle import friction
from bristle.core import InputError
from bristle.identification import identify
from bristle.identification.output_error import OutputError
from bristle.prediction import predict
from bristle.report.messages import assumptions_of, warnings_of

pytestmark = pytest.mark.slow

TRUTH = friction.stribeck(F_C=20.0, F_S=28.0, v_S=3e-3, F_v=200.0)
LAG = 0.8e-3
SOUGHT = replace(AXIS, seeks_lag=True)


@pytest.fixture(scope="module")
def log():
    return recorded_in_loop(TRUTH, 3, pairs=5, scatter=0.0, lag=LAG, pulses=6.0)


@pytest.fixture(scope="module")
def fit(log):
    return identify(log, "stribeck", axis=SOUGHT, draws=0).best


def test_every_parameter_and_the_lag_of_the_drive_are_recovered(fit):
    for name, truth in {**TRUTH.values, "M": MASS, "lag": LAG}.items():
        assert fit.parameters[name].value == pytest.approx(truth, rel=0.05 if name == "lag" else 0.02), name
    assert fit.lag == fit.parameters["lag"].value
    assert fit.loop_error_percent < 1.8  # steps of the encoder in the effort
    assert fit.error_percent == fit.loop_error_percent
    assert fit.position_error_percent is None


def test_inverse_dynamics_of_the_same_log_is_less_accurate(fit, log):
    start = identify(log, "stribeck", axis=SOUGHT, method="inverse_dynamics", draws=0, blocks=0).best
    assert "lag" not in start.parameters
    # The mass of both is within 0.1 %: what the lag biases is the damping.
    off = [abs(item.parameters["F_v"].value / TRUTH.values["F_v"] - 1.0) for item in (fit, start)]
    assert off[0] < 0.2 * off[1]


def test_the_prediction_of_the_same_loop_has_the_error_of_the_fit(fit, log):
    with_lag, without = (
        predict(fit.plant, fit.friction, log, AXIS, "closed-loop", lag=lag).metrics["force_error_percent"] for lag in (fit.lag, None)
    )
    # The simulated encoder adds its own steps to those of the log.
    assert fit.loop_error_percent < with_lag < 1.6 * fit.loop_error_percent
    assert without > 1.3 * with_lag


def test_without_its_known_input_the_loop_differs(fit, log):
    missing = identify(replace(log, injected=()), "stribeck", axis=SOUGHT, draws=0, blocks=0).best
    assert missing.loop_error_percent > 2.0 * fit.loop_error_percent


def test_blocks_are_held_out_of_the_loop(fit):
    assert fit.held_out.of == "time blocks"
    assert fit.held_out.mean_percent == pytest.approx(fit.loop_error_percent, rel=0.3)


def test_intervals_of_replicates_contain_the_truth_for_scattering_friction():
    log = recorded_in_loop(TRUTH, 11, pairs=10)
    fit = identify(log, "stribeck", axis=AXIS, draws=60, blocks=0).best
    plain, twins = [], []
    for name, truth in {**TRUTH.values, "M": MASS}.items():
        item = fit.parameters[name]
        if item.status != "identified":
            continue
        plain.append(abs(item.value - truth) < 1.96 * item.std)
        twins.append(item.interval[0] < truth < item.interval[1])
    assert np.mean(twins) >= 0.8
    assert np.mean(plain) <= 0.6
    assert fit.resampling.scatter.low < 0.05 < fit.resampling.scatter.high
    assert "in the loop" in assumptions_of(fit)[-1]


def test_an_interruption_returns_the_best_so_far(log, monkeypatch):
    residual, seen = OutputError.residual, [0]

    def counting(self, free):
        seen[0] += 1
        if seen[0] == 4:
            raise KeyboardInterrupt
        return residual(self, free)

    monkeypatch.setattr(OutputError, "residual", counting)
    identification = identify(log, "stribeck", axis=SOUGHT, draws=0)
    assert identification.best.unfinished
    assert identification.unfinished == "interrupted: the fit of stribeck is incomplete"
    assert warnings_of(identification.best)[0].startswith("unfinished: ")
    assert identification.best.loop_error_percent < 20.0


def test_a_force_missing_in_the_loop_is_reported(log):
    for axis, changed, text in (
        (
            replace(AXIS, controller=None, loop="closed"),
            log,
            "axis.controller: is needed to fit the closed loop.*the controller of the recorded axis",
        ),
        (replace(AXIS, loop="closed"), replace(log, reference=None), "has no reference"),
        (replace(SOUGHT, loop="open"), log, "effort.lag: can be identified in a closed loop only"),
    ):
        with pytest.raises(InputError, match=text) as refused:
            identify(changed, "coulomb_viscous", axis=axis)
        assert "--mode" not in str(refused.value), "that is an option of predict"
    with pytest.raises(InputError, match="model: needs inverse dynamics"):
        identify(log, "maxwell_slip+position,gms", axis=AXIS)
    with pytest.raises(InputError, match="method: is not a valid choice"):
        identify(log, "coulomb_viscous", axis=AXIS, method="guess")


def test_incomparable_models_are_omitted_and_named(log):
    identification = identify(log, "coulomb_viscous,maxwell_slip+position", axis=AXIS, blocks=0, draws=0)
    assert [item.name for item in identification.fits] == ["coulomb_viscous"]
    assert not identification.unfinished
    assert identification.notes[-1] == "maxwell_slip+position is omitted: needs inverse dynamics"
