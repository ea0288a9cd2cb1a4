"""Known truth is recovered within the stated standard errors."""

import numpy as np
import pytest
from tests.identification.known_logs import STATED, TRUTH, log_of, sines, sliding_effort, sliding_log, slow_log

from bristle import friction
from bristle.core import InputError
from bristle.identification import identify
from bristle.report.messages import note_of, warnings_of

pytestmark = pytest.mark.slow


def test_standard_errors_are_valid_for_white_noise():
    scores = []
    for seed in range(40):
        parameters = identify(sliding_log(seed), "coulomb_viscous", axis=STATED, blocks=0, draws=0).best.parameters
        scores.append([(parameters[name].value - truth) / parameters[name].std for name, truth in TRUTH.items()])
    scores = np.array(scores)
    # The spread of 40 draws is known to 11 %, its mean to 0.16; central differences shift M by a known 1e-4.
    assert np.all(np.abs(scores.mean(axis=0)) < [0.8, 0.5, 0.5, 0.5])
    assert np.all((scores.std(axis=0) > 0.65) & (scores.std(axis=0) < 1.4))


def test_each_direction_has_its_own_friction():
    motion = sines()
    forward = sliding_effort(motion, F_C=9.0, F_v=25.0, offset=0.0)
    backward = sliding_effort(motion, F_C=6.0, F_v=40.0, offset=0.0)
    log = log_of(motion, np.where(motion.velocity > 0.0, forward, backward))
    parameters = identify(log, "coulomb_viscous+asymmetry", axis=STATED, draws=0).best.parameters
    for name, truth in {"F_C_pos": 9.0, "F_C_neg": 6.0, "F_v_pos": 25.0, "F_v_neg": 40.0, "M": 12.0}.items():
        assert abs(parameters[name].value - truth) < 4.0 * parameters[name].std
        assert parameters[name].status == "identified"


@pytest.mark.parametrize(
    ("name", "truth"),
    [
        ("dahl", {"sigma_0": 1e5, "F_C": 8.0, "sigma_2": 30.0, "offset": 0.5}),
        ("lugre", {"F_C": 8.0, "F_S": 11.0, "v_S": 4e-3, "sigma_0": 1e5, "sigma_2": 30.0, "offset": 0.5}),
        ("stribeck", {"F_C": 8.0, "F_S": 11.0, "v_S": 4e-3, "F_v": 30.0, "offset": 0.5}),
    ],
)
def test_nonlinear_models_are_recovered(name, truth):
    fit = identify(slow_log(friction.find(name)(**truth)), name, axis=STATED, draws=0).best
    for parameter, value in truth.items():
        estimate = fit.parameters[parameter]
        assert estimate.status == "identified", note_of(estimate)
        assert estimate.value == pytest.approx(value, rel=0.03), parameter
        assert estimate.relative_std_percent < 8.0
    assert fit.parameters["M"].value == pytest.approx(12.0, rel=0.01)


def test_a_gap_and_its_hardening_are_recovered():
    truth = {"F_C": 8.0, "give": 4e-4, "gap": 6e-4, "n": 2.0, "share": 0.1, "sigma_2": 30.0, "offset": 0.5}
    log = slow_log(friction.find("gap_slider")(**truth), duration=6.0)
    parameters = identify(log, "gap_slider", axis=STATED, mass=12.0, blocks=0, draws=0).best.parameters
    for name, value in truth.items():
        assert parameters[name].status == "identified", note_of(parameters[name])
        assert parameters[name].value == pytest.approx(value, rel=0.03), name


def test_a_bound_is_respected_and_reported():
    fit = identify(sliding_log(F_v=-5.0), "coulomb_viscous", axis=STATED, draws=0).best
    assert fit.parameters["F_v"].value == 0.0
    assert fit.parameters["F_v"].status == "at_edge"
    assert fit.parameters["F_v"].std is None
    assert any(sentence.startswith("F_v has no standard error") for sentence in warnings_of(fit))
    assert fit.parameters["F_C"].std > 0.0


def test_predicted_and_measured_are_traced():
    fit = identify(sliding_log(), "coulomb_viscous", axis=STATED, draws=0).best
    traces = fit.traces
    assert traces.time.shape == traces.velocity.shape == traces.measured.shape == traces.predicted.shape
    assert np.all(np.diff(traces.time) > 0.0)
    relative = np.linalg.norm(traces.residual) / np.linalg.norm(traces.measured)
    assert 100.0 * relative == pytest.approx(fit.force_error_percent)
    assert fit.metrics["force_error_percent"] == fit.force_error_percent
    # Of the effort, inertia takes none that friction does: the same residual is a larger share of what is left.
    friction_alone = traces.measured - fit.plant.values["M"] * traces.acceleration
    share = np.std(traces.measured) / np.std(friction_alone)
    assert fit.metrics["friction_error_percent"] == pytest.approx(share * fit.force_error_percent, rel=0.05)


@pytest.mark.parametrize("model", ["coulomb_viscous", "coulomb_viscous+asymmetry"])
def test_weight_is_not_friction_in_relative_errors(model):
    light, heavy = (identify(sliding_log(offset=offset), model, axis=STATED, draws=0, blocks=0).best for offset in (0.0, 6.0))
    assert heavy.friction_alone_error_percent == pytest.approx(light.friction_alone_error_percent, rel=0.02)
    assert heavy.friction_error_percent < 0.9 * light.friction_error_percent
    assert heavy.metrics["friction_alone_error_percent"] == heavy.friction_alone_error_percent


def test_progress_runs_from_start_to_end_and_an_interrupt_passes():
    message = []
    identify(sliding_log(), "coulomb_viscous,stribeck", axis=STATED, progress=lambda share, text: message.append((share, text)), draws=0)
    shares = [share for share, _ in message]
    assert shares == sorted(shares)
    assert (shares[0], shares[-1]) == (0.0, 1.0)
    assert {text.partition(",")[0] for _, text in message} == {"fitting coulomb_viscous", "fitting stribeck"}

    def interrupt(share: float, text: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        identify(sliding_log(), "coulomb_viscous", axis=STATED, progress=interrupt, draws=0)


@pytest.mark.parametrize(
    ("model", "words"),
    [
        ("karnopp", "no such friction model"),
        ("coulomb+humidity", "no such slot"),
        ("maxwell_stribeck", "lists of numbers"),
        ([], "names no friction model"),
        ([3.0], "must be a name"),
    ],
)
def test_a_model_that_cannot_be_fitted_is_named(model, words):
    with pytest.raises(InputError, match=words) as caught:
        identify(sliding_log(), model, axis=STATED, draws=0)
    assert caught.value.path == "model"


@pytest.mark.parametrize(
    ("arguments", "path"),
    [
        ({"mass": 0.0}, "mass"),
        ({"mass": float("nan")}, "mass"),
        ({"offset": float("inf")}, "offset"),
        ({"offset": "7 J"}, "offset"),
        ({"offset": "some"}, "offset"),
        ({"mass": "3 N"}, "mass"),
        ({"cutoff": "60 rad/s"}, "cutoff"),
        ({"decimation": 2.5}, "decimation"),
        ({"blocks": float("nan")}, "blocks"),
        ({"blocks": 1}, "blocks"),
        ({"blocks": 2.5}, "blocks"),
        ({"blocks": 500}, "blocks"),
    ],
)
def test_an_argument_out_of_range_is_named(arguments, path):
    with pytest.raises(InputError) as caught:
        identify(sliding_log(), **({"model": "coulomb_viscous"} | arguments))
    assert caught.value.path == path
