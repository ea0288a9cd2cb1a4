"""Open loops: a given effort drives the plant, with steps of one length or of those that a tolerance asks for."""

from dataclasses import replace

import numpy as np
import pytest

from bristle import controllers, friction, plants
from bristle.apps.design import design, runnable
from bristle.core.errors import InputError
from bristle.core.experiment import Run
from bristle.core.status import Status
from bristle.engine import interpreted, run_open_loop
from bristle.models.sensors import encoder
from bristle.report.simulation import simulation_summary
from bristle.simulation import open_loop_experiment, simulate

DT, COUNT = 1e-2, 800
TOLERANCE = 1e-5
FINE = 300  # steps in a sample of the reference
CONTACT = {"F_C": 1.0, "F_S": 1.5, "v_S": 1e-3, "sigma_0": 1e5, "sigma_1": 316.0}
PULLED = plants.pulled_inertia(M=1.0, k=2.0, v_e=0.2)
TIME = DT * np.arange(COUNT)


def run(plant, model, effort, **options):
    return simulate(open_loop_experiment(plant, model, effort, DT, **options)).variants["base"]


STICKS = {
    "LuGre, pulled": (PULLED, friction.lugre(sigma_2=0.4, **CONTACT), np.zeros(COUNT)),
    "Stribeck, pulled": (
        PULLED,
        friction.stribeck(F_C=1.0, F_S=1.5, v_S=1e-2, F_v=0.0),
        np.zeros(COUNT),
    ),
    "Coulomb, pushed to and fro": (
        plants.inertia(M=2.0),
        friction.stribeck(F_C=1.0, F_S=1.0, v_S=1.0, F_v=0.0),
        3.0 * np.sign(np.sin(2.0 * TIME)),
    ),
    "Dahl, on a spring": (
        plants.oscillator(M=1.0, c=0.5, k=40.0),
        friction.dahl(F_C=1.0, sigma_0=1e3),
        4.0 * np.sin(3.0 * TIME),
    ),
}


@pytest.mark.parametrize(
    "name",
    [
        name if name.startswith("LuGre") else pytest.param(name, marks=pytest.mark.slow)
        for name in STICKS
    ],
)
def test_a_tolerance_holds_against_fine_steps_of_one_length(name):
    plant, model, effort = STICKS[name]
    exact = run_open_loop(plant, model, effort, DT, steps=FINE)
    result = run(plant, model, effort, tolerance=TOLERANCE)
    assert result.status is Status.OK
    assert np.max(np.abs(result.position - exact.position)) < TOLERANCE
    assert np.ptp(result.position) > 1e3 * TOLERANCE


@pytest.mark.parametrize("steps", [{"tolerance": 1e-9}, {"substeps": 7}])
def test_the_effort_is_constant_between_samples_and_no_more_than_its_limit(steps):
    push = np.repeat([2.0, -3.0, 1.0, 0.0, 5.0], 3)
    with interpreted():
        result = run(
            plants.inertia(M=2.0), friction.viscous(F_v=0.0), push, effort_limit=4.0, **steps
        )
    applied = np.minimum(push, 4.0)
    np.testing.assert_allclose(
        result.velocity, np.concatenate([[0.0], np.cumsum(applied[:-1]) * DT / 2.0]), atol=1e-8
    )
    assert result.effort.tolist() == applied.tolist()
    assert result.effort_peak == 4.0


def test_a_sensor_reads_tolerance_runs_and_step_runs_in_the_same_way():
    counts = encoder(resolution=1e-3, noise=1e-4, seed=4)
    plant, model, effort = STICKS["Coulomb, pushed to and fro"]
    result, beside = (
        run(plant, model, effort, sensor=counts, **way)
        for way in ({"tolerance": 1e-9}, {"substeps": 40})
    )
    np.testing.assert_allclose(result.measured / 1e-3, np.round(result.measured / 1e-3), atol=1e-6)
    assert np.mean(result.measured == beside.measured) > 0.98
    assert np.std(result.measured - result.position) > 1e-4


@pytest.fixture(scope="module")
def pulled():
    """A block that sticks and slips, as an experiment and simulated."""
    plant, model, effort = STICKS["Stribeck, pulled"]
    experiment = open_loop_experiment(plant, model, effort, DT, tolerance=TOLERANCE, settle=4.0)
    return experiment, simulate(experiment)


def test_an_open_loop_has_no_following_error_but_a_motion_after_its_settling_time(pulled):
    result = pulled[1].variants["base"]
    assert result.is_open
    assert np.isnan(
        [result.following_error.rms, result.true_error.rms, result.by_direction["forward"].rms]
    ).all()
    assert (result.motion.max, result.motion.min) == (
        np.max(result.position),
        np.min(result.position[400:]),
    )
    assert result.motion.min > 0.0
    assert "Position, peak to peak" in repr(pulled[1])
    assert (
        simulation_summary(pulled[1], files={}, provenance={})["variants"]["base"]["motion"]["max"]
        == result.motion.max
    )


def test_an_open_loop_has_no_poles_no_gains_and_no_law_to_design(pulled):
    kept, judged = runnable(pulled[0])
    assert (kept.variants, judged) == (pulled[0].variants, {})
    assert "open_loop" not in controllers.CONTROLLERS
    with pytest.raises(InputError, match="has no gains"):
        design(pulled[0])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"effort": None}, "is only for open loops"),
        (
            {"run": Run(duration=COUNT * DT, sample_time=DT, tolerance=1e-6, delay=1)},
            "run.delay: .*tolerance",
        ),
        (
            {"run": Run(duration=COUNT * DT, sample_time=DT, tolerance=1e-6, current_lag=1e-3)},
            "run.current_lag: .*tol",
        ),
        ({"plant": plants.ball_screw(J=1e-4, M=20.0, lead=5e-3, k=1e8)}, "ball_screw has a table"),
    ],
)
def test_cases_without_support_for_a_tolerance_are_refused(pulled, change, message):
    with pytest.raises(InputError, match=message):
        replace(pulled[0].variants[0], **change)


def test_where_it_sticks_friction_holds_against_spring_and_effort(pulled):
    result = pulled[1].variants["base"]
    sticks = (result.velocity[:-1] == 0.0) & (result.velocity[1:] == 0.0)
    assert 0.2 < np.mean(sticks) < 0.9
    spring = 2.0 * (0.2 * (result.time + 0.5 * DT) - result.position)
    np.testing.assert_allclose(result.friction[:-1][sticks], spring[:-1][sticks], atol=1e-9)
