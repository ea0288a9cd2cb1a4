"""Closed forms from a few loops: both numbers, and the kernel, come back."""

import numpy as np
import pytest
from tests.golden.simulated import NOISE

from bristle import hysteresis, response
from bristle.core.errors import InputError
from bristle.identification.hysteresis.identify import fit_closed_form
from bristle.logs.curves import Curve, Curves
from bristle.models.hysteresis.everett import KERNELS

S, F_P = 40.0, 60.0  # mN*m/um, mN*m


def loops(kernel, rng, **shape):
    """Three loops of the source paper's kind, of 2, 4.4 and 6.8 um, with an offset and noise."""
    truth = hysteresis.preisach(kernel=kernel, s=S, f_p=F_P, **shape)
    turns = [0.0, 2.0, -2.0, 2.0, 4.4, -4.4, 4.4, 6.8, -6.8, 6.8]
    u = np.interp(np.linspace(0, len(turns) - 1, 900), np.arange(len(turns)), turns)
    return Curves((Curve(u, response(truth, u) + 5.0 + NOISE * F_P * rng.standard_normal(u.size)),))


@pytest.mark.parametrize("kernel", KERNELS)
def test_the_kernel_and_both_numbers_are_recovered(kernel):
    rng = np.random.default_rng(7)
    result = fit_closed_form(loops(kernel, rng))
    assert result.offset == pytest.approx(5.0, abs=0.1)
    assert result.rms == pytest.approx(NOISE * F_P, rel=0.1)
    values = result.operator.values
    assert values["s"] == pytest.approx(S, rel=0.02)
    assert values["f_p"] == pytest.approx(F_P, rel=0.02)
    if kernel == "exp_masing":
        # The exponential is the limit of the Dahl family: both say the same.
        assert values["kernel"] == kernel or values["exponent"] == pytest.approx(1.0, abs=0.05)
    else:
        assert values["kernel"] == kernel


def test_the_exponent_is_recovered():
    result = fit_closed_form(
        loops("dahl_masing", np.random.default_rng(8), exponent=1.5), kernels=("dahl_masing",)
    )
    assert result.operator.values["exponent"] == pytest.approx(1.5, abs=0.1)


def test_unsuitable_data_are_refused():
    with pytest.raises(InputError, match="must vary"):
        fit_closed_form(Curves((Curve(np.arange(9.0), np.ones(9)),)))
