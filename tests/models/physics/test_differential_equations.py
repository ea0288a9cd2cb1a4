"""Contacts led to and fro against their differential equations, solved by a library."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bristle import friction
from bristle.core.contracts import Motion
from bristle.engine.contact import Contact

pytestmark = pytest.mark.usefixtures("in_plain_python")
SPEED = 8e-4


def bouc_wen(exponent, beta):
    model = friction.bouc_wen(s=2e5, F_C=1.3, exponent=exponent, beta=beta)

    def slope(x, f, way):
        ratio = np.abs(f / 1.3) ** exponent
        return 2e5 * (1.0 - ratio * ((1.0 - beta) + beta * np.sign(way * f)))

    return model, slope, (0.0, 9e-6, -4e-6, 3e-6), False


def classic(nu, beta, gamma, delta):
    model = friction.bouc_wen_classic(alpha=5e4, beta=beta, gamma=gamma, delta=delta, nu=nu)

    def slope(x, z, way):
        return 5e4 - beta * (gamma * way * np.abs(z) ** (nu - 1.0) * z + delta * np.abs(z) ** nu)

    # Exact along a move, through zero too, if nu is 1.
    return model, slope, (0.0, 2e-3, -1.5e-3, 1e-3, -2.5e-3), nu == 1.0


def by_rate(model, is_exact):
    def slope(x, z, way):
        _, rate = model.component.rate(
            model.component.State(*z), Motion(way * SPEED, 0.0), model.parameters
        )
        return [rate[0] / (way * SPEED)]

    return model, slope, (0.0, 4e-6, -5e-6, 3e-6, 2e-6, 1.8e-5), is_exact


SLIDING = {"F_C": 1.0, "F_S": 1.4, "v_S": 1e-3, "sigma_0": 1e5, "sigma_1": 10.0, "sigma_2": 0.4}
CASES = {
    **{
        f"bouc_wen {shape}": bouc_wen(*shape)
        for shape in ((1.0, 0.5), (2.0, 0.5), (2.0, 0.9), (5.0, 0.7))
    },
    **{
        f"bouc_wen_classic {shape}": classic(*shape)
        for shape in ((1.0, 1e3, 0.8, -1.1), (1.0, 1e3, 0.8, 0.3), (1.0, 1e3, 0.2, 0.7))
    },
    **{
        f"bouc_wen_classic {shape}": classic(*shape)
        for shape in ((1.7, 50.0, 0.8, 0.3), (2.0, 0.1, 0.8, -0.9))
    },
    **{
        f"dahl {i}": by_rate(friction.dahl(sigma_0=2e5, F_C=1.3, exponent=i), True)
        for i in (0.8, 1.0, 1.5, 2.0, 3.0)
    },
    "elastoplastic": by_rate(friction.elastoplastic(**SLIDING, z_ba=7e-6), False),
}


@pytest.mark.parametrize("name", CASES)
def test_steps_solve_the_differential_equation_exactly_or_with_order_two(name):
    model, slope, turns, is_exact = CASES[name]
    # Deflections and forces are as large as what the first slope gives over ten micrometres.
    expected, errors, unit = 0.0, [], 1e-5 * np.ravel(slope(0.0, np.zeros(1), 1.0))[0]
    for a, b in pairwise(turns):
        way, step = np.sign(b - a), abs(b - a) / 100.0
        expected = solve_ivp(
            slope,
            (a, b),
            [expected],
            args=(way,),
            rtol=1e-10,
            atol=1e-12 * unit,
            max_step=step,
            method="DOP853",
        ).y[0, -1]
    for count in (1, 80, 160, 320)[not is_exact :]:
        contact = Contact(model)
        for turn in turns[1:]:
            contact.move(turn - contact.x, SPEED, count)
        errors.append(abs(contact.state[0] / expected - 1.0))
    assert errors[-1] < (1e-7 if is_exact else 1e-4)
    assert max(errors) < 1e-7 or np.log2(errors[0] / errors[-1]) / 2 > 1.6, errors
