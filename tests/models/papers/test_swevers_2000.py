"""J. Swevers et al., IEEE Trans. Automatic Control 45(4), 2000: the Leuven model, slip by a power of the force.

doi:10.1109/9.847103
"""

import numpy as np
import pytest
from tests.simulation.certificates.ballscrew import (
    DAMPING,
    F_C,
    F_P,
    F_S,
    RIPPLE,
    SLIDING,
    STIFFNESS,
    UM,
    composite,
)

from bristle import friction
from bristle.simulation.certificates import check

pytestmark = pytest.mark.slow

LOOP = (3 * UM, 1.5 * UM)
EXPONENTS = (1.0, 2.0, 4.0, 8.0, 16.0)


@pytest.fixture(scope="module")
def result():
    return {n: check(leuven(n), force_ripple=RIPPLE, loop=LOOP) for n in EXPONENTS}


def leuven(n):
    return friction.leuven(s=STIFFNESS, f_p=F_P, n=n, **(SLIDING | DAMPING))


def test_a_large_exponent_drifts_less_and_closes_better(result):
    drifts = [result[n]["drift"].value for n in EXPONENTS]
    misses = [-result[n]["closure"].value for n in EXPONENTS]
    assert np.all(np.diff(drifts) < 0.0)
    assert np.all(np.diff(misses) < 0.0)
    assert drifts[-1] < 1e-4 * drifts[0]


def test_no_exponent_closes_the_loop_or_stops_the_drift(result):
    assert not any(result[n][name].passed for n in EXPONENTS for name in ("drift", "closure"))


def test_a_large_exponent_costs_passivity_and_the_gate_does_not(result):
    needed = [result[n]["passive"].threshold for n in EXPONENTS]
    assert np.all(np.diff(needed) > 0.0)
    assert needed[3] / DAMPING["sigma_1"] == pytest.approx(7.2, abs=0.05)
    gate = check(composite())["passive"].threshold
    assert gate == pytest.approx(needed[0], rel=1e-8)
    assert gate / DAMPING["sigma_1"] == pytest.approx(F_S / F_C - 1.0, rel=1e-8)


def test_the_exponent_one_is_the_source_paper(result):
    paper = check(composite("paper"), force_ripple=RIPPLE, loop=LOOP)
    assert paper["drift"].value == pytest.approx(result[1.0]["drift"].value, rel=1e-9)
    assert paper["closure"].value == pytest.approx(result[1.0]["closure"].value, rel=1e-9)
