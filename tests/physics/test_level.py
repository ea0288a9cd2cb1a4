"""Slots that raise the level of dry friction: by an effort, by the angle of a screw, and no viscous part of it."""

import math

import pytest

from bristle import friction
from bristle.engine import force_along
from bristle.friction.level import Rise, has_level, risen, rises_with_effort, share_at, viscous_of

pytestmark = pytest.mark.usefixtures("in_plain_python")


RIPPLE = Rise(pitch=0.2, h_c1=3.0, h_s1=4.0, h_c2=1.0, h_s2=2.0, level=10.0)


@pytest.mark.parametrize(
    ("turn", "level"),
    [(0.0, 3.0 + 1.0), (0.25, 4.0 - 1.0), (0.5, -3.0 + 1.0), (0.75, -4.0 - 1.0), (0.125, 7.0 * math.sqrt(0.5) + 2.0), (1.0, 4.0)],
)
def test_a_ripple_varies_once_and_twice_a_turn_as_a_share_of_the_level(turn, level):
    assert share_at(0.2 * turn, 0.0, RIPPLE) == pytest.approx(0.1 * level)
    assert share_at(0.2 * turn, 0.0, RIPPLE._replace(level=20.0)) == pytest.approx(0.05 * level)


@pytest.mark.parametrize("effort", [30.0, -30.0])
def test_an_effort_of_either_sign_raises_the_level(effort):
    assert share_at(0.3, effort, Rise(c_T=0.1, level=20.0)) == pytest.approx(0.15)


def test_a_level_keeps_a_hundredth_of_its_value():
    assert share_at(0.0, 0.0, Rise(h_c1=-9.9, level=10.0)) == pytest.approx(-0.99)
    assert share_at(0.0, 0.0, Rise(h_c1=-50.0, level=10.0)) == pytest.approx(-0.99)


def test_the_viscous_part_is_unchanged_in_both_directions():
    model = friction.find("coulomb_viscous+transmitted")(F_C=20.0, F_v=100.0, c_T=0.1)
    v = [0.1, -0.1]
    assert force_along(model, v, 1e-3).tolist() == pytest.approx([30.0, -30.0])
    assert force_along(model, v, 1e-3, transmitted=50.0).tolist() == pytest.approx([35.0, -35.0])


def test_a_ripple_is_that_of_the_middle_of_the_step():
    model = friction.find("coulomb+ripple")(F_C=20.0, pitch=0.4, h_c1=0.0, h_s1=5.0, h_c2=0.0, h_s2=0.0)
    # A step from 0 to 0.2, and one back from 0.4 to 0.2: their middles are a quarter and three quarters of a turn.
    assert force_along(model, [2.0, -2.0], 0.1, [0.2, 0.2]).tolist() == pytest.approx([25.0, -15.0])


def test_a_model_without_a_level_is_unchanged():
    model = friction.find("viscous+transmitted")(F_v=100.0, c_T=0.1)
    assert force_along(model, [0.1], 1e-3, transmitted=50.0).tolist() == pytest.approx([10.0])
    assert [has_level(friction.MODELS[name]) for name in ("viscous", "coulomb", "lugre")] == [False, True, True]
    assert [viscous_of(friction.MODELS[name]) for name in ("coulomb", "coulomb_viscous", "lugre")] == ["", "F_v", "sigma_2"]


def test_models_that_rise_with_the_effort_are_recognised():
    risen_models = [friction.find(f"coulomb+{slot}") for slot in ("transmitted", "ripple", "load")]
    assert [rises_with_effort(model(**model.example)) for model in risen_models] == [True, False, False]
    assert not rises_with_effort(friction.coulomb(F_C=1.0))
    assert risen(friction.coulomb, ()) is risen(friction.coulomb, ("load",)) is friction.coulomb
    both = risen(friction.coulomb, ("ripple", "transmitted"))
    assert both.name == "coulomb+transmitted+ripple"
    assert both.description.endswith("rising with the effort transmitted to the load and the angle of the screw")
    assert [key for key in both.variables if key not in both.defaults] == ["F_C", "pitch"]
