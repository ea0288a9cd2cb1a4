"""The elastoplastic model: a spring below its threshold, LuGre in sliding."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bristle import friction
from bristle.core import InputError
from bristle.core.contracts import Motion
from bristle.engine import force_along, response
from bristle.engine.contact import Contact

pytestmark = pytest.mark.usefixtures("in_plain_python")

VALUES = {"F_C": 1.0, "F_S": 1.4, "v_S": 1e-3, "sigma_0": 1e5, "sigma_1": 10.0, "sigma_2": 0.4}
MODEL = friction.elastoplastic(**VALUES, z_ba=7e-6)


def test_below_the_threshold_the_contact_is_a_spring():
    x = 6.5e-6 * np.sin(np.linspace(0.0, 60.0, 2000))
    free = friction.elastoplastic(**(VALUES | {"sigma_1": 0.0, "sigma_2": 0.0}), z_ba=7e-6)
    middle = 0.5 * (x[1:] + x[:-1])
    np.testing.assert_allclose(response(free, x, 1e-3)[1:], 1e5 * middle, atol=1e-12)


def test_steady_sliding_is_that_of_lugre():
    lugre = friction.lugre(**VALUES)
    for v in (1e-4, 1e-3, -2e-2, 0.5):
        steady = [force_along(item, np.full(100, v), 1e-5 / abs(v))[-1] for item in (MODEL, lugre)]
        assert steady[0] == pytest.approx(steady[1], rel=1e-12)


def test_steps_solve_the_differential_equation_with_order_two():
    period, speed = 0.1, 8e-4

    def velocity(t):
        return speed * np.cos(2 * np.pi * t / period)

    def rate(t, y):
        return MODEL.component.rate(MODEL.component.State(y[0]), Motion(velocity(t), 0.0), MODEL.parameters)[1]

    exact = solve_ivp(rate, (0, period), [0.0], method="Radau", rtol=1e-9, atol=1e-16, max_step=1e-3).y[0, -1]
    errors = []
    for count in (200, 400, 800):
        contact, h = Contact(MODEL), period / count
        for k in range(count):
            v = velocity((k + 0.5) * h)
            contact.move(v * h, abs(v))
        errors.append(abs(contact.state[0] - exact) / abs(exact))
    assert errors[-1] < 1e-4
    assert np.log2(errors[0] / errors[-1]) / 2 > 1.7, errors


def test_a_threshold_above_sliding_is_refused_with_advice():
    with pytest.raises(InputError, match=r"sigma_0 \* z_ba < F_C.*Lower z_ba"):
        friction.elastoplastic(**VALUES, z_ba=1.1e-5)
