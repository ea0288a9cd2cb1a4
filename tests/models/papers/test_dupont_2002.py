"""P. Dupont et al., IEEE Trans. Automatic Control 47(5), 2002: an elastoplastic bristle does not drift.

It deflects without slip up to a threshold. doi:10.1109/TAC.2002.1000274
"""

import numpy as np
import pytest
from tests.models.papers.rippled import closure_of, drift_of, steps_per_cycle
from tests.simulation.certificates.ballscrew import (
    DAMPING,
    F_C,
    F_S,
    RIPPLE,
    SLIDING,
    STIFFNESS,
    UM,
    lugre,
)

from bristle import friction
from bristle.simulation.certificates import Path, traced


def elastoplastic(share):
    """The model with a threshold at a share of the Coulomb force."""
    return friction.elastoplastic(
        sigma_0=STIFFNESS, z_ba=share * F_C / STIFFNESS, **(SLIDING | DAMPING)
    )


def test_it_rests_below_its_threshold_where_lugre_drifts():
    assert drift_of(elastoplastic(0.9)).passed
    assert not drift_of(lugre()).passed


@pytest.mark.slow
def test_it_rests_after_break_away_too():
    assert abs(steps_per_cycle(elastoplastic(0.9), *RIPPLE, top=1.02 * F_S)[-1]) < 1e-8 * UM


def test_above_its_threshold_it_drifts():
    result = drift_of(elastoplastic(0.5))
    assert result.value > result.threshold


@pytest.mark.parametrize(("load", "closes"), [(0.8, True), (1.2, False)])
def test_its_loops_close_only_while_it_is_a_spring(load, closes):
    x1 = load * 0.9 * F_C / STIFFNESS
    result = closure_of(elastoplastic(0.9), (x1, 0.5 * x1))
    assert result.passed is closes


def test_below_its_threshold_it_has_no_hysteresis():
    reach = 0.8 * F_C / STIFFNESS
    x, force = traced(elastoplastic(0.9), Path.to_position, [reach, -reach, reach])
    assert np.max(np.abs(force - STIFFNESS * x)) < 1e-12
