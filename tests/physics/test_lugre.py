"""LuGre against its own differential equation, solved by another code."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bristle import friction
from bristle.core.contracts import Motion
from bristle.engine import force_along, run_open_loop
from bristle.plants import inertia

MODEL = friction.lugre(F_C=1.0, F_S=1.5, v_S=1e-3, sigma_0=1e5, sigma_1=300.0, sigma_2=0.4, v_d=5e-3)


@pytest.mark.parametrize("v", [1e-5, 3e-4, -2e-3, 0.5])
@pytest.mark.parametrize("h", [1e-6, 1e-4, 1e-2])
def test_constant_velocity_is_exact(v, h):
    p = MODEL.parameters
    count = 50
    force = force_along(MODEL, np.full(count, v), h)
    # The bristle relaxes exponentially to G/sigma_0: its mean over a step follows from the exact displacement.
    G = p.F_C + (p.F_S - p.F_C) * np.exp(-((v / p.v_S) ** 2))
    z_steady, rate = np.sign(v) * G / p.sigma_0, p.sigma_0 * abs(v) / G
    t = h * np.arange(count + 1)
    z = -z_steady * np.expm1(-rate * t)
    z_integral = z_steady * (t + np.expm1(-rate * t) / rate)
    sigma_1 = p.sigma_1 * np.exp(-((v / p.v_d) ** 2))
    exact = p.sigma_0 * np.diff(z_integral) / h + sigma_1 * np.diff(z) / h + p.sigma_2 * v
    scale = np.max(np.abs(exact))
    # The exact displacement itself loses digits by its differences where the step is short.
    assert np.max(np.abs(force - exact)) < 1e-14 * scale + 4e-16 * abs(z_steady) * p.sigma_0 / min(1.0, rate * h)


def test_steady_force_is_the_static_map():
    for v in (1e-4, 1e-3, 1e-2, -0.3):
        p = MODEL.parameters
        G = p.F_C + (p.F_S - p.F_C) * np.exp(-((v / p.v_S) ** 2))
        force = force_along(MODEL, np.full(4000, v), 1e-5 / abs(v))[-1]
        assert force == pytest.approx(np.sign(v) * G + p.sigma_2 * v, rel=1e-13)


def test_bristle_deflection_stays_bounded():
    generator = np.random.default_rng(3)
    v = 10 ** generator.uniform(-6, 0, 5000) * generator.choice((-1, 1), 5000)
    free = friction.lugre(F_C=1.0, F_S=1.5, v_S=1e-3, sigma_0=1e5)
    assert np.max(np.abs(force_along(free, v, 1e-3))) <= 1.5 * (1 + 1e-15)


def test_driven_mass_converges_to_the_differential_equation_with_order_two():
    # Solved for by an implicit multistep code on the smooth equations of `rate`.
    plant = inertia(M=1.0)

    def effort(t):
        return 1.2 * np.sin(12.0 * t)

    def right_hand_side(t, y):
        force, slope = MODEL.component.rate(MODEL.component.State(y[2]), Motion(y[1], 0.0), MODEL.parameters)
        return [y[1], effort(t) - force, slope.z]

    end = 0.5
    exact = solve_ivp(right_hand_side, (0, end), [0, 0, 0], method="Radau", rtol=1e-10, atol=1e-14, max_step=1e-3)
    errors = []
    for h in (4e-4, 2e-4, 1e-4):
        t = h * np.arange(round(end / h) + 1)
        trace = run_open_loop(plant, MODEL, effort(t), h, hold="linear")
        errors.append(abs(trace.position[-1] - exact.y[0, -1]) / np.max(np.abs(exact.y[0])))
    assert errors[-1] < 1e-4
    assert np.mean(np.log2(np.array(errors[:-1]) / errors[1:])) > 1.6, errors
