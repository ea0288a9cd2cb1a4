"""Generalised Maxwell slip, from logs with known elements: elements, curve and attraction are recovered."""

import numpy as np
import pytest
from tests.identification.known_logs import STATED, Motion, log_of, sines

from bristle.engine import force_along
from bristle.files.model import read_model, write_model
from bristle.friction import find
from bristle.identification import identify
from bristle.identification.simulated_bands import Bands
from bristle.prediction import predict
from bristle.report.messages import assumptions_of, note_of

pytestmark = pytest.mark.slow

LEVEL, REACH = np.array([0.3, 0.4, 0.3]), np.array([2e-6, 6e-6, 15e-6])  # shares, and where each breaks away
SHAPE = {"v_S": 1e-3, "C": 2e3, "k_i": 28.0 * LEVEL / REACH, "nu_i": LEVEL}
TRUTH = {"F_C": 20.0, "F_S": 28.0, "sigma_2": 300.0, "offset": 1.5}
MASS = 12.0
ASKED = {"axis": STATED, "mass": MASS, "cutoff": 80.0, "decimation": 2, "blocks": 0}


def gms_log(name="gms", *, seed=0, scatter=0.0, **truth):
    """Loops before sliding, then slow sines, with the truth run ten times as fine as the log.

    The level of friction is drawn anew at each reversal.
    """
    dt = 1e-4
    loops = sines(8.0, dt, (30e-6, 14e-6, 6e-6), (0.31, 0.83, 1.97))
    slides = sines(8.0, dt, (6e-3, 6e-4, 2e-4), (0.25, 1.7, 3.1))
    x = np.concatenate([loops.position, slides.position + loops.position[-1] - slides.position[0]])
    v, a = (np.concatenate([getattr(item, name) for item in (loops, slides)]) for name in ("velocity", "acceleration"))
    friction = force_along(find(name)(**(SHAPE | (truth or TRUTH))), v, dt, x)
    sides = np.sign(v)
    leg = np.cumsum(np.diff(sides, prepend=sides[0]) != 0.0)
    levels = 1.0 + scatter * np.random.default_rng(seed + 10).standard_normal(leg[-1] + 1)
    friction = (friction - TRUTH["offset"]) * levels[leg] + TRUTH["offset"]
    coarse = Motion(*(item[::10] for item in (dt * np.arange(x.size), x, v, a)))
    noise = np.random.default_rng(seed).normal(0.0, 0.05, coarse.time.size)
    return log_of(coarse, MASS * coarse.acceleration + friction[::10] + noise, step=1e-8)


def virgin_curve(values, x):
    reach = values["nu_i"] * values["F_S"] / values["k_i"]
    return np.minimum(np.asarray(x)[:, None], reach) @ values["k_i"]


@pytest.fixture(scope="module")
def result():
    return identify(gms_log(), "gms", draws=20, **ASKED)


def test_curve_attraction_and_stiffness_are_recovered(result):
    fit = result.best
    truth = TRUTH | {"v_S": SHAPE["v_S"], "C": SHAPE["C"]}
    for name, value in truth.items():
        estimate = fit.parameters[name]
        assert estimate.status == "identified", note_of(estimate)
        assert estimate.value == pytest.approx(value, rel=0.05), name
    assert fit.parameters["s"].value == pytest.approx(float(np.sum(SHAPE["k_i"])), rel=0.05)
    assert any("assume the given shape of the elements" in item for item in assumptions_of(fit))


def test_intervals_contain_curve_and_attraction_for_scattering_friction():
    fit = identify(gms_log(seed=1, scatter=0.03), "gms", draws=30, **ASKED).best
    for name, value in {"F_C": 20.0, "F_S": 28.0, "v_S": 1e-3, "C": 2e3}.items():
        low, high = fit.parameters[name].interval
        assert low < value < high, name
        assert high - low < 0.5 * value, name


def test_the_virgin_curve_is_recovered_for_any_single_elements(result):
    values, x = result.best.friction.values, np.linspace(0.5e-6, 18e-6, 30)
    assert np.max(np.abs(virgin_curve(values, x) - virgin_curve(SHAPE | TRUTH, x))) < 0.02 * TRUTH["F_S"]


def test_its_model_file_predicts_another_log_with_bands(result, tmp_path):
    fit = result.best
    write_model(tmp_path / "model.toml", fit.plant, fit.friction, estimates=fit.estimates, bands=fit.resampling.bands)
    read = read_model(tmp_path / "model.toml")
    assert read.friction == fit.friction
    bands = Bands(**read.info["bands"])
    text = predict(read.plant, read.friction, gms_log(seed=5), cutoff=80.0, decimation=2, bands=bands)
    assert text.metrics["force_error_percent"] == pytest.approx(fit.force_error_percent, rel=0.1)
    assert text.inside_percent > 85.0


def test_it_ranks_before_elements_without_a_curve():
    fits = identify(gms_log(), "maxwell_slip,gms", draws=0, **(ASKED | {"blocks": 2})).fits
    assert fits[0].name == "gms"
    assert fits[0].force_error_percent < 0.3 * fits[1].force_error_percent


def test_by_direction():
    levels = {"F_C_pos": 24.0, "F_C_neg": 16.0, "F_S_pos": 32.0, "F_S_neg": 24.0}
    log = gms_log("gms+asymmetry", **levels, sigma_2_pos=300.0, sigma_2_neg=300.0)
    fit = identify(log, "gms+asymmetry", draws=0, **ASKED).best
    for name, value in levels.items():
        assert fit.parameters[name].value == pytest.approx(value, rel=0.02), name
