"""Control laws on a surface, one sample at a time and in a loop."""

import math

import numpy as np
import pytest

from bristle import controllers, friction, response, sensors
from bristle.engine import Compensator, run_closed_loop
from bristle.engine.motion import compensation_along
from bristle.models.controllers.feedforward import Shape
from bristle.models.controllers.velocity import ESTIMATORS, observed
from bristle.models.plants import inertia

pytestmark = pytest.mark.usefixtures("in_plain_python")

DT = 1e-3
GAINS = {"J": 2.0, "lambda_": 30.0, "K_1": 40.0}
LAWS = {
    "sliding_mode": controllers.sliding_mode(**GAINS, K_2=2.0, phi=0.01, cutoff=200.0),
    "super_twisting": controllers.super_twisting(**GAINS, k_1=0.5, k_2=5.0, cutoff=200.0),
    "disturbance_observer": controllers.disturbance_observer(**GAINS, g=60.0, cutoff=200.0),
    "lugre_observer": controllers.lugre_observer(
        **GAINS, F_C=1.0, F_S=1.2, v_S=1e-3, sigma_0=1e3, k=0.5, cutoff=200.0
    ),
    "adaptive_hysteresis": controllers.adaptive_hysteresis(
        **GAINS, reach=1e-3, Gamma=500.0, w_max=2.0, delta=1e-5, cutoff=200.0
    ),
}


def drive(law, reference, *, model=None, disturbance=None, sensor=None, **options):
    desired = np.zeros((4, reference.size))
    desired[0] = reference
    desired[1] = np.gradient(reference, DT)
    desired[2] = np.gradient(desired[1], DT)
    return run_closed_loop(
        inertia(M=2.0),
        model or friction.viscous(F_v=0.0),
        law,
        sensor or sensors.encoder(),
        desired,
        DT,
        disturbance=None if disturbance is None else np.full(reference.size, disturbance),
        **options,
    )


@pytest.mark.parametrize(
    ("name", "left"),
    [
        ("sliding_mode", 1e-6),
        ("disturbance_observer", 1e-6),
        ("super_twisting", 20.0 * 2.0 * 5.0 * DT),
    ],
)
def test_a_law_that_takes_over_a_motion_causes_no_jolt(name, left):
    # Super-twisting chatters around its surface by a few steps of its integral, J k_2 T_s.
    t = DT * np.arange(400)
    trace = drive(LAWS[name], 0.05 * t, v=0.05)
    assert np.max(np.abs(trace.command)) < left


@pytest.mark.parametrize("name", sorted(LAWS))
def test_the_effort_is_within_its_limit(name):
    trace = drive(LAWS[name].with_values(limit=1.5), np.full(100, 0.2))
    assert np.max(np.abs(trace.command)) == 1.5


def test_the_root_term_stops_a_velocity_in_torricellis_time():
    # With k_1 alone dv/dt = -k_1 sqrt(|v|): at rest after 2 sqrt(v_0)/k_1, having gone 2 v_0^1.5/(3 k_1).
    dt, v, k_1 = 2.5e-4, 0.09, 0.5
    law = controllers.super_twisting(J=2.0, lambda_=0.0, K_1=0.0, k_1=k_1, k_2=0.0)
    reference = np.zeros((4, 6400))
    trace = run_closed_loop(
        inertia(M=2.0), friction.viscous(F_v=0.0), law, sensors.encoder(), reference, dt, v=v
    )
    end = 2.0 * math.sqrt(v) / k_1
    assert trace.time[np.argmax(trace.velocity < 1e-5 * v)] == pytest.approx(end, rel=1e-2)
    assert trace.velocity[round(0.5 * end / dt)] == pytest.approx(0.25 * v, rel=1e-3)
    assert trace.position[-1] == pytest.approx(2.0 * v**1.5 / (3.0 * k_1), rel=1e-3)


def test_the_observer_removes_the_error_of_a_constant_force():
    steps = np.zeros(1000)
    left = {
        g: drive(controllers.disturbance_observer(**GAINS, g=g), steps, disturbance=3.0).position[
            -1
        ]
        for g in (0.0, 60.0)
    }
    assert left[0.0] == pytest.approx(-3.0 / (2.0 * 30.0 * 40.0), rel=1e-3)
    assert abs(left[60.0]) < 1e-6 * abs(left[0.0])


@pytest.mark.parametrize(
    ("name", "part"), [("disturbance_observer", {"g": 60.0}), ("super_twisting", {"k_2": 50.0})]
)
def test_a_limit_winds_up_neither_the_observer_nor_the_integrated_switching(name, part):
    # Wound up, 0.1 s at the limit are as much as the limit itself.
    reference = np.concatenate((np.zeros(20), np.full(1480, 0.2)))
    law = LAWS[name].with_values(limit=5.0)
    whole = drive(law.with_values(**part), reference).position
    plain = drive(law.with_values(**dict.fromkeys(part, 0.0)), reference).position
    assert whole.max() < 1.02 * plain.max()
    assert whole[-1] == pytest.approx(0.2, abs=2e-3)


def test_the_tracking_observer_fits_a_line_to_the_past_that_fades():
    # Least squares over all samples with weights p^age: the fading-memory filter of degree one.
    position, cutoff = np.random.default_rng(4).normal(size=3000), 40.0
    q, v = 0.0, 0.0
    for measured in position:
        q, v = observed(q, v, measured, DT, ESTIMATORS.index("tracking_observer"), cutoff)
    age = np.arange(position.size)[::-1]
    fading = np.exp(-2.0 * math.pi * cutoff * DT) ** age
    slope, now = np.polyfit(-DT * age, position, 1, w=np.sqrt(fading))
    assert (q, v) == (pytest.approx(now, rel=1e-9), pytest.approx(slope, rel=1e-9))


# --- what is fed forward ----------------------------------------------------------------------------------------


def test_friction_along_the_measured_motion_is_that_of_the_model_there():
    model = friction.maxwell_slip(F_C=2.0, k_i=[2e4, 1e4], nu_i=[0.5, 0.5])
    reference = 5e-3 * np.sin(15.0 * DT * np.arange(450))
    trace = drive(
        LAWS["sliding_mode"],
        reference,
        model=model,
        compensator=Compensator(model, Shape(gain=0.8)),
    )
    assert trace.compensation == pytest.approx(0.8 * response(model, trace.measured, DT), abs=1e-9)
    # One mass: its motor is where it is itself.
    assert np.array_equal(trace.motor_position, trace.position)
    assert np.array_equal(trace.motor_velocity, trace.velocity)


@pytest.mark.parametrize("name", ["gms", pytest.param("maxwell_stribeck", marks=pytest.mark.slow)])
def test_desired_and_measured_motion_with_dwells_have_equal_feedforward(name):
    model = friction.MODELS[name](**friction.MODELS[name].example)
    reference = 3e-2 * np.sin(40.0 * DT * np.arange(900))
    coarse = sensors.encoder(resolution=1e-3)
    trace = drive(
        LAWS["sliding_mode"],
        reference,
        model=model,
        compensator=Compensator(model, Shape()),
        sensor=coarse,
    )
    v = np.diff(trace.measured, prepend=trace.measured[0]) / DT
    assert 100 < np.sum(v == 0.0) < 850
    along = compensation_along(model, Shape(), v, DT, trace.measured)
    np.testing.assert_array_equal(trace.compensation, along)


def test_feedforward_of_a_set_valued_model_at_rest_is_the_middle():
    contact = friction.find("coulomb")(F_C=2.0, offset=0.5)
    trace = drive(LAWS["sliding_mode"], np.zeros(50), compensator=Compensator(contact, Shape()))
    assert trace.compensation[0] == pytest.approx(0.5)
