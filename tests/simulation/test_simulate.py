"""Experiments: statistics, feedforward along the desired trajectory, what compensation gains."""

from dataclasses import replace

import numpy as np
import pytest

from bristle import controllers, friction
from bristle.core.experiment import Feedforward
from bristle.core.status import Status
from bristle.engine import interpreted, run_open_loop
from bristle.models.plants import inertia
from bristle.simulation import compensation_experiment, feedforward_effort, simulate

DT = 1e-3
CONTROLLER = controllers.cascade(k_p=60.0, k_v=3000.0)
TRUTH = friction.lugre(F_C=20.0, F_S=28.0, v_S=5e-3, sigma_0=5e6, sigma_1=1e3, sigma_2=100.0)


def motion(count=3000):
    t = DT * np.arange(count)
    return 5e-3 * (1.0 - np.cos(5.0 * t))


def test_feedforward_equals_the_effort_of_the_desired_motion():
    # Fed to a plant without any feedback, the effort reproduces the desired motion (without dry friction, which
    # would let a small error at a stop grow).
    film, position = friction.viscous(F_v=80.0), motion(1200)
    acceleration = np.gradient(np.gradient(position, DT), DT)
    with interpreted():
        effort = feedforward_effort(
            Feedforward(mass=3.0, friction=film), position, acceleration, DT
        )
        trace = run_open_loop(inertia(M=3.0), film, effort, DT, steps=2)
    assert np.max(np.abs(trace.position - position)) < 1e-3 * np.ptp(position)


def only(experiment, name, **changes):
    """The experiment with one of its variants, changed."""
    (variant,) = (item for item in experiment.variants if item.name == name)
    return simulate(replace(experiment, variants=(replace(variant, **changes),))).variants[name]


@pytest.mark.parametrize("along", ["desired", "measured"])
def test_a_loop_that_starts_away_from_0_is_compensated_there(along):
    # 10 N at the middle of the axis, and 3 N more where the loop is.
    model = friction.find("coulomb+position")(F_C=10.0, p_1=0.5, x_0=0.0, x_L=0.5)
    experiment = compensation_experiment(
        inertia(M=3.0), model, model, CONTROLLER, 0.3 + motion(600), DT
    )
    with interpreted():
        run = only(experiment, "compensated", feedforward=Feedforward(friction=model, along=along))
    assert np.mean(run.feedforward[200:500]) == pytest.approx(13.0, abs=0.1)


def test_compensation_with_the_true_model_takes_most_of_the_error_away():
    experiment = compensation_experiment(
        inertia(M=3.0), TRUTH, TRUTH, CONTROLLER, motion(), DT, resolution=1e-8
    )
    result = simulate(experiment)
    assert list(result.variants) == ["as_recorded", "feedforward", "compensated"]
    errors = [variant.following_error.rms for variant in result.variants.values()]
    assert errors[2] < 0.1 * errors[1] < 0.1 * errors[0]
    assert all(variant.status == Status.OK for variant in result.variants.values())


def test_feedforward_leads_by_the_delay_of_the_loop():
    film, slow = friction.viscous(F_v=80.0), controllers.cascade(k_p=10.0, k_v=100.0)
    experiment = compensation_experiment(inertia(M=3.0), film, film, slow, motion(1000), DT)
    run = experiment.variants[2].run
    with interpreted():
        prompt, delayed = (
            only(experiment, "compensated", run=replace(run, delay=delay, substeps=1))
            for delay in (0, 3)
        )
    # At each instant the effort that acts is the one for that instant: what is left differs by the feedback alone.
    assert np.array_equal(delayed.feedforward[:-4], prompt.feedforward[3:-1])
    # The first effort of the delayed loop comes late, and what that leaves at the start fades with the loop.
    late = (delayed.reference - delayed.measured)[700:]
    assert np.max(np.abs(late)) < 1e-5 * np.ptp(delayed.reference)
