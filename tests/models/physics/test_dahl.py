"""Dahl in closed form: means of its steps, and its bound."""

import numpy as np
import pytest

from bristle import friction
from bristle.engine import force_along
from bristle.models.friction.dahl import decayed

pytestmark = pytest.mark.usefixtures("in_plain_python")


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
