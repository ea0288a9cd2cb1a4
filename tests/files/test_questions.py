"""What a proposed axis file asks for: the travel for a turn of the motor, and the controller."""

import math

import numpy as np
import pytest

import bristle as br
from bristle.files.axis import read_axis
from bristle.files.proposal import propose_axis


@pytest.fixture
def screw_log(tmp_path):
    """A log in mm and per cent of a rated torque, with its reference."""
    t = 1e-3 * np.arange(3000)
    x = 40.0 * np.sin(3.0 * t)
    rows = np.column_stack([t, x, x + 0.1, 5.0 * np.sign(np.cos(3.0 * t))])
    path = tmp_path / "stage.csv"
    np.savetxt(path, rows, delimiter=",", header="time [s],position [mm],reference [mm],torque [N*m]", comments="")
    return path


def test_the_travel_is_that_for_a_turn_of_the_motor_or_gear_and_screw_apart(screw_log, tmp_path):
    text = propose_axis(screw_log).text
    (line,) = [line for line in text.splitlines() if line.startswith("lead")]
    assert "per turn of the motor" in line
    assert "gear_ratio" in line
    by_motor, by_screw = tmp_path / "motor.toml", tmp_path / "screw.toml"
    by_motor.write_text(text.replace('lead = "?"', 'lead = "10 mm"'))
    geared = text.replace('lead = "?"', 'gear_ratio = 2.0\nlead = "20 mm"')
    by_screw.write_text(geared.replace("effort = { column", 'effort = { side = "motor", column'))
    arms = [read_axis(path).arm for path in (by_motor, by_screw)]
    assert arms == pytest.approx([0.01 / (2.0 * math.pi)] * 2)


def test_the_controller_is_asked_for_where_there_is_a_reference(screw_log, tmp_path):
    text = propose_axis(screw_log).text
    for key in ("[controller]", "k_p", "k_v", "k_i", "k_ff"):
        assert f"# {key}" in text
    answers = {"k_p": "60 1/s", "k_v": "5000 N*s/m", "k_i": "100 kN/m"}
    lines = []
    for line in text.replace('lead = "?"', 'lead = "10 mm"').splitlines():
        key = line.removeprefix("# ").split(" ")[0]
        if key in answers:
            lines.append(f'{key} = "{answers[key]}"')
        elif key in ("[controller]", "model"):
            lines.append(line.removeprefix("# "))
        else:
            lines.append(line)
    path = tmp_path / "axis.toml"
    path.write_text("\n".join(lines))
    assert read_axis(path).controller.values["k_v"] == pytest.approx(5000.0)
    without = tmp_path / "plain.csv"
    rows = np.loadtxt(screw_log, delimiter=",", skiprows=1)[:, [0, 1, 3]]
    np.savetxt(without, rows, delimiter=",", header="time [s],position [mm],torque [N*m]", comments="")
    assert "[controller]" not in propose_axis(without).text
    assert br.read_axis(path).controller is not None
