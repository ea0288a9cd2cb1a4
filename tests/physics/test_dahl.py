"""Dahl in closed form against its differential equation, for every exponent."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bristle import friction
from bristle.core.contracts import Motion
from bristle.engine import force_along
from bristle.friction.dahl import decayed

pytestmark = pytest.mark.usefixtures("in_plain_python")


@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.5, 2.0, 3.0])
def test_ends_of_steps_are_exact(exponent):
    model = friction.dahl(sigma_0=2e5, F_C=1.3, exponent=exponent)
    component, p = model.component, model.parameters
    turns = [0.0, 4e-6, -5e-6, 3e-6, 2e-6, 8e-6]
    expected, state = 0.0, component.State()
    for a, b in pairwise(turns):
        v = np.copysign(1e-3, b - a)
        duration = (b - a) / v

        def slope(t, y, v=v):
            _, d_state = component.rate(component.State(y[0]), Motion(v, 0.0), p)
            return [d_state.F]

        solved = solve_ivp(slope, (0.0, duration), [expected], rtol=1e-11, atol=1e-13, method="DOP853")
        expected = solved.y[0, -1]
        # In one step or in a hundred, the end is the same.
        for count in (100, 1):
            now = state
            for _ in range(count):
                _, move = component.trial(now, (), Motion(v, 0.0), duration / count, p)
                now = component.commit(now, (), move, p)
            assert pytest.approx(expected, rel=1e-8, abs=1e-9) == now.F, count
        state = now


def test_mean_force_is_second_order():
    model = friction.dahl(sigma_0=2e5, F_C=1.3, exponent=2.0)
    count = 4096
    x = 1e-5 * np.sin(2 * np.pi * np.arange(count + 1) / count)
    v = np.diff(x) / 1e-3
    reference = force_along(model, v, 1e-3)
    errors = []
    for division in (32, 16, 8):
        coarse = force_along(model, v.reshape(-1, division).mean(axis=1), 1e-3 * division)
        errors.append(np.sqrt(np.mean((coarse - reference.reshape(-1, division).mean(axis=1)) ** 2)))
    assert errors[-1] < 1e-4 * 1.3
    assert np.all(np.log2(np.array(errors[:-1]) / errors[1:]) > 1.95), errors


def test_force_never_passes_coulomb():
    generator = np.random.default_rng(1)
    model = friction.dahl(sigma_0=2e5, F_C=1.3, exponent=0.7)
    v = 10 ** generator.uniform(-6, -1, 3000) * generator.choice((-1, 1), 3000)
    assert np.max(np.abs(force_along(model, v, 1e-3))) <= 1.3 * (1 + 1e-14)


@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.5, 2.0, 2.5, 4.0])
@pytest.mark.parametrize(("r", "kappa"), [(1.0, 0.3), (1.9, 2.5), (-0.6, 1.5)])
def test_the_mean_of_a_step_is_that_of_its_points(exponent, r, kappa):
    along = kappa * (np.arange(500) + 0.5) / 500.0
    places = [decayed(r, at, exponent)[0] for at in along.tolist()]
    assert decayed(r, kappa, exponent)[1] == pytest.approx(np.mean(places), rel=1e-5)
