"""Dahl in closed form against its differential equation, for every exponent."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bristle import friction
from bristle.engine import force_along


@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.5, 2.0, 3.0])
def test_ends_of_steps_are_exact(exponent):
    sigma_0, F_C = 2e5, 1.3
    model = friction.dahl(sigma_0=sigma_0, F_C=F_C, exponent=exponent)
    turns = [0.0, 4e-6, -5e-6, 3e-6, 2e-6, 8e-6]

    def slope(x, f, side):
        r = 1.0 - f / F_C * side
        return sigma_0 * np.abs(r) ** exponent * np.sign(r)

    expected = 0.0
    state = model.component.State()
    for a, b in pairwise(turns):
        solved = solve_ivp(slope, (a, b), [expected], args=(np.sign(b - a),), rtol=1e-11, atol=1e-13, method="DOP853")
        expected = solved.y[0, -1]
        # In one step or in a hundred, the end is the same.
        for count in (100, 1):
            v = np.full(count, (b - a) / count / 1e-3)
            memory = model.component.new_memory(model.parameters)
            now = state
            for one in v:
                from bristle.core.contracts import Motion

                _, move = model.component.trial(now, memory, Motion(one, 0.0), 1e-3, model.parameters)
                now = model.component.commit(now, memory, move, model.parameters)
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
    assert np.mean(np.log2(np.array(errors[:-1]) / errors[1:])) > 1.4, errors


def test_force_never_passes_coulomb():
    generator = np.random.default_rng(1)
    model = friction.dahl(sigma_0=2e5, F_C=1.3, exponent=0.7)
    v = 10 ** generator.uniform(-6, -1, 3000) * generator.choice((-1, 1), 3000)
    assert np.max(np.abs(force_along(model, v, 1e-3))) <= 1.3 * (1 + 1e-14)
