"""Control laws in files: gains in the units of the drive."""

import math
import tomllib

import pytest

from bristle.core import Axis, Column, InputError
from bristle.files.axis import axis_from
from bristle.files.components import controller_from


def axis(base: str, scale: float, kind="translational", **gains):
    column = Column("u", base, base, scale)
    return {"model": "cascade", "k_p": 160.18, **gains}, Axis(kind=kind, columns={"effort": column})


def controller_of(table, of_axis):
    return controller_from(table, kind=of_axis.kind, axis=of_axis, path="controller")


@pytest.mark.parametrize(
    ("found", "k_v", "limit"),
    [
        (axis("V", 35.0, k_v="200 V*s/m", limit="10 V"), 7000.0, 350.0),
        (axis("V", -35.0, k_v="0.2 V*s/mm", limit="10000 mV"), 7000.0, 350.0),
        (axis("V", 35.0, k_v="7 N*s/mm", limit="350 N"), 7000.0, 350.0),
        (axis("V", 35.0, k_v=7000.0), 7000.0, math.inf),
        (axis("A", 0.12, "rotational", k_v="2 A*s/rad", limit="5 A"), 0.24, 0.6),
        (axis("rated", 2.4, "rotational", k_v=0.1, limit="50 %"), 0.1, 1.2),
        (axis("N", 1.0, k_v="7 N*s/mm"), 7000.0, math.inf),
    ],
)
def test_gains_of_the_drive_become_si(found, k_v, limit):
    law = controller_of(*found)
    assert law.values["k_v"] == pytest.approx(k_v, rel=1e-12)
    assert law.values["limit"] == pytest.approx(limit, rel=1e-12)
    assert law.values["k_p"] == 160.18
    assert law.kind == found[1].kind


SCREW = """
schema = 1
kind = "translational"
columns.position = { column = "q", unit = "rev", side = "motor" }
columns.effort = { column = "i", unit = "A" }
effort.torque_constant = "0.5 N*m/A"
transmission = { gear_ratio = 2, lead = "10 mm" }
controller = { model = "cascade", k_p = "60 1/s", k_v = "12 A*s/rad", k_i = "6 A/rad", limit = "8 A" }
"""


def test_an_inertia_may_be_an_effort_of_the_drive_per_acceleration():
    column = Column("u", "A", "A", 0.12)
    table = {"model": "sliding_mode", "J": "2 A*s^2/rad", "lambda": "10 1/s", "K_1": "10 1/s"}
    assert controller_of(table, Axis(kind="rotational", columns={"effort": column})).values["J"] == pytest.approx(0.24)


def test_gains_for_an_angle_of_the_motor_go_through_gear_and_lead():
    law = axis_from(tomllib.loads(SCREW)).controller
    travel = 0.01 / (2 * 2 * math.pi)  # of the carriage for one radian of the motor [m]
    assert law.values["k_v"] == pytest.approx(12.0 * 0.5 / travel / travel, rel=1e-12)
    assert law.values["k_i"] == pytest.approx(6.0 * 0.5 / travel / travel, rel=1e-12)
    assert law.values["limit"] == pytest.approx(8.0 * 0.5 / travel, rel=1e-12)


def test_a_gain_for_the_motor_angle_is_independent_of_the_position_unit():
    by_angle, by_scale = (axis_from(tomllib.loads(text)) for text in (SCREW, SCREW.replace('unit = "rev", side = "motor"', 'unit = "mm"')))
    assert by_scale.controller.values["k_v"] == pytest.approx(by_angle.controller.values["k_v"], rel=1e-12)


def test_a_gain_in_the_torque_of_the_motor_goes_through_gear_and_lead():
    # Power: k_v v_m w_m on the motor is k_v' v v on the axis, with v = w_m lead/(2 pi gear).
    for unit in ("rev", "mm"):
        text = SCREW.replace('"12 A*s/rad"', '"0.03 N*m*s/rad"').replace('"rev", side = "motor"', f'"{unit}"')
        if unit == "rev":
            text = text.replace('unit = "rev"', 'unit = "rev", side = "motor"')
        result = axis_from(tomllib.loads(text)).controller.values["k_v"]
        travel = 0.01 / (2 * 2 * math.pi)
        assert result * travel**2 == pytest.approx(0.03, rel=1e-12)


def test_an_integral_time_is_a_gain():
    text = SCREW.replace('k_i = "6 A/rad"', 'T_n = "20 ms"')
    values = axis_from(tomllib.loads(text)).controller.values
    assert values["k_i"] * 0.02 == pytest.approx(values["k_v"], rel=1e-12)
    with pytest.raises(InputError, match=r"controller\.T_n: sets the integral gain, but k_i sets it too"):
        axis_from(tomllib.loads(text.replace("T_n =", "k_i = 5.0, T_n =")))
    off = axis_from(tomllib.loads(text.replace('"20 ms"', "0.0"))).controller.values
    assert off["k_i"] == 0.0


def test_a_unit_of_neither_is_refused():
    with pytest.raises(InputError, match=r"controller\.k_v.*N\*s/m"):
        controller_of(*axis("V", 35.0, k_v="200 A*s/m"))
