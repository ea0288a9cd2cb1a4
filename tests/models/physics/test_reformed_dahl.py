"""The reformed Dahl model: its symmetric loops, and what it forgets."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bristle import friction, hysteresis, response
from bristle.engine import force_along
from bristle.engine.contact import Contact

pytestmark = pytest.mark.usefixtures("in_plain_python")

MODEL = friction.reformed_dahl(s=1.0, f_p=1.0)
SPEED = 1.0


def ends(contact, *turns, count=1):
    """Forces where a path turns."""
    result = []
    for turn in turns:
        contact.move(turn - contact.x, SPEED, count)
        result.append(contact.force(0.0))
    return np.array(result)


def test_every_branch_solves_the_differential_equation():
    contact, f, f_r, side = Contact(MODEL), 0.0, 0.0, 0.0
    for a, b in pairwise([0.0, 3.0, -1.0, 0.5, 0.2, 2.0]):
        way = np.sign(b - a)
        f_r = f if way != side else f_r
        side = way
        solved = solve_ivp(
            lambda x, f, way=way, f_r=f_r: ((1.0 - way * f) / (1.0 - way * f_r)) ** 2,
            (a, b),
            [f],
            rtol=1e-12,
            atol=1e-14,
            method="DOP853",
        )
        f = solved.y[0, -1]
        item, many = contact.copy(), contact
        assert ends(item, b)[-1] == pytest.approx(f, abs=1e-10)
        assert ends(many, b, count=50)[-1] == pytest.approx(f, abs=1e-10)


def test_the_mean_force_of_a_step_is_exact():
    v = np.concatenate([np.full(64, 0.03), np.full(96, -0.03), np.full(32, 0.03)])
    fine = force_along(MODEL, v, 1.0).reshape(6, 32).mean(axis=1)
    np.testing.assert_allclose(force_along(MODEL, v[::32], 32.0), fine, atol=1e-13)


@pytest.mark.parametrize("k", [1e-3, 0.1, 1.0, 10.0, 1e3])
def test_a_symmetric_loop_is_that_of_the_exact_operator(k):
    x = k * np.cos(2 * np.pi * np.arange(65) / 64)
    expected = response(hysteresis.preisach(kernel="reformed_dahl_exact", s=1.0, f_p=1.0), x)
    # After each step one at rest, of which the mean force is the force there.
    v = np.stack([np.diff(x), np.zeros(64)], axis=1).ravel()
    tip = MODEL.component.State(expected[0], -expected[0], 1.0)
    result = force_along(MODEL, v, 1.0, state=tip)[1::2]
    np.testing.assert_allclose(result, expected[1:], rtol=1e-13, atol=1e-13)


def test_a_minor_loop_stays_open_and_the_outer_loop_is_lost():
    contact = Contact(MODEL)
    tips = ends(contact, 3.5, *[2.5, 3.5] * 20)[::2]
    assert tips[0] - tips[1] == pytest.approx(0.177, abs=5e-4)
    assert tips[0] == pytest.approx(0.778, abs=5e-4)
    assert tips[-1] == pytest.approx(0.281, abs=5e-4)


def test_a_force_at_its_limit_stays_finite_through_reversals_too_short_to_change_it():
    contact = Contact(MODEL)
    contact.move(-1e18, SPEED)
    for distance in (1e-18, -1e-18, 1e-18, -1e-18, -1.0, 2.0):
        contact.move(distance, SPEED)
        assert abs(contact.force(0.0)) <= 1.0
