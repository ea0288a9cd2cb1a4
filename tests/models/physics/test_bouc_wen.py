"""Bouc-Wen its closed forms, and its known flaw."""

import numpy as np
import pytest

from bristle import friction
from bristle.core import InputError
from bristle.engine import force_along
from bristle.engine.contact import Contact

pytestmark = pytest.mark.usefixtures("in_plain_python")

S, F_C = 2e5, 1.3


def test_dahl_of_exponent_one_is_the_case_of_full_direction_dependence():
    v = 10 ** np.random.default_rng(4).uniform(-6, -2, 200) * np.random.default_rng(5).choice(
        (-1, 1), 200
    )
    bouc_wen = friction.bouc_wen(s=S, F_C=F_C, exponent=1.0, beta=1.0, sigma_2=3.0)
    dahl = friction.dahl(sigma_0=S, F_C=F_C, exponent=1.0, sigma_2=3.0)
    np.testing.assert_allclose(
        force_along(bouc_wen, v, 1e-3), force_along(dahl, v, 1e-3), rtol=1e-9, atol=1e-9
    )


def test_a_stiffness_that_never_yields_adds_a_spring():
    x = 5e-6 * np.sin(np.linspace(0.0, 20.0, 400))
    v = np.diff(x) / 1e-3
    plain, half, spring = (
        force_along(friction.bouc_wen(s=S, F_C=F_C, alpha=alpha), v, 1e-3, x[1:])
        for alpha in (0.0, 0.5, 1.0)
    )
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
