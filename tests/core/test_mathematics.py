"""Elementary functions: as exact as the C library, without traps, and the same bits compiled."""

import math

import numpy as np
import pytest

from bristle.core import mathematics
from bristle.core.kernel import activate, kernel_options

UNIT = np.finfo(float).eps


def points():
    generator = np.random.default_rng(7)
    small = generator.choice((-1.0, 1.0), 5000) * 10 ** generator.uniform(-20, 0, 5000)
    return np.concatenate([generator.uniform(-708.0, 709.0, 5000), small, [0.0, 1.0, -1.0, 0.5 * math.log(2.0)]])


@pytest.mark.parametrize(("ours", "library"), [(mathematics.exp, math.exp), (mathematics.expm1, math.expm1)])
def test_exponentials_agree_with_the_library_to_rounding(ours, library):
    for x in points().tolist():
        assert ours(x) == pytest.approx(library(x), rel=3 * UNIT, abs=0.0), x


def test_the_exponential_is_finite_for_every_finite_number():
    assert mathematics.exp(0.0) == 1.0
    assert mathematics.exp(-1e300) == 0.0
    assert mathematics.exp(-math.inf) == 0.0
    assert mathematics.exp(1e300) == mathematics.exp(709.0) < math.inf
    assert mathematics.expm1(-1e300) == -1.0
    assert math.isnan(mathematics.exp(math.nan))


@pytest.mark.parametrize("rate", [0.0, 1e-320, 1e-40, 1e-17, 1e-9, 1e-3, 0.7, 30.0, 800.0, 1e300])
def test_relaxation_is_the_mean_of_a_decay(rate):
    assert mathematics.relaxation(rate) == pytest.approx(-math.expm1(-rate) / rate if rate else 1.0, rel=4 * UNIT)


@pytest.mark.parametrize("name", ["exp", "expm1", "relaxation", "fitted_weight", "log"])
def test_compiled_functions_give_the_same_bits(name):
    import numba

    activate()
    function = getattr(mathematics, name)

    @numba.njit(**kernel_options(inline=False))
    def over(x, y):
        for i in range(x.size):
            y[i] = function(x[i])

    x = np.concatenate([points(), [-1e300, 1e300, -math.inf, math.inf, 5e-324]])
    x = np.abs(x[np.isfinite(x)]) if name in ("relaxation", "fitted_weight", "log") else x
    compiled = np.empty(x.size)
    over(x, compiled)
    plain = np.array([function(one) for one in x.tolist()])
    assert np.array_equal(compiled, plain)
