"""Bouc-Wen in its customary amplitudes: hardening, and what is redundant in it."""

import numpy as np
import pytest

from bristle import friction
from bristle.engine import force_along

pytestmark = pytest.mark.usefixtures("in_plain_python")

ALPHA = 5e4


def test_a_yielding_shape_equals_the_model_in_stiffness_and_force():
    v = 10 ** np.random.default_rng(4).uniform(-6, -2, 300) * np.random.default_rng(5).choice(
        (-1, 1), 300
    )
    bound, exponent, beta = 20.0, 2.0, 0.6
    plain = friction.bouc_wen(s=ALPHA, F_C=bound, exponent=exponent, beta=beta)
    amplitude = ALPHA / bound**exponent
    classic = friction.bouc_wen_classic(
        alpha=ALPHA, beta=amplitude, gamma=beta, delta=1.0 - beta, nu=exponent
    )
    np.testing.assert_allclose(
        force_along(classic, v, 1e-3), force_along(plain, v, 1e-3), rtol=1e-9, atol=1e-9
    )


def test_the_force_depends_on_products_of_the_amplitudes_only():
    v = 1e-2 * np.sin(np.linspace(0.0, 40.0, 500))
    item, other = (
        friction.bouc_wen_classic(alpha=ALPHA, beta=beta, gamma=800.0 / beta, delta=-1100.0 / beta)
        for beta in (1e3, 20.0)
    )
    np.testing.assert_allclose(force_along(item, v, 1e-3), force_along(other, v, 1e-3), atol=1e-9)


@pytest.mark.parametrize("nu", [1.0, 1.7])
@pytest.mark.parametrize("length", [1e-3, 0.02, 1.0, 1e6])
def test_a_yielding_contact_slides_at_its_bound_for_steps_of_any_length(nu, length):
    model = friction.bouc_wen_classic(alpha=6e6, beta=10.0, gamma=37_000.0, delta=-27_000.0, nu=nu)
    bound = 60.0 ** (1.0 / nu)  # where the slope alpha - beta (gamma + delta) z**nu is 0
    assert force_along(model, np.full(8, 1.0), length)[1:] == pytest.approx(bound, rel=1e-9)
    assert force_along(model, np.array([1.0, -1.0, -1.0]), length)[-1] == pytest.approx(
        -bound, rel=1e-9
    )


def test_a_negative_sum_of_amplitudes_hardens():
    hard = friction.bouc_wen_classic(alpha=ALPHA, beta=1e3, gamma=0.8, delta=-1.1)
    force = force_along(hard, np.full(100, 1e-3), 1e-2)
    assert np.all(np.diff(np.diff(force)) > 0.0)
    assert force[-1] > ALPHA * 1e-3


@pytest.mark.parametrize("delta", [0.3, -1.1])
def test_closed_cycles_dissipate_for_yielding_and_hardening(delta):
    v = 0.02 * np.cos(np.linspace(0.0, 4.0 * np.pi, 401)[:-1])
    power = (
        force_along(
            friction.bouc_wen_classic(alpha=ALPHA, beta=1e3, gamma=0.8, delta=delta), v, 5e-4
        )
        * v
    )
    assert np.sum(power[200:]) > 0.0
