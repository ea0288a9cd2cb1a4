"""Slots that raise the level of dry friction: by an effort, by the angle of a screw, and no viscous part of it."""

import math

import pytest

from bristle import friction
from bristle.models.friction.level import (
    Rise,
    has_level,
    risen,
    rises_with_effort,
    share_at,
    viscous_of,
)

RIPPLE = Rise(pitch=0.2, h_c1=3.0, h_s1=4.0, h_c2=1.0, h_s2=2.0, level=10.0)


@pytest.mark.parametrize(
    ("turn", "level"),
    [
        (0.0, 3.0 + 1.0),
        (0.25, 4.0 - 1.0),
        (0.5, -3.0 + 1.0),
        (0.75, -4.0 - 1.0),
        (0.125, 7.0 * math.sqrt(0.5) + 2.0),
        (1.0, 4.0),
    ],
)
def test_a_ripple_varies_once_and_twice_a_turn_as_a_share_of_the_level(turn, level):
    assert share_at(0.2 * turn, 0.0, RIPPLE) == pytest.approx(0.1 * level)
    assert share_at(0.2 * turn, 0.0, RIPPLE._replace(level=20.0)) == pytest.approx(0.05 * level)


@pytest.mark.parametrize(
    ("effort", "rise", "share"),
    [
        *((effort, Rise(c_T=0.1, level=20.0), 0.15) for effort in (30.0, -30.0)),
        # A level keeps a hundredth of its value.
        *((0.0, Rise(h_c1=ripple, level=10.0), -0.99) for ripple in (-9.9, -50.0)),
    ],
)
def test_an_effort_of_either_sign_raises_the_level_and_no_ripple_takes_it_away(effort, rise, share):
    assert share_at(0.0, effort, rise) == pytest.approx(share)


@pytest.mark.parametrize(
    ("name", "level", "viscous", "rises"),
    [
        ("viscous", False, "F_v", False),
        ("coulomb", True, "", False),
        ("coulomb_viscous", True, "F_v", False),
        ("lugre", True, "sigma_2", False),
        ("coulomb+transmitted", True, "", True),
        ("coulomb+ripple", True, "", False),
        ("coulomb+load", True, "", False),
    ],
)
def test_dry_and_viscous_parts_and_what_rises_with_the_effort_are_recognised(
    name, level, viscous, rises
):
    base = friction.MODELS[name.partition("+")[0]]
    assert (has_level(base), viscous_of(base)) == (level, viscous)
    assert rises_with_effort(friction.find(name)(**friction.find(name).example)) is rises


def test_slots_of_the_level_combine_in_one_order():
    assert risen(friction.coulomb, ()) is risen(friction.coulomb, ("load",)) is friction.coulomb
    both = risen(friction.coulomb, ("ripple", "transmitted"))
    assert both.name == "coulomb+transmitted+ripple"
    assert both.description.endswith(
        "rising with the effort transmitted to the load and the angle of the screw"
    )
    assert [key for key in both.variables if key not in both.defaults] == ["F_C", "pitch"]
