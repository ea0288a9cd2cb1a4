"""Experiments: statistics, feedforward along the desired trajectory, what compensation gains."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bristle import controllers, friction
from bristle.core.experiment import Feedforward, Run
from bristle.core.status import Status
from bristle.plants import inertia
from bristle.references import recorded, sine
from bristle.simulation import compensation_experiment, feedforward_effort, friction_along, simulate, statistics_of

DT = 1e-3
CONTROLLER = controllers.cascade(k_p=60.0, k_v=3000.0)
TRUTH = friction.lugre(F_C=20.0, F_S=28.0, v_S=5e-3, sigma_0=5e6, sigma_1=1e3, sigma_2=100.0)


def motion(count=3000):
    t = DT * np.arange(count)
    return 5e-3 * (1.0 - np.cos(5.0 * t))


@given(arrays(float, st.integers(1, 50), elements=st.floats(-1e3, 1e3)))
def test_statistics_hold_together(signal):
    s = statistics_of(signal)
    assert s.min <= s.mean + 1e-9
    assert s.mean <= s.max + 1e-9
    assert s.peak_to_peak == s.max - s.min
    assert s.rms**2 == pytest.approx(s.mean**2 + s.std**2, rel=1e-6, abs=1e-9)


def test_feedforward_equals_the_effort_of_the_desired_motion():
    # Fed to a plant without any feedback, the effort reproduces the desired motion (without dry friction, which
    # would let a small error at a stop grow).
    from bristle.engine import run_open_loop

    film = friction.viscous(F_v=80.0)
    position = motion()
    velocity = np.gradient(position, DT)
    effort = feedforward_effort(Feedforward(mass=3.0, friction=film), position, np.gradient(velocity, DT), DT)
    trace = run_open_loop(inertia(M=3.0), film, effort, DT, steps=4)
    assert np.max(np.abs(trace.position - position)) < 1e-3 * np.ptp(position)


def test_a_resting_reference_is_fed_the_force_of_the_side_it_came_from_or_the_middle():
    model = friction.find("coulomb")(F_C=5.0, offset=1.5)
    motion = np.array([0.0, 1.0, 0.0, -1.0, 0.0])
    assert friction_along(model, np.zeros(4), DT).tolist() == [1.5] * 4
    assert friction_along(model, motion, DT).tolist() == [1.5, 6.5, 6.5, -3.5, -3.5]
    assert friction_along(model, motion, DT, rest="middle").tolist() == [1.5, 6.5, 1.5, -3.5, 1.5]


def test_feedforward_depends_on_the_position_along_the_path():
    # 10 N at the middle of the axis, 5 N more 0.5 m farther on: at 0.25, 0.35 and 0.45 m, the middles of the steps.
    model = friction.find("coulomb+position")(F_C=10.0, p_1=0.5, x_0=0.0, x_L=0.5)
    position = np.array([0.2, 0.3, 0.4])
    fed = feedforward_effort(Feedforward(friction=model), position, np.zeros(3), DT)
    assert fed == pytest.approx([12.5, 13.5, 14.5], rel=1e-12)
    back = feedforward_effort(Feedforward(friction=model), position[::-1], np.zeros(3), DT)
    assert back == pytest.approx([-13.5, -12.5, -11.5], rel=1e-12)


@pytest.mark.parametrize("along", ["desired", "measured"])
def test_a_loop_that_starts_away_from_0_is_compensated_there(along):
    model = friction.find("coulomb+position")(F_C=10.0, p_1=0.5, x_0=0.0, x_L=0.5)
    experiment = compensation_experiment(inertia(M=3.0), model, model, CONTROLLER, 0.3 + motion(1500), DT)
    variant = next(item for item in experiment.variants if item.name == "compensated")
    fed = replace(variant.feedforward, mass=0.0, along=along)
    run = simulate(replace(experiment, variants=(replace(variant, feedforward=fed),))).variants["compensated"]
    forward = (DT * np.arange(1500) > 0.2) & (DT * np.arange(1500) < 0.5)
    assert np.mean(run.feedforward[forward]) == pytest.approx(13.0, abs=0.1)


def test_compensation_with_the_true_model_takes_most_of_the_error_away():
    experiment = compensation_experiment(inertia(M=3.0), TRUTH, TRUTH, CONTROLLER, motion(), DT, resolution=1e-8)
    result = simulate(experiment)
    assert list(result.variants) == ["as_recorded", "feedforward", "compensated"]
    errors = [variant.following_error.rms for variant in result.variants.values()]
    assert errors[2] < 0.1 * errors[1] < 0.1 * errors[0]
    assert all(variant.status == Status.OK for variant in result.variants.values())


def test_unmodelled_friction_limits_the_gain():
    unseen = 3.0 * np.sin(40.0 * DT * np.arange(3000))
    clean = simulate(compensation_experiment(inertia(M=3.0), TRUTH, TRUTH, CONTROLLER, motion(), DT))
    disturbed = simulate(compensation_experiment(inertia(M=3.0), TRUTH, TRUTH, CONTROLLER, motion(), DT, disturbance=unseen))
    assert disturbed.variants["compensated"].true_error.rms > 3.0 * clean.variants["compensated"].true_error.rms


def test_directions_are_judged_apart():
    model = friction.find("coulomb+asymmetry")(F_C_pos=30.0, F_C_neg=10.0)
    experiment = compensation_experiment(inertia(M=3.0), model, model, CONTROLLER, motion(), DT)
    fed = simulate(experiment).variants["feedforward"]
    assert fed.by_direction["forward"].mean > -2.0 * fed.by_direction["backward"].mean > 0.0


def test_progress_names_every_variant():
    seen = []
    experiment = compensation_experiment(inertia(M=3.0), TRUTH, TRUTH, CONTROLLER, motion(300), DT)
    simulate(experiment, progress=lambda share, text: seen.append((share, text)))
    assert [text for _, text in seen] == ["as_recorded", "feedforward", "compensated"]
    assert seen[0][0] == 0.0


def test_sine_begins_at_rest_and_its_derivatives_are_its_derivatives():
    model = sine(amplitude=2e-3, frequency=3.0, ramp=0.2, offset=1e-3)
    t = np.linspace(0.0, 1.0, 20001)
    x, v, a = model.component.sample(t, model.parameters)
    assert (x[0], v[0], a[0]) == (1e-3, 0.0, 0.0)
    np.testing.assert_allclose(np.gradient(x, t)[1:-1], v[1:-1], atol=1e-6)
    np.testing.assert_allclose(np.gradient(v, t)[2:-2], a[2:-2], atol=2e-3)


def test_a_recorded_motion_stands_still_beyond_its_end():
    model = recorded(position=[0.0, 1.0, 2.0, 3.0], sample_time=0.5)
    x, v, a = model.component.sample(np.array([0.25, 1.5, 9.0]), model.parameters)
    assert x.tolist() == [0.5, 3.0, 3.0]
    assert v[0] == pytest.approx(2.0)
    assert (v[2], a[2]) == (0.0, 0.0)


@pytest.mark.parametrize("spelling", ["of the drive", "of the controller"])
def test_the_integral_does_not_wind_up_for_any_source_of_the_limit(spelling):
    law = controllers.cascade(k_p=30.0, k_v=400.0, k_i=2e4)
    limit = 12.0
    if spelling == "of the controller":
        law, limit = law.with_values(limit=12.0), np.inf
    position = np.where(DT * np.arange(3000) < 0.02, 0.0, 0.2)
    experiment = compensation_experiment(
        inertia(M=2.0), friction.coulomb_viscous(F_C=5.0, F_v=20.0), TRUTH, law, position, DT, effort_limit=limit
    )
    run = simulate(experiment).variants["as_recorded"]
    assert run.effort_peak <= 12.0
    assert run.position.max() < 1.05 * 0.2
    assert run.position[-1] == pytest.approx(0.2, abs=1e-3)


def late(experiment, delay):
    return replace(experiment, variants=tuple(replace(variant, run=replace(variant.run, delay=delay)) for variant in experiment.variants))


def test_feedforward_leads_by_the_delay_of_the_loop():
    film = friction.viscous(F_v=80.0)
    slow = controllers.cascade(k_p=10.0, k_v=100.0)
    prompt = compensation_experiment(inertia(M=3.0), film, film, slow, motion(), DT)
    delayed = simulate(late(prompt, 3)).variants["compensated"]
    prompt = simulate(prompt).variants["compensated"]
    # At each instant the effort that acts is the one for that instant: what is left differs by the feedback alone.
    assert np.array_equal(delayed.feedforward[:-4], prompt.feedforward[3:-1])
    # The first effort of the delayed loop comes late, and what that leaves at the start fades with the loop.
    errors = [(run.reference - run.measured)[2000:] for run in (prompt, delayed)]
    assert np.sqrt(np.mean(errors[1] ** 2)) < 1.2 * np.sqrt(np.mean(errors[0] ** 2))


def test_steps_of_the_integration_follow_the_sample_time():
    assert [Run(duration=1.0, sample_time=item).substeps for item in (1e-4, 1e-3, 1.0000000000000009e-3, 4e-3)] == [4, 4, 4, 16]
    assert Run(duration=1.0, sample_time=4e-3, substeps=2).substeps == 2
