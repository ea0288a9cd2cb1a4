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
    assert (law.values["k_v"], law.values["limit"]) == pytest.approx((k_v, limit), rel=1e-12)
    assert (law.values["k_p"], law.kind) == (160.18, found[1].kind)


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
    assert controller_of(table, Axis(kind="rotational", columns={"effort": column})).values[
        "J"
    ] == pytest.approx(0.24)


TRAVEL = 0.01 / (2 * 2 * math.pi)  # of the carriage for one radian of the motor [m]


@pytest.mark.parametrize("position", ['"rev", side = "motor"', '"mm"'])
@pytest.mark.parametrize(
    ("gain", "k_v"),
    [
        ("12 A*s/rad", 12.0 * 0.5),
        # Power: k_v v_m w_m on the motor is k_v' v v on the axis, with v = w_m lead/(2 pi gear).
        ("0.03 N*m*s/rad", 0.03),
    ],
)
def test_gains_for_an_angle_of_the_motor_go_through_gear_and_lead(position, gain, k_v):
    text = SCREW.replace('"rev", side = "motor"', position).replace("12 A*s/rad", gain)
    values = axis_from(tomllib.loads(text)).controller.values
    expected = {"k_v": k_v / TRAVEL**2, "k_i": 6.0 * 0.5 / TRAVEL**2, "limit": 8.0 * 0.5 / TRAVEL}
    assert {name: values[name] for name in expected} == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(("time", "per_gain"), [('"20 ms"', 50.0), ("0.0", 0.0)])
def test_an_integral_time_is_a_gain(time, per_gain):
    values = axis_from(
        tomllib.loads(SCREW.replace('k_i = "6 A/rad"', f"T_n = {time}"))
    ).controller.values
    assert values["k_i"] == pytest.approx(per_gain * values["k_v"], rel=1e-12)


def test_a_unit_of_neither_is_refused():
    with pytest.raises(InputError, match=r"controller\.k_v.*N\*s/m"):
        controller_of(*axis("V", 35.0, k_v="200 A*s/m"))
