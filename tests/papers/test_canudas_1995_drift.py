"""C. Canudas de Wit et al., IEEE Trans. Automatic Control 40(3), 1995: bristles that always slip, and so drift.

doi:10.1109/9.376053
"""

import numpy as np
import pytest
from tests.certificates.ballscrew import F_S, RIPPLE, STIFFNESS, UM, composite, lugre, maxwell_slip
from tests.papers.rippled import drift_of, steps_per_cycle


def test_the_drift_is_the_same_by_the_integrator_and_by_the_slow_path():
    dynamic = steps_per_cycle(lugre(), *RIPPLE, top=RIPPLE[1])[-1]
    assert dynamic / UM == pytest.approx(0.38980, rel=2e-3)
    assert drift_of(lugre()).value == pytest.approx(dynamic, rel=2e-3)


@pytest.mark.slow
def test_lugre_drifts_after_break_away_and_the_gate_comes_to_rest():
    walks, rests = (steps_per_cycle(model, *RIPPLE, top=1.02 * F_S, cycles=16) for model in (lugre(), composite(sigma_2=0.03)))
    assert walks[-1] > 0.3 * UM
    assert abs(rests[-1]) < 1e-8 * UM


@pytest.mark.parametrize("top", [0.08, 0.99 * F_S])
def test_spring_slider_elements_rest(top):
    assert abs(steps_per_cycle(maxwell_slip(), *RIPPLE, top=top)[-1]) < 1e-8 * UM


@pytest.mark.parametrize("amplitude", [0.005, 0.01, 0.02])
def test_a_small_ripple_drifts_by_the_difference_of_both_compliances(amplitude):
    # 1/(1 - r) and 1/(1 + r) differ at any bias: the smaller the ripple, the more nearly is the drift their difference
    # times its width.
    bias = 0.06
    moved = drift_of(lugre(), (bias - amplitude, bias + amplitude)).value
    width, r = 2.0 * amplitude / STIFFNESS, bias / F_S
    assert moved == pytest.approx(width * (1.0 / (1.0 - r) - 1.0 / (1.0 + r)), rel=0.05)
    assert np.sign(moved) == 1.0
