"""Maxwell slip, which is a sum of stops: its mean forces, and the limits of its parts."""

from itertools import pairwise

import numpy as np
import pytest

from bristle import friction, response
from bristle.engine import force_along

pytestmark = pytest.mark.usefixtures("in_plain_python")

MODEL = friction.maxwell_slip(F_C=1.0, k_i=[4e5, 2e5, 1e5, 4e4], nu_i=[0.2, 0.3, 0.3, 0.2])


def path(*turns, count=40):
    pieces = [np.linspace(a, b, count, endpoint=False) for a, b in pairwise(turns)]
    return np.concatenate([*pieces, [turns[-1]]])


def test_mean_force_is_exact_for_any_step():
    fine, coarse = 1024, 4
    v = np.full(fine, 2e-3)
    mean_fine = force_along(MODEL, v, 4e-6).reshape(coarse, -1).mean(axis=1)
    np.testing.assert_allclose(
        force_along(MODEL, v[:coarse], 4e-6 * fine / coarse), mean_fine, rtol=1e-9
    )


def test_rate_independence():
    x = path(0, 4e-6, -3e-6, 1e-6)
    slow, fast = response(MODEL, x, 1.0), response(MODEL, x, 1e-4)
    np.testing.assert_allclose(slow, fast, rtol=0, atol=1e-9)


def test_asymmetric_limits_and_reversal_keep_the_force_continuous():
    model = friction.find("maxwell_slip+asymmetry")(
        F_C_pos=1.2, F_C_neg=0.8, k_i=[2e5, 1e5], nu_i=[0.5, 0.5], offset=0.1
    )
    x = path(0, 60e-6, -60e-6, 60e-6, count=1500)
    force = response(model, x, 1e-3)
    assert np.max(np.abs(np.diff(force[2:]))) < 0.05
    assert abs(force.max() - 1.3) < 1e-9
    assert abs(force.min() + 0.7) < 1e-9


def test_an_element_without_stiffness_has_no_force():
    v = np.array([1e-3, 2e-3, -1e-3, 0.0])
    with_it = friction.maxwell_slip(F_C=1.0, k_i=[1e6, 0.0], nu_i=[1.0, 0.0], validate=False)
    # A division of 0 by 0 would warn.
    assert np.array_equal(
        force_along(with_it, v, 1e-3),
        force_along(friction.maxwell_slip(F_C=1.0, k_i=[1e6], nu_i=[1.0]), v, 1e-3),
    )
