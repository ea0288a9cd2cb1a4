"""Lyapunov's (20) and (21) with what is left of friction: reached or not, how near, and what sampling makes of it.

The bounds are held against a simulator of their own: a mass whose effort stands still between samples, arrives late,
and is made from a velocity and a position that are read with errors, under friction that pushes as badly as it can.
Each must hold, and be no more than a small factor above what is found.
"""

import math
from importlib.resources import files

import numpy as np
import pytest

from bristle import controllers, friction, sensors
from bristle.apps.paper.surface import reaching_time, sampled_bound, ultimate_bound
from bristle.engine import run_closed_loop
from bristle.files import read_experiment
from bristle.models.plants import inertia

LAMBDA, K_1 = 50.0, 40.0
AMPLITUDE, OMEGA = 1.0, 3.0  # of the command; its jerk is at most AMPLITUDE OMEGA^3


def worst(t, surface, D):
    """Outward, always."""
    return D if surface >= 0.0 else -D


def square(t, surface, D):
    """One way for long, then the other."""
    return D if math.sin(7.0 * t) >= 0.0 else -D


def surfaces(
    *, K_2, D, T, push=worst, delay=0, step_v=0.0, count=0.0, phi=0.0, samples=4000, start=0.05
):
    """The surface at each sample and between, of a mass under the law; in Python alone."""
    e, e_dot, waiting, read, result = start, 0.0, [0.0] * delay, -start, []
    for k in range(samples):
        t = k * T
        off, v = e, step_v * round(e_dot / step_v) if step_v else e_dot
        if count:  # what an encoder reads of the position, and its difference
            command = AMPLITUDE * math.sin(OMEGA * t)
            q = count * round((command - e) / count)
            off, v = command - q, AMPLITUDE * OMEGA * math.cos(OMEGA * t) - (q - read) / T
            read = q
        s = v + LAMBDA * off
        switched = max(-1.0, min(1.0, s / phi)) if phi else math.copysign(1.0, s) if s else 0.0
        waiting.append(
            -AMPLITUDE * OMEGA**2 * math.sin(OMEGA * t) + LAMBDA * v + K_1 * s + K_2 * switched
        )
        effort = waiting.pop(0)
        for i in range(8):
            h, now = T / 8.0, t + (i + 0.5) * T / 8.0
            surface = e_dot + LAMBDA * e
            result.append(surface)
            gain = -AMPLITUDE * OMEGA**2 * math.sin(OMEGA * now) - effort + push(now, surface, D)
            e += h * e_dot + 0.5 * h * h * gain
            e_dot += h * gain
    return np.abs(result)


def late(outcome):
    return float(np.max(outcome[-outcome.size // 4 :]))


@pytest.mark.parametrize(("K_2", "D"), [(10.0, 5.0), (5.0, 1.0), (6.0, 0.0)])
def test_the_surface_is_reached_within_the_time_of_the_reaching_condition(K_2, D):
    T = 2e-5
    result = surfaces(K_2=K_2, D=D, T=T, samples=20_000)
    reached = T / 8.0 * int(np.argmax(result < 2.0 * T * (K_2 + D)))
    bound = reaching_time(result[0], K_1=K_1, K_2=K_2, residual=D)
    assert 0.97 * bound < reached <= bound
    assert late(result) < 3.0 * T * (K_2 + D)


def test_with_a_gain_below_the_residual_friction_the_surface_may_not_be_reached():
    assert reaching_time(1.0, K_1=K_1, K_2=5.0, residual=5.0) == math.inf
    # From on the surface there is no way to go; and without K_1 the way is straight.
    assert reaching_time(0.0, K_1=K_1, K_2=6.0, residual=5.0) == 0.0
    assert reaching_time(-3.0, K_1=0.0, K_2=6.0, residual=5.0) == 3.0
    assert reaching_time(-3.0, K_1=1e-9, K_2=6.0, residual=5.0) == pytest.approx(3.0, rel=1e-6)


@pytest.mark.parametrize(
    ("K_2", "D", "phi"),
    [(0.0, 30.0, 0.0), (10.0, 30.0, 0.0), (10.0, 30.0, 0.1), (10.0, 5.0, 0.5), (10.0, 20.0, 0.4)],
)
def test_residual_friction_keeps_the_state_within_the_bound(K_2, D, phi):
    result = late(surfaces(K_2=K_2, D=D, T=2e-5, phi=phi, samples=25_000))
    bound = ultimate_bound(K_1=K_1, K_2=K_2, residual=D, phi=phi)
    assert 0.98 * bound < result < 1.01 * bound


def differenced(count, T, acceleration):
    """What an encoder adds whose counts are differenced while the command is accelerated."""
    return {
        "position_error": 0.5 * count,
        "velocity_error": count / T + 0.5 * T * acceleration,
        "lag": 0.5 * T,
    }


CASES = [  # residual friction, sample time, how far above what is found the bound may be, and what else is so
    (5.0, 1e-4, 1.1, {}),
    (5.0, 1e-4, 1.2, {"delay": 1}),
    (5.0, 1e-4, 1.2, {"delay": 2, "step_v": 2e-3}),
    (5.0, 1e-3, 1.2, {}),
    (5.0, 1e-3, 1.4, {"delay": 1, "step_v": 1e-2}),
    (5.0, 5e-4, 1.3, {"delay": 1, "step_v": 2e-2}),
    (30.0, 1e-4, 1.2, {}),
    (30.0, 1e-3, 2.6, {"delay": 1, "step_v": 1e-2}),
    (0.0, 1e-3, 1.6, {"delay": 3}),
    # In a boundary layer.
    (9.5, 1e-4, 1.3, {"phi": 0.02, "delay": 1}),
    (30.0, 1e-4, 1.3, {"phi": 0.1, "delay": 1}),
    (5.0, 1e-4, 1.3, {"phi": 0.5}),
    (5.0, 1e-4, 1.3, {"phi": 0.5, "delay": 3}),
    (2.0, 1e-4, 1.3, {"phi": 0.1, "delay": 1}),
    (20.0, 1e-4, 1.3, {"phi": 0.4, "delay": 2}),
    # With the velocity from counts of an encoder.
    (5.0, 1e-3, 1.7, {"count": 2e-6, "delay": 1}),
    (5.0, 5e-4, 1.7, {"count": 5e-6, "delay": 1}),
]


@pytest.mark.parametrize(("D", "T", "slack", "options"), CASES)
def test_sampled_and_late_the_state_stays_in_the_band_and_fills_most_of_it(D, T, slack, options):
    common = {name: options.get(name, 0) for name in ("delay", "phi")}
    read = (
        differenced(options["count"], T, AMPLITUDE * OMEGA**2)
        if "count" in options
        else {"velocity_error": 0.5 * options.get("step_v", 0.0)}
    )
    bound = sampled_bound(
        lambda_=LAMBDA,
        K_1=K_1,
        K_2=10.0,
        residual=D,
        sample_time=T,
        jerk=AMPLITUDE * OMEGA**3,
        **common,
        **read,
    )
    samples = 12_000 if common["phi"] else 4000
    result = max(
        late(surfaces(K_2=10.0, D=D, T=T, samples=samples, push=push, **options))
        for push in (worst, square)
    )
    assert result <= bound <= slack * result


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_the_band_is_mainly_the_travel_until_the_switch(delay):
    T, K_2, D = 5e-5, 10.0, 5.0
    result = late(surfaces(K_2=K_2, D=D, T=T, delay=delay, samples=12_000))
    assert result == pytest.approx((delay + 1) * T * (K_2 + D), rel=0.15)


def test_the_band_approaches_the_bound_of_continuous_time():
    for K_2, D, phi in (
        (10.0, 30.0, 0.0),
        (10.0, 5.0, 0.0),
        (10.0, 5.0, 0.5),
        (10.0, 20.0, 0.4),
        (10.0, 30.0, 0.1),
    ):
        band = sampled_bound(
            lambda_=LAMBDA, K_1=K_1, K_2=K_2, residual=D, sample_time=1e-9, phi=phi
        )
        assert band == pytest.approx(
            ultimate_bound(K_1=K_1, K_2=K_2, residual=D, phi=phi), rel=1e-5, abs=1e-6
        )


@pytest.mark.parametrize(
    ("gain", "T", "slack"), [(2.0, 1e-3, 1.6), (2.0, 2e-4, 1.2), (0.3, 2e-4, 1.4)]
)
def test_the_loop_of_bristle_stays_within_the_band(gain, T, slack):
    J, force, count = 2.0, 10.0, 0.2 * T * T
    K_2, D = gain * force / J, force / J
    law = controllers.sliding_mode(J=J, lambda_=LAMBDA, K_1=K_1, K_2=K_2)
    t = np.arange(0.0, 4.0, T)
    amplitude, omega = 0.02, 20.0
    shape = (np.sin(omega * t), omega * np.cos(omega * t), -(omega**2) * np.sin(omega * t), 0.0 * t)
    desired = amplitude * np.stack(shape)
    trace = run_closed_loop(
        inertia(M=J),
        friction.coulomb(F_C=force),
        law,
        sensors.encoder(resolution=count),
        desired,
        T,
        delay=1,
    )
    result = late(np.abs(desired[1] - trace.velocity + LAMBDA * (desired[0] - trace.position)))
    bound = sampled_bound(
        lambda_=LAMBDA,
        K_1=K_1,
        K_2=K_2,
        residual=D,
        sample_time=T,
        delay=1,
        jerk=amplitude * omega**3,
        **differenced(count, T, amplitude * omega**2),
    )
    assert result <= bound <= slack * result


def test_at_the_gains_of_the_bench_sampling_and_delay_leave_no_bound():
    item = read_experiment(files("bristle.apps.paper") / "experiments" / "set_a.toml").variants[0]
    gains = {name: item.controller.values[name] for name in ("lambda_", "K_1", "K_2")}
    gains["residual"] = item.friction.values["F_S_pos"] / item.plant.values["M"]
    continuous = ultimate_bound(**{key: gains[key] for key in ("K_1", "K_2", "residual")})
    assert (
        sampled_bound(**gains, sample_time=item.run.sample_time, delay=item.run.delay) == math.inf
    )
    assert (
        continuous
        < sampled_bound(**gains, sample_time=item.run.sample_time / 10.0, delay=1)
        < 2.0 * continuous
    )


@pytest.mark.parametrize("too_slow", [{"sample_time": 0.03}, {"sample_time": 1e-3, "lag": 0.02}])
def test_where_reading_is_too_old_there_is_no_bound(too_slow):
    assert sampled_bound(lambda_=LAMBDA, K_1=K_1, K_2=10.0, residual=5.0, **too_slow) == math.inf
