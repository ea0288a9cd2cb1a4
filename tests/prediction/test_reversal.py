"""How far a reversal goes before friction has turned, against the exponential that a bristle follows."""

import math

import pytest

from bristle.friction import coulomb, lugre
from bristle.prediction.drive_table import reversal_distance


@pytest.mark.parametrize("stiffness", [1e6, 1e8])
def test_the_change_after_a_reversal_counts_from_the_force_before_it(stiffness):
    # From -F to F the force is F (1 - 2 exp(-x sigma_0 / F)): 5 % of the change of 2 F is left after ln 20, of F alone after ln 40.
    model = lugre(F_C=10.0, F_S=10.0, v_S=1e-3, sigma_0=stiffness, sigma_1=0.0, sigma_2=0.0)
    assert reversal_distance(model, 0.1) == pytest.approx(math.log(20.0) * 10.0 / stiffness, rel=0.1)


def test_a_model_without_memory_reverses_at_once():
    assert reversal_distance(coulomb(F_C=10.0), 0.1) == 0.0


def test_a_contact_is_followed_for_a_tenth_of_a_metre():
    # A spring that hardly yields over that: 95 % of the change are there after 95 % of the way.
    assert reversal_distance(lugre(F_C=1e4, F_S=1e4, v_S=1.0, sigma_0=1e2), 0.1) == pytest.approx(0.095, rel=0.01)
