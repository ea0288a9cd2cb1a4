"""Output error in open and closed loop: a ringing structure, a lagging drive, and derivatives."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.loops import AXIS, MASS, recorded_in_loop
from tests.identification.own_models import own_model
from tests.identification.test_sensitivities import OWN, own_trial
from tests.simulation.test_between_samples import multisine

from bristle import friction, plants
from bristle.core import Axis, InputError, InputWarning
from bristle.engine import run_open_loop
from bristle.identification import identify
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.output_error import LAG, OutputError
from bristle.identification.outputs import Effort, Position
from bristle.identification.parameters import PriorKnowledge, parameters_of
from bristle.identification.preprocessing import treat
from bristle.logs.log import Channel, Log
from bristle.models.friction import find
from bristle.prediction import predict
from bristle.report.messages import assumptions_of, note_of, notes_of, warnings_of

RATE, SIZE, FINE = 750.0, 1500, 20
PLANT = plants.oscillator(M=2.0, c=40.0, k=5e4)
YIELDING = friction.bouc_wen_classic(alpha=4e4, beta=1e3, gamma=0.9, delta=0.3)
RINGING = Axis(
    plant="oscillator",
    offset=0.0,
    hold="band_limited",
    at_rest=True,
    method="output_error",
    cutoff=150.0,
    decimation=1,
)


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
    return identify(log, "bouc_wen_classic", axis=RINGING, draws=0).best


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
        hold: predict(
            fit.plant, fit.friction, log, replace(RINGING, hold=hold), "open-loop"
        ).metrics["position_rmse"]
        for hold in ("band_limited", "linear", "zero")
    }
    assert errors["band_limited"] == pytest.approx(5e-6, rel=0.05)
    assert errors["zero"] > 5.0 * errors["band_limited"]
    assert errors["band_limited"] < errors["linear"] < errors["zero"]


def test_a_zero_order_hold_is_simulated(log):
    fixed = run_open_loop(
        PLANT, YIELDING, np.tile(log.effort.values, 3), log.sample_time, steps=FINE, hold="zero"
    ).position[-log.position.values.size :]
    exact = replace(log, position=Channel(fixed, "m", "y"))
    prediction = predict(PLANT, YIELDING, exact, replace(RINGING, hold="zero"), "open-loop")
    assert prediction.metrics["position_error_percent"] < 0.5
    assert "2 equal periods" in notes_of(prediction)[-1]


def test_a_record_stated_as_not_periodic_starts_at_rest(log, fit):
    prediction = predict(
        fit.plant, fit.friction, log, replace(RINGING, periodic=False), "open-loop"
    )
    assert notes_of(prediction)[-1] == "the motion begins at rest"
    error = np.abs(prediction.position - prediction.position_predicted)
    assert np.max(error[:100]) > 5.0 * np.max(error[-SIZE:])


def test_a_diverging_model_ends_with_a_status(log):
    # Each cycle puts energy in.
    wild = friction.bouc_wen_classic(alpha=4e4, beta=1e5, gamma=-1.0, delta=0.0)
    prediction = predict(PLANT, wild, log, RINGING, "open-loop")
    assert prediction.metrics["position_rmse"] is None
    assert prediction.status.name == "NOT_FINITE"


TRUTH = friction.stribeck(F_C=20.0, F_S=28.0, v_S=3e-3, F_v=200.0)
LATE = 0.8e-3
SOUGHT = replace(AXIS, seeks_lag=True)


@pytest.fixture(scope="module")
def loop_log():
    return recorded_in_loop(TRUTH, 3, pairs=5, scatter=0.0, lag=LATE, pulses=6.0)


@pytest.fixture(scope="module")
def loop_fit(loop_log):
    return identify(loop_log, "stribeck", axis=SOUGHT, draws=0).best


@pytest.mark.slow
def test_every_parameter_and_the_lag_of_the_drive_are_recovered(loop_fit):
    for name, truth in {**TRUTH.values, "M": MASS, "lag": LATE}.items():
        assert loop_fit.parameters[name].value == pytest.approx(
            truth, rel=0.05 if name == "lag" else 0.02
        ), name
    assert loop_fit.lag == loop_fit.parameters["lag"].value
    assert loop_fit.loop_error_percent < 1.8  # steps of the encoder in the effort
    assert loop_fit.error_percent == loop_fit.loop_error_percent
    assert loop_fit.position_error_percent is None


@pytest.mark.slow
def test_inverse_dynamics_of_the_same_log_is_less_accurate(loop_fit, loop_log):
    start = identify(
        loop_log, "stribeck", axis=SOUGHT, method="inverse_dynamics", draws=0, blocks=0
    ).best
    assert "lag" not in start.parameters
    # The mass of both is within 0.1 %: what the lag biases is the damping.
    off = [
        abs(item.parameters["F_v"].value / TRUTH.values["F_v"] - 1.0) for item in (loop_fit, start)
    ]
    assert off[0] < 0.2 * off[1]


@pytest.mark.slow
def test_the_prediction_of_the_same_loop_has_the_error_of_the_fit(loop_fit, loop_log):
    with_lag, without = (
        predict(loop_fit.plant, loop_fit.friction, loop_log, AXIS, "closed-loop", lag=lag).metrics[
            "force_error_percent"
        ]
        for lag in (loop_fit.lag, None)
    )
    # The simulated encoder adds its own steps to those of the log.
    assert loop_fit.loop_error_percent < with_lag < 1.6 * loop_fit.loop_error_percent
    assert without > 1.3 * with_lag


@pytest.mark.slow
def test_without_its_known_input_the_loop_differs(loop_fit, loop_log):
    missing = identify(
        replace(loop_log, injected=()), "stribeck", axis=SOUGHT, draws=0, blocks=0
    ).best
    assert missing.loop_error_percent > 2.0 * loop_fit.loop_error_percent


@pytest.mark.slow
def test_blocks_are_held_out_of_the_loop(loop_fit):
    assert loop_fit.held_out.of == "time blocks"
    assert loop_fit.held_out.mean_percent == pytest.approx(loop_fit.loop_error_percent, rel=0.3)


@pytest.mark.slow
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


@pytest.mark.slow
def test_an_interruption_returns_the_best_so_far(loop_log, monkeypatch):
    residual, seen = OutputError.residual, [0]

    def counting(self, free):
        seen[0] += 1
        if seen[0] == 4:
            raise KeyboardInterrupt
        return residual(self, free)

    monkeypatch.setattr(OutputError, "residual", counting)
    identification = identify(loop_log, "stribeck", axis=SOUGHT, draws=0)
    assert identification.best.unfinished
    assert (
        identification.unfinished
        == "interrupted: 0 of 1 models fitted; the fit of stribeck is incomplete"
    )
    assert warnings_of(identification.best)[0].startswith("unfinished: ")
    assert identification.best.loop_error_percent < 20.0


@pytest.mark.slow
def test_a_force_missing_in_the_loop_is_reported(loop_log):
    for axis, changed, text in (
        (
            replace(AXIS, controller=None, loop="closed"),
            loop_log,
            "axis.controller: is needed to fit the closed loop.*the controller of the recorded axis",
        ),
        (replace(AXIS, loop="closed"), replace(loop_log, reference=None), "has no reference"),
        (
            replace(SOUGHT, loop="open"),
            loop_log,
            "effort.lag: can be identified in a closed loop only",
        ),
    ):
        with pytest.raises(InputError, match=text) as refused:
            identify(changed, "coulomb_viscous", axis=axis)
        assert "--mode" not in str(refused.value), "that is an option of predict"
    with pytest.raises(InputError, match="model: needs inverse dynamics"):
        identify(loop_log, "maxwell_slip+position,gms", axis=AXIS)
    with pytest.raises(InputError, match="method: is not a valid choice"):
        identify(loop_log, "coulomb_viscous", axis=AXIS, method="guess")


@pytest.mark.slow
def test_incomparable_models_are_omitted_and_named(loop_log):
    identification = identify(
        loop_log, "coulomb_viscous,maxwell_slip+position", axis=AXIS, blocks=0, draws=0
    )
    assert [item.name for item in identification.fits] == ["coulomb_viscous"]
    assert not identification.unfinished
    assert identification.notes[-1] == "maxwell_slip+position is omitted: needs inverse dynamics"


VALUES = {
    "M": 19.0,
    "F_C": 21.0,
    "F_S": 27.0,
    "v_S": 4e-3,
    "F_v": 210.0,
    "delta_S": 1.8,
    "offset": 0.2,
    LAG: 1e-3,
}
VALUES |= {"sigma_0": 4e6, "sigma_1": 2e3, "sigma_2": 190.0}
YIELDED = {
    "offset": 0.1,
    "M": 2.1,
    "c": 45.0,
    "k": 4.8e4,
    "alpha": 3.8e4,
    "beta": 1.1e3,
    "gamma": 0.85,
    "delta": 0.25,
}


@pytest.fixture(scope="module")
def stretches():
    """Two stretches of a loop whose drive lags; the second one begins in motion."""
    log = recorded_in_loop(
        friction.stribeck(F_C=20.0, F_S=28.0, v_S=3e-3, F_v=200.0),
        3,
        pairs=2,
        scatter=0.0,
        lag=0.8e-3,
        pulses=6.0,
    )
    return replace(log, segments=(slice(0, 600), slice(700, 1300)))


def problem_of(loop, log, axis, component, plant):
    dataset = treat(log, axis)
    return OutputError.of(
        loop,
        InverseDynamics(dataset, parameters_of(component, PriorKnowledge(plant=plant), dataset)),
        [log],
        [axis],
    )


def compare(problem, values):
    values = {name: values[name] for name in problem.parameters.free}
    residual, derivatives = problem.linearised(values)
    assert residual.tobytes() == problem.residual(values).tobytes()
    for column, (name, value) in zip(derivatives.T, values.items(), strict=True):
        step = 1e-6 * (abs(value) or 1.0)
        high, low = (problem.residual({**values, name: value + change}) for change in (step, -step))
        assert np.linalg.norm(column - (low - high) / (2.0 * step)) < 1e-4 * np.linalg.norm(
            column
        ), name


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("name", ["stribeck", "lugre"])
def test_derivatives_of_the_effort_of_a_loop_are_those_of_its_simulation(stretches, name):
    compare(
        problem_of(
            Effort,
            stretches,
            replace(AXIS, seeks_lag=True, presliding=5e-6),
            find(name),
            plants.inertia,
        ),
        VALUES,
    )


@pytest.mark.slow
def test_derivatives_of_a_settled_position_are_those_of_its_simulation():
    log = recorded()
    problem = problem_of(Position, log, RINGING, find("bouc_wen_classic"), plants.oscillator)
    assert problem.outputs[0].loop.periodic
    compare(problem, YIELDED)


def test_an_untranslatable_model_is_differentiated_by_differences_with_a_warning(
    stretches, monkeypatch
):
    own = own_model(own_trial, OWN)
    problem = problem_of(Effort, stretches, AXIS, own, plants.inertia)
    values = {name: (VALUES | {"sigma_2": 200.0})[name] for name in problem.parameters.free}
    monkeypatch.setattr(OutputError, "residual", lambda self, free: np.ones(3))
    with pytest.warns(
        InputWarning, match="bristle differentiates own by finite differences: .*math.tanh"
    ):
        residual, derivatives = problem.linearised(values)
    assert (residual.tolist(), derivatives) == ([1.0] * 3, None)


def constant(state, memory, motion, dt, p):
    return 0.0, state


def test_a_constant_force_is_differentiated_by_differences(stretches, monkeypatch):
    own = own_model(constant, OWN)
    problem = problem_of(Effort, stretches, AXIS, own, plants.inertia)
    monkeypatch.setattr(OutputError, "residual", lambda self, free: np.ones(3))
    with pytest.warns(InputWarning, match="returns a constant force"):
        assert (
            problem.linearised({name: VALUES[name] for name in problem.parameters.free})[1] is None
        )


class HalvedOutputError(OutputError):
    """An estimator of one's own, which differs in its residual only."""

    def residual(self, free):
        return np.full(3, 0.5)


def test_an_overridden_residual_is_used(stretches):
    problem = problem_of(Effort, stretches, AXIS, find("coulomb_viscous"), plants.inertia)
    residual, derivatives = HalvedOutputError(problem.inverse, problem.outputs).linearised(
        {name: VALUES[name] for name in problem.parameters.free}
    )
    assert (residual.tolist(), derivatives) == ([0.5] * 3, None)


def test_known_columns_of_the_log_require_differences(stretches, monkeypatch):
    problem = problem_of(Effort, stretches, AXIS, find("coulomb_viscous"), plants.inertia)
    beside = replace(
        problem,
        outputs=tuple(replace(output, regressors=(output.position,)) for output in problem.outputs),
    )
    monkeypatch.setattr(OutputError, "residual", lambda self, free: np.ones(3))
    assert beside.linearised({name: VALUES[name] for name in problem.parameters.free})[1] is None
