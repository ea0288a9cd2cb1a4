"""The sliding mode law, (19) to (23): what brings the state to the surface, what keeps it there, and what chatters."""

from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest

from bristle import controllers, friction, sensors
from bristle.engine import run_closed_loop
from bristle.files.experiment import read_experiment
from bristle.models.plants import inertia
from bristle.simulation import simulate

J, LAMBDA, K_1, STATIC = 2.0, 50.0, 40.0, 10.0
FAST = 1e-5


def resting(reference, *, K_2, phi=0.0, dt=FAST, load=0.0, model=None, **options):
    """A loop at the reference 0 or a motion; returns its trace and the surface at each sample."""
    law = controllers.sliding_mode(J=J, lambda_=LAMBDA, K_1=K_1, K_2=K_2, phi=phi)
    r = np.asarray(reference, dtype=float)
    desired = np.stack(
        (r, np.gradient(r, dt), np.gradient(np.gradient(r, dt), dt), np.zeros(r.size))
    )
    trace = run_closed_loop(
        inertia(M=J),
        model or friction.viscous(F_v=0.0),
        law,
        sensors.encoder(),
        desired,
        dt,
        disturbance=np.full(r.size, load),
        **options,
    )
    return trace, desired[1] - trace.velocity + LAMBDA * (r - trace.position)


@pytest.mark.parametrize("load", [STATIC, -STATIC])
def test_the_surface_is_reached_in_the_time_that_the_reaching_condition_gives(load):
    K_2 = 2.0 * STATIC / J
    trace, surface = resting(np.zeros(40_000), K_2=K_2, load=load, x=-1e-2)
    bound = abs(surface[0]) / (K_2 - STATIC / J)
    chatter = 3.0 * (K_2 + STATIC / J) * FAST
    reached = int(np.argmax(np.abs(surface) <= chatter))
    assert 0 < reached * FAST <= bound
    assert np.max(np.abs(surface[reached:])) <= chatter
    # On the surface the error dies out with lambda alone, whatever the load.
    late = trace.position[reached:]
    assert late[-1] / late[0] == pytest.approx(np.exp(-LAMBDA * FAST * (late.size - 1)), abs=0.02)


def test_sliding_under_friction_needs_the_static_friction_over_the_inertia():
    t = FAST * np.arange(60_000)
    contact = friction.maxwell_slip(F_C=STATIC, k_i=[2e6, 1e6], nu_i=[0.5, 0.5])
    worst = {}
    for factor in (0.3, 1.5):
        _, surface = resting(1e-4 * np.sin(10.0 * t), K_2=factor * STATIC / J, model=contact)
        worst[factor] = np.max(np.abs(surface[20_000:]))
    chatter = 3.0 * (1.5 + 1.0) * STATIC / J * FAST
    assert worst[1.5] <= chatter < 0.1 * worst[0.3]


@pytest.mark.parametrize(("load", "inside"), [(4.0, True), (9.0, False)])
def test_the_error_under_a_load_inside_and_outside_the_boundary_layer(load, inside):
    K_2, phi = 3.0, 0.03
    trace, surface = resting(np.zeros(100_000), K_2=K_2, phi=phi, load=load)
    assert (abs(surface[-1]) < phi) == inside
    stiffness = J * LAMBDA * (K_1 + K_2 / phi if inside else K_1)
    expected = (load if inside else load - J * K_2) / stiffness
    assert -trace.position[-1] == pytest.approx(expected, rel=1e-3)


def test_in_sampled_time_the_sign_function_chatters_and_the_layer_does_not():
    steps = np.zeros(4000)
    sampled = {"dt": 1e-3, "load": 0.3 * STATIC, "delay": 1}
    sharp, _ = resting(steps, K_2=STATIC / J, **sampled)
    smooth, _ = resting(steps, K_2=STATIC / J, phi=0.2, **sampled)
    late = slice(2000, None)
    assert np.ptp(sharp.command[late]) == pytest.approx(2.0 * STATIC, rel=0.2)
    assert np.ptp(smooth.command[late]) < 1e-6 * STATIC


@pytest.fixture(scope="module")
def set_a():
    return read_experiment(files("bristle.apps.paper") / "experiments" / "set_a.toml")


def with_gains(experiment, names, **gains):
    variants = tuple(
        replace(
            variant,
            controller=variant.controller.with_values(**gains) if gains else variant.controller,
            run=replace(variant.run, seeds=2),
        )
        for variant in experiment.variants
        if variant.name in names
    )
    return simulate(replace(experiment, variants=variants)).variants


def test_the_gains_of_the_paper_are_far_from_true_sliding(set_a):
    law, rig = set_a.variants[0].controller.values, set_a.variants[0].friction.values
    assert 0.5 * (rig["F_S_pos"] + rig["F_S_neg"]) / law["J"] / law["K_2"] == pytest.approx(
        16.0, abs=0.5
    )


@pytest.mark.slow
def test_with_the_gain_of_true_sliding_two_kilohertz_chatter_and_the_compensated_error_rises(set_a):
    layer = with_gains(set_a, ("none", "paper"))
    sharp = with_gains(set_a, ("paper",), K_2=5e-2, phi=0.0)
    assert sharp["paper"].effort_rms > 1.4 * layer["none"].effort_rms
    assert (
        sharp["paper"].following_error.peak_to_peak
        > 1.15 * layer["paper"].following_error.peak_to_peak
    )
