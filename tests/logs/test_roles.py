"""Which column is which channel: by numbers, where names do not tell."""

import numpy as np
import pytest

from bristle.logs.roles import explained, pulls_as_a_link, rate_of, roles_of, roughness, slope
from bristle.logs.table import Table

TIME = 1e-3 * np.arange(4000)
PHASE = 2.0 * np.pi * TIME
POSITION = 0.1 * np.sin(PHASE) + 0.03 * np.sin(2.7 * PHASE)
VELOCITY = 0.1 * 2.0 * np.pi * np.cos(PHASE) + 0.03 * 2.7 * 2.0 * np.pi * np.cos(2.7 * PHASE)
SPEEDS = [("mm", 1e3, "mm/s"), ("mm", 6e4, "mm/min"), ("rev", 60.0, "rpm"), ("rev", 1.0, "rev/s")]
EFFORT = 5.0 * np.sign(VELOCITY) + 2.0 * VELOCITY


def roles(**columns):
    units = {name: column[1] for name, column in columns.items() if isinstance(column, tuple)}
    values = {name: column[0] if isinstance(column, tuple) else column for name, column in columns.items()}
    return roles_of(Table(values, units, names=tuple(values)))


def units_of(result):
    return {name: role.unit for name, role in result.channels.items()}


def test_the_rate_of_a_signal_is_taken_over_time_and_else_over_samples():
    assert rate_of(3.0 * TIME, TIME)[20:-20] == pytest.approx(3.0)
    assert rate_of(3.0 * TIME, None)[20:-20] == pytest.approx(3e-3)
    assert rate_of(3.0 * TIME, TIME[:-1])[20:-20] == pytest.approx(3e-3)
    assert rate_of(3.0 * TIME, np.zeros(TIME.size))[20:-20] == pytest.approx(3e-3)


def test_the_slope_between_two_signals_is_their_ratio_but_for_a_constant():
    assert slope(POSITION, 7.0 - 3.0 * POSITION) == pytest.approx(-3.0)
    assert slope(np.ones(9), np.arange(9.0)) == 0.0


def test_a_rough_signal_bends_more_than_a_smooth_one_goes():
    rough = np.random.default_rng(1).standard_normal(TIME.size)
    assert roughness(POSITION) < 0.1 < 1.0 < roughness(rough)
    assert roughness(rough) == pytest.approx(3.0**0.5, rel=0.05)  # of white noise: root of 6 over root of 2
    assert roughness(np.ones(30)) == np.inf


def test_motion_explains_inertia_and_friction_and_no_noise():
    assert explained(EFFORT, POSITION) == pytest.approx(1.0, abs=0.05)
    assert explained(np.random.default_rng(1).standard_normal(TIME.size), POSITION) == pytest.approx(0.0, abs=0.02)
    assert explained(np.ones(TIME.size), POSITION) == pytest.approx(1.0)


def test_a_link_pulls_with_sine_and_cosine_of_its_angle_over_a_wide_range():
    angle = 20.0 * POSITION + 0.5
    assert pulls_as_a_link(EFFORT + 20.0 * np.sin(angle), angle)
    assert pulls_as_a_link(EFFORT + 20.0 * np.cos(angle), angle)
    assert not pulls_as_a_link(EFFORT, angle)
    assert not pulls_as_a_link(EFFORT + 20.0 * angle, angle)
    assert not pulls_as_a_link(EFFORT + 20.0 * np.sin(3.0 * POSITION), 3.0 * POSITION)  # [rad]
    assert not pulls_as_a_link((EFFORT + 20.0 * np.sin(angle))[:79], angle[:79])
    assert not pulls_as_a_link(EFFORT[:-1], angle)


def test_columns_are_told_by_names_and_have_the_units_of_the_file():
    result = roles(
        t=(TIME, "s"), pos=(1e3 * POSITION, "mm"), vel=(VELOCITY, "m/s"), force=(EFFORT, "N"), possoll=(1e3 * POSITION + 0.01, "mm")
    )
    assert units_of(result) == {"time": "s", "position": "mm", "velocity": "m/s", "reference": "mm", "effort": "N"}
    assert [result.channels[name].column for name in ("position", "reference")] == ["pos", "possoll"]
    assert result.rivals == ()


@pytest.mark.parametrize(("factor", "unit"), [(1.0, "m"), (1e3, "mm"), (1e6, "um")])
def test_a_recorded_velocity_tells_the_unit_of_the_position(factor, unit):
    result = roles(time=(TIME, "s"), position=factor * POSITION, velocity=(VELOCITY, "m/s"), force=(EFFORT, "N"))
    assert units_of(result)["position"] == unit
    assert result.channels["position"].told_by == "velocity"


@pytest.mark.parametrize(
    ("unit", "factor", "own"), [("mm", 1e3, "mm/s"), ("mm", 6e4, "mm/min"), ("rev", 60.0, "rpm"), ("rev", 1.0, "rev/s")]
)
def test_the_position_tells_the_unit_of_a_velocity_over_seconds_or_minutes(unit, factor, own):
    position = POSITION * (1e3 if unit == "mm" else 1.0)
    result = roles(time=(TIME, "s"), position=(position, unit), velocity=factor * VELOCITY, torque=(EFFORT, "N*m"))
    assert units_of(result)["velocity"] == own
    other = roles(time=(TIME, "s"), position=(position, unit), velocity=1.5 * factor * VELOCITY, torque=(EFFORT, "N*m"))
    assert "velocity" not in other.channels


def test_whole_numbers_are_counts_where_they_are_large():
    counts = np.round(1e5 * POSITION)
    assert units_of(roles(time=(TIME, "s"), position=counts, force=(EFFORT, "N")))["position"] == "count"
    assert units_of(roles(time=(TIME, "s"), position=np.round(500.0 * POSITION), force=(EFFORT, "N")))["position"] == ""
    assert units_of(roles(time=(TIME, "s"), position=1e5 * POSITION, force=(EFFORT, "N")))["position"] == ""


def test_columns_without_names_are_told_by_what_goes_with_the_motion():
    noise = 1e-4 * np.random.default_rng(1).standard_normal(TIME.size)
    result = roles(ch1=TIME, ch2=POSITION, ch3=EFFORT + noise)
    assert {name: role.column for name, role in result.channels.items()} == {"time": "ch1", "position": "ch2", "effort": "ch3"}
    assert result.channels["time"].reason == "it rises evenly"
    assert result.channels["position"].reason == "it is the smoothest"
    assert result.channels["effort"].reason == "it goes with the motion"
    assert roles(ch1=TIME, ch2=POSITION, ch3=np.random.default_rng(1).standard_normal(TIME.size)).channels.keys() == {"time"}


def test_the_speed_alone_is_the_motion_where_no_position_is():
    result = roles(time=(TIME, "s"), speed=(VELOCITY, "m/s"), force=(EFFORT, "N"))
    assert units_of(result) == {"time": "s", "velocity": "m/s", "effort": "N"}
    assert "position" not in result.channels


@pytest.mark.parametrize(
    ("name", "effort", "unit", "told_by"),
    [
        ("motor current", EFFORT, "A", "its name"),
        ("voltage", EFFORT, "V", "its name"),
        ("torque", np.round(100.0 * EFFORT), "‰", "drive"),
        ("torque", np.round(10.0 * EFFORT), "", "rated"),
        ("torque", np.round(1000.0 * EFFORT), "", ""),
        ("torque", EFFORT, "", ""),
    ],
)
def test_the_unit_of_an_effort_is_in_its_name_or_told_by_whole_numbers(name, effort, unit, told_by):
    role = roles(**{"time": (TIME, "s"), "position": (POSITION, "m"), name: effort}).channels["effort"]
    assert (role.unit, role.told_by) == (unit, told_by)
