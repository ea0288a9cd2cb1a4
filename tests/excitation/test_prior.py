"""What is believed of an axis: the distance over which friction turns, from any model."""

import math
from dataclasses import replace

import pytest
from tests.excitation.axes import STAGE

from bristle.excitation.limits import prior_of, turning_distance
from bristle.friction import coulomb_viscous, lugre, maxwell_slip


def test_a_bristle_turns_over_four_of_its_lengths():
    # Slowly, the deflection of a bristle approaches its new side as exp(-x / z): 2 % are left after ln 50 lengths.
    model = lugre(F_C=20.0, F_S=25.0, v_S=1e-3, sigma_0=5e6, sigma_1=1e3, sigma_2=100.0)
    assert turning_distance(model) == pytest.approx(0.5 * math.log(50.0) * 25.0 / 5e6, rel=0.02)


def test_sliders_turn_over_twice_the_longest_stretch():
    model = maxwell_slip(F_C=20.0, k_i=[20.0 / 7e-6], nu_i=[1.0])
    assert turning_distance(model) == pytest.approx(7e-6, rel=0.03)


def test_a_static_map_turns_at_once():
    assert turning_distance(coulomb_viscous(F_C=20.0, F_v=1.0)) is None


def test_a_model_made_of_limits_turns_over_the_distance_of_the_axis_file():
    prior = prior_of(STAGE)
    assert prior.presliding == STAGE.presliding
    assert turning_distance(prior.friction) == pytest.approx(7e-6, rel=0.02)
    assert any("Coulomb friction" in item for item in prior.assumed)


def test_a_static_model_is_given_the_distance_of_the_axis_file():
    prior = prior_of(STAGE, None, coulomb_viscous(F_C=20.0, F_v=1.0))
    assert turning_distance(prior.friction) == pytest.approx(7e-6, rel=0.02)
    assert prior.resonance == pytest.approx(math.sqrt(prior_stiffness(prior) / 28.0) / (2.0 * math.pi), rel=0.01)


def prior_stiffness(prior):
    return 20.0 * 0.5 * math.log(50.0) / 7e-6


def test_the_resonance_is_not_known_without_a_mass():
    assert prior_of(replace(STAGE, mass=None)).resonance is None
