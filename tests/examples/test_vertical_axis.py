"""A vertical axis behind a gear and a screw: what its drive wants, in percent of rated, is what was put in."""

import numpy as np
import pytest

import bristle as br
from bristle.prediction import drive_table
from bristle.report.model_tables import drive_rows

pytestmark = pytest.mark.slow

# m for a turn, turns of the motor for one of the screw, N*m of the motor
LEAD, GEAR, RATED = (10e-3, 3.0, 2.4)
MASS, WEIGHT, LEVEL, VISCOUS = 42.0, 310.0, 95.0, 180.0  # kg, N, N, N*s/m, all at the load
FASTEST = 0.25  # m/s
PERCENT = 0.01 * RATED * GEAR * 2.0 * np.pi / LEAD  # N at the load for 1 % of rated

AXIS = f"""
schema = 1
kind = "translational"
name = "Z axis"
[columns]
time = {{ column = "Time", unit = "ms" }}
position = {{ column = "Motor position", unit = "deg", side = "motor" }}
effort = {{ column = "Torque", unit = "%", side = "motor" }}
[effort]
rated = "{RATED} N*m"
[transmission]
lead = "10 mm"
gear_ratio = {GEAR}
"""


@pytest.fixture(scope="module")
def identification(tmp_path_factory):
    """What comes of a log as a servo drive writes it: degrees and percent of the motor, in steps of its encoder."""
    time = np.arange(0.0, 24.0, 1e-3)
    wanted = FASTEST * np.clip(
        1.6 * np.sin(2.0 * np.pi * 0.21 * time) + 0.5 * np.sin(2.0 * np.pi * 0.9 * time), -1, 1
    )
    speed = np.convolve(wanted, np.hanning(81) / np.sum(np.hanning(81)), mode="same")
    place = np.cumsum(speed) * 1e-3
    force = MASS * np.gradient(speed, 1e-3) + WEIGHT + LEVEL * np.sign(speed) + VISCOUS * speed
    torque = force / PERCENT + 0.15 * np.random.default_rng(8).standard_normal(time.size)
    turned = np.round(place / LEAD * GEAR * 2**20) * 360.0 / 2**20
    folder = tmp_path_factory.mktemp("vertical")
    rows = np.column_stack([1e3 * time, turned, torque])
    np.savetxt(
        folder / "log.csv",
        rows,
        delimiter=",",
        header="Time,Motor position,Torque",
        comments="",
        fmt="%.9g",
    )
    (folder / "axis.toml").write_text(AXIS)
    return br.identify(
        folder / "log.csv", "coulomb_viscous", axis=folder / "axis.toml", draws=0, blocks=0
    )


def test_three_values_are_in_percent_of_rated(identification):
    levels = identification.outcome.summary["drive_levels"]
    message = levels["units"]["% of rated"]
    assert message["constant"] == pytest.approx(WEIGHT / PERCENT, rel=0.03)
    assert message["forward"] == pytest.approx(LEVEL / PERCENT, rel=0.03)
    assert message["backward"] == pytest.approx(LEVEL / PERCENT, rel=0.03)
    assert levels["viscous_forward"] == pytest.approx(VISCOUS, rel=0.05)
    assert levels["inertia"] == pytest.approx(MASS, rel=0.03)
    at_motor = MASS * (LEAD / (2.0 * np.pi * GEAR)) ** 2
    assert levels["units"]["kg*m^2 at the motor"]["inertia"] == pytest.approx(at_motor, rel=0.03)
    assert levels["units"]["N*m at the motor"]["constant"] == pytest.approx(
        0.01 * RATED * WEIGHT / PERCENT, rel=0.03
    )


@pytest.mark.parametrize("entries", [4, 20])
def test_the_table_is_in_rpm_and_percent_of_rated(identification, entries):
    table = drive_rows(
        drive_table(identification.best, entries), "translational", identification.axis
    )
    heads = list(table.heads)
    speeds, percents = (heads.index(head) for head in ("[rpm of the motor]", "[% of rated]"))
    for row in table.rows:
        rpm = {"−0": -0.0, "+0": 0.0}.get(row[speeds])
        rpm = float(row[speeds].replace("−", "-")) if rpm is None else rpm
        speed = rpm / 60.0 / GEAR * LEAD
        truth = WEIGHT + np.copysign(LEVEL, rpm) + VISCOUS * speed
        assert float(row[percents].replace("−", "-")) == pytest.approx(truth / PERCENT, rel=0.03)
