"""Effects of noise, coarse steps and a missing mechanism are reported, and no parameter counts as identified wrongly."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import held_log, slow_log

from bristle import friction
from bristle.core import Axis
from bristle.identification import identify
from bristle.report.messages import note_of, warnings_of

pytestmark = pytest.mark.usefixtures("of_one_mass")

STIFF = friction.lugre(F_C=35.0, F_S=44.0, v_S=5e-3, sigma_0=7e6, sigma_1=5e3, sigma_2=200.0)


@pytest.fixture(scope="module")
def stiff():
    return held_log(STIFF, duration=8.0)


def with_position(log, position):
    return replace(log, position=replace(log.position, values=position))


@pytest.fixture(scope="module")
def presliding():
    return slow_log(friction.lugre(F_C=8.0, F_S=11.0, v_S=4e-3, sigma_0=1e5, sigma_1=100.0, sigma_2=30.0), duration=10.0)


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
    doubted(fit_to(with_position(stiff, stiff.position.values + scatter)), "times the noise of the position")


def test_coarse_counts_are_not_presliding(stiff):
    step = 50e-6
    doubted(fit_to(with_position(stiff, np.round(stiff.position.values / step) * step)), "steps of the recorded position")


def test_a_fine_encoder_shows_presliding(stiff):
    stiffness = fit_to(stiff).parameters["sigma_0"]
    assert stiffness.value == pytest.approx(7e6, rel=0.1)
    assert stiffness.status == "identified"


def test_a_static_model_is_reported_to_lack_presliding(presliding):
    warning = next(item for item in warnings_of(fit_to(presliding, "coulomb_viscous")) if "after each reversal" in item)
    assert "`lugre`" in warning
    assert "units" not in warning
    assert not any("unexplained" in item for item in warnings_of(fit_to(presliding)))
