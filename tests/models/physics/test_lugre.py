"""LuGre against its own differential equation, solved by another code."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from bristle import friction
from bristle.core.contracts import Motion
from bristle.engine import force_along, run_open_loop
from bristle.models.plants import inertia

MODEL = friction.lugre(
    F_C=1.0, F_S=1.5, v_S=1e-3, sigma_0=1e5, sigma_1=300.0, sigma_2=0.4, v_d=5e-3
)


def exact(v: float, h: float, count: int) -> np.ndarray:
    """Mean forces over steps at constant velocity, by a matrix exponential of the equations in continuous time.

    At constant velocity the equations are affine in the deflection.
    """
    component, p, unit = MODEL.component, MODEL.parameters, 1e-5
    (f_0, z_0), (f_1, z_1) = (
        component.rate(component.State(z), Motion(v, 0.0), p) for z in (0.0, unit)
    )
    # Of deflection in units, its integral, and 1.
    growth = expm(
        h
        * np.array([[(z_1.z - z_0.z) / unit, 0.0, z_0.z / unit], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    )
    forces, deflection = [], 0.0
    for _ in range(count):
        deflection, integral, _ = growth @ [deflection, 0.0, 1.0]
        forces.append(f_0 + (f_1 - f_0) * integral / h)
    return np.array(forces)


@pytest.mark.parametrize("v", [1e-5, 3e-4, -2e-3, 0.5])
@pytest.mark.parametrize("h", [1e-6, 1e-4, 1e-2])
def test_constant_velocity_is_exact(v, h):
    count = 50
    force, expected = force_along(MODEL, np.full(count, v), h), exact(v, h, count)
    # Each step may round the state that it starts from.
    assert np.max(np.abs(force - expected)) < count * 1e-15 * np.max(np.abs(expected))
    in_eighths = force_along(MODEL, np.full(8 * count, v), h / 8.0).reshape(count, 8).mean(axis=1)
    assert np.max(np.abs(force - in_eighths)) < count * 1e-15 * np.max(np.abs(force))


@pytest.mark.parametrize(("v", "expected"), [(1e-9, 1.5), (-1e-9, -1.5), (0.5, 1.2), (-0.5, -1.2)])
def test_steady_force_lies_between_its_limits(v, expected):
    # Break-away force at creep; far beyond the Stribeck velocity Coulomb force and 0.4 N*s/m of viscous friction.
    force = force_along(MODEL, np.full(200, v), 1e-5 / abs(v))[-1]
    assert force == pytest.approx(expected, rel=1e-9)


def test_bristle_deflection_stays_bounded():
    generator = np.random.default_rng(3)
    v = 10 ** generator.uniform(-6, 0, 5000) * generator.choice((-1, 1), 5000)
    free = friction.lugre(F_C=1.0, F_S=1.5, v_S=1e-3, sigma_0=1e5)
    assert np.max(np.abs(force_along(free, v, 1e-3))) <= 1.5 * (1 + 1e-15)


@pytest.mark.slow
def test_driven_mass_converges_to_the_differential_equation_with_order_two():
    # Solved for by an implicit multistep code on the smooth equations of `rate`.
    plant = inertia(M=1.0)

    def effort(t):
        return 1.2 * np.sin(12.0 * t)

    def right_hand_side(t, y):
        force, slope = MODEL.component.rate(
            MODEL.component.State(y[2]), Motion(y[1], 0.0), MODEL.parameters
        )
        return [y[1], effort(t) - force, slope.z]

    end = 0.5
    solved = solve_ivp(
        right_hand_side, (0, end), [0, 0, 0], method="Radau", rtol=1e-10, atol=1e-14, max_step=2e-3
    )
    errors = []
    for h in (2e-4, 1e-4, 5e-5):
        t = h * np.arange(round(end / h) + 1)
        trace = run_open_loop(plant, MODEL, effort(t), h, hold="linear")
        errors.append(abs(trace.position[-1] - solved.y[0, -1]) / np.max(np.abs(solved.y[0])))
    assert errors[-1] < 1e-8
    assert np.all(np.log2(np.array(errors[:-1]) / errors[1:]) > 1.95), errors
