"""The elastoplastic model: a spring below its threshold, LuGre in sliding."""

import numpy as np
import pytest

from bristle import friction
from bristle.core import InputError
from bristle.engine import force_along, response

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


def test_a_threshold_above_sliding_is_refused_with_advice():
    with pytest.raises(InputError, match=r"sigma_0 \* z_ba < F_C.*Lower z_ba"):
        friction.elastoplastic(**VALUES, z_ba=1.1e-5)
