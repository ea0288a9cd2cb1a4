"""Gear and lead against numbers worked out by hand."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, strategies as st

from bristle.core.errors import InputError
from bristle.core.motion import RECORDED, Motion, Reference, Transmission


@pytest.mark.parametrize(
    ("train", "measured", "side", "travel"),
    [
        # A screw of 5 mm lead: a quarter turn moves the carriage by 1.25 mm.
        (Transmission("translational", lead=0.005), "rotational", "load", 0.00125 / (math.pi / 2)),
        # Behind a gear of 4:1 the motor makes a whole turn for it.
        (Transmission("translational", 4.0, 0.005), "rotational", "motor", 0.00125 / (2 * math.pi)),
        (Transmission("translational", 4.0, 0.005), "rotational", "load", 0.00125 / (math.pi / 2)),
        (Transmission("translational", 4.0, 0.005), "translational", "load", 1.0),
        # A joint behind a harmonic drive of 100:1.
        (Transmission("rotational", 100.0), "rotational", "motor", 0.01),
        (Transmission("rotational", 100.0), "rotational", "load", 1.0),
        # A screw told as an angle, its carriage measured by a linear scale: 2.5 mm is half a turn.
        (Transmission("rotational", lead=0.005), "translational", "load", math.pi / 0.0025),
    ],
)
def test_travel_by_hand(train, measured, side, travel):
    assert train.travel(measured, side) == pytest.approx(travel, rel=1e-14)


@pytest.mark.parametrize(
    ("train", "side", "effort"),
    [
        # 1 N*m on a screw of 5 mm lead lifts 1256.6 N; through a gear of 4:1 the motor needs a quarter of it.
        (Transmission("translational", lead=0.005), "load", 1256.637),
        (Transmission("translational", 4.0, 0.005), "motor", 5026.548),
        (Transmission("rotational", 100.0), "motor", 100.0),
    ],
)
def test_effort_by_hand(train, side, effort):
    assert train.effort("rotational", side) == pytest.approx(effort, abs=1e-3)


@given(
    kind=st.sampled_from(["translational", "rotational"]),
    measured=st.sampled_from(["translational", "rotational"]),
    side=st.sampled_from(["motor", "load"]),
    gear=st.floats(0.01, 200),
    lead=st.floats(1e-4, 1),
)
def test_no_power_is_lost(kind, measured, side, gear, lead):
    train = Transmission(kind, gear, lead)
    velocity, effort = 3.0, 7.0
    power = velocity * train.travel(measured, side) * effort * train.effort(measured, side)
    assert power == pytest.approx(velocity * effort, rel=1e-12)


def test_an_angle_gives_a_travel_only_with_a_lead():
    with pytest.raises(InputError, match='lead = "5 mm"'):
        Transmission("translational").travel("rotational")


def test_a_motion_without_surroundings_is_under_its_nominal_load_at_room_temperature():
    motion = Motion(1.0, 2.0)
    assert (motion.load, motion.transmitted) == (1.0, 0.0)  # a load is told over its nominal value
    assert motion.temperature == pytest.approx(20.0 + 273.15)
    assert Reference(0.0, 0.0, 0.0).effort == 0.0
    assert set(RECORDED) == {"load", "temperature"}
