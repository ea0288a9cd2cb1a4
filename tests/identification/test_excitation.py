"""Missing excitation is reported with the numbers of the log."""

import re
from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, log_of, sines, sliding_effort, slow_log
from tests.identification.rigid import identify
from tests.logs.test_check import Run

from bristle import friction
from bristle.identification import Fit
from bristle.report.messages import note_of, warnings_of


def warning_about(name: str, fit: Fit) -> str:
    """The only warning that this parameter is not identified."""
    assert fit.parameters[name].status == "unidentifiable"
    (warning,) = (warning for warning in warnings_of(fit) if warning.startswith(f"{name} cannot be identified: "))
    return warning


def test_slow_motion_does_not_show_viscous_friction_nor_inertia():
    motion = sines(30.0, amplitudes=(2e-4,), frequencies=(0.5,), phases=(0.0,))
    fit = identify(log_of(motion, sliding_effort(motion, noise=3.0)), "coulomb_viscous", axis=STATED, draws=0).best
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
    fit = identify(log, "coulomb_viscous", mass=12.0, blocks=0, cutoff=200.0, decimation=1, draws=0).best
    assert "one speed only, 62.8 mm/s" in warning_about("F_v", fit)


def test_few_fast_reversals_do_not_show_presliding():
    stiff = friction.find("lugre")(F_C=8.0, F_S=8.5, v_S=4e-3, sigma_0=2e7, sigma_1=100.0, sigma_2=30.0)
    log = slow_log(stiff, duration=8.0, step=2e-8)
    fit = identify(log, "lugre", axis=STATED, draws=0).best
    for name in ("sigma_0", "sigma_1"):
        assert "reversals. Each reversal crosses the pre-sliding zone of" in warning_about(name, fit)
    assert fit.parameters["F_C"].status == "identified"


def test_friction_that_does_not_fall_hides_the_stribeck_velocity():
    estimate = identify(slow_log(friction.coulomb_viscous(F_C=8.0, F_v=30.0)), "stribeck", axis=STATED, draws=0).best.parameters["v_S"]
    assert estimate.status in ("unidentifiable", "at_edge")
    assert estimate.std is None or estimate.relative_std_percent > 50.0
    assert re.search("falls with speed.*the log has no constant-velocity segment", note_of(estimate))


def test_the_speeds_of_steady_sliding_are_named():
    fit = identify(Run(0, (0.05, 0.2)).log(), "stribeck", axis=STATED, blocks=0, draws=0).best
    assert re.search(r"the constant speeds are (49|50)\.\d mm/s to (199|20\d) mm/s", note_of(fit.parameters["v_S"]))


def test_an_offset_of_zero_is_identified_as_zero():
    motion = sines()
    fit = identify(log_of(motion, sliding_effort(motion, offset=0.0)), "coulomb_viscous", axis=STATED, draws=0).best
    offset = fit.parameters["offset"]
    assert offset.status == "identified"
    assert abs(offset.value) < 4.0 * offset.std
    assert warnings_of(fit) == ()


def test_bias_of_the_inertia_by_noise_is_reported_for_a_stated_treatment():
    motion = sines(3.0, 1e-4)
    log = log_of(motion, sliding_effort(motion), step=1e-6)

    def fit_with(cutoff):
        fit = identify(log, "coulomb_viscous", axis=replace(STATED, cutoff=cutoff), blocks=0, draws=0).best
        return fit.parameters["M"].value, [item for item in warnings_of(fit) if item.startswith("M is too small by about")]

    noisy, (advice,) = fit_with(1000.0)
    assert noisy < 0.97 * 12.0
    assert fit_with(float(advice.split("cut-off to ")[1].split()[0])) == (pytest.approx(12.0, rel=0.01), [])


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
    fit = identify(log_of(motion, sliding_effort(motion)), "coulomb_viscous", axis=STATED, mass=400.0, draws=0).best
    assert fit.force_error_percent > 40.0
    assert any("the model does not explain" in item for item in warnings_of(fit))
