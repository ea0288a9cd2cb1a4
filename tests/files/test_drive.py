"""From the units of a drive to SI of its axis, one rule at a time."""

import math

import pytest

from bristle.core.errors import InputError
from bristle.core.motion import Transmission
from bristle.files.axis import axis_from
from bristle.files.drive import Constant, Drive, Scale, refuse_misspelt, with_kind

LINEAR, TURNING = Transmission("translational", 1.0, 0.01), Transmission("rotational", 5.0, None)


@pytest.mark.parametrize(
    ("text", "effort", "expected"),
    [
        ("61.2 N/A", None, ("A", "N", 61.2)),
        ("0.12 N*m/A", None, ("A", "N*m", 0.12)),
        ("120 mN*m/V", None, ("V", "N*m", 0.12)),
        ("2 N/%", None, ("rated", "N", 200.0)),
        ("2 N/count", "N", ("count", "N", 2.0)),
    ],
)
def test_the_unit_of_a_constant_decides_between_force_and_torque(text, effort, expected):
    item = Constant.of(text, effort, "effort.constant")
    assert (item.drive, item.effort, item.value) == (*expected[:2], pytest.approx(expected[2]))


@pytest.mark.parametrize(
    ("text", "effort", "words"),
    [
        ("0 N/A", None, "must be finite and not zero"),
        ("3 N", None, "is not a drive constant.*a force or torque per unit of the drive"),
        ("3 N*m/A", "N", "a value in N/V, N/A, N/% or N/count"),
    ],
)
def test_invalid_constants_are_refused(text, effort, words):
    with pytest.raises(InputError, match=words):
        Constant.of(text, effort, "effort.constant")


OF_TORQUE, TURN = Constant("A", "N*m", 0.5), 2.0 * math.pi / 0.01


@pytest.mark.parametrize(
    ("drive", "unit", "side", "base", "factor"),
    [
        (Drive(LINEAR, OF_TORQUE), None, None, "A", 0.5 * TURN),
        (Drive(LINEAR, OF_TORQUE), "mA", None, "A", 0.5 * TURN),
        (Drive(LINEAR, OF_TORQUE), "kN", None, "N", 1.0),
        (Drive(LINEAR, OF_TORQUE), "N*m", None, "N*m", TURN),
        (Drive(LINEAR), None, None, "N", 1.0),
        (Drive(TURNING, OF_TORQUE), "A", None, "A", 2.5),  # of the motor, before the gear
        (Drive(TURNING, OF_TORQUE), "A", "load", "A", 0.5),
        # A share of the rated effort is one of the motor.
        (Drive(TURNING, rated="2 N*m"), "%", None, "rated", 10.0),
        (Drive(TURNING, rated="2 N*m"), "%", "load", "rated", 2.0),
        (Drive(LINEAR, rated="120 N"), "%", None, "rated", 120.0),
        (Drive(TURNING, OF_TORQUE, "3 A"), "%", None, "rated", 7.5),
    ],
)
def test_an_effort_is_carried_to_the_axis(drive, unit, side, base, factor):
    assert drive.effort(unit, side, "x") == Scale(base, pytest.approx(factor))


@pytest.mark.parametrize(
    ("drive", "unit", "words"),
    [
        (
            Drive(LINEAR),
            "A",
            r"x: needs a drive constant, which converts it to a force or torque.*constant = \"0\.12 N\*m/A\"",
        ),
        (
            Drive(LINEAR),
            "%",
            r"x: needs a drive constant, which converts it to a force or torque.*rated = \"2\.4 N\*m\"",
        ),
        (Drive(LINEAR), "mm", "x: is not a unit of effort"),
        (
            Drive(LINEAR, Constant("A", "N", 1.0)),
            "V",
            "x: does not match the constant under .effort..*A or a multiple",
        ),
        (Drive(LINEAR, rated="30 %"), "%", "effort.rated: is not an effort"),
        (Drive(LINEAR, rated="30"), "%", "effort.rated: is not an effort"),
        (Drive(LINEAR, rated="0 N"), "%", "effort.rated: must be finite and not zero"),
    ],
)
def test_invalid_efforts_are_refused(drive, unit, words):
    with pytest.raises(InputError, match=words):
        drive.effort(unit, None, "x")


@pytest.mark.parametrize(
    ("drive", "unit", "side", "per", "base", "factor"),
    [
        (Drive(LINEAR), "um", None, "", "m", 1.0),
        (Drive(LINEAR), "rad", "motor", "", "rad", 0.01 / (2.0 * math.pi)),
        (Drive(LINEAR), None, None, "/s", "m/s", 1.0),
        (Drive(TURNING), "deg/s", "motor", "/s", "rad/s", 0.2),
        (Drive(LINEAR, count=2e-6), "count", None, "", "count", 2e-6),
        (Drive(LINEAR, count=2e-6), "count/s", None, "/s", "count/s", 2e-6),
    ],
)
def test_a_movement_is_carried_to_the_axis(drive, unit, side, per, base, factor):
    assert drive.movement(unit, side, "x", per=per) == Scale(base, pytest.approx(factor))
    assert Scale("m", 3.0).of("2 mm", "path") == pytest.approx(6e-3)


@pytest.mark.parametrize(
    ("drive", "unit", "side", "words"),
    [
        (Drive(LINEAR), "count", None, "needs the movement of the axis per count"),
        (
            Drive(LINEAR),
            "mm",
            "motor",
            "is a unit of length, but the motor side of a gear is rotational",
        ),
        (Drive(TURNING), "rad", None, "has no key `side`, but a gear has"),
        (Drive(LINEAR), "N", None, "x"),
    ],
)
def test_invalid_movements_are_refused(drive, unit, side, words):
    with pytest.raises(InputError, match=words):
        drive.movement(unit, side, "x")


@pytest.mark.parametrize(
    ("tables", "kind"),
    [
        ({"kind": "other"}, "other"),
        ({"columns": {"position": {"unit": "mm"}}}, "translational"),
        ({"columns": {"position": {"unit": "deg"}}}, "rotational"),
        (
            {"columns": {"position": {"unit": "count"}}, "encoder": {"resolution": "0.1 um/count"}},
            "translational",
        ),
        ({"encoder": {"resolution": "0.01 deg"}}, "rotational"),
        (
            {"encoder": {"resolution": "x y z"}, "columns": {"velocity": {"unit": "rpm"}}},
            "rotational",
        ),
        (
            {"encoder": {"resolution": 3}, "columns": {"velocity": {"unit": "mm/s"}}},
            "translational",
        ),
        ({"columns": {"velocity": {"unit": "m/min"}}}, "translational"),
        ({"encoder": {"counts_per_rev": 4096}}, "rotational"),
        ({"encoder": {"counts_per_rev": 4096}, "transmission": {"lead": "5 mm"}}, "translational"),
        ({"columns": {"position": "x"}}, None),
        ({}, None),
    ],
)
def test_units_speak_of_a_kind_of_axis(tables, kind):
    assert with_kind(tables) == (tables if kind is None else {**tables, "kind": kind})


BASE = {"schema": 1, "kind": "rotational", "columns": {"position": "q", "effort": "u"}}


def channel(name, plant=None, **entry):
    """A further column of an axis."""
    data = (
        BASE
        | {"columns": BASE["columns"] | {name: {"column": "c", **entry}}}
        | ({"plant": plant} if plant else {})
    )
    return axis_from(data).columns[name]


@pytest.mark.parametrize(
    ("name", "plant", "entry", "expected"),
    [
        # A load counts in multiples of the nominal load, and temperatures are absolute.
        (
            "load",
            {"nominal_load": "500 N"},
            {"unit": "kN", "sign": -1},
            ("kN", "N", pytest.approx(-1.0 / 500.0), 0.0),
        ),
        ("load", {"nominal_load": "500 N"}, {}, ("", "N", pytest.approx(1.0 / 500.0), 0.0)),
        *(
            ("temperature", None, {"unit": unit}, ("", "", 1.0, 273.15))
            for unit in ("degC", "°C", "celsius")
        ),
        ("temperature", None, {"unit": "K"}, ("K", "K", 1.0, 0.0)),
        ("oil", None, {"unit": "bar", "sign": -1}, ("bar", "kg/m/s^2", -1.0, 0.0)),
    ],
)
def test_further_channels_are_in_si_or_multiples_of_their_nominal_value(
    name, plant, entry, expected
):
    column = channel(name, plant, **entry)
    assert (column.unit, column.base, column.scale, column.shift) == expected


@pytest.mark.parametrize(
    ("name", "plant", "entry", "words"),
    [
        ("load", None, {}, r"plant\.nominal_load.*is missing"),
        ("load", {"nominal_load": "0 N"}, {}, r"plant\.nominal_load.*must be positive and finite"),
        ("load", {"nominal_load": "5 N"}, {"unit": "mm"}, r"columns\.load\.unit"),
        ("temperature", None, {"unit": "mm"}, r"columns\.temperature\.unit"),
        (
            "temperature",
            None,
            {"unit": "degF"},
            r"columns\.temperature\.unit.*has a zero point that bristle cannot convert.*degC",
        ),
        (
            "oil",
            None,
            {},
            r'columns\.oil.*unknown key.*A further channel.* needs a unit: oil = \{ column = "c", unit = "%" \}',
        ),
        ("oil", None, {"unit": "barr"}, r"columns\.oil\.unit: is not a unit"),
        ("oil", None, {"unit": "bar", "side": 3}, r"columns\.oil\.side"),
        ("oil", None, {"unit": "degF"}, "has a zero point that bristle cannot convert"),
        (
            "positon",
            None,
            {"unit": "mm"},
            r"columns\.positon: unknown key.*Did you mean 'position'",
        ),
    ],
)
def test_invalid_columns_are_refused(name, plant, entry, words):
    with pytest.raises(InputError, match=words):
        channel(name, plant, **entry)


def test_a_name_near_to_a_known_column_is_refused():
    refuse_misspelt({"position": 1, "position_2": 2, "oil": 3})
    refuse_misspelt(3)
    with pytest.raises(InputError, match="Did you mean 'effort'"):
        refuse_misspelt({"efort": 1})
