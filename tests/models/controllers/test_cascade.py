"""The cascade: its law, its limit, and an integral that does not wind up."""

import numpy as np
import pytest
from tests.models.controllers import test_laws as laws

from bristle import controllers, friction, sensors
from bristle.core.contracts import Reference
from bristle.core.errors import InputError
from bristle.core.status import Status
from bristle.engine import interpreted, run_closed_loop
from bristle.models.plants import inertia

DT = 1e-3
# One law of friction for every loop, so that one compiled motion is enough.
FRICTION = friction.coulomb_viscous(F_C=5.0, F_v=20.0)
FILM, FREE = friction.coulomb_viscous(F_C=0.0, F_v=20.0), friction.coulomb_viscous(F_C=0.0, F_v=0.0)


def drive(controller, reference, model=FRICTION, **options):
    return laws.drive(controller, reference, model=model, **options)


@pytest.mark.parametrize("averaging", [1, 2])
def test_a_cascade_that_takes_over_continues_like_one_from_the_start(averaging):
    c = controllers.cascade(k_p=20.0, k_v=300.0, averaging=averaging)

    def position(k):
        return 0.3 + 0.05 * k * DT + 0.5 * 3.0 * (k * DT) ** 2

    state = c.component.start(position(-5), 0.0, 0.0, DT, c.parameters)
    for k in range(-5, 0):
        _, state = c.component.step(state, Reference(0.0, 0.0, 0.0), position(k), DT, c.parameters)
    fresh = c.component.start(position(0), 0.05, 3.0, DT, c.parameters)
    efforts = [
        c.component.step(item, Reference(0.31, 0.0, 0.0), position(0), DT, c.parameters)[0]
        for item in (state, fresh)
    ]
    assert efforts[1] == pytest.approx(efforts[0], rel=1e-9)


@pytest.mark.parametrize("averaging", [1, 2])
@pytest.mark.parametrize("k_p", [40.0, 80.0])
def test_exact_feedforward_leaves_no_error(k_p, averaging):
    """Velocity and desired velocity are late by the same half of a sample, or of two."""
    t = DT * np.arange(4000)
    acceleration = 0.16 * np.cos(4.0 * t)
    ahead = 0.5 * (acceleration + np.append(acceleration[1:], acceleration[-1]))
    desired = np.stack(
        (0.01 * (1.0 - np.cos(4.0 * t)), 0.04 * np.sin(4.0 * t), acceleration, 20.0 * ahead)
    )
    c = controllers.cascade(k_p=k_p, k_v=4000.0, k_ff=1.0, averaging=averaging)
    trace = run_closed_loop(
        inertia(M=20.0), FREE, c, sensors.encoder(), desired, DT, acceleration=acceleration[0]
    )
    assert np.ptp(desired[0] - trace.measured) < 1e-9  # one of them alone would leave 4 µm


@pytest.mark.parametrize(
    ("law", "ripple", "missed"),
    [
        (controllers.cascade(k_p=60.0, k_v=400.0, k_i=8e3, k_ff=1.0), 1e-6, 1e-9),
        (controllers.disturbance_observer(J=2.0, lambda_=60.0, K_1=60.0, g=30.0), 1e-6, 1e-9),
        (controllers.super_twisting(J=2.0, lambda_=60.0, K_1=60.0, k_1=0.1, k_2=0.5), 0.05, 1e-6),
    ],
)
def test_an_integrating_law_takes_over_the_effort_of_a_motion(law, ripple, missed):
    v, effort = 0.05, 9.0
    reference = 0.1 + v * DT * np.arange(800)
    with interpreted():
        trace = drive(
            law,
            reference,
            x=0.1,
            v=v,
            model=FILM,
            resumed_effort=effort,
            disturbance=np.full(800, effort - 20.0 * v),
        )
    assert np.ptp(trace.command) < ripple
    assert np.ptp(reference - trace.position) < missed


def test_a_long_saturation_causes_no_windup():
    reference = np.concatenate((np.zeros(20), np.full(3980, 0.2)))
    trace = drive(controllers.cascade(k_p=30.0, k_v=400.0, k_i=2e4, limit=12.0), reference)
    assert np.max(np.abs(trace.command)) <= 12.0
    assert trace.position.max() < 1.05 * 0.2
    assert trace.position[-1] == pytest.approx(0.2, abs=1e-3)


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_delay_moves_the_effort_by_whole_samples(delay):
    t = DT * np.arange(300)
    c = controllers.cascade(k_p=20.0, k_v=100.0)
    trace = drive(c, 1e-3 * np.sin(30 * t), delay=delay, effort_before=0.5)
    assert np.array_equal(trace.effort[delay:], trace.command[: trace.command.size - delay])
    assert np.all(trace.effort[:delay] == 0.5)


def test_an_unstable_loop_ends_with_a_status_not_with_infinities():
    t = DT * np.arange(5000)
    trace = drive(controllers.cascade(k_p=400.0, k_v=9000.0), 1e-3 * np.sin(30 * t), delay=3)
    assert trace.status == Status.NOT_FINITE
    assert trace.time.size < t.size


@pytest.mark.parametrize("averaging", [1.5, 0, 3, "2 s"])
def test_the_velocity_is_taken_over_one_sample_or_two(averaging):
    with pytest.raises(InputError, match="averaging"):
        controllers.cascade(k_p=1.0, k_v=1.0, averaging=averaging)


def test_a_known_input_is_added_behind_the_limit_of_the_controller():
    reference = np.concatenate((np.zeros(20), np.full(480, 0.2)))
    c = controllers.cascade(k_p=30.0, k_v=400.0, limit=20.0)
    pulses = np.where(np.arange(reference.size) < 60, 15.0, 0.0)
    assert np.max(drive(c, reference, injected=pulses).command) == 35.0
    assert np.max(drive(c, reference, injected=pulses, limit=30.0).command) == 30.0
