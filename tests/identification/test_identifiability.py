"""What a log shows of a parameter: excitation, edges, noise, encoder steps and rounding."""

import re
from dataclasses import replace

import numpy as np
import pytest
from benchmarks.strangers import make
from tests.identification.known_logs import (
    STATED,
    TRUTH,
    held_log,
    log_of,
    sines,
    sliding_effort,
    sliding_log,
    slow_log,
)
from tests.identification.rigid import identify
from tests.logs.test_check import Run

from bristle import friction
from bristle.core import Axis
from bristle.engine import force_along
from bristle.identification import Fit
from bristle.models.friction import find
from bristle.prediction import predict
from bristle.report.messages import note_of, warnings_of


@pytest.mark.slow
def test_a_rich_log_identifies_every_parameter():
    motion = sines(4.0)
    fit = identify(
        log_of(motion, sliding_effort(motion)), "coulomb_viscous", axis=STATED, blocks=0, draws=20
    ).best
    assert {estimate.status for estimate in fit.estimates} == {"identified"}
    for estimate in fit.estimates:
        assert estimate.interval[0] < estimate.value < estimate.interval[1]
        assert (
            estimate.interval[0] - estimate.larger_std
            < TRUTH[estimate.name]
            < estimate.interval[1] + estimate.larger_std
        )


def test_an_inertia_of_small_effect_is_not_identified():
    motion = sines(6.0, amplitudes=(0.02,), frequencies=(0.1,), phases=(0.3,))
    fit = identify(
        log_of(motion, sliding_effort(motion, noise=0.3, M=0.4)),
        "coulomb_viscous",
        axis=STATED,
        blocks=0,
        draws=20,
    ).best
    assert fit.parameters["M"].status == "unidentifiable"
    assert fit.parameters["F_C"].status == "identified"
    assert any("M cannot be identified" in item for item in warnings_of(fit))


def warning_about(name: str, fit: Fit) -> str:
    """The only warning that this parameter is not identified."""
    assert fit.parameters[name].status == "unidentifiable"
    (warning,) = (
        warning
        for warning in warnings_of(fit)
        if warning.startswith(f"{name} cannot be identified: ")
    )
    return warning


def test_slow_motion_does_not_show_viscous_friction_nor_inertia():
    motion = sines(30.0, amplitudes=(2e-4,), frequencies=(0.5,), phases=(0.0,))
    fit = identify(
        log_of(motion, sliding_effort(motion, noise=3.0)), "coulomb_viscous", axis=STATED, draws=0
    ).best
    assert "never exceeds 628 µm/s" in warning_about("F_v", fit)
    assert re.search("acceleration never exceeds .* mm/s²", warning_about("M", fit))
    assert fit.parameters["F_C"].status == "identified"


def test_one_speed_does_not_separate_coulomb_from_viscous_friction():
    motion = sines(20.0, amplitudes=(0.1,), frequencies=(0.1,), phases=(0.0,))
    # Both ends of a fast stroke cut out leave nearly one speed.
    steady = np.abs(motion.velocity) > 0.995 * np.max(np.abs(motion.velocity))
    edges = np.flatnonzero(np.diff(np.concatenate([[False], steady, [False]]).astype(int)))
    parts = tuple(slice(int(a), int(b)) for a, b in edges.reshape(-1, 2))
    log = log_of(motion, sliding_effort(motion), segments=parts)
    fit = identify(
        log, "coulomb_viscous", mass=12.0, blocks=0, cutoff=200.0, decimation=1, draws=0
    ).best
    assert "one speed only, 62.8 mm/s" in warning_about("F_v", fit)


@pytest.mark.slow
def test_few_fast_reversals_do_not_show_presliding():
    stiff = friction.find("lugre")(
        F_C=8.0, F_S=8.5, v_S=4e-3, sigma_0=2e7, sigma_1=100.0, sigma_2=30.0
    )
    log = slow_log(stiff, duration=8.0, step=2e-8)
    fit = identify(log, "lugre", axis=STATED, draws=0).best
    for name in ("sigma_0", "sigma_1"):
        assert "reversals. Each reversal crosses the pre-sliding zone of" in warning_about(
            name, fit
        )
    assert fit.parameters["F_C"].status == "identified"


@pytest.mark.slow
def test_friction_that_does_not_fall_hides_the_stribeck_velocity():
    estimate = identify(
        slow_log(friction.coulomb_viscous(F_C=8.0, F_v=30.0)), "stribeck", axis=STATED, draws=0
    ).best.parameters["v_S"]
    assert estimate.status in ("unidentifiable", "at_edge")
    assert estimate.std is None or estimate.relative_std_percent > 50.0
    assert re.search(
        "falls with speed.*the log has no constant-velocity segment", note_of(estimate)
    )


def test_the_speeds_of_steady_sliding_are_named():
    fit = identify(Run(0, (0.05, 0.2)).log(), "stribeck", axis=STATED, blocks=0, draws=0).best
    assert re.search(
        r"the constant speeds are (49|50)\.\d mm/s to (199|20\d) mm/s",
        note_of(fit.parameters["v_S"]),
    )


def test_an_offset_of_zero_is_identified_as_zero():
    motion = sines()
    fit = identify(
        log_of(motion, sliding_effort(motion, offset=0.0)), "coulomb_viscous", axis=STATED, draws=0
    ).best
    offset = fit.parameters["offset"]
    assert offset.status == "identified"
    assert abs(offset.value) < 4.0 * offset.std
    assert warnings_of(fit) == ()


def test_bias_of_the_inertia_by_noise_is_reported_for_a_stated_treatment():
    motion = sines(3.0, 1e-4)
    log = log_of(motion, sliding_effort(motion), step=1e-6)

    def fit_with(cutoff):
        fit = identify(
            log, "coulomb_viscous", axis=replace(STATED, cutoff=cutoff), blocks=0, draws=0
        ).best
        return fit.parameters["M"].value, [
            item for item in warnings_of(fit) if item.startswith("M is too small by about")
        ]

    noisy, (advice,) = fit_with(1000.0)
    assert noisy < 0.97 * 12.0
    assert fit_with(float(advice.split("cut-off to ")[1].split()[0])) == (
        pytest.approx(12.0, rel=0.01),
        [],
    )


def test_an_inertia_hidden_by_noise_is_not_identified():
    motion = sines()
    noise = np.random.default_rng(1).normal(0.0, 4e-5, motion.time.size)
    log = log_of(motion._replace(position=motion.position + noise), sliding_effort(motion))
    fit = identify(log, "coulomb_viscous", axis=STATED, blocks=0, draws=0).best
    assert fit.parameters["M"].value < 0.93 * 12.0
    assert fit.parameters["M"].status == "unidentifiable"
    assert [diagnostic.code for diagnostic in fit.diagnostics].count("noisy_acceleration") == 1
    assert fit.parameters["F_C"].status == "identified"


def test_a_model_that_explains_little_is_reported():
    motion = sines()
    fit = identify(
        log_of(motion, sliding_effort(motion)), "coulomb_viscous", axis=STATED, mass=400.0, draws=0
    ).best
    assert fit.force_error_percent > 40.0
    assert any("the model does not explain" in item for item in warnings_of(fit))


@pytest.mark.parametrize(
    ("F_S", "v_S", "status"), [(10.0, 3e-3, "identified"), (9.0, 1e-3, "unidentifiable")]
)
def test_break_away_force_and_stribeck_velocity_are_identified_only_together(F_S, v_S, status):
    # The slowest half of a percent of the rows moves at 1.3 mm/s.
    motion = sines(phases=tuple(np.random.default_rng(0).uniform(0.0, 6.0, 3)))
    falls = (
        (F_S - TRUTH["F_C"]) * np.exp(-((motion.velocity / v_S) ** 2)) * np.sign(motion.velocity)
    )
    parameters = identify(
        log_of(motion, sliding_effort(motion) + falls), "stribeck", axis=STATED, blocks=0, draws=0
    ).best.parameters
    assert {parameters[name].status for name in ("F_S", "v_S")} == {status}
    if status == "identified":
        assert (parameters["F_S"].value, parameters["v_S"].value) == (
            pytest.approx(F_S, rel=0.02),
            pytest.approx(v_S, rel=0.1),
        )


def test_a_force_is_compared_with_the_effort_without_that_of_the_inertia():
    """Of an effort of 65 N friction takes 16: a third of that is less than its level, a third of the effort is not."""
    log, third = sliding_log(), {"beyond_effort": 0.3}
    fit = identify(log, "coulomb_viscous", axis=STATED, blocks=0, draws=0, settings=third).best
    assert np.max(np.abs(log.effort.values)) > 4.0 * TRUTH["F_C"]
    assert fit.parameters["F_C"].reason.code == "beyond_effort"
    assert (
        TRUTH["F_C"]
        < fit.parameters["F_C"].reason.numbers["effort"]
        < 0.5 * np.max(np.abs(log.effort.values))
    )


@pytest.mark.slow
@pytest.mark.parametrize(("v_S", "told"), [(2e-3, False), (10.0, True)])
def test_a_level_at_slow_speeds_is_reported_as_such(v_S, told):
    truth = find("lugre")(
        F_C=8.0, F_S=11.0, v_S=v_S, sigma_0=3e5, sigma_1=600.0, sigma_2=0.0 if told else 30.0
    )
    fit = identify(slow_log(truth), "lugre", axis=STATED, blocks=0, draws=20).best
    assert fit.parameters["F_C"].status == "identified"
    assert (
        any("is the friction at the speeds of this log" in text for text in warnings_of(fit))
        is told
    )


def test_a_level_with_a_known_viscous_friction_is_valid_at_all_speeds():
    fit = identify(
        slow_log(find("coulomb_viscous")(F_C=8.0, F_v=90.0), duration=10.0),
        "stribeck",
        axis=STATED,
        blocks=0,
        draws=0,
    ).best
    statuses = {name: fit.parameters[name].status == "identified" for name in ("F_C", "F_v", "v_S")}
    assert statuses == {"F_C": True, "F_v": True, "v_S": False}
    assert "level_as_seen" not in [diagnostic.code for diagnostic in fit.diagnostics]


STIFF = friction.lugre(F_C=35.0, F_S=44.0, v_S=5e-3, sigma_0=7e6, sigma_1=5e3, sigma_2=200.0)


@pytest.fixture(scope="module")
def stiff():
    return held_log(STIFF, duration=8.0)


def with_position(log, position):
    return replace(log, position=replace(log.position, values=position))


@pytest.fixture(scope="module")
def presliding():
    return slow_log(
        friction.lugre(F_C=8.0, F_S=11.0, v_S=4e-3, sigma_0=1e5, sigma_1=100.0, sigma_2=30.0),
        duration=10.0,
    )


def fit_to(log, model="lugre", settings=None):
    axis = Axis(held=True, seeks_delay=False, cutoff=100.0)
    return identify(log, model, axis=axis, blocks=0, draws=0, settings=settings).best


def doubted(fit, words):
    for name in ("sigma_0", "sigma_1"):
        assert fit.parameters[name].status == "unidentifiable", name
        assert words in note_of(fit.parameters[name])
    if fit.parameters["F_S"].value > 1.2 * np.max(np.abs(fit.traces.measured)):
        assert fit.parameters["F_S"].status != "identified"
    if fit.parameters["F_S"].status != "identified":
        assert fit.parameters["v_S"].status == "unidentifiable"


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("noise", [2e-6, 20e-6])
def test_noise_of_the_position_is_not_presliding(stiff, noise):
    scatter = np.random.default_rng(0).normal(0.0, noise, len(stiff))
    doubted(
        fit_to(with_position(stiff, stiff.position.values + scatter)),
        "times the noise of the position",
    )


def test_coarse_counts_are_not_presliding(stiff):
    step = 50e-6
    doubted(
        fit_to(with_position(stiff, np.round(stiff.position.values / step) * step)),
        "steps of the recorded position",
    )


def test_a_fine_encoder_shows_presliding(stiff):
    stiffness = fit_to(stiff).parameters["sigma_0"]
    assert stiffness.value == pytest.approx(7e6, rel=0.1)
    assert stiffness.status == "identified"


def test_a_static_model_is_reported_to_lack_presliding(presliding):
    warning = next(
        item
        for item in warnings_of(fit_to(presliding, "coulomb_viscous"))
        if "after each reversal" in item
    )
    assert "`lugre`" in warning
    assert "units" not in warning
    assert not any("unexplained" in item for item in warnings_of(fit_to(presliding)))


@pytest.mark.slow
def test_a_stiffness_blurred_by_the_encoder_is_not_identified():
    # Friction builds up over half a step of the encoder; along what the encoder shows a fit finds nine.
    truth, record = make(40009, "lugre", "multisine")
    assert truth.friction.F_C[1] / truth.friction.sigma_0 < 0.6 * truth.encoder.resolution
    motion = type(
        "Recorded", (), {"time": np.asarray(record.t), "position": np.asarray(record.position)}
    )
    effort = record.effort * truth.recording.force_per_effort
    axis = Axis(kind="rotational", seeks_delay=False, cutoff=100.0)
    fit = identify(
        log_of(motion, effort, kind="rotational"), "lugre", axis=axis, blocks=0, draws=20
    ).best
    for name in ("sigma_0", "sigma_1"):
        assert (fit.parameters[name].status, fit.parameters[name].reason.code) == (
            "unidentifiable",
            "coarse_position",
        )


MOTION = sines(duration=6.0)
PLAIN = friction.find("coulomb_viscous")(F_C=8.0, F_v=30.0)
FALLING = friction.find("stribeck")(F_C=8.0, F_S=14.0, v_S=0.02, F_v=30.0)


def log_with(model, seed=None):
    effort = 12.0 * MOTION.acceleration + force_along(model, MOTION.velocity, 1e-3)
    effort = effort + np.random.default_rng(1).normal(0.0, 0.05, effort.size)
    if seed is not None:
        effort = effort + 1e-13 * np.ptp(effort) * np.random.default_rng(seed).uniform(
            -1.0, 1.0, effort.size
        )
    return log_of(MOTION, effort)


def fitted(log, model):
    return identify(log, model, draws=0, blocks=0).best


@pytest.fixture(scope="module")
def plain():
    return fitted(log_with(PLAIN), "stribeck+asymmetry")


@pytest.mark.slow
def test_an_invisible_fall_is_fixed_at_the_edge_of_the_search(plain):
    v_S = plain.parameters["v_S"]
    assert v_S.status == "unidentifiable"
    assert v_S.std is None
    assert v_S.reason.code in ("no_fall", "no_fall")
    assert "v_S" not in plain.correlation_names
    assert [diagnostic.parameter for diagnostic in plain.diagnostics].count("v_S") == 1
    assert plain.parameters["F_C_pos"].value == pytest.approx(8.0, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_last_digits_do_not_change_a_status(plain, seed):
    again = fitted(log_with(PLAIN, seed), "stribeck+asymmetry")
    for name, estimate in plain.parameters.items():
        other = again.parameters[name]
        assert other.status == estimate.status, name
        assert other.value == pytest.approx(estimate.value, rel=1e-4, abs=1e-6), name
        if estimate.std is not None:
            assert other.std == pytest.approx(estimate.std, rel=1e-3), name


@pytest.mark.slow
def test_a_visible_fall_is_found():
    v_S = fitted(log_with(FALLING), "stribeck").parameters["v_S"]
    assert v_S.status == "identified"
    assert v_S.value == pytest.approx(0.02, rel=0.1)


HELD = {"F_C": 35.0, "F_S": 44.0, "v_S": 5e-3, "sigma_0": 1e6, "sigma_1": 2e3, "sigma_2": 200.0}


@pytest.fixture(scope="module")
def log():
    return held_log(friction.lugre(**HELD))


def fit_with(log, held):
    return identify(log, "lugre", axis=Axis(held=held, resolution=1e-7), blocks=0, draws=0).best


@pytest.mark.slow
def test_every_parameter_is_in_its_interval_if_the_hold_is_stated(log):
    fit = fit_with(log, True)
    for name, truth in HELD.items():
        result = fit.parameters[name]
        assert result.status == "identified", note_of(result)
        if name != "sigma_1":
            assert abs(result.value - truth) < 0.015 * result.interval_percent * result.value, name
    damping = fit.parameters["sigma_1"]
    # Of the half sample, a few hundredths of a sample are left: friction bends between the samples.
    left = 0.03 * log.sample_time * HELD["sigma_0"]
    assert (
        abs(damping.value - HELD["sigma_1"])
        < 0.01 * damping.interval_percent * damping.value + left
    )
    assert damping.interval_percent < 5.0
    assert not any("held" in item for item in warnings_of(fit))


def test_predictions_use_the_effort_with_the_same_hold(log):
    model = friction.lugre(**HELD)
    plant = identify(sliding_log(), "coulomb_viscous", mass=28.0, blocks=0, draws=0).best.plant
    stated, unstated = (
        predict(plant, model, log, Axis(held=fixed)).metrics["force_error_percent"]
        for fixed in (True, None)
    )
    assert stated < 0.6 * unstated
