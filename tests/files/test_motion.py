"""A motion as CSV: in the units of the axis, read back as it was written."""

import numpy as np
import pytest

from bristle.files import read_log
from bristle.files.axis import axis_from
from bristle.files.motion import write_motion

T = 1e-3 * np.arange(2000)
X = 0.01 * np.sin(2.0 * np.pi * T) ** 3
SIGNALS = {
    "time": T,
    "position": X,
    "velocity": np.gradient(X, T),
    "acceleration": np.gradient(np.gradient(X, T), T),
}

AXES = {
    "millimetres": {
        "columns": {
            "time": {"column": "t", "unit": "ms"},
            "position": {"column": "q", "unit": "mm"},
            "reference": {"column": "soll", "unit": "mm"},
        }
    },
    "counts, turned round": {
        "columns": {
            "time": "t",
            "position": {"column": "Position [count]", "unit": "count", "sign": -1},
        },
        "encoder": {"resolution": "0.01 um"},
    },
    "turns of the motor": {
        "columns": {
            "time": "t",
            "position": {"column": "angle", "unit": "rev", "side": "motor"},
            "velocity": {"column": "speed", "unit": "rpm", "side": "motor"},
        },
        "transmission": {"gear_ratio": 2.0, "lead": "10 mm"},
    },
}


@pytest.mark.parametrize("name", AXES)
def test_a_motion_survives_a_round_trip(name, tmp_path):
    axis = axis_from({"schema": 1, "kind": "translational", **AXES[name]})
    write_motion(tmp_path / "motion.csv", axis, SIGNALS)
    head = (tmp_path / "motion.csv").read_text().splitlines()[0].split(",")
    columns = {
        "time": {"column": head[0].split(" [")[0]},
        "position": {**AXES[name]["columns"]["position"], "column": head[1].split(" [")[0]},
        "velocity": AXES[name]["columns"].get("velocity"),
    }
    again = axis_from(
        {
            "schema": 1,
            "kind": "translational",
            **AXES[name],
            "columns": {key: item for key, item in columns.items() if item},
        }
    )
    log = read_log(tmp_path / "motion.csv", again)
    assert log.sample_time == pytest.approx(1e-3)
    assert log.position.values == pytest.approx(X, abs=1e-12)
    if log.velocity is not None:
        assert log.velocity.values == pytest.approx(SIGNALS["velocity"], abs=1e-9)
