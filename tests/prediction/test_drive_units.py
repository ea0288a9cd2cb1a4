"""What a parameter is in the units of a log and of a motor: a law of friction says the same in each of them."""

import numpy as np
import pytest

from bristle.core.axis import Axis, Column
from bristle.prediction.drive_units import (
    DriveUnit,
    column_signs,
    command_units,
    drive_units,
    log_units,
    table_units,
)


def axis(kind="translational", arm=None, rated=None, **columns):
    """Return an axis whose columns have a unit, a unit in SI and a scale."""
    motor = {name: Column(name, unit, base, scale) for name, (unit, base, scale) in columns.items()}
    return Axis(kind=kind, columns=motor, arm=arm, rated=rated)


def sizes(units):
    return {unit.name: pytest.approx(unit.si) for unit in units}


def test_the_units_of_a_log_are_those_of_its_columns_or_si():
    units = log_units(axis(position=("mm", "m", -1.0), effort=("mN", "N", 2.0)), "translational")
    assert (units.velocity.name, units.velocity.si) == ("mm/s", pytest.approx(1e-3))
    assert (units.effort.name, units.effort.si) == ("mN", pytest.approx(2e-3))
    fed = log_units(axis(velocity=("mm/min", "m/s", 1.0)), "translational")
    assert (fed.velocity.name, fed.velocity.of(0.03)) == ("mm/min", pytest.approx(1800.0))
    bare = log_units(None, "rotational")
    assert (bare.velocity, bare.effort) == (DriveUnit("rad/s", 1.0), DriveUnit("N*m", 1.0))
    assert DriveUnit("mm", 1e-3).of(0.5) == 500.0


def test_a_column_may_run_against_the_axis():
    assert column_signs(None) == (1.0, 1.0)
    assert column_signs(axis(position=("mm", "m", -1.0), effort=("N", "N", 2.0))) == (-1.0, 1.0)
    assert column_signs(
        axis(position=("mm", "m", 1.0), velocity=("m/s", "m/s", -1.0), effort=("N", "N", -2.0))
    ) == (-1.0, -1.0)
    assert column_signs(axis(effort=("N", "N", -2.0))) == (1.0, -1.0)


def test_a_drive_wants_the_units_of_its_log_its_motor_and_percent_of_rated():
    assert drive_units(None, "translational") == (None, "translational", (), (), (), ())
    units = drive_units(
        axis(position=("mm", "m", 1.0), effort=("mN", "N", 1.0), arm=2e-3, rated=50.0),
        "translational",
    )
    # A turn a minute of a motor that moves the table by 2 mm a radian.
    assert sizes(units.velocities) == {"mm/s": 1e-3, "rpm of the motor": 2e-3 * 2.0 * np.pi / 60.0}


def test_percent_of_a_log_is_listed_once():
    rated = axis(position=("m", "m", 1.0), effort=("%", "%", 0.5), rated=50.0)
    assert sizes(drive_units(rated, "translational").efforts) == {"% of rated": 0.5}
    unrated = axis(position=("m", "m", 1.0), effort=("%", "%", 0.5))
    assert sizes(drive_units(unrated, "translational").efforts) == {"%": 0.5}
    assert drive_units(unrated, "translational").velocities == ()


def test_a_command_has_the_signs_of_the_columns_of_the_log():
    assert command_units(None, "translational") is None
    assert command_units(axis(position=("mm", "m", 1.0)), "translational") is None
    command = command_units(
        axis(position=("mm", "m", -1.0), effort=("mN", "N", 2.0), arm=2e-3, rated=50.0),
        "translational",
    )
    assert (command.position.name, command.position.si) == ("mm", pytest.approx(-1e-3))
    assert (command.effort.name, command.effort.si) == ("mN", pytest.approx(2e-3))
    assert sizes(command.others) == {"N*m at the motor": -500.0, "% of rated": -0.5}


def test_a_command_in_another_unit_has_the_sign_of_the_position():
    command = command_units(
        axis(position=("mm", "m", -1.0), effort=("N", "N", 1.0), rated=50.0), "translational"
    )
    assert (command.effort.name, command.effort.si) == ("% of rated", -0.5)
    without = command_units(axis(position=("mm", "m", -1.0), rated=50.0), "translational")
    assert (without.effort.name, without.effort.si) == ("% of rated", -0.5)


def test_a_table_is_in_the_units_of_the_log_and_for_the_drive_in_percent_or_torque():
    units = table_units(
        axis(position=("mm", "m", 1.0), effort=("mN", "N", 1.0), arm=2e-3, rated=50.0),
        "translational",
    )
    assert (units.log.velocity.name, units.log.effort.name) == ("mm/s", "mN")
    assert (units.drive.velocity.name, units.drive.effort.name) == (
        "rpm of the motor",
        "% of rated",
    )
    assert [unit.name for unit in units.efforts] == ["mN", "N*m at the motor", "% of rated"]
    assert sizes(units.inertias) == {"kg": 1.0, "kg*m^2 at the motor": 250_000.0}
    geared = table_units(
        axis(position=("mm", "m", 1.0), effort=("mN", "N", 1.0), arm=2e-3), "translational"
    )
    assert geared.drive.effort.name == "N*m at the motor"
    feed = table_units(axis(position=("mm", "m", 1.0), effort=("N", "N", 1.0)), "translational")
    assert (feed.drive.velocity.name, feed.drive.velocity.of(0.001)) == (
        "mm/min",
        pytest.approx(60.0),
    )
    assert table_units(None, "translational").drive is None
    assert table_units(axis("rotational", position=("deg", "rad", 1.0)), "rotational").drive is None


def test_a_distance_is_in_the_unit_of_the_log_and_in_degrees_of_the_motor():
    assert drive_units(None, "translational").lengths == ()
    assert sizes(
        drive_units(axis(position=("mm", "m", 1.0), arm=2e-3), "translational").lengths
    ) == {"mm": 1e-3, "deg of the motor": 2e-3 * np.pi / 180.0}
    assert drive_units(axis(position=("m", "m", 1.0)), "translational").lengths == ()
    # One degree of the motor is one of the axis.
    assert [
        unit.name
        for unit in drive_units(
            axis("rotational", position=("deg", "rad", 1.0), arm=1.0), "rotational"
        ).lengths
    ] == ["deg"]


@pytest.mark.parametrize(
    ("quantity", "units"),
    [
        ("force/length", {"mN/mm": 1.0, "%/deg": 0.5 / (2e-3 * np.pi / 180.0)}),
        ("force*time/length", {"mN/(mm/s)": 1.0, "%/rpm": 0.5 / (2e-3 * 2.0 * np.pi / 60.0)}),
        (
            "force*time^2/length^2",
            {"mN/(mm/s)^2": 1e3, "%/rpm^2": 0.5 / (2e-3 * 2.0 * np.pi / 60.0) ** 2},
        ),
        ("1/length", {"1/mm": 1e3, "1/deg": 1.0 / (2e-3 * np.pi / 180.0)}),
        ("force/time", {"mN/s": 1e-3, "%/s": 0.5}),
        ("length/time^2", {"mm/s^2": 1e-3, "deg/s^2": 2e-3 * np.pi / 180.0}),
        ("force*length", {"mN*mm": 1e-6, "%*deg": 0.5 * 2e-3 * np.pi / 180.0}),
        ("force", {"mN": 1e-3, "N*m at the motor": 500.0, "% of rated": 0.5}),
        ("length/time", {"mm/s": 1e-3, "rpm of the motor": 2e-3 * 2.0 * np.pi / 60.0}),
        ("length", {"mm": 1e-3, "deg of the motor": 2e-3 * np.pi / 180.0}),
        ("mass", {"kg*m^2 at the motor": 250_000.0}),
        *((quantity, {}) for quantity in ("1", "time", "1/temperature", "force*temperature")),
    ],
)
def test_a_parameter_is_in_the_units_of_the_log_and_of_the_motor(quantity, units):
    motor = axis(position=("mm", "m", 1.0), effort=("mN", "N", 1.0), arm=2e-3, rated=50.0)
    assert sizes(drive_units(motor, "translational").of(quantity)) == units


def test_without_a_motor_there_are_fewer_units():
    assert drive_units(None, "rotational").of("force") == ()
    bare = drive_units(axis(position=("mm", "m", 1.0), effort=("N", "N", 1.0)), "translational")
    assert (bare.of("force"), sizes(bare.of("force/length"))) == ((), {"N/mm": 1e3})


@pytest.mark.parametrize(("arm", "torques"), [(1.0, 0), (1.0 + 1e-10, 0), (0.5, 1), (2.0, 1)])
def test_a_motor_without_a_gear_has_the_torque_of_the_axis(arm, torques):
    units = drive_units(axis("rotational", arm=arm), "rotational")
    assert len(units.efforts) == len(units.inertias) == torques
    assert [unit.name for unit in units.velocities] == ["rpm of the motor"]
    assert drive_units(axis(arm=1.0), "translational").efforts[0].name == "N*m at the motor"
