"""The rehearsal: a log as the drive would write it, and what it tells of a truth that is known."""

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from tests.prediction.excitation.axes import STAGE

from bristle.engine import force_along
from bristle.models.controllers import cascade
from bristle.models.friction import find, lugre, maxwell_slip
from bristle.prediction.excitation import excite
from bristle.prediction.excitation.limits import prior_of
from bristle.prediction.excitation.rehearsal import recorded

AXIS = replace(STAGE, resolution=1e-8)
TRUTH = lugre(F_C=60.0, F_S=80.0, v_S=2e-3, sigma_0=1.2e7, sigma_1=4e3, sigma_2=150.0)


@pytest.fixture(scope="module")
def result():
    return excite(AXIS, duration="24 s", purposes="presliding,stribeck", model=TRUTH, draws=0)


def test_the_prior_is_identified_within_the_scatter(result):
    values = {
        estimate.name: estimate.value for estimate in result.rehearsal.identification.best.estimates
    }
    assert result.rehearsal.truth["sigma_0"] == 1.2e7
    assert values["sigma_0"] == pytest.approx(1.2e7, rel=0.1)
    assert values["F_C"] == pytest.approx(60.0, rel=0.05)
    assert values["F_S"] == pytest.approx(80.0, rel=0.05)


@pytest.mark.slow
def test_without_slow_loops_stiffness_is_not_found():
    lost = excite(AXIS, duration="10 s", purposes="stribeck", model=TRUTH, draws=0)
    status = {
        estimate.name: estimate.status for estimate in lost.rehearsal.identification.best.estimates
    }
    assert status["sigma_0"] != "identified" or status["sigma_1"] != "identified"
    assert lost.rehearsal.lag == 0.0


@pytest.mark.slow
def test_with_a_controller_it_runs_in_the_loop():
    stiff, soft = (
        excite(
            replace(AXIS, controller=cascade(k_p=k, k_v=4e3, k_i=40.0 * k * 4e3)),
            duration="16 s",
            purposes="presliding",
            model=TRUTH,
            draws=0,
        )
        for k in (60.0, 6.0)
    )
    assert stiff.rehearsal.loop is soft.rehearsal.loop is True
    assert 0.0 < stiff.rehearsal.lag < AXIS.presliding < soft.rehearsal.lag


@pytest.fixture
def fitted(monkeypatch, result):
    """The models that are fitted to logs, which all give what that of `result` gives."""
    names = []
    identify = lambda log, name, **how: names.append(name) or result.rehearsal.identification  # noqa: E731
    monkeypatch.setattr(
        import_module("bristle.prediction.excitation.rehearsal"), "identify", identify
    )
    return names


def test_a_model_with_lists_is_rehearsed_and_another_fitted(fitted):
    elements = maxwell_slip(F_C=60.0, k_i=[2e7, 8e6], nu_i=[0.5, 0.5])
    rehearsal = excite(
        AXIS, duration="16 s", purposes="presliding", model=elements, draws=0
    ).rehearsal
    assert (fitted, set(rehearsal.truth)) == (["lugre"], {"M"})


def test_a_loop_that_the_guessed_mass_would_make_unstable_is_not_run(fitted):
    guessed = replace(
        AXIS, mass=None, effort_limit=None, controller=cascade(k_p=160.0, k_v=8500.0, limit=350.0)
    )
    result = excite(guessed, duration="7 s", purposes="break-away", draws=0)
    assert result.rehearsal.loop is False
    assert any("mass of" in item for item in result.prior.assumed)


@pytest.mark.slow
def test_the_chirp_identifies_micro_damping():
    axis, truth = replace(AXIS, sample_time=2e-4, jerk_limit=None), TRUTH.with_values(sigma_1=8e3)
    result = {}
    for purposes in ("presliding,damping", "presliding"):
        motion = excite(axis, duration="12 s", purposes=purposes, model=truth, draws=0)
        result[purposes] = motion.rehearsal.identification.best.parameters["sigma_1"]
    chirped, plain = result.values()
    assert chirped.status == "identified"
    assert chirped.value == pytest.approx(8e3, rel=0.1)
    assert chirped.larger_std < 0.5 * plain.larger_std


@pytest.fixture(scope="module")
def motion():
    return excite(AXIS, duration="6 s", purposes="break-away", rehearsed=False).motion


@pytest.fixture(scope="module")
def loops():
    """A motion of many reversals."""
    return excite(AXIS, duration="16 s", purposes="presliding", rehearsed=False).motion


def test_a_log_without_a_loop_is_the_motion_with_friction_that_scatters_and_an_effort_that_is_noisy(
    loops,
):
    prior = prior_of(replace(AXIS, resolution=None), None, TRUTH)
    log, friction, loop = recorded(loops, replace(AXIS, resolution=None, offset=3.0), prior)
    v, dt = loops.velocity, loops.sample_time
    expected = force_along(TRUTH, v, dt)
    factors = (friction / np.where(expected == 0.0, np.nan, expected))[np.abs(expected) > 1.0]
    turns = np.unique(np.round(factors, 9))
    assert loop is False
    assert log.position.values == pytest.approx(loops.position, abs=0.0)
    assert log.reference.values == pytest.approx(loops.position, abs=0.0)
    assert 50 < turns.size < 100  # another factor after every reversal
    assert np.mean(turns) == pytest.approx(1.0, abs=0.02)
    assert np.std(turns) == pytest.approx(0.05, rel=0.3)
    noise = log.effort.values - 28.0 * loops.acceleration - friction
    assert np.mean(noise) == pytest.approx(3.0, abs=0.02)
    assert np.std(noise) == pytest.approx(0.005 * np.sqrt(np.mean(expected**2)), rel=0.05)


def test_a_log_is_in_the_units_of_the_kind_of_axis(motion):
    log, _, _ = recorded(motion, AXIS, prior_of(AXIS, None, TRUTH))
    assert [getattr(log, name).unit for name in ("time", "position", "effort", "reference")] == [
        "s",
        "m",
        "N",
        "m",
    ]
    assert log.segments == (slice(0, motion.time.size),)


@pytest.mark.parametrize(("offset", "added"), [("identify", 0.0), (-2.5, -2.5)])
def test_a_known_offset_of_the_effort_is_added(motion, offset, added):
    prior = prior_of(AXIS, None, TRUTH)
    log, _, _ = recorded(motion, replace(AXIS, offset=offset), prior)
    exact, _, _ = recorded(motion, replace(AXIS, offset=0.0), prior)
    assert log.effort.values - exact.effort.values == pytest.approx(
        np.full(motion.time.size, added)
    )


@pytest.mark.parametrize(("gain", "stable"), [(60.0, True), (6e4, False)])
def test_a_stable_loop_is_simulated_for_the_log(motion, gain, stable):
    axis = replace(AXIS, controller=cascade(k_p=gain, k_v=4e3), effort_limit=None)
    log, _, loop = recorded(motion, axis, prior_of(axis, None, TRUTH))
    assert loop is stable
    astray = np.max(np.abs(log.position.values - motion.position))
    assert (1e-7 < astray < 1e-3) if stable else astray <= 0.51e-8


def test_an_axis_that_follows_exactly_lags_by_half_a_step_of_the_encoder(result):
    assert 0.3e-8 < result.rehearsal.lag <= 0.5e-8 * 1.001


def test_friction_of_a_rehearsal_is_that_of_the_place(motion):
    rising = find("coulomb+position")(
        F_C=60.0, x_0=motion.start, x_L=1e-4, p_1=0.5, p_2=0.0, a_1=0.0, a_2=0.0
    )
    axis = replace(AXIS, resolution=None, presliding=None)
    _, friction, _ = recorded(motion, axis, prior_of(axis, None, rising))
    moving = np.abs(motion.velocity) > 1e-6
    # Scatter aside friction is 60 N times 1 + (x - x_0) / 0.2 mm in the middle of each step.
    expected = 60.0 * (1.0 + 0.5 * (motion.position - motion.start) / 1e-4)
    ratio = np.abs(friction)[moving] / expected[moving]
    assert np.unique(np.round(ratio, 6)).size < 40
    assert np.mean(ratio) == pytest.approx(1.0, abs=0.05)
