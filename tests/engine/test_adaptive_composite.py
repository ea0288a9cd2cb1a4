"""Adaptive steps against solutions from event to event by another method, over three decades of the tolerance."""

from functools import partial

import numpy as np
import pytest
from tests.engine.composite_reference import Composite
from tests.engine.test_efim_composite import CONTACT, EFFORT, SETTLED, J

from bristle import friction, plants
from bristle.contract import example_of
from bristle.core.status import Status
from bristle.engine import interpreted, run_adaptive
from bristle.models.friction.preisach_lugre import KERNELS, TRANSITIONS

DT = 1e-4
# The effort [mN*m] runs straight between these, 12.5 ms apart: loops within loops below F_S, break-away beyond.
BENDS = {
    "pre-sliding": [0, 75, -10, 60, 20, 70, -80, -20, -60, 40, 90, -90, -30, -70, 0, 80, 0],
    "break-away": [0, 160, -40, 150, -160, -120, -155, 160, 0],
}


class Bristles(Composite):
    """LuGre: a linear contact, which remembers no turning points."""

    def hysteretic(self, z):
        return self.s * z

    def turn(self, y, way):
        self.way = way


def case(name):
    """Plant, effort at the samples and as a function, and where it bends."""
    if name == "stick-slip":
        return (
            plants.pulled_inertia(M=J, k=20.0, v_e=200.0),
            np.zeros(2501),
            lambda t, x: 20.0 * (200.0 * t - x),
            (),
        )
    levels = BENDS[name]
    knots = 0.0125 * np.arange(len(levels))
    effort = np.interp(DT * np.arange(round(knots[-1] / DT) + 1), knots, levels)
    return plants.inertia(M=J), effort, lambda t, x: np.interp(t, knots, levels), knots


LONGEST = (("elastoplastic", "pre-sliding"), ("elastoplastic", "stick-slip"))
# Steady sliding without the gate: errors grow, beyond the tolerance.
UNSTABLE = ("paper", "stick-slip")


def model_and_reference(name, effort):
    if name == "lugre":
        values = {key: value for key, value in CONTACT.items() if key not in ("s", "f_p")}
        return friction.lugre(sigma_0=CONTACT["s"], **values), Bristles(
            J=J, **CONTACT, rho=None, effort=effort
        )
    rho = {"elastoplastic": 0.9, "paper": None}[name]
    return friction.preisach_lugre(**CONTACT, transition=name), Composite(
        J=J, **CONTACT, rho=rho, effort=effort
    )


@pytest.mark.fast_cases(3)
@pytest.mark.parametrize(
    ("name", "motion"),
    [
        pytest.param(name, motion, marks=pytest.mark.slow if (name, motion) in LONGEST else ())
        for name in ("lugre", "elastoplastic", "paper")
        for motion in ("pre-sliding", "break-away", "stick-slip")
        if (name, motion) != UNSTABLE
    ],
)
def test_the_tolerance_is_the_global_error_over_three_decades(name, motion):
    plant, u, effort, bends = case(motion)
    model, reference = model_and_reference(name, effort)
    exact = reference.solve(DT * np.arange(u.size), bends)
    largest = np.max(np.abs(exact))
    for tolerance in largest * 10.0 ** -np.arange(3.0, 6.0):
        trace = run_adaptive(plant, model, u, DT, tolerance=tolerance)
        assert trace.status == Status.OK
        assert np.max(np.abs(trace.position - exact)) <= tolerance, tolerance / largest


def noisy_effort():
    t = 1e-3 * np.arange(200)
    return 150.0 * np.sin(40.0 * t) + 40.0 * np.random.default_rng(1).standard_normal(t.size)


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("transition", TRANSITIONS)
def test_under_noise_two_tolerances_agree(kernel, transition):
    model = friction.preisach_lugre(**CONTACT, kernel=kernel, transition=transition)
    rough, fine = (
        run_adaptive(plants.inertia(M=J), model, noisy_effort(), 1e-3, tolerance=tolerance)
        for tolerance in (1e-2, 1e-3)
    )
    assert np.max(np.abs(rough.position - fine.position)) <= 1e-2


def test_rounding_does_not_reverse_the_deflection_in_fast_sliding():
    trace = run_adaptive(
        plants.inertia(M=J),
        friction.preisach_lugre(**CONTACT),
        np.full(501, EFFORT),
        1e-3,
        tolerance=0.1,
    )
    assert trace.velocity[500] == pytest.approx(SETTLED, abs=1.0)
    assert trace.steps < 400


def test_direction_dependent_parameters_and_offset_take_effect():
    # 10 N forward against 3 + 1 N for a second, then 10 N backward: against 3 + 1 N to the stop, and against 2 - 1 N from there.
    model = friction.find("coulomb+asymmetry")(F_C_pos=3.0, F_C_neg=2.0, offset=1.0)
    effort = np.where(np.arange(31) < 10, 10.0, -10.0)
    with interpreted():
        trace = run_adaptive(plants.inertia(M=2.0), model, effort, 0.1, tolerance=1e-9, hold="zero")
    stopping, back = 3.0 / 7.0, np.maximum(trace.time - 1.0 - 3.0 / 7.0, 0.0)
    late = np.clip(trace.time - 1.0, 0.0, stopping)
    forward = 1.5 * np.minimum(trace.time, 1.0) ** 2 + 3.0 * late - 3.5 * late**2
    np.testing.assert_allclose(trace.position, forward - 2.25 * back**2, atol=1e-8)


def test_a_full_memory_is_reported():
    model = friction.preisach_lugre(**CONTACT, capacity=4)
    trace = run_adaptive(plants.inertia(M=J), model, 0.5 * noisy_effort(), 1e-3, tolerance=1e-3)
    assert trace.status == Status.MEMORY_OVERFLOW


def test_plain_python_is_identical_across_events():
    t = 1e-3 * np.arange(60)
    effort = 40.0 * np.sin(150.0 * t) + 5.0 * np.sin(611.0 * t)
    run = partial(
        run_adaptive,
        plants.inertia(M=2.0),
        example_of(friction.preisach_lugre),
        effort,
        1e-3,
        tolerance=1e-6,
    )
    compiled = run()
    with interpreted():
        plain = run()
    assert compiled.steps == plain.steps
    assert np.array_equal(compiled.position, plain.position)
    assert np.array_equal(compiled.friction, plain.friction)
