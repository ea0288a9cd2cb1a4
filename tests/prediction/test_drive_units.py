"""What a parameter is in the units of a log and of a motor: a law of friction says the same in each of them."""

import numpy as np
import pytest

import bristle as br
from bristle.prediction.drive_units import drive_units, log_units, table_units

SCREW = br.read_axis(
    {
        "schema": 1,
        "kind": "translational",
        "columns": {
            "time": {"column": "t", "unit": "s"},
            "position": {"column": "q", "unit": "mm"},
            "effort": {"column": "u", "unit": "%", "side": "motor"},
        },
        "effort": {"rated": "2 N*m"},
        "transmission": {"lead": "10 mm", "gear_ratio": 2.0},
    }
)
BARE = br.read_axis(
    {
        "schema": 1,
        "kind": "translational",
        "columns": {
            "time": {"column": "t", "unit": "s"},
            "position": {"column": "q", "unit": "mm"},
            "velocity": {"column": "v", "unit": "mm/min"},
            "effort": {"column": "u", "unit": "N"},
        },
    }
)
PER_TORQUE = 2.0 * np.pi * 2.0 / 0.01  # N for 1 N*m of the motor
SPEED = 0.03  # m/s


def by_name(quantity, axis=SCREW, kind="translational"):
    return {unit.name: unit for unit in drive_units(axis, kind).of(quantity)}


def test_viscous_friction_is_percent_for_a_turn_a_minute():
    coefficient = 250.0  # N*s/m
    percent = coefficient * SPEED / PER_TORQUE / 2.0 * 100.0
    result = by_name("force*time/length")
    assert result["%/rpm"].of(coefficient) * SPEED / 0.01 * 2.0 * 60.0 == pytest.approx(percent)
    assert result["%/(mm/s)"].of(coefficient) * SPEED * 1e3 == pytest.approx(percent)


def test_stiffness_is_percent_for_a_degree_of_the_motor():
    stiffness, distance = 3e6, 4e-6
    percent = stiffness * distance / PER_TORQUE / 2.0 * 100.0
    result = by_name("force/length")
    assert result["%/deg"].of(stiffness) * distance / 0.01 * 2.0 * 360.0 == pytest.approx(percent)
    assert result["%/mm"].of(stiffness) * distance * 1e3 == pytest.approx(percent)


def test_levels_distances_and_inertia():
    assert by_name("force")["% of rated"].of(PER_TORQUE) == pytest.approx(50.0)
    assert by_name("length")["deg of the motor"].of(0.01) == pytest.approx(720.0)
    assert by_name("length/time")["rpm of the motor"].of(SPEED) == pytest.approx(360.0)
    assert by_name("mass")["kg*m^2 at the motor"].of(7.0) == pytest.approx(7.0 / PER_TORQUE**2)


@pytest.mark.parametrize("quantity", ["1", "time", "1/temperature", "force*temperature"])
def test_what_has_no_length_and_no_force_stays_as_it_is(quantity):
    assert drive_units(SCREW, "translational").of(quantity) == ()


def test_without_an_axis_or_a_motor_there_is_less():
    assert drive_units(None, "rotational").of("force") == ()
    assert set(by_name("force", BARE)) == set()
    assert set(by_name("force/length", BARE)) == {"N/mm"}


def test_a_column_of_velocity_tells_its_own_unit():
    assert log_units(BARE, "translational").velocity.name == "mm/min"
    assert table_units(BARE, "translational").drive is None
    assert log_units(BARE, "translational").velocity.of(SPEED) == pytest.approx(1800.0)
