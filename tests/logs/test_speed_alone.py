"""Logs of the speed and no position: the position is the integral of the speed, and what that leaves open is said."""

from __future__ import annotations

import numpy as np
import pytest

from bristle.core import InputError
from bristle.files.axis import axis_from
from bristle.files.proposal import propose_axis
from bristle.identification import identify
from bristle.logs import read_log, summarize
from bristle.report.log import inspect_log

DT, COUNT = 1e-3, 4000
T = DT * np.arange(COUNT)
X = 0.08 * np.sin(4.4 * T) + 0.03 * np.sin(11.9 * T + 0.4)
V = 0.08 * 4.4 * np.cos(4.4 * T) + 0.03 * 11.9 * np.cos(11.9 * T + 0.4)
A = -0.08 * 4.4**2 * np.sin(4.4 * T) - 0.03 * 11.9**2 * np.sin(11.9 * T + 0.4)
F = 12.0 * A + 40.0 * V + 18.0 * np.tanh(V / 2e-3)
SPEED = {
    "velocity": {"column": "speed", "unit": "mm/s"},
    "effort": {"column": "force", "unit": "N"},
}


def log(time=T, **more):
    columns = {"time [s]": time, "speed [mm/s]": 1e3 * V, "force [N]": F, **more}
    rows = [";".join(f"{cell:.7f}" for cell in row) for row in np.column_stack([*columns.values()])]
    return "\n".join([";".join(columns), *rows, ""]).encode()


def axis(**columns):
    return axis_from(
        {"schema": 1, "kind": "translational", "columns": {"time": "time", **SPEED, **columns}}
    )


def test_friction_and_inertia_are_those_of_the_axis():
    estimates = identify(
        read_log(log(), axis()), "coulomb_viscous", axis=axis(), draws=0
    ).best.estimates
    found = {estimate.name: estimate.value for estimate in estimates if estimate.name != "offset"}
    assert found == pytest.approx({"M": 12.0, "F_C": 18.0, "F_v": 40.0}, rel=0.02)


def test_a_motor_that_turns_is_read_by_its_gear_and_lead():
    described = axis_from(
        {
            "schema": 1,
            "kind": "translational",
            "transmission": {"lead": "10 mm", "gear_ratio": 2.0},
            "columns": {
                "time": "time",
                "velocity": {"column": "speed", "unit": "rpm", "side": "motor"},
            },
        }
    )
    turning = log().replace(b"speed [mm/s]", b"speed [rpm]")
    np.testing.assert_allclose(
        read_log(turning, described).position.values, (X - X[0]) * 1e3 / 60 * 0.01 / 2, atol=1e-7
    )


def test_an_axis_file_is_proposed_and_the_log_looked_at():
    inspected = inspect_log(log())
    assert 'velocity = { column = "speed", unit = "mm/s" }' in inspected.proposal.text
    assert (inspected.proposal.missing, set(inspected.proposal.axis.columns)) == (
        (),
        {"time", "velocity", "effort"},
    )
    assert [channel["name"] for channel in inspected.summary["channels"]] == [
        "time",
        "position",
        "velocity",
        "effort",
    ]
    assert inspected.summary["passages"]
    counted = propose_axis(log().replace(b"mm/s", b"count/s"))
    assert counted.missing == ("encoder.resolution",)
    assert inspect_log(log().replace(b"mm/s", b"Skt/s")).log is None


def test_a_speed_that_is_only_asked_for_is_no_motion():
    with pytest.raises(InputError, match="has no column that bristle recognises as the position"):
        propose_axis(log().replace(b"speed", b"speed_setpoint"))


def test_without_an_axis_file_a_usual_name_will_do():
    result = summarize(log().replace(b"speed", b"velocity"))
    assert result["problems"] == []
    assert "position" in [channel["name"] for channel in result["channels"]]
