"""Objects of an AX8000: a spring that slips, viscous friction, and both at the motor behind a gear."""

import numpy as np
import pytest
from tests.exports import drives
from tests.exports.drives import ARM

import bristle as br
from bristle.exports import ax8000
from bristle.exports.ax8000 import reads, write
from bristle.exports.drive import levels_and_curves
from bristle.exports.targets import Request
from bristle.prediction.drive_table import LevelValues

RISING = br.friction.coulomb_viscous(F_C=8.0, F_v=30.0)
SOFT = br.friction.dahl(F_C=8.0, sigma_0=4e5)
SCREW = br.read_axis(drives.SCREW)


def request_for(model, axis=None):
    return Request(model, "axis_x", 1e-3, speed=0.2, axis=axis)


def objects(model, axis=None):
    product = write(request_for(model, axis))
    lines = [line.split(",") for line in product.files["axis_x.csv"].splitlines() if line.startswith("0x")]
    return {index: (float(value), unit) for index, value, unit, _ in lines}, product


def test_a_model_without_presliding_has_level_and_slope_but_no_spring():
    values, product = objects(RISING)
    assert values == {"0x3144:02": (pytest.approx(8.0), "N"), "0x3144:03": (pytest.approx(30.0, rel=1e-6), "N*s/m")}
    assert any("0x3144:01 is not written" in note for note in product.notes)


def test_the_spring_turns_95_per_cent_over_the_presliding_distance():
    values, product = objects(SOFT)
    # Of a bristle that slips exponentially 5 % of the change are left after ln 20 of F_C over its stiffness.
    distance = np.log(20.0) * 8.0 / 4e5
    assert values["0x3144:01"] == (pytest.approx(0.95 * 2.0 * 8.0 / distance, rel=0.1), "N/m")
    assert any("95 % of the friction reverses" in note for note in product.notes)


def test_with_a_gear_the_objects_are_motor_torques():
    for model in (RISING, SOFT):
        plain, at_motor = objects(model)[0], objects(model, SCREW)[0]
        for index, power in (("0x3144:02", 1), ("0x3144:03", 2), ("0x3144:01", 2)):
            if index in plain:
                assert at_motor[index][0] == pytest.approx(plain[index][0] * ARM**power, rel=1e-6)
    assert [objects(SOFT, SCREW)[0][f"0x3144:0{k}"][1] for k in (1, 2, 3)] == ["N*m/rad", "N*m", "N*m*s/rad"]


def test_objects_are_the_mean_of_both_directions_and_notes_state_the_difference():
    pushing = br.friction.with_slots(br.friction.coulomb_viscous, ["asymmetry"])(
        F_C_pos=9.0, F_C_neg=5.0, F_v_pos=3.0, F_v_neg=1.0, offset=2.0
    )
    values, product = objects(pushing)
    assert values["0x3144:02"][0] == pytest.approx(7.0)
    assert values["0x3144:03"][0] == pytest.approx(2.0, rel=1e-6)
    text = " ".join(product.notes)
    assert "wrong by 2 N in each" in text
    assert "do not contain the constant force of 2 N" in text
    assert "constant force" not in " ".join(objects(RISING)[1].notes)
    assert "wrong by" not in " ".join(objects(RISING)[1].notes)


@pytest.mark.parametrize("axis", [None, SCREW])
def test_the_drive_turns_the_spring_between_both_levels(axis):
    request = request_for(SOFT, axis)
    drive = reads(write(request).files, request)
    dt, spring = 1e-3, 0.95 * 16.0 / (np.log(20.0) * 8.0 / 4e5)
    x = np.concatenate([[0.0, 1e-5, 2e-5], np.linspace(2e-5, 1e-3, 50)[1:], [1e-3 - 1e-5]])
    force = drive(x, dt)
    assert force[0] == 0.0
    assert force[1:3] == pytest.approx([spring * 1e-5, spring * 2e-5], rel=0.1)
    assert force[-2] == pytest.approx(8.0, rel=1e-6)
    assert force[-1] == pytest.approx(8.0 - spring * 1e-5, rel=0.1)
    assert drive(-x, dt) == pytest.approx(-force)


def test_without_a_spring_a_drive_follows_the_last_direction():
    request = request_for(RISING, SCREW)
    drive = reads(write(request).files, request)
    x, dt = np.array([0.0, 0.0, 1e-4, 2e-4, 2e-4, 1e-4]), 1e-3
    assert drive(x, dt) == pytest.approx([0.0, 0.0, 11.0, 11.0, 8.0, -11.0], rel=1e-6)


def test_a_line_with_negative_intercept_has_no_level(monkeypatch):
    levels = LevelValues(0.0, 0.0, -0.5, -0.3, -2.0, -4.0, 0.0, 0.0)
    monkeypatch.setattr(ax8000, "levels_and_curves", lambda request: (levels_and_curves(request)[0], levels))
    values, _ = objects(SOFT)
    assert values == {"0x3144:02": (0.0, "N"), "0x3144:03": (0.0, "N*s/m")}
