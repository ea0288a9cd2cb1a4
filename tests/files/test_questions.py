"""What a proposed axis file asks for: the travel for a turn of the motor, and the controller."""

import math
import re

import numpy as np
import pytest

from bristle.files.axis import read_axis
from bristle.files.proposal import propose_axis


@pytest.fixture
def screw_log(tmp_path):
    """A log in mm and per cent of a rated torque, with its reference."""
    t = 1e-3 * np.arange(3000)
    x = 40.0 * np.sin(3.0 * t)
    rows = np.column_stack([t, x, x + 0.1, 5.0 * np.sign(np.cos(3.0 * t))])
    path = tmp_path / "stage.csv"
    np.savetxt(
        path,
        rows,
        delimiter=",",
        header="time [s],position [mm],reference [mm],torque [N*m]",
        comments="",
    )
    return path


@pytest.mark.parametrize(
    ("lead", "side"),
    [('lead = "10 mm"', ""), ('gear_ratio = 2.0\nlead = "20 mm"', 'side = "motor", ')],
)
def test_the_travel_is_that_for_a_turn_of_the_motor_or_gear_and_screw_apart(screw_log, lead, side):
    text = propose_axis(screw_log).text
    assert re.search("(?m)^lead = .*per turn of the motor.*gear_ratio", text)
    filled = text.replace('lead = "?"', lead).replace(
        "effort = { column", f"effort = {{ {side}column"
    )
    assert read_axis(filled.encode()).arm == pytest.approx(0.01 / (2.0 * math.pi))


def test_the_controller_is_asked_for_where_there_is_a_reference(screw_log, tmp_path):
    text = propose_axis(screw_log).text
    assert [
        key for key in ("[controller]", "k_p", "k_v", "k_i", "k_ff") if f"# {key}" not in text
    ] == []
    answers = {"k_p": "60 1/s", "k_v": "5000 N*s/m", "k_i": "100 kN/m"}
    filled = re.sub(
        r"(?m)^# (\[controller\]|model = )", r"\1", text.replace('lead = "?"', 'lead = "10 mm"')
    )
    for key, value in answers.items():
        filled = re.sub(rf"(?m)^# {key} = .*$", f'{key} = "{value}"', filled)
    assert read_axis(filled.encode()).controller.values["k_v"] == pytest.approx(5000.0)
    without = tmp_path / "plain.csv"
    rows = np.loadtxt(screw_log, delimiter=",", skiprows=1)[:, [0, 1, 3]]
    np.savetxt(
        without, rows, delimiter=",", header="time [s],position [mm],torque [N*m]", comments=""
    )
    assert "[controller]" not in propose_axis(without).text
