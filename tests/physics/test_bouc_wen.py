"""Bouc-Wen against its differential equation, its closed forms, and its known flaw."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bristle import friction
from bristle.core import InputError
from bristle.engine import force_along
from bristle.engine.contact import Contact

pytestmark = pytest.mark.usefixtures("in_plain_python")

S, F_C = 2e5, 1.3


@pytest.mark.parametrize(("exponent", "beta"), [(1.0, 0.5), (2.0, 0.5), (2.0, 0.9), (5.0, 0.7)])
def test_steps_solve_the_differential_equation_with_order_two(exponent, beta):
    model = friction.bouc_wen(s=S, F_C=F_C, exponent=exponent, beta=beta)

    def slope(x, f, way):
        ratio = np.abs(f / F_C) ** exponent
        return S * (1.0 - ratio * ((1.0 - beta) + beta * np.sign(way * f)))

    turns, f = [0.0, 9e-6, -4e-6, 3e-6], 0.0
    for a, b in pairwise(turns):
        f = solve_ivp(slope, (a, b), [f], args=(np.sign(b - a),), rtol=1e-11, atol=1e-13, max_step=1e-7).y[0, -1]
    errors = []
    for count in (40, 80, 160):
        contact = Contact(model)
        for turn in turns[1:]:
            contact.move(turn - contact.x, 1.0, count)
        errors.append(abs(contact.force(0.0) - f) / F_C)
    assert errors[-1] < 1e-4
    assert np.log2(errors[0] / errors[-1]) / 2 > 1.6, errors


def test_dahl_of_exponent_one_is_the_case_of_full_direction_dependence():
    v = 10 ** np.random.default_rng(4).uniform(-6, -2, 200) * np.random.default_rng(5).choice((-1, 1), 200)
    bouc_wen = friction.bouc_wen(s=S, F_C=F_C, exponent=1.0, beta=1.0, sigma_2=3.0)
    dahl = friction.dahl(sigma_0=S, F_C=F_C, exponent=1.0, sigma_2=3.0)
    np.testing.assert_allclose(force_along(bouc_wen, v, 1e-3), force_along(dahl, v, 1e-3), rtol=1e-9, atol=1e-9)


def test_a_stiffness_that_never_yields_adds_a_spring():
    x = 5e-6 * np.sin(np.linspace(0.0, 20.0, 400))
    v = np.diff(x) / 1e-3
    plain, half, spring = (force_along(friction.bouc_wen(s=S, F_C=F_C, alpha=alpha), v, 1e-3, x[1:]) for alpha in (0.0, 0.5, 1.0))
    np.testing.assert_allclose(half, 0.5 * (plain + spring), atol=1e-12)
    np.testing.assert_allclose(spring, S * 0.5 * (x[1:] + x[:-1]), atol=1e-12)


def test_a_small_cycle_at_a_force_of_one_sign_relaxes():
    # A rate-independent contact with return-point memory would come back to the force that it left.
    contact = Contact(friction.bouc_wen(s=S, F_C=F_C))
    contact.move(6e-6, 1.0, 200)
    before = contact.force(0.0)
    for distance in (-1e-6, 1e-6):
        contact.move(distance, 1.0, 200)
    assert contact.force(0.0) < 0.99 * before


def test_a_shape_that_creates_energy_is_refused():
    with pytest.raises(InputError, match=r"beta.*0.5 to 1"):
        friction.bouc_wen(s=S, F_C=F_C, beta=0.2)
